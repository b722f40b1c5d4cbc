# SPDX-License-Identifier: Apache-2.0
"""Generation of generated/MODEL/ from changed sources as a whole, and detection of stale files.

A derivation needs SymPy and CasADi; the test for changes needs neither.
"""

from __future__ import annotations

import contextlib
import gc
import hashlib
import os
import sys
import tempfile
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, cast

from mehvar.base.errors import InputError, value_text
from mehvar.base.manifest import FILE, Manifest, files_on_first_use, manifest_text, parse_manifest, read_manifest
from mehvar.base.names import identifier
from mehvar.base.versions import installed

from .loaded import tracing
from .plants import kept_plant
from .watch import ABSENT, answer
from .workspace import (
    GenerateError,
    Tree,
    find_tree,
    installed_tree,
    load_model,
    own_text,
    package_name,
    prefer_vocabulary,
    sha256,
)

if TYPE_CHECKING:
    from mehvar.models.system import System

__all__ = [
    "GenerateError",
    "Report",
    "Tree",
    "check",
    "derive",
    "find_tree",
    "generate",
    "installed_tree",
    "load_model",
    "locked",
    "outdated",
    "own_inputs",
    "system_of",
    "write",
]


@dataclass(frozen=True)
class Report:
    """Result of the generation of one model.

    Attributes
    ----------
    model : str
        Its name.
    written : tuple of str
        Files that were or would be written.
    reasons : tuple of str
        Reasons: sources that changed, files that are missing or were edited.
    """

    model: str
    written: tuple[str, ...] = ()
    reasons: tuple[str, ...] = ()

    @property
    def stale(self) -> bool:
        """True if the folder differed from its sources."""
        return bool(self.reasons)


def check(tree: Tree, model: str) -> Report:
    """Compare generated/MODEL with its sources without a derivation."""
    folder = tree.root / "generated" / model
    reasons = _reasons(tree, model, folder)
    record = _record(folder) if reasons else None
    return Report(model, (*(record.files_sha256 if record else ()), FILE) if reasons else (), reasons)


def generate(
    tree: Tree,
    model: str,
    out: Path | None = None,
    structure: Mapping[str, str] | None = None,
    casadi: bool = False,
) -> Report:
    """Derive a model and write its files unless they are up to date.

    Parameters
    ----------
    tree : Tree
        Where the model lives.
    model : str
        Its name.
    out : Path, optional
        Folder to write instead of generated/MODEL. It gets every file; generated/MODEL lacks the files that mehvar
        makes on first use (`mehvar.base.manifest.files_on_first_use`).
    structure : mapping, optional
        Structural choices that differ from the defaults.
    casadi : bool
        Also write CasADi's own C, which `load` can run and other tools can call. A folder that has it keeps it.

    Raises
    ------
    GenerateError
        If the model or a structural choice is not known.
    OSError
        If the folder cannot be written; its old contents stay complete.
    """
    folder = out or tree.root / "generated" / model
    choices = dict(structure or {})
    casadi = casadi or has_casadi(folder, model)
    reasons = _reasons(tree, model, folder, choices, casadi)
    if not reasons:
        return Report(model)
    texts = _renumbered(tree, model, folder, choices, casadi)
    texts = texts or derive(tree, model, choices, casadi, whole=out is not None)
    write(folder, texts)
    return Report(model, tuple(texts), reasons)


def _renumbered(
    tree: Tree, model: str, folder: Path, structure: Mapping[str, str], casadi: bool
) -> dict[str, str] | None:
    """Return an updated manifest if only numbers in tables have changed."""
    record = _record(folder)
    if record is None or not record.shapes_sha256:
        return None
    from .new_numbers import renumber, shapes

    tables, sources = tree.root / "models" / model, inputs(tree, model, record)
    names = [f"models/{model}/{name}" for name in record.shapes_sha256]
    now = {**record.inputs_sha256, **{name: sources[name] for name in names if name in sources}}
    record = replace(record, inputs_sha256=now)
    if shapes(tables) != record.shapes_sha256 or _differences(record, tree, model, folder, structure, casadi):
        return None
    prefer_vocabulary(tree)
    new = renumber(record, tables)
    if new is None:
        return None
    text = manifest_text(new)
    try:
        parse_manifest(text, tables / FILE)
    except InputError:
        return None  # the check of the whole system reports what is wrong with the numbers
    return {FILE: text}


@contextlib.contextmanager
def _few_collections() -> Iterator[None]:
    """Reduce garbage collection, because a derivation creates few reference cycles.

    With a tenth of the threshold collections take 0.1 s of 4.7 s for slosh and 0.4 s of 15 s with eight pendulums, and
    save 3 MB of 237.
    """
    before = gc.get_threshold()
    gc.set_threshold(max(before[0], 1_000_000) if before[0] else 0, *before[1:])
    try:
        yield
    finally:
        gc.set_threshold(*before)


@_few_collections()
def derive(
    tree: Tree, model: str, structure: Mapping[str, str] | None = None, casadi: bool = False, whole: bool = True
) -> dict[str, str]:
    """Derive a model and return all files of its generated folder, manifest last.

    Parameters
    ----------
    tree, model, structure, casadi
        As of `generate`.
    whole : bool
        True to include the files that mehvar makes on first use.

    Raises
    ------
    GenerateError
        If the model or a structural choice is not known.
    VerificationError
        If the efficient form differs from the derived equations.
    """
    with tracing(tree.root, package_name(tree, model)) as loading:
        system = system_of(tree, model, structure or {})
        loaded = {name: sha256(path) for name, path in loading.files().items()}
        libraries, answers = loading.libraries(), loading.answers()
    sources = {**answers, **loaded, **(_plant_inputs(tree, model) or {}), **tree.sources(model)}
    tables = tree.root / "models" / model
    return generated_files(system, sources, libraries, tables, casadi, whole)


def generated_files(
    system: System,
    sources: Mapping[str, str],
    libraries: Mapping[str, str] | None = None,
    tables: Path | None = None,
    casadi: bool = False,
    whole: bool = True,
) -> dict[str, str]:
    """Generate all files of a folder from a derived system, manifest last.

    Parameters
    ----------
    system : System
        As `system_of` returns it.
    sources : mapping of str to str
        SHA-256 of every source file it depends on.
    libraries : mapping of str to str, optional
        Versions of the distributions that its code imports.
    tables : Path, optional
        Folder of its tables; numbers in them may change without a new derivation.
    casadi : bool
        True to include CasADi's own C.
    whole : bool
        True to include the other files that mehvar makes on first use.
    """
    from .code.files import code_files, printed_functions
    from .equations.document import Document
    from .equations.graph import equations_json
    from .equations.page import equations_markdown
    from .functions.graphs import generate_functions
    from .functions.verify import check_counterparts, verify
    from .manifest import manifest_of
    from .new_numbers import TABLES, renumber, shapes

    check_counterparts(system)
    verify(system)
    graphs = generate_functions(system)
    functions = printed_functions(graphs)
    manifest = manifest_of(system, functions, sources)
    manifest = replace(manifest, versions=dict(sorted({**(libraries or {}), **manifest.versions}.items())))
    _check_constants(manifest, [f.name for f in functions])
    left_out = frozenset() if whole else files_on_first_use(system.name)
    files = code_files(manifest, functions, left_out)
    files["equations.json"] = equations_json(system)
    files["equations.md"] = equations_markdown(Document.parse(files["equations.json"]), manifest)
    if casadi:
        from .code.casadi_c import casadi_c

        files |= casadi_c(system.name, graphs)
    hashes = {name: hashlib.sha256(text.encode()).hexdigest() for name, text in files.items()}
    manifest = replace(manifest, files_sha256=dict(sorted(hashes.items())))
    table_shapes = shapes(tables) if tables else {}
    if tables and len(table_shapes) == len(TABLES) and renumber(manifest, tables) == manifest:
        manifest = replace(manifest, shapes_sha256=table_shapes)
    files[FILE] = manifest_text(manifest)
    try:
        parse_manifest(files[FILE], (tables or Path(system.name)) / FILE)
    except InputError as error:
        raise GenerateError(f"{system.name}: the derived code does not run: {error}") from error
    return files


def _check_constants(manifest: Manifest, functions: Iterable[str]) -> None:
    """Refuse two functions, or two constants of the header, whose names coincide in C."""
    from mehvar.base.constants import constants

    names = [*map(identifier, functions), *(name for name, _ in constants(manifest))]
    twice = [name for name, count in Counter(names).items() if count > 1]
    if twice:
        raise GenerateError(
            f"{manifest.model}: {twice[0]!r} has two meanings in the generated C: "
            "rename a law, a function or an element of a vector"
        )


def system_of(tree: Tree, model: str, structure: Mapping[str, str]) -> System:
    """Derive and check a model without writing.

    Raises
    ------
    GenerateError
        If the model or a structural choice is not known.
    ModelError
        If the model has an error.
    """
    system = _system(tree, model, structure)
    return prepared(system)


def prepared(system: System) -> System:
    """Return a checked system in its form for generation, with arrays, sample counts and clock."""
    from mehvar.models.arrays.constraints import with_arrays
    from mehvar.models.clock import with_clock
    from mehvar.models.forms import with_mass, with_samples

    return with_clock(with_samples(with_mass(with_arrays(system))))


def _system(tree: Tree, model: str, structure: Mapping[str, str]) -> System:
    """Derive and check a model, still in the form of its sources."""
    plant = tree.plant(model)
    system = _whole(tree, model, structure) if plant is None else _law(tree, model, structure, *plant)
    from mehvar.models.check import check as check_system
    from mehvar.models.check import check_tables

    folder = tree.root / "models" / model
    check_system(system, folder)
    check_tables(system, folder, {} if plant is not None else load_model(tree, model).STRUCTURE)
    if system.name != model:
        raise GenerateError(
            f"{folder}: the system's name is {system.name!r} but must equal the folder's name, {model!r}"
        )
    return system


def _law(tree: Tree, model: str, structure: Mapping[str, str], plant_tree: Tree, name: str) -> System:
    """Derive a user's law on a plant, which is derived once and cached."""
    package = load_model(tree, model)
    folder = tree.root / "models" / model
    if not hasattr(package, "laws"):
        raise GenerateError(f"{folder / '__init__.py'} must define laws(plant, d)")
    prefer_vocabulary(plant_tree)
    sources = _plant_inputs(tree, model)
    plant = (
        _system(plant_tree, name, structure)
        if sources is None
        else kept_plant(sources, structure, lambda: _system(plant_tree, name, structure))
    )
    from mehvar.models.check import no_branching
    from mehvar.models.derivation import Derivation
    from mehvar.models.plant import with_laws, without_laws

    bare = without_laws(plant)
    derivation = Derivation(bare.steps)
    derivation.section("Laws")
    with own_text(folder), no_branching():
        laws = package.laws(bare, derivation)
    return with_laws(bare, model, laws, derivation)


def _whole(tree: Tree, model: str, structure: Mapping[str, str]) -> System:
    """Return the system with a structure from the model's code; refuse one that declares another structure."""
    package = load_model(tree, model)
    folder = tree.root / "models" / model
    if not hasattr(package, "system"):
        raise GenerateError(f"{folder / '__init__.py'} must define system()")
    choices: Mapping[str, tuple[str, ...]] = _structure(package.STRUCTURE, folder)
    for name, value in structure.items():
        if name not in choices:
            raise GenerateError(f"{model} has no structure {name!r}; it has: {', '.join(choices) or 'none'}")
        if value not in choices[name]:
            raise GenerateError(f"structure {name} = {value!r} is not one of {', '.join(choices[name])}")
    from mehvar.models.check import check_kinds, no_branching

    with own_text(folder), no_branching():
        system: System = package.system(**structure)
    check_kinds(system)
    defaults = {name: values[0] for name, values in choices.items()}
    chosen = defaults | dict(structure)
    if {**defaults, **system.structure} != chosen:  # what has its default may be left out
        raise GenerateError(f"{folder}: the system's structure is {value_text(system.structure)} but must be {chosen}")
    return system


def _structure(choices: object, folder: Path) -> Mapping[str, tuple[str, ...]]:
    """Return a model's structural choices, or raise GenerateError if they are malformed."""
    words = isinstance(choices, Mapping) and all(
        isinstance(name, str) and isinstance(values, tuple) and values and all(isinstance(v, str) for v in values)
        for name, values in choices.items()
    )
    if not words:
        raise GenerateError(
            f"{folder / '__init__.py'}: STRUCTURE = {value_text(choices)}: must be a mapping of names to tuples of "
            "words, {} for a model without structural choices"
        )
    return cast(Mapping[str, tuple[str, ...]], choices)


def _reasons(
    tree: Tree, model: str, folder: Path, structure: Mapping[str, str] | None = None, casadi: bool = False
) -> tuple[str, ...]:
    """Return the reasons why a generated folder is stale; empty for a current one."""
    path = folder / FILE
    if not path.is_file():
        return (f"{path} is missing",)
    record = _record(folder)
    if record is None:
        return (f"{path} is damaged or of another version",)
    return _differences(record, tree, model, folder, structure or {}, casadi)


def _record(folder: Path) -> Manifest | None:
    """Return the manifest of a generated folder; None if it is missing or unreadable."""
    try:
        return read_manifest(folder)
    except InputError:
        return None


def has_casadi(folder: Path, model: str) -> bool:
    """Return True if a generated folder has CasADi's own C, or should have it."""
    record, name = _record(folder), f"{model}_casadi.c"
    return (folder / name).is_file() or (record is not None and name in record.files_sha256)


def _differences(
    record: Manifest, tree: Tree, model: str, folder: Path, structure: Mapping[str, str], casadi: bool
) -> tuple[str, ...]:
    """Compare sources, structure and files with a manifest's record."""
    files, before = record.files_sha256, record.structure
    reasons = [f"{name} {change}" for name, change in _changes(record.inputs_sha256, inputs(tree, model, record))]
    now = installed(*record.versions)
    reasons += [f"{k} is {now[k]}, was {v}" for k, v in record.versions.items() if now.get(k, v) != v]
    reasons += [f"structure {k} was {before.get(k)!r}" for k, v in structure.items() if before.get(k) != v]
    if casadi and f"{model}_casadi.c" not in files:
        reasons.append(f"{model}_casadi.c was not written before")
    for name, digest in files.items():
        if not (folder / name).is_file():
            reasons.append(f"{name} is missing")
        elif sha256(folder / name) != digest:
            reasons.append(f"{name} was edited by hand")
    return tuple(reasons)


def inputs(tree: Tree, model: str, record: Manifest) -> dict[str, str]:
    """Return the SHA-256 of each current file that the model's last derivation read."""
    now: dict[str, str] = {}
    for name, digest in record.inputs_sha256.items():
        present = answer(tree.root, name)
        if present is not None or digest == ABSENT:
            now[name] = present or ABSENT
    return now | (_plant_inputs(tree, model) or {}) | tree.sources(model)


def outdated(tree: Tree, model: str) -> tuple[str, ...]:
    """Return the project's own sources that changed since the generated folder was derived.

    Sources and versions of mehvar and files outside the tree are ignored, because a revision does not contain them.

    Raises
    ------
    InputError
        If the folder's manifest is missing or damaged.
    """
    record = read_manifest(tree.root / "generated" / model, any_age=True)
    own = tuple(own_inputs(tree, names) for names in (record.inputs_sha256, inputs(tree, model, record)))
    return tuple(f"{name} {change}" for name, change in _changes(*own))


def own_inputs(tree: Tree, names: Mapping[str, str]) -> dict[str, str]:
    """Return the inputs of a derivation that belong to the project, not to mehvar."""

    def is_own(name: str) -> bool:
        if name.startswith(("codegen/", "mehvar/", "../", "./", "/", "environment:")):
            return False
        vocabulary = name.startswith("models/") and name.split("/")[1] not in tree.models
        return tree.has_vocabulary or not vocabulary or (tree.root / name).exists()

    return {name: digest for name, digest in names.items() if is_own(name)}


def _plant_inputs(tree: Tree, model: str) -> dict[str, str] | None:
    """Return the inputs of a law's plant; None without a plant or a generated folder."""
    plant = tree.plant(model)
    record = None if plant is None else _record(plant[0].root / "generated" / plant[1])
    return None if plant is None or record is None else inputs(*plant, record)


def _changes(before: Mapping[str, str], now: Mapping[str, str]) -> Iterable[tuple[str, str]]:
    """Yield each source that differs from the record, with "is new", "was removed" or "changed"."""
    for name in sorted({*before, *now}):
        if name not in before:
            yield name, "is new"
        elif name not in now:
            yield name, "was removed"
        elif before[name] != now[name] and ABSENT in (before[name], now[name]):
            yield name, "was removed" if before[name] else "is new"
        elif before[name] != now[name]:
            yield name, "changed"


def write(folder: Path, texts: Mapping[str, str]) -> None:
    """Write all files under temporary names, then rename them, manifest last; an interrupted write shows as stale.

    A lock lets one process at a time rename, so that files of two processes never mix. A new folder that stays empty
    is removed.
    """
    new = not folder.exists()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=".writing-", dir=folder) as scratch:
            for name, text in texts.items():
                (Path(scratch) / name).write_text(text, encoding="utf-8", newline="\n")
            with locked(folder):
                for name in texts:
                    (Path(scratch) / name).replace(folder / name)
    except OSError as error:
        raise OSError(error.errno or 0, f"cannot write {folder}: {error.strerror or error}") from error
    finally:
        if new:
            with contextlib.suppress(OSError):
                folder.rmdir()


@contextlib.contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Hold a folder's lock, which the operating system releases if the process ends."""
    if sys.platform == "win32":
        yield
        return
    import fcntl

    handle = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX)
        yield
    finally:
        os.close(handle)
