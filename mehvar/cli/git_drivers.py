# SPDX-License-Identifier: Apache-2.0
"""What git calls to show a changed equations.json: an external diff and a textconv."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import typer

from mehvar.codegen.equations.document import Row, Symbol
from mehvar.codegen.equations.formula import Printer
from mehvar.comparison.compare import compare_documents, read_equations
from mehvar.errors import InputError
from mehvar.terminal import print_lines

_NOWHERE = "/dev/null"


def external_diff(arguments: Sequence[str]) -> None:
    """Print how two versions of an equations.json differ, under its path.

    Git takes any exit status but 0 for a failure, so there is no other. What cannot be compared is said so.

    Parameters
    ----------
    arguments : sequence of str
        What git passes: path, old file, old hash, old mode, new file, new hash, new mode, and more for a renamed file;
        the path alone for one with merge conflicts.
    """
    typer.echo(f"mehvar diff {arguments[0]}")
    if len(arguments) < 7:
        typer.echo("  has merge conflicts: resolve them in models/, then run mehvar generate")
        return
    old, new = arguments[1], arguments[4]
    if _NOWHERE in (old, new):
        typer.echo("  is new" if old == _NOWHERE else "  is gone")
        return
    try:
        before, after = read_equations(Path(old)), read_equations(Path(new))
    except InputError as error:
        typer.echo(f"  cannot be compared here, but mehvar diff can derive it: {error}")
        return
    print_lines((indent + 2, text) for indent, text in compare_documents(before, after).lines())


def textconv(file: Path) -> str:
    """Return an equations.json as text for git to compare: names, titles, and one term a line.

    One of another schema, or damaged, is returned as it is.
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
