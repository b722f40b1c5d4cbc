# SPDX-License-Identifier: Apache-2.0
"""`mehvar list`: what models there are, read from manifests."""

from __future__ import annotations

from mehvar.manifest import Manifest
from mehvar.runtime.model.catalogue import find_model, known_models
from mehvar.settings import AsJson
from mehvar.terminal import print_json, print_table


def command(as_json: AsJson = False) -> None:
    """Print every generated model with its laws and scenarios."""
    manifests = {name: find_model(name) for name in known_models()}
    if as_json:
        print_json({"models": [_facts(name, manifest) for name, manifest in manifests.items()]})
        return
    rows = []
    for name, manifest in manifests.items():
        rows.append([name, manifest.title, " ".join(manifest.controllers), " ".join(manifest.scenarios)])
    print_table("", ["model", "what it is", "controllers", "scenarios"], rows)


def _facts(name: str, manifest: Manifest) -> dict[str, object]:
    return {
        "model": name,
        "title": manifest.title,
        "controllers": list(manifest.controllers),
        "scenarios": list(manifest.scenarios),
    }
