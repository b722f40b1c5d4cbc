# SPDX-License-Identifier: Apache-2.0
"""`mehvar list`: what models there are, in mehvar and in the project one stands in, read from manifests."""

from __future__ import annotations

import typer

from mehvar.manifest import read_manifest
from mehvar.runtime.model.catalogue import known_models, project_models, shipped_models
from mehvar.terminal import print_table


def command() -> None:
    """Print every generated model with its laws and scenarios."""
    rows, own = [], project_models()
    for name, folder in known_models().items():
        manifest = read_manifest(folder)
        place = [str(folder.parents[1]) if name in own else "mehvar"] if own else []
        rows.append([name, manifest.title, " ".join(manifest.controllers), " ".join(manifest.scenarios), *place])
    print_table("", ["model", "what it is", "controllers", "scenarios", *(["from"] if own else [])], rows)
    for name in own.keys() & shipped_models().keys():
        typer.echo(f"note: {name} of {own[name].parents[1]} hides the one that comes with mehvar")
