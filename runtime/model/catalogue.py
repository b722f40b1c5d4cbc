# SPDX-License-Identifier: Apache-2.0
"""Which generated models there are, by name."""

from __future__ import annotations

import importlib.util
import os
from pathlib import Path

from mehvar.errors import bad_value, unknown_name
from mehvar.manifest import FILE, Manifest, read_manifest


def known_models() -> dict[str, Path]:
    """Return the folders of the models that come with the `generated` package, by name."""
    spec = importlib.util.find_spec("mehvar.generated")
    roots = list(spec.submodule_search_locations or []) if spec else []
    folders = [folder for root in roots if Path(root).is_dir() for folder in sorted(Path(root).iterdir())]
    return {folder.name: folder for folder in folders if (folder / FILE).is_file()}


def find_folder(model: str | os.PathLike[str]) -> Path:
    """Return the folder of a model, by a name that comes with the `generated` package or as the folder itself.

    Raises
    ------
    InputError
        If there is no such model.
    """
    if not isinstance(model, str | os.PathLike):
        raise bad_value("model", model, "the name of a model, or the path of a generated folder")
    models = known_models()
    if isinstance(model, str) and model in models:
        return models[model]
    if os.path.isdir(model):  # noqa: PTH112 - pathlib raises for a name that is too long
        return Path(model)
    raise unknown_name("model (neither a known name nor a generated folder)", os.fspath(model), models)


def find_model(model: str | os.PathLike[str]) -> Manifest:
    """Read the manifest of a model.

    Parameters
    ----------
    model : str or path
        The name of a model that comes with the `generated` package, or a generated folder.

    Raises
    ------
    InputError
        If there is no such model, or its manifest cannot be read.
    """
    return read_manifest(find_folder(model))
