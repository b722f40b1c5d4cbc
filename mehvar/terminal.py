# SPDX-License-Identifier: Apache-2.0
"""Terminal output: tables, progress bars, messages, closed pipes.

The library rich is imported on first use; `mehvar --version` does not need it.
"""

from __future__ import annotations

import io
import json
import math
import os
import re
import shutil
import sys
import textwrap
import time
import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager, redirect_stdout
from typing import TYPE_CHECKING, NoReturn, Protocol

from mehvar.base.display import CellProgress, in_notebook
from mehvar.base.errors import printable

if TYPE_CHECKING:
    from rich.text import Text

Line = tuple[int, "Text"]
"""A line of text and its indentation."""

_ENDLESS = re.compile(r"(\S{200})\S{600,}(\S{200})")
"""Number of characters above which a name in a message is shortened, more than users type."""
_NARROWEST = 40
"""Smallest width of a line's text; narrower terminals cut words."""

PAGE = 80
"""Width of long texts: the default width of a terminal."""
_GAP = 2
"""Columns between two cells."""
_INDENT = 4
"""Indentation of a text below its cells."""
_TEXT = 36
"""Smallest width of readable text; half of it holds three words per line."""


class Advance(Protocol):
    """Function that receives the finished amount, the total, and the description of the current work."""

    def __call__(self, done: float, total: float, what: str = "") -> None:
        """Show the progress."""


def print_table(title: str, columns: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Print a table, without a width limit if the output is not a terminal."""
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    console = Console(highlight=False)
    if not console.is_terminal:
        console = Console(highlight=False, width=10_000)
    table = Table(title=title or None, title_justify="left", box=None, pad_edge=False, header_style="bold")
    for name in columns:
        table.add_column(name, overflow="fold")
    for row in rows:
        table.add_row(*(Text(cell) for cell in row))
    console.print(table)


def print_folded(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Print a table in parts that fit a page and repeat the first column."""
    cells = list(zip(columns, *rows, strict=True))
    widths = [max(map(len, column)) for column in cells]
    first, parts, free = cells[0], [], 0
    for column, width in zip(cells[1:], widths[1:], strict=True):
        if width + _GAP > free:
            parts.append([first])
            free = PAGE - widths[0]
        parts[-1].append(column)
        free -= width + _GAP
    for part in parts:
        heads, *body = zip(*part, strict=True)
        print_table("", heads, body)


def print_entries(title: str, columns: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Print a table that fits a page; the text in the last cell of a row wraps.

    The text is beside the other cells, or below them if the remaining width is too small.
    """
    widths = [max(map(len, column)) for column in zip(columns, *rows, strict=True)][:-1]
    place = sum(widths) + _GAP * len(widths)
    below = PAGE - place < _TEXT
    heads = columns[:-1] if below else columns
    headings = [(title, "italic"), (_aligned(heads, widths), "bold")]
    print_lines((0, _styled(text, style)) for text, style in headings if text)
    for *cells, text in rows:
        line = _aligned(cells, widths)
        if below:
            print(line.rstrip())
        indents = (" " * _INDENT,) * 2 if below else (line.ljust(place), " " * place)
        print(textwrap.fill(text, PAGE, initial_indent=indents[0], subsequent_indent=indents[1]).rstrip())


def _aligned(cells: Sequence[str], widths: Sequence[int]) -> str:
    """Return cells in columns; cells beyond the last width are not padded."""
    return (" " * _GAP).join(cell.ljust(width) for cell, width in zip(cells, [*widths, 0], strict=False))


def _styled(text: str, style: str) -> Text:
    from rich.text import Text

    return Text(text.rstrip(), style)


_WIDTH = 110
"""Width of a report in a notebook, in which wider output scrolls."""


def print_lines(lines: Iterable[Line]) -> None:
    """Print lines; on a terminal, coloured and wrapped with their indentation."""
    from rich.console import Console
    from rich.text import Text

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


def html_text(lines: Iterable[Line]) -> str:
    """Return lines as preformatted HTML with a terminal's colours, for a notebook."""
    from io import StringIO

    from rich.console import Console
    from rich.text import Text

    console = Console(record=True, file=StringIO(), highlight=False, width=_WIDTH, force_jupyter=False)
    for indent, text in lines:
        for part in text.wrap(console, _WIDTH - indent):
            console.print(Text(" " * indent) + part, soft_wrap=True)
    return console.export_html(inline_styles=True, code_format='<pre style="line-height:1.3">{code}</pre>')


class BatchMeter:
    """Progress of a batch: finished runs, rate, and runs that ended early."""

    def __init__(self, advance: Advance) -> None:
        self._advance = advance
        self._begun: tuple[float, int] | None = None
        self.runs, self.seconds = 0, 0.0

    def __call__(self, runs: int, total: int, failed: int) -> None:
        """Show the progress."""
        self._begun = self._begun or (time.perf_counter(), runs)
        self.runs, self.seconds = runs - self._begun[1], time.perf_counter() - self._begun[0]
        rate = f"{self.rate}, " if self.runs else ""
        self._advance(runs, total, f"{runs}/{total} runs, {rate}{failed} not done")

    @property
    def rate(self) -> str:
        """Runs per second."""
        return f"{self.runs / self.seconds:.3g} runs/s"


@contextmanager
def cell_progress(title: str) -> Iterator[Advance | None]:
    """Show a progress bar below a notebook cell and yield its update function; elsewhere yield None."""
    if not in_notebook():
        yield None
        return
    with closing(CellProgress(title)) as bar:
        yield bar.advance


@contextmanager
def progress(title: str) -> Iterator[Advance]:
    """Show a progress bar on a terminal or in a notebook; yield its update function (done, total, what).

    Until the first call the bar shows activity and elapsed time.
    """
    with cell_progress(title) as advance_cell:
        if advance_cell is not None:
            yield advance_cell
            return
    if not (sys.stderr.isatty() or {"FORCE_COLOR", "TTY_COMPATIBLE"} & os.environ.keys()):  # as rich decides
        yield lambda *_: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, Task, TextColumn, TimeElapsedColumn, TimeRemainingColumn
    from rich.text import Text

    class Share(TextColumn):
        def render(self, task: Task) -> Text:
            return super().render(task) if task.total is not None else Text()

    class Remaining(TimeRemainingColumn):
        def render(self, task: Task) -> Text:
            return super().render(task) + " left" if task.total is not None else Text()

    console = Console(stderr=True)
    bar = Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        Share("{task.percentage:3.0f} %,"),
        TimeElapsedColumn(),
        TextColumn("elapsed"),
        Remaining(),
        console=console,
        transient=True,
        disable=not console.is_terminal,
    )
    with bar:
        task = bar.add_task(title, total=None)

        def advance(done: float, total: float, what: str = "") -> None:
            if bar.tasks[0].total is None:  # earlier work, and the time until now, are not part of the rate
                bar.reset(task, total=total, completed=int(done))
            bar.update(task, completed=done, total=total, description=f"{title} {what}".strip())

        yield advance


class _Screen(io.StringIO):
    """Output stream that keeps colours like a terminal."""

    def isatty(self) -> bool:
        """Return True, so that colours are kept."""
        return True


@contextmanager
def pages() -> Iterator[None]:
    """Show the output of the block in $PAGER or less if it is longer than the terminal."""
    if not sys.stdout.isatty():
        yield
        return
    import pydoc

    with redirect_stdout(_Screen()) as screen:
        yield
    text = screen.getvalue()
    if text.count("\n") < shutil.get_terminal_size().lines:
        sys.stdout.write(text)
    else:
        os.environ.setdefault("LESS", "FRX")  # as git does: less shows colours, and leaves the text on the screen
        pydoc.pager(text)


def print_json(facts: object) -> None:
    """Print facts as JSON."""
    print(json.dumps(finite(facts), indent=1, ensure_ascii=False))


def finite(value: object) -> object:
    """Return facts with infinity and NaN as texts, because JSON lacks them."""
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    if isinstance(value, Mapping):
        return {str(key): finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [finite(item) for item in value]
    return value


def print_version() -> None:
    """Print the version, as `mehvar --version` does."""
    from mehvar.base.versions import installed

    print(f"mehvar {installed('mehvar')['mehvar']}")


def fail(message: object, status: int) -> NoReturn:
    """Print a message on standard error and exit; a very long name is shortened in the middle."""
    text = _ENDLESS.sub(r"\1...\2", printable(str(message)))
    print(f"mehvar: {text}", file=sys.stderr)
    sys.exit(status)


@contextmanager
def interruptible() -> Iterator[None]:
    """End with a message and status 130 when the user presses Ctrl-C."""
    try:
        yield
    except KeyboardInterrupt:
        fail("interrupted", 130)


def shorten_warnings() -> None:
    """Show only the message of a warning, without source lines."""
    warnings.formatwarning = lambda message, *_, **__: f"mehvar: {message}\n"


def ignore_closed_output() -> None:
    """Ignore output after the reader has closed it, as in `mehvar show slosh | head -3`."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout = _Output(sys.stdout)
    if isinstance(sys.stderr, io.TextIOWrapper):
        sys.stderr = _Output(sys.stderr)


class _Output(io.TextIOWrapper):
    """A stream that switches to the null device when its pipe breaks."""

    def __init__(self, stream: io.TextIOWrapper) -> None:
        stream.flush()
        super().__init__(
            stream.buffer,
            encoding=stream.encoding,
            errors=stream.errors,
            line_buffering=stream.line_buffering,
            write_through=stream.write_through,
        )

    def write(self, text: str) -> int:
        """Write the text; drop it if the reader has closed the output."""
        try:
            return super().write(text)
        except BrokenPipeError:
            self._drop()
            return len(text)

    def flush(self) -> None:
        """Flush the output; ignore an output that the reader has closed."""
        try:
            super().flush()
        except BrokenPipeError:
            self._drop()

    def _drop(self) -> None:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, self.fileno())
        os.close(nowhere)
