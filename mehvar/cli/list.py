# SPDX-License-Identifier: Apache-2.0
"""`mehvar list`: what models there are, read from manifests."""

from __future__ import annotations

from mehvar.runtime.model.catalogue import find_model, known_models
from mehvar.terminal import print_table


def command() -> None:
    """Print every generated model with its laws and scenarios."""
    rows = []
    for name in known_models():
        manifest = find_model(name)
        rows.append([name, manifest.title, " ".join(manifest.controllers), " ".join(manifest.scenarios)])
    print_table("", ["model", "what it is", "controllers", "scenarios"], rows)
