# SPDX-License-Identifier: Apache-2.0
"""`mehvar convert`: a result or a batch in another program's format."""

from __future__ import annotations

from typing import Annotated

import typer

from mehvar.formats.conversion import ENDINGS, convert
from mehvar.terminal import working


def command(
    source: Annotated[str, typer.Argument(metavar="STORE_OR_FILE", help="A batch, or a result file (.nc).")],
    to: Annotated[str, typer.Option("--to", metavar="FORMAT", help=f"One of {', '.join(ENDINGS)}.")],
    out: Annotated[str, typer.Option("--out", metavar="FILE", help="The file to write.")],
) -> None:
    """Write a table, or everything."""
    with working(f"converting {source}"):
        paths = convert(source, to, out)
    for path in paths:
        typer.echo(f"saved {path}")
