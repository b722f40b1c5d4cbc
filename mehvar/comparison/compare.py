# SPDX-License-Identifier: Apache-2.0
"""`mehvar diff`: compare the equations of two versions, model by model."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from mehvar.codegen.diff import Document, DocumentError, compare
from mehvar.codegen.diff.report import Comparison, Fate
from mehvar.errors import InputError, bad_value, unknown_name
from mehvar.names import WORK
from mehvar.runtime.model.generated import check_unedited
from mehvar.terminal import working

from .consequences import consequences
from .result import Diff, ModelDiff
from .sources import Sources, Version
from .status import ModelStatus


def diff_versions(old: str, new: str, model: str | None = None) -> Diff:
    """Compare two versions.

    Parameters
    ----------
    old, new : str
        A git revision, a generated folder, a folder with generated/, or "work".
    model : str, optional
        The only model to compare.

    Raises
    ------
    InputError
        If a version does not exist or cannot be derived, or has no such model.
    """
    with tempfile.TemporaryDirectory(prefix="mehvar-diff-") as scratch:
        sources = Sources(Path(scratch), model)
        before, after = sources.version(old), sources.version(new)
        names = _names(before, after, model)
        models = tuple(_model(name, before.folders.get(name), after.folders.get(name)) for name in names)
    return Diff(before.label, after.label, models)


def diff(model: str, old: str = "HEAD", new: str = WORK) -> ModelDiff:
    """Compare two versions of a model's equations.

    Parameters
    ----------
    model : str
        Its name.
    old, new : str
        A git revision, a generated folder, a folder with generated/, or "work": what models/ derives now.

    Returns
    -------
    ModelDiff
        With `changed`, `added`, `removed`, `equivalent`, `parameters`, `consequences`; printing it gives the command's
        text.

    Raises
    ------
    InputError
        If a version does not exist or cannot be derived, or has no such model.
    """
    for name, value in (("model", model), ("old", old), ("new", new)):
        if not isinstance(value, str):
            raise bad_value(name, value, "a text", "the call")
    return diff_versions(old, new, model).models[0]


def compare_folders(old: Path, new: Path) -> ModelDiff:
    """Compare two generated folders of a model, and run both if anything but the form differs."""
    model = compare_documents(_document(old), _document(new))
    if not model.differs:
        return model
    with working(f"running {model.model}"):
        follows, overlay = consequences(old, new)
    return replace(model, consequences=follows, overlay=overlay)


def compare_documents(old: Document, new: Document) -> ModelDiff:
    """Compare the equations of a model, and the numbers where both have a manifest."""
    comparison = compare(old, new)
    return ModelDiff(comparison.model, _status(comparison), comparison)


def read_equations(path: Path) -> Document:
    """Read an equations.json without the manifest beside it.

    Raises
    ------
    InputError
        If it is damaged or of another schema.
    """
    try:
        return Document.parse(path.read_text(encoding="utf-8"), where=str(path))
    except DocumentError as error:
        raise InputError(str(error)) from None


def _names(before: Version, after: Version, model: str | None) -> Sequence[str]:
    names = sorted({*before.models, *after.models})
    if model is not None and model not in names:
        raise unknown_name("model", model, names, "--model")
    for version in (before, after):
        if version.single:
            names = [name for name in names if name in version.folders]
    names = [name for name in names if model in (None, name)]
    if not names:
        raise InputError(f"{before.label} and {after.label} have no model in common")
    return names


def _model(name: str, old: Path | None, new: Path | None) -> ModelDiff:
    if old is None or new is None:
        return ModelDiff(name, ModelStatus.ADDED if old is None else ModelStatus.REMOVED, Comparison(name, ()))
    return compare_folders(old, new)


def _document(folder: Path) -> Document:
    try:
        document = Document.read(folder)
    except DocumentError as error:
        raise InputError(str(error)) from None
    if document.manifest is not None:
        check_unedited(document.manifest)  # equations that are the same say nothing of code that was edited
    return document


def _status(comparison: Comparison) -> ModelStatus:
    telling = [equation for equation in comparison if equation.matters]
    if any(equation.verdict is not Fate.UNDECIDED for equation in telling):
        return ModelStatus.CHANGED
    if telling:
        return ModelStatus.UNDECIDED
    return ModelStatus.PARAMETERS if comparison.differs else ModelStatus.SAME
