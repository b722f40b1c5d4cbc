# SPDX-License-Identifier: Apache-2.0
"""`mehvar show`: contents of a model, from its manifest."""

from __future__ import annotations

import textwrap

import typer

from mehvar.base.manifest import Manifest
from mehvar.base.schema import plain
from mehvar.report.tables import model_tables
from mehvar.runtime.model.catalogue import find_model
from mehvar.settings import AsJson, ModelName
from mehvar.terminal import PAGE, pages, print_entries, print_json


def command(
    model: ModelName,
    as_json: AsJson = False,
) -> None:
    """Print names, units, defaults, bounds and sources of one model."""
    manifest = find_model(model)
    if as_json:
        print_json(plain(Manifest, manifest))
        return
    with pages():
        _show(manifest)


def _show(manifest: Manifest) -> None:
    """Print title and structure of a model, then its tables."""
    structure = ", ".join(f"{name}\u00a0=\u00a0{value}" for name, value in manifest.structure.items())  # kept on a line
    lines = textwrap.fill(f"structure: {structure or 'fixed'}", PAGE, subsequent_indent="  ").replace("\u00a0", " ")
    typer.echo(f"{manifest.model}: {manifest.title}\n{lines}")
    for title, columns, rows in model_tables(manifest):
        typer.echo()
        print_entries(title, columns, rows)
