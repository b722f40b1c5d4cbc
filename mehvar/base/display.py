# SPDX-License-Identifier: Apache-2.0
"""Notebook display of objects: tables in HTML, formulas in LaTeX, which the notebook typesets, and progress bars."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Iterable, Sequence
from html import escape
from typing import Any

_PATIENCE = 1.0
"""Delay before the progress bar appears, s. Most cells end earlier."""
_REFRESH = 0.25
"""Time between updates of the bar, s, longer than a browser needs to draw one."""


def heading(text: str) -> str:
    """Return a line of emphasised text."""
    return f"<p><strong>{escape(text)}</strong></p>"


def table(title: str, columns: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Return a table in HTML with escaped texts; an empty text if it has no rows."""
    body = "".join(_row("td", row) for row in rows)
    if not body:
        return ""
    caption = f"<caption>{escape(title)}</caption>" if title else ""
    return f"<table>{caption}<thead>{_row('th', columns)}</thead><tbody>{body}</tbody></table>"


def frame(page: str, height: int) -> str:
    """Return a whole page as a frame in a notebook's output, `height` pixels high."""
    return f'<iframe srcdoc="{escape(page)}" width="100%" height="{height}" style="border: 0"></iframe>'


def _row(tag: str, cells: Sequence[object]) -> str:
    return f"<tr>{''.join(f'<{tag}>{escape(str(cell))}</{tag}>' for cell in cells)}</tr>"


def displayed_formulas(formulas: Sequence[str]) -> str:
    """Return formulas, one below the other, as displayed LaTeX; an empty text without formulas."""
    lines = r" \\ ".join(formulas)
    return rf"$$\begin{{gathered}} {lines} \end{{gathered}}$$" if formulas else ""


def in_notebook() -> bool:
    """Return True in a notebook."""
    ipython = sys.modules.get("IPython")
    return ipython is not None and hasattr(ipython.get_ipython(), "kernel")


class CellProgress:
    """Progress bar below a notebook cell, which appears after a moment and disappears when the work ends."""

    def __init__(self, title: str) -> None:
        self._title, self._what, self._share = title, "", ""
        self._begun, self._ended = time.perf_counter(), threading.Event()
        self._thread = threading.Thread(target=self._show, daemon=True)
        self._thread.start()

    def advance(self, done: float, total: float, what: str = "") -> None:
        """Update the bar: finished amount, total, and description of the current work."""
        self._what, self._share = what, f' value="{done:g}" max="{total:g}"'

    def close(self) -> None:
        """Remove the bar."""
        self._ended.set()
        self._thread.join()

    def _show(self) -> None:
        """Display the progress if the work takes long, renew it until the end, and then clear it."""
        if self._ended.wait(_PATIENCE):
            return
        from IPython.display import display

        handle: Any = display(self._state(), raw=True, display_id=True)  # type: ignore[no-untyped-call]
        while handle is not None and not self._ended.wait(_REFRESH):
            handle.update(self._state(), raw=True)
        if handle is not None:
            handle.update({"text/plain": ""}, raw=True)

    def _state(self) -> dict[str, str]:
        text = f"{self._title} {self._what}".strip() + f", {time.perf_counter() - self._begun:.0f} s"
        return {"text/plain": text, "text/html": f"<progress{self._share}></progress> {escape(text)}"}
