# SPDX-License-Identifier: Apache-2.0
"""Printing for people: tables, and progress that is quiet when nobody looks."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Protocol

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.table import Table
from rich.text import Text

Line = tuple[int, Text]
"""A line with its indentation."""
_NARROWEST = 40
"""Columns that are left for a line's text however narrow the terminal: below this, words are cut."""


class Advance(Protocol):
    """Called with what is done, the total, and what is being done now."""

    def __call__(self, done: float, total: float, what: str = "") -> None:
        """Show it."""


def print_table(title: str, columns: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Print a table; unlimited width when the output is not a terminal."""
    console = Console(highlight=False)
    if not console.is_terminal:
        console = Console(highlight=False, width=10_000)
    table = Table(title=title or None, title_justify="left", box=None, pad_edge=False, header_style="bold")
    for name in columns:
        table.add_column(name, overflow="fold")
    for row in rows:
        table.add_row(*(Text(cell) for cell in row))
    console.print(table)


def print_lines(lines: Iterable[Line]) -> None:
    """Print lines: coloured and wrapped below their indentation on a terminal, as they are elsewhere."""
    console = Console(highlight=False)
    for indent, text in lines:
        if not console.is_terminal:
            print(" " * indent + text.plain)
            continue
        for part in text.wrap(console, max(console.width - indent, _NARROWEST)):
            console.print(Text(" " * indent) + part, soft_wrap=True)


def plain_text(lines: Iterable[Line]) -> str:
    """Return lines as plain text."""
    return "\n".join(" " * indent + text.plain for indent, text in lines)


@contextmanager
def progress(title: str) -> Iterator[Advance]:
    """Show a bar on a terminal's standard error; call what is yielded with (done, total)."""
    console = Console(stderr=True)
    bar = Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.percentage:3.0f} %"),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
        console=console,
        transient=True,
        disable=not console.is_terminal,
    )
    with bar:
        task = bar.add_task(title, total=1.0)

        def advance(done: float, total: float, what: str = "") -> None:
            bar.update(task, completed=done, total=total, description=f"{title} {what}".strip())

        yield advance


@contextmanager
def working(what: str) -> Iterator[None]:
    """Show that something of unknown length is under way, on a terminal's standard error."""
    console = Console(stderr=True)
    if not console.is_terminal:
        yield
        return
    with console.status(what):
        yield
