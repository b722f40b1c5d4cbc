# SPDX-License-Identifier: Apache-2.0
"""Notebook display of objects: tables in HTML, and formulas in LaTeX, which the notebook typesets."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape


def heading(text: str) -> str:
    """Return a line that stands out."""
    return f"<p><strong>{escape(text)}</strong></p>"


def table(title: str, columns: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Return a table in HTML with escaped texts; an empty text if it has no rows."""
    body = "".join(_row("td", row) for row in rows)
    if not body:
        return ""
    caption = f"<caption>{escape(title)}</caption>" if title else ""
    return f"<table>{caption}<thead>{_row('th', columns)}</thead><tbody>{body}</tbody></table>"


def frame(page: str, height: int) -> str:
    """Return a whole page as a frame of a notebook's output, `height` pixels high."""
    return f'<iframe srcdoc="{escape(page)}" width="100%" height="{height}" style="border: 0"></iframe>'


def _row(tag: str, cells: Sequence[object]) -> str:
    return f"<tr>{''.join(f'<{tag}>{escape(str(cell))}</{tag}>' for cell in cells)}</tr>"


def gathered(formulas: Sequence[str]) -> str:
    """Return formulas below each other as displayed LaTeX; an empty text if there are none."""
    lines = r" \\ ".join(formulas)
    return rf"$$\begin{{gathered}} {lines} \end{{gathered}}$$" if formulas else ""
