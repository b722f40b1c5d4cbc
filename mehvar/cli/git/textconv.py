# SPDX-License-Identifier: Apache-2.0
"""`mehvar git-textconv`: equations.json as text that git can compare."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

import typer

from mehvar.base.errors import InputError
from mehvar.codegen.equations.document import Row, Symbol
from mehvar.codegen.equations.formula import Printer
from mehvar.comparison.compare import read_equations


def command(file: Annotated[Path, typer.Argument(help="An equations.json.")]) -> None:
    """Print the text."""
    typer.echo(textconv(file), nl=False)


def textconv(file: Path) -> str:
    """Return an equations.json as text for git: names, titles, and one term per line.

    A file with another schema or with damage is returned unchanged.
    """
    try:
        document = read_equations(file)
    except InputError:
        return file.read_text(encoding="utf-8")
    printer = Printer(document.nodes)
    declared = [_symbol(symbol) for symbol in document.symbols if symbol.unit]
    text = [f"model {document.model}", *declared]
    for row in document.rows:
        text += _row(row, printer)
    return "\n".join(text) + "\n"


def _symbol(symbol: Symbol) -> str:
    return f"{symbol.role} {symbol.name} [{symbol.unit}] {symbol.bounds} {symbol.source}".rstrip()


def _row(row: Row, printer: Printer) -> Iterator[str]:
    title = " ".join(part for part in (row.kind, row.name, row.number, row.title) if part)
    yield f"{title} [{row.unit}]" if row.unit else title
    for k, term in enumerate(printer.terms(row.node)):
        yield f"    {term.strip()}" if k else f"  = {term.strip()}"
