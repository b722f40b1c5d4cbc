# SPDX-License-Identifier: Apache-2.0
"""`mehvar list`: the models of mehvar and of the current project."""

from __future__ import annotations

import typer

from mehvar.base.manifest import Manifest, read_manifest
from mehvar.runtime.model.catalogue import known_models, project_models, shipped_models
from mehvar.settings import AsJson
from mehvar.terminal import print_json, print_table


def command(as_json: AsJson = False) -> None:
    """Print every generated model with its laws and scenarios."""
    manifests, own = {name: read_manifest(folder) for name, folder in known_models().items()}, project_models()
    if as_json:
        print_json({"models": [_facts(name, manifest) for name, manifest in manifests.items()]})
        return
    rows = []
    for name, manifest in manifests.items():
        place = [str(manifest.folder.parents[1]) if name in own else "mehvar"] if own else []
        rows.append([name, manifest.title, " ".join(manifest.controllers), " ".join(manifest.scenarios), *place])
    print_table("", ["model", "description", "controllers", "scenarios", *(["from"] if own else [])], rows)
    for name in sorted(own.keys() & shipped_models().keys()):
        typer.echo(f"note: {name} of {own[name].parents[1]} hides mehvar's model of the same name")


def _facts(name: str, manifest: Manifest) -> dict[str, object]:
    return {
        "model": name,
        "title": manifest.title,
        "controllers": list(manifest.controllers),
        "scenarios": list(manifest.scenarios),
    }
