# SPDX-License-Identifier: Apache-2.0
"""The project that one stands in: a folder with models and what is generated from them."""

from __future__ import annotations

from pathlib import Path


def project_root(start: Path) -> Path | None:
    """Return the nearest folder at or above `start` that has generated/, and a model in models/.

    A model has system.py, or plant.toml if it is a law; where that is missing or misspelt, it has at least parameters.
    """
    for folder in (start, *start.parents):
        models = folder / "models"
        patterns = ("system.py", "*/system.py", "*/plant.toml", "*/parameters.toml")
        if (folder / "generated").is_dir() and any(any(models.glob(pattern)) for pattern in patterns):
            return folder
    return None
