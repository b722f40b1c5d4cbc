# SPDX-License-Identifier: Apache-2.0
"""`mehvar convert`: a result or a batch in another program's format."""

from __future__ import annotations

from typing import Annotated

import typer

from mehvar.formats.conversion import ENDINGS, convert


def command(
    source: Annotated[str, typer.Argument(metavar="STORE_OR_FILE", help="A batch, or a result file (.nc).")],
    to: Annotated[str, typer.Option("--to", metavar="FORMAT", help=f"One of {', '.join(ENDINGS)}.")],
    out: Annotated[str, typer.Option("--out", metavar="FILE", help="The file to write.")],
) -> None:
    """Write a table, or everything."""
    for path in convert(source, to, out):
        typer.echo(f"saved {path}")
