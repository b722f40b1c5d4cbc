# SPDX-License-Identifier: Apache-2.0
"""`mehvar export web`: a page that simulates a model."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mehvar.settings import ModelName
from mehvar.terminal import progress
from mehvar.web.export import export_web


def command(
    model: ModelName,
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="The folder of the page, MODEL.html.")],
    success: Annotated[
        str | None,
        typer.Option(
            metavar="COND",
            help="Condition on metrics; the page offers a run that fails it. Default: reach the end.",
        ),
    ] = None,
) -> None:
    """Compile the generated C to WebAssembly and write it with sliders and plots into one page."""
    with progress(f"running and compiling {model}"):
        page = export_web(model, out, success=success)
    typer.echo(f"saved {page}, {page.stat().st_size / 1024:.0f} KiB")
