# SPDX-License-Identifier: Apache-2.0
"""`mehvar diff`: compare the equations of two versions, model by model."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from enum import StrEnum
from pathlib import Path
from typing import Any

from mehvar.codegen.diff import Document, DocumentError, compare
from mehvar.codegen.diff.report import Comparison, Equation, ParameterChange, Verdict
from mehvar.comparison.consequences import Consequences, consequences
from mehvar.comparison.sources import WORK, Sources, Version
from mehvar.errors import InputError, unknown_name

SCHEMA = 1


class Status(StrEnum):
    """What became of a model, in one word."""

    SAME = "same"
    PARAMETERS = "parameters changed"
    UNDECIDED = "undecided"
    CHANGED = "changed"
    ADDED = "added"
    REMOVED = "removed"


@dataclass(frozen=True)
class ModelDiff:
    """What changed in one model.

    Attributes
    ----------
    model : str
        Its name.
    status : Status
        In one word.
    comparison : Comparison
        Equation by equation; empty for a model that only one side has.
    consequences : Consequences or None
        What the change does; None where nothing changed or nothing could be run.
    """

    model: str
    status: Status
    comparison: Comparison
    consequences: Consequences | None = None

    @property
    def differs(self) -> bool:
        """Whether anything but the form differs: an equation, a parameter, the structure."""
        return self.status is not Status.SAME

    @property
    def changed(self) -> tuple[Equation, ...]:
        """Equations with another value, by themselves or through what they use, and undecided ones."""
        return self.comparison.changed

    @property
    def added(self) -> tuple[Equation, ...]:
        """Equations that only the new side has."""
        return self.comparison.added

    @property
    def removed(self) -> tuple[Equation, ...]:
        """Equations that only the old side has."""
        return self.comparison.removed

    @property
    def equivalent(self) -> tuple[Equation, ...]:
        """Equations that are written or called differently and mean the same."""
        return self.comparison.equivalent

    @property
    def parameters(self) -> tuple[ParameterChange, ...]:
        """Names, units, bounds, sources and values that differ."""
        return self.comparison.parameters

    def to_json(self) -> dict[str, Any]:
        """Return it as plain lists, dicts and strings."""
        found = self.comparison.to_json()
        found.pop("schema")
        follows = None if self.consequences is None else asdict(self.consequences)
        if follows is not None:
            follows["eigenvalues"] = [[[z.real, z.imag] for z in pair] for pair in follows["eigenvalues"]]
        return {
            **found,
            "model": self.model,
            "status": self.status.value,
            "differs": self.differs,
            "consequences": follows,
        }

    def __str__(self) -> str:
        from mehvar.comparison.text import plain_text

        return plain_text([self])


@dataclass(frozen=True)
class Diff:
    """What changed between two versions.

    Attributes
    ----------
    old, new : str
        What the versions are called.
    models : tuple of ModelDiff
        Every model of either side.
    """

    old: str
    new: str
    models: tuple[ModelDiff, ...]

    @property
    def differs(self) -> bool:
        """Whether any model differs."""
        return any(model.differs for model in self.models)

    def to_json(self) -> dict[str, Any]:
        """Return it as docs/reference/diff-json.md describes."""
        models = [model.to_json() for model in self.models]
        return {"schema": SCHEMA, "old": self.old, "new": self.new, "differs": self.differs, "models": models}

    def json_text(self) -> str:
        """Return the JSON text."""
        return json.dumps(self.to_json(), indent=1, ensure_ascii=False) + "\n"


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
    return diff_versions(old, new, model).models[0]


def compare_folders(old: Path, new: Path) -> ModelDiff:
    """Compare two generated folders of a model, and run both if anything but the form differs."""
    found = compare_documents(_document(old), _document(new))
    return replace(found, consequences=consequences(old, new)) if found.differs else found


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
    known = sorted({*before.models, *after.models})
    if model is not None and model not in known:
        raise unknown_name("model", model, known, "--model")
    for version in (before, after):
        if version.single:
            known = [name for name in known if name in version.folders]
    names = [name for name in known if model in (None, name)]
    if not names:
        raise InputError(f"{before.label} and {after.label} have no model in common")
    return names


def _model(name: str, old: Path | None, new: Path | None) -> ModelDiff:
    if old is None or new is None:
        return ModelDiff(name, Status.ADDED if old is None else Status.REMOVED, Comparison(name, ()))
    return compare_folders(old, new)


def _document(folder: Path) -> Document:
    try:
        return Document.read(folder)
    except DocumentError as error:
        raise InputError(str(error)) from None


def _status(comparison: Comparison) -> Status:
    telling = [equation for equation in comparison if equation.matters]
    if any(equation.verdict is not Verdict.UNDECIDED for equation in telling):
        return Status.CHANGED
    if telling:
        return Status.UNDECIDED
    return Status.PARAMETERS if comparison.differs else Status.SAME
