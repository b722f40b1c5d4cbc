# SPDX-License-Identifier: Apache-2.0
"""`mehvar report`: a page about a model, a run or a batch."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from mehvar.pictures.style import require_matplotlib
from mehvar.runtime.batch.store.store import open_store
from mehvar.runtime.files import check_folder, filling
from mehvar.runtime.model.catalogue import known_models
from mehvar.runtime.model.model import load
from mehvar.runtime.run.formats import open_result
from mehvar.settings import complete_models
from mehvar.terminal import progress

if TYPE_CHECKING:
    from mehvar.report.page import Page

_PAGE = "index.html"


def command(
    subject: Annotated[
        str,
        typer.Argument(
            metavar="MODEL_OR_FILE", help="A model, a generated folder, a result .nc, or the store of a batch.",
            autocompletion=complete_models,
        ),
    ],
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Folder of the page; default: SUBJECT-report.")
    ] = None,
) -> None:  # fmt: skip
    """Write the page.

    Raises
    ------
    InputError
        If the subject is no model, result or store, the folder cannot be made or has another page, or matplotlib is
        missing.
    """
    require_matplotlib()
    out, maker = out or Path(f"{Path(subject).stem}-report"), f"mehvar report {subject}"
    check_folder(out, maker, [_PAGE])
    from mehvar.report.page import page_text

    with progress(f"report {subject}") as advance:
        advance(0, 1, "(the first run compiles)")
        page = page_text(_page(subject))
    with filling(out, maker) as folder:
        (folder / _PAGE).write_text(page, encoding="utf-8")
    typer.echo(f"report: {out / _PAGE}")


def _page(subject: str) -> Page:
    """Return the page about a NetCDF file, a store or a model; a model's name has precedence over a folder."""
    from mehvar.report.accessor import Results
    from mehvar.report.page import Page
    from mehvar.report.subjects import model_sections

    if subject.endswith(".nc"):
        return Results(open_result(subject)).page()
    if subject not in known_models() and (Path(subject) / "zarr.json").is_file():
        return Results(open_store(Path(subject)).dataset()).page(subject)
    model = load(subject)
    return Page(f"{model.name}: {model.manifest.title}", model_sections(model))
