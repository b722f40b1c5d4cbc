# SPDX-License-Identifier: Apache-2.0
"""`mehvar convert`: a result or a batch in another file format."""

from __future__ import annotations

from typing import Annotated

import typer

from mehvar.formats.conversion import ENDINGS, convert, format_of
from mehvar.settings import read_settings
from mehvar.terminal import progress


def command(
    source: Annotated[str, typer.Argument(metavar="STORE_OR_FILE", help="A batch, or a result file (.nc).")],
    out: Annotated[str, typer.Option("--out", metavar="FILE", help="The file to write.")],
    to: Annotated[
        str | None,
        typer.Option("--to", metavar="FORMAT", help=f"One of {', '.join(ENDINGS)}; default: by the ending of --out."),
    ] = None,
    about: Annotated[
        list[str] | None,
        typer.Option(
            "--about",
            metavar="NAME=VALUE",
            help="For aem, ck and oem: quaternion, position, frames, epoch, ...; repeat as needed.",
        ),
    ] = None,
) -> None:
    """Write a table of the selected values, or the complete contents."""
    with progress(f"converting {source}"):
        conversion = convert(source, format_of(out) if to is None else to, out, read_settings(about, "--about"))
    for path in conversion.paths:
        typer.echo(f"saved {path}")
    if conversion.note:
        typer.echo(f"note: {conversion.note}", err=True)
