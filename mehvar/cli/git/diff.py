# SPDX-License-Identifier: Apache-2.0
"""`mehvar git-diff`: display of a changed equations.json in git, as an external diff."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from mehvar.base.errors import InputError
from mehvar.comparison.compare import compare_documents, read_equations
from mehvar.terminal import print_lines

_NOWHERE = "/dev/null"


def command(
    arguments: Annotated[list[str], typer.Argument(help="Arguments that git passes to an external diff.")],
) -> None:
    """Compare the two versions that git passes."""
    external_diff(arguments)


def external_diff(arguments: Sequence[str]) -> None:
    """Print the differences of two versions of an equations.json, under its path.

    The exit status is always 0, because git treats any other as a failure. Incomparable files are reported.

    Parameters
    ----------
    arguments : sequence of str
        Git's arguments: path, old file, old hash, old mode, new file, new hash, new mode, and more for a renamed
        file. For a file with merge conflicts only the path.
    """
    typer.echo(f"mehvar diff {arguments[0]}")
    if len(arguments) < 7:
        typer.echo("  has merge conflicts: resolve them in models/, then run mehvar generate")
        return
    old, new = arguments[1], arguments[4]
    if _NOWHERE in (old, new):
        typer.echo("  is new" if old == _NOWHERE else "  was removed")
        return
    try:
        before, after = read_equations(Path(old)), read_equations(Path(new))
    except InputError as error:
        typer.echo(f"  cannot be compared here, but mehvar diff can derive it: {error}")
        return
    print_lines((indent + 2, text) for indent, text in compare_documents(before, after).lines())
