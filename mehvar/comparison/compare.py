# SPDX-License-Identifier: Apache-2.0
"""`mehvar diff`: comparison of the equations of two versions, model by model."""

from __future__ import annotations

import pickle
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import astuple, replace
from pathlib import Path
from typing import TYPE_CHECKING

import mehvar.codegen
from mehvar.base import cache
from mehvar.base.errors import InputError, bad_value, first_names, unknown_name
from mehvar.base.manifest import Manifest
from mehvar.base.names import WORK
from mehvar.base.parts import part_changes
from mehvar.codegen.diff import Document, DocumentError, compare
from mehvar.codegen.diff.report import Comparison, EquationChange, EquationVerdict, ModelStatus
from mehvar.codegen.equations.formula import Printer
from mehvar.codegen.processes import in_processes
from mehvar.runtime.model.generated import check_unedited
from mehvar.terminal import progress

from .consequences import consequences
from .result import Diff, ModelDiff
from .versions.sources import Sources, Version
from .versions.structures import Variant, changed_sources, selection

if TYPE_CHECKING:
    from mehvar.models.parts import Spacecraft
    from mehvar.models.system import System

_CODEGEN = Path(mehvar.codegen.__file__).parent
_FILES, _KEPT = ("equations.json", "manifest.json"), "comparison.pickle"
_SHAPE = "shape"
"""Role of the numbers of a picture."""
_NAMED = 4
"""Largest number of files in a message, which fit on one line."""


def diff_versions(old: str, new: str, model: str | None = None, structures: Sequence[str] = ()) -> Diff:
    """Compare two versions.

    Parameters
    ----------
    old, new : str
        A git revision, a generated folder, a folder with generated/, or "work".
    model : str, optional
        Model to compare; default: all.
    structures : sequence of str
        Further structures to compare: "all", or NAME=VALUE with commas between several.

    Raises
    ------
    InputError
        If a version does not exist or cannot be derived, or has no such model or structure.
    """
    with tempfile.TemporaryDirectory(prefix="mehvar-diff-") as scratch:
        sources = Sources(Path(scratch), model)
        before, after = sources.version(old), sources.version(new)
        names = _names(before, after, model)
        models = tuple(_model(name, before, after, structures) for name in names)
    return Diff(before.label, after.label, models)


def diff(
    model: str | System | Spacecraft,
    old: str | System | Spacecraft = "HEAD",
    new: str = WORK,
    structures: str | Sequence[str] = (),
) -> ModelDiff:
    """Compare two versions of a model's equations.

    Parameters
    ----------
    model : str, System or Spacecraft
        Name of the model. Or two systems defined in Python, the older one first: `diff(before, after)`; for two
        spacecraft, `parts` lists the changes part by part.
    old, new : str
        A git revision, a generated folder, a folder with generated/, or "work": the current derivation of models/.
    structures : str or sequence of str
        Further structures to compare: "all", or NAME=VALUE with commas between several.

    Returns
    -------
    ModelDiff
        With `changed`, `added`, `removed`, `equivalent`, `parameters`, `consequences`, `parts`, `notes`, `structures`;
        printing it gives the command's text.

    Raises
    ------
    InputError
        If a version does not exist or cannot be derived, or has no such model or structure.
    """
    if not isinstance(model, str) and not isinstance(old, str):
        if new != WORK or structures:
            raise InputError("diff(before, after) compares two systems: leave new and structures out")
        from mehvar.codegen.build import built_folder

        return compare_folders(built_folder(model), built_folder(old))
    name, before, after = (_text(n, v) for n, v in (("model", model), ("old", old), ("new", new)))
    texts = [structures] if isinstance(structures, str) else structures
    if not isinstance(texts, Sequence) or not all(isinstance(text, str) for text in texts):
        raise bad_value("structures", structures, "a text or a list of texts", "the call")
    return diff_versions(before, after, name, texts).models[0]


def _text(name: str, value: object) -> str:
    if not isinstance(value, str):
        raise bad_value(name, value, "a text", "the call")
    return value


def compare_folders(old: Path, new: Path) -> ModelDiff:
    """Compare two generated folders of a model, with runs of both unless only the form of equations differs."""
    return _with_consequences(compare_documents(_document(old), _document(new)), old, new)


def _with_consequences(model: ModelDiff, old: Path, new: Path) -> ModelDiff:
    if not model.differs:
        return model
    with progress(f"running {model.name}"):
        follows, overlay = consequences(old, new, dict(model.comparison.renamed))
    return replace(model, consequences=follows, overlay=overlay)


def compare_documents(old: Document, new: Document) -> ModelDiff:
    """Compare the equations of a model, and its numbers if both sides have a manifest."""
    comparison = compare(old, new)
    parts = _part_changes(old.manifest, new.manifest, dict(comparison.renamed))
    return ModelDiff(comparison.model, _status(comparison), comparison, parts=parts)


def _part_changes(old: Manifest | None, new: Manifest | None, renamed: Mapping[str, str]) -> tuple[str, ...]:
    if not (old and new and (old.parts or new.parts)):
        return ()
    from mehvar.models.parts.part import unit_of

    names = {name: renamed[name] for name in old.parts if renamed.get(name) in new.parts}
    return part_changes(old.parts, new.parts, unit_of, names)


def read_equations(path: Path) -> Document:
    """Read an equations.json; ignore a manifest in the same folder.

    Raises
    ------
    InputError
        If it is damaged or of another schema.
    """
    return _read(lambda: Document.parse(path.read_text(encoding="utf-8"), where=str(path)))


def _read(read: Callable[[], Document]) -> Document:
    try:
        return read()
    except DocumentError as error:
        raise InputError(str(error)) from None


def _names(before: Version, after: Version, model: str | None) -> Sequence[str]:
    """Return the models to compare; a version that is a single folder limits them to its own."""
    names = sorted({*before.models, *after.models})
    if model is not None and model not in names:
        raise unknown_name("model", model, names, "--model")
    for version in (before, after):
        if version.single:
            names = [name for name in names if name in version.folders]
    names = [name for name in names if model in (None, name)]
    if not names:
        raise InputError(f"{before.label} and {after.label} have no model in common: name two versions of one model")
    return names


def _model(name: str, old: Version, new: Version, structures: Sequence[str]) -> ModelDiff:
    """Return the comparison of a model; undecided if a changed source may affect structures that were not compared."""
    stale = tuple(
        f"generated/{name} of {side.label} is stale, derived anew: {first_names(side.stale[name], _NAMED)}"
        for side in (old, new)
        if name in side.stale
    )
    if name not in old.folders or name not in new.folders:
        status = ModelStatus.ADDED if name not in old.folders else ModelStatus.REMOVED
        return ModelDiff(name, status, Comparison(name, ()), notes=stale)
    model = compare_folders(old.folders[name], new.folders[name])
    others = selection(name, old, new, structures)
    compared_structures, notes = _others(model, others.variants)
    unread = () if others.complete else changed_sources(name, old, new)
    if unread and model.status is ModelStatus.SAME:
        model = replace(model, status=ModelStatus.UNDECIDED)
    notes = [*model.notes, *stale, *notes, *_unread(unread, others.variants)]
    return replace(model, notes=tuple(notes), structures=compared_structures)


def _unread(sources: Sequence[str], compared: Sequence[Variant]) -> Iterator[str]:
    """Return a note about changed sources that could affect structures that were not compared."""
    if sources:
        instead = "other combinations were" if compared else "other structures than the default were"
        mend = "name them with --structures NAME=VALUE,NAME=VALUE" if compared else "--structures all compares them"
        named = first_names(sources, _NAMED)
        yield f"undecided: {instead} not compared, and {named} changed, which they may use; {mend}"


def _others(model: ModelDiff, variants: Sequence[Variant]) -> tuple[tuple[ModelDiff, ...], list[str]]:
    """Compare further structures; return those with additional changes, and a note about the rest."""
    parts, known = [], _edits(model)
    named: dict[str, list[str]] = {}
    pairs = [(v.old, v.new) for v in variants if isinstance(v.old, Path) and isinstance(v.new, Path)]
    with progress(f"comparing {len(pairs)} structures of {model.name}"):
        compared = iter(in_processes(lambda pair, processes: processes.submit(_cached, *pair).result(), pairs))
    for variant in variants:
        if isinstance(variant.old, str) or isinstance(variant.new, str):
            if variant.is_refused:
                named.setdefault(f"neither version derives: {variant.new}", []).append(variant.name)
            else:
                parts.append(_one_sided(model.model, variant))
            continue
        other = replace(next(compared), variant=variant.name)
        edits = _edits(other)
        if not other.differs:
            named.setdefault("the same", []).append(variant.name)
        elif other.status is not ModelStatus.UNDECIDED and edits <= known:
            named.setdefault("changed by edits that are shown for another structure", []).append(variant.name)
        else:
            known |= edits
            parts.append(_with_consequences(other, variant.old, variant.new))
    return tuple(parts), [f"structures, {what}: {'; '.join(names)}" for what, names in named.items()]


def _cached(old: Path, new: Path) -> ModelDiff:
    """Compare two folders, or return a cached comparison of the same files by this version."""
    engine = sorted(
        (*_CODEGEN.rglob("*.py"), *(p for of in (__file__, cache.__file__) for p in Path(of).parent.glob("*.py")))
    )
    texts = [
        path.read_text(encoding="utf-8") for path in (*engine, *(side / name for side in (old, new) for name in _FILES))
    ]

    def fill(folder: Path) -> None:
        (folder / _KEPT).write_bytes(pickle.dumps(compare_documents(_document(old), _document(new))))

    # read back from a folder that only this user can write, like compiled libraries
    folder = cache.entry("comparisons", cache.key(*texts), fill)
    model: ModelDiff = pickle.loads((folder / _KEPT).read_bytes())
    return model


def _one_sided(model: str, variant: Variant) -> ModelDiff:
    lost = isinstance(variant.new, str)
    status = ModelStatus.REMOVED if lost else ModelStatus.ADDED
    reason = str(variant.new if lost else variant.old)
    return ModelDiff(model, status, Comparison(model, ()), variant=variant.name, notes=(reason,))


def _edits(model: ModelDiff) -> set[tuple[str, ...]]:
    """Return the edits of a model; structures with equal edits share one entry."""
    comparison = model.comparison
    equations = {
        (equation.name, equation.verdict.value, *_contents(comparison, equation))
        for equation in comparison
        if equation.verdict not in (EquationVerdict.SAME, EquationVerdict.INHERITED)
        and (equation.matters or equation in comparison.pictured)
    }
    return equations | {tuple(map(str, astuple(change))) for change in comparison.parameters} | {*comparison.structure}


def _contents(comparison: Comparison, equation: EquationChange) -> Iterator[str]:
    """Yield the edits of an equation with their positions and parts; without edits, yield both whole sides."""
    for edit in equation.edits:
        yield from (edit.says, *edit.path, *(part.text if part else "" for part in (edit.old, edit.new)))
    if not equation.edits:
        sides = ((comparison.old_nodes, equation.old_node), (comparison.new_nodes, equation.new_node))
        yield from (Printer(nodes).text(node) if node is not None else "" for nodes, node in sides)


def _document(folder: Path) -> Document:
    document = _read(lambda: Document.read(folder))
    if document.manifest is not None:
        check_unedited(document.manifest)  # equal equations do not rule out edited code
    return document


def _status(comparison: Comparison) -> ModelStatus:
    """Return the most severe kind of difference: equations, numbers, the picture, then names."""
    material = [equation for equation in comparison if equation.matters]
    if any(equation.verdict is not EquationVerdict.UNDECIDED for equation in material):
        return ModelStatus.CHANGED
    if material:
        return ModelStatus.UNDECIDED
    others = [change for change in comparison.parameters if not change.only_names]
    if comparison.structure or any(change.role != _SHAPE for change in others):
        return ModelStatus.PARAMETERS
    if others or comparison.pictured:
        return ModelStatus.PICTURE
    return ModelStatus.NAMES if comparison.parameters or comparison.renamed else ModelStatus.SAME
