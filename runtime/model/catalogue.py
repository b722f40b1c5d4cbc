# SPDX-License-Identifier: Apache-2.0
"""Generated models by name."""

from __future__ import annotations

import functools
import importlib.util
import os
import warnings
from collections.abc import Iterable
from pathlib import Path

from mehvar.base.errors import bad_value, unknown_name
from mehvar.base.manifest import FILE, Manifest, read_manifest
from mehvar.base.versions import project_root


def shipped_models() -> dict[str, Path]:
    """Return the folders of mehvar's models by name."""
    return {name: folder for root in _shipped_roots() for name, folder in _models_in(root).items()}


def project_models() -> dict[str, Path]:
    """Return the generated folders of the current project by name; empty in mehvar's own checkout."""
    models = {name: folder for root in _project_roots(Path.cwd()) for name, folder in _models_in(root).items()}
    shipped = shipped_models()
    return {name: folder for name, folder in models.items() if not _is_same(folder, shipped.get(name))}


def known_models() -> dict[str, Path]:
    """Return the folders of all models by name; a project's model hides mehvar's model of the same name."""
    return shipped_models() | project_models()


def list_models() -> list[str]:
    """Return the names of all models, of mehvar and of the current project."""
    return sorted(known_models())


@functools.cache
def _shipped_roots() -> tuple[Path, ...]:
    spec = importlib.util.find_spec("mehvar.generated")
    return tuple(Path(folder).resolve() for folder in spec.submodule_search_locations or []) if spec else ()


def _project_roots(start: Path) -> tuple[Path, ...]:
    root = project_root(start)
    return () if root is None else (root / "generated",)


def _models_in(root: Path) -> dict[str, Path]:
    folders = sorted(root.iterdir()) if root.is_dir() else []
    return {folder.name: folder for folder in folders if (folder / FILE).is_file()}


def _model_in(roots: Iterable[Path], name: str) -> Path | None:
    """Return the entry of one model in `_models_in` without reading others."""
    folders = [root / name for root in roots if os.path.isfile(root / name / FILE)]  # noqa: PTH113 - as in find_folder
    return folders[-1] if folders and folders[-1].name == name else None


def _is_same(folder: Path, other: Path | None) -> bool:
    return other is not None and folder.samefile(other)


def find_folder(model: str | os.PathLike[str], beside: Path | None = None) -> Path:
    """Return a model's folder from a known name or else a path.

    Parameters
    ----------
    model : str or path
        Name or folder.
    beside : Path, optional
        Folder to which paths are relative and whose project defines names; default: the current folder.

    Raises
    ------
    InputError
        If there is no such model.
    """
    if not isinstance(model, str | os.PathLike):
        raise bad_value("model", model, "the name of a model, or the path of a generated folder")
    if isinstance(model, str):
        start = Path.cwd() if beside is None else beside.absolute()
        shipped, own = _model_in(_shipped_roots(), model), _model_in(_project_roots(start), model)
        if own is not None and not _is_same(own, shipped):
            if shipped is not None:
                warnings.warn(f"{model}: using the model in {own}, not mehvar's model of this name", stacklevel=2)
            return own
        if shipped is not None:
            return shipped
    folder = Path(model) if beside is None else beside.absolute() / model
    if os.path.isdir(folder):  # noqa: PTH112 - pathlib raises for a name that is too long
        return folder
    raise unknown_name("model (neither a known name nor a generated folder)", os.fspath(model), known_models())


def is_installed(model: str, digest: str) -> bool:
    """Return True if the installed model of this name has this hash."""
    return model in known_models() and find_model(model).hash == digest


def find_model(model: str | os.PathLike[str]) -> Manifest:
    """Read the manifest of a model.

    Parameters
    ----------
    model : str or path
        Name of a model of mehvar or of the current project, or a generated folder.

    Raises
    ------
    InputError
        If there is no such model, or its manifest cannot be read.
    """
    return read_manifest(find_folder(model))
