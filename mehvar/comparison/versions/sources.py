# SPDX-License-Identifier: Apache-2.0
"""The two versions of a comparison as generated folders, from git revisions, folders or current sources."""

from __future__ import annotations

import itertools
import json
import os
from collections.abc import Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from pathlib import Path

from mehvar.base import cache
from mehvar.base.errors import InputError
from mehvar.base.manifest import read_manifest
from mehvar.base.names import WORK
from mehvar.base.schema import SchemaError, parse
from mehvar.base.versions import installed
from mehvar.codegen.equations import SCHEMA
from mehvar.codegen.generate import Tree, check, find_tree, inputs, installed_tree, outdated
from mehvar.codegen.watch import is_ours
from mehvar.runtime.model.derived import last_line, run_python
from mehvar.runtime.model.generated import check_unedited
from mehvar.terminal import progress

from .git import Revision, find_revision, in_repository

_EQUATIONS = "equations.json"
_BUILD = """
import json
import os
import sys
from pathlib import Path
from mehvar.codegen.build import file_folder
from mehvar.codegen.watch import opened_file
path, read = Path(sys.argv[1]), set()
sys.path.insert(0, str(path.parent.resolve()))
sys.addaudithook(lambda event, of: read.add(opened_file(event, of)))
folder = file_folder(path).resolve()
data = {name for name in read if name and not name.endswith((".py", ".pyc"))}
code = {module.__file__ for name, module in sys.modules.items() if name.partition(".")[0] != "mehvar" and
        getattr(module, "__file__", None)}
print(json.dumps(sorted(data | code | set(map(os.path.realpath, data | code)))))
print(folder)
"""


@dataclass(frozen=True)
class Version:
    """One side of a comparison.

    Attributes
    ----------
    label : str
        Its name in messages.
    folders : mapping
        Generated folder of each model that is compared, with equations.json and manifest.json.
    models : tuple of str
        Every model that the version has.
    single : bool
        True if the user named a single generated folder.
    tree : Tree or None
        Project with its models/; None for folders without one.
    stale : mapping
        Models that were derived again because their generated folder was stale, with the reason.
    """

    label: str
    folders: Mapping[str, Path]
    models: tuple[str, ...]
    single: bool = False
    tree: Tree | None = None
    stale: Mapping[str, tuple[str, ...]] = field(default_factory=dict)


def names_model(text: str) -> bool:
    """Return True for a text that names a model and neither `work`, a path nor a revision."""
    tree = _tree_here()
    if text == WORK or Path(text).exists() or text not in tree.models:
        return False
    return not in_repository(tree.root) or find_revision(tree.root, text) is None


def _tree_here() -> Tree:
    return find_tree(Path.cwd()) or installed_tree()


class Sources:
    """Finder of versions, which unpacks git revisions below `scratch`; the caller removes this folder."""

    def __init__(self, scratch: Path, model: str | None = None) -> None:
        self.scratch = scratch
        self.model = model
        self.tree = _tree_here()

    def version(self, text: str) -> Version:
        """Return the version that a user's text names.

        Raises
        ------
        InputError
            If it is neither `work`, a folder with equations nor a git revision, or if its models cannot be derived.
        """
        folder = Path(text)
        if text == WORK:
            return self._of_tree(self.tree, WORK)
        if folder.suffix == ".py":
            return self._of_file(text)
        if (folder / _EQUATIONS).is_file():
            model = _model_of(folder)
            return self._of_folders({model: folder}, text, single=True)
        if (folder / "generated").is_dir():
            return self._of_tree(Tree(folder.resolve()), text)
        if folder.is_dir() and (inner := _generated(folder)):
            return self._of_folders(inner, text)
        revision = find_revision(self.tree.root, text)
        if revision is None:
            raise InputError(self._unknown(text))
        return self._of_revision(revision)

    def _unknown(self, text: str) -> str:
        where = f"no revision of the git repository around {self.tree.root}"
        if not in_repository(self.tree.root):
            where = f"no git revision either, because {self.tree.root} is in no git repository"
        return (
            f"{text!r} is not 'work', no folder with {_EQUATIONS}, and {where}: "
            "give a revision, a generated folder, a folder with generated/, or 'work'"
        )

    def _of_file(self, text: str) -> Version:
        """Return the system of a Python file, or of a file of a revision, as in HEAD~1:craft.py.

        The path starts at the folder of the command, as that of today's file, or, as git has it, at the repository's.
        """
        path, here, label, revision = Path(text), Path.cwd(), text, None
        if not path.is_file():
            name, _, file = text.partition(":")
            revision = find_revision(here, name) if file else None
            if revision is None:
                raise InputError(f"{text!r} is no Python file: give one, or one of a git revision, as in HEAD:craft.py")
            top, whole, label = revision.top, self.scratch / revision.commit, f"{revision.label}:{file}"
            replace(revision, root=top).extract(["."], whole)  # the file may read any other
            here = whole / here.relative_to(top)
            here.mkdir(parents=True, exist_ok=True)  # of which the revision may have no file
            path = next((folder / file for folder in (here, whole) if (folder / file).is_file()), Path())
            if not path.name:
                raise InputError(f"{text!r} is no Python file: {name} has it neither in {Path.cwd()} nor in {top}")
            path = Path(os.path.relpath(path, here))
        with progress(f"deriving {label}"):
            built, read = _built(path, here, label)
        if revision is not None:
            _refuse_files_of_today(revision, label, read)
        return self._of_folders({_model_of(built): built}, label, single=True)

    def _chosen(self, folders: Mapping[str, Path]) -> dict[str, Path]:
        return {name: path for name, path in folders.items() if self.model in (None, name)}

    def _of_folders(self, folders: Mapping[str, Path], label: str, single: bool = False) -> Version:
        """Return generated folders, after deriving those again that do not match the models/ of their project."""
        chosen, models = self._chosen(folders), tuple(folders)
        tree = _tree_around(chosen)
        if tree is None:
            return Version(label, chosen, models, single)
        stale = {name: reasons for name, folder in chosen.items() if (reasons := _outdated(tree, name, folder))}
        return Version(label, chosen | derive(tree, [*stale], label), models, single, tree, stale)

    def _of_tree(self, tree: Tree, label: str) -> Version:
        """Return generated/ if it is up to date, else a fresh derivation of models/."""
        if not tree.models:
            generated = _generated(tree.root / "generated")
            return Version(label, self._chosen(generated), tuple(generated))
        folders = self._chosen({name: tree.root / "generated" / name for name in tree.models})
        old = [name for name in folders if check(tree, name).stale]
        stale = {name: reasons for name in old if label != WORK and (reasons := _outdated(tree, name, folders[name]))}
        return Version(label, folders | derive(tree, old, label), tree.models, tree=tree, stale=stale)

    def _of_revision(self, revision: Revision) -> Version:
        """Return the committed generated/; derive models/ if it is stale or of an older schema."""
        root = self.scratch / revision.commit
        models = revision.models()
        folders = self._chosen({name: root / "generated" / name for name in models})
        revision.extract(["models", *(f"generated/{name}" for name in folders)], root)
        (root / "generated").mkdir(parents=True, exist_ok=True)
        revision.extract(sorted({name for folder in folders.values() for name in _files_outside_models(folder)}), root)
        tree = Tree(root)
        derivable = [name for name in folders if name in tree.models]
        old = {name for name, folder in folders.items() if _schema(folder) != SCHEMA}
        stale = {
            name: reasons
            for name in derivable
            if name not in old and (reasons := _outdated(tree, name, folders[name]) or _mixed(folders[name]))
        }
        folders = {name: folder for name, folder in folders.items() if name not in old}
        fresh = derive(tree, [name for name in derivable if name in old or name in stale], revision.label)
        for name, folder in fresh.items():
            read = [os.path.abspath(root / file) for file in read_manifest(folder).inputs_sha256]  # noqa: PTH100
            read += [os.path.realpath(file) for file in read]
            _refuse_files_of_today(revision, f"{revision.label}: {name}", read)
        folders |= fresh
        return Version(revision.label, folders, models, tree=tree, stale=stale)


def _refuse_files_of_today(revision: Revision, label: str, read: Iterable[str]) -> None:
    """Refuse a derivation of a revision that read a file of the working tree, by its absolute path.

    Files of mehvar do not count: in its own repository, today's mehvar derives every version.
    """
    if mixed := revision.of_today(file for file in read if not is_ours(Path(file))):
        raise InputError(
            f"{label} reads {mixed}, which is the file of today: give paths, also those of PYTHONPATH, relative to the "
            "file that reads it or to the folder of the command, so that the revision's own file is read"
        )


def _outdated(tree: Tree, model: str, folder: Path) -> tuple[str, ...]:
    """Return the reason why a generated folder does not match its models; empty without models."""
    try:
        return outdated(tree, model) if _schema(folder) == SCHEMA else ()
    except InputError:  # reported by its reader
        return ()


def _mixed(folder: Path) -> tuple[str, ...]:
    """Return the error about generated files of a revision that another derivation wrote, as after a merge, if any."""
    try:
        check_unedited(read_manifest(folder, any_age=True))
    except InputError as error:
        return (str(error).replace(f"{folder}/", "").partition(";")[0],)
    return ()


def _tree_around(folders: Mapping[str, Path]) -> Tree | None:
    """Return the project whose generated/ contains the folders."""
    places = {folder.resolve().parent for folder in folders.values()}
    tree = Tree(places.pop().parent) if len(places) == 1 else None
    if tree is None or any(folder.resolve() != tree.root / "generated" / name for name, folder in folders.items()):
        return None
    return tree if {*folders} <= {*tree.models} else None


def _files_outside_models(folder: Path) -> list[str]:
    """Return the files outside models/, but inside the project, that a derivation read."""
    try:
        names = read_manifest(folder, any_age=True).inputs_sha256
    except InputError:
        return []
    other = ("models/", "codegen/", "mehvar/", "..", "./", "/", "environment:")
    return [name.rstrip("/") for name in names if not name.startswith(other)]


def derive(tree: Tree, models: list[str], label: str) -> dict[str, Path]:
    """Derive models with this codegen, each in its own process, or take them from the cache.

    Raises
    ------
    InputError
        If a model cannot be derived; the message ends with the derivation's message.
    """
    if not models:
        return {}
    with progress(f"deriving {', '.join(models)} of {label}"), ThreadPoolExecutor(os.cpu_count()) as pool:
        folders = list(pool.map(lambda name: derived(tree, name, label), models))
    return dict(zip(models, folders, strict=True))


def derived(tree: Tree, model: str, label: str, structure: Mapping[str, str] | None = None) -> Path:
    """Return the current derivation of a model, whose previous folder lists additional files that it reads.

    Raises
    ------
    InputError
        As `derive` does.
    """
    choices = [f"{name}={value}" for name, value in sorted((structure or {}).items())]
    known = {**tree.sources(model), **installed("sympy", "casadi")}
    while True:
        key = cache.key(*choices, *itertools.chain(*sorted(known.items())))
        folder = cache.entry("derived", f"{model}-{key}", lambda folder: _derive(tree, model, label, choices, folder))
        record = read_manifest(folder)
        now = {**inputs(tree, model, record), **installed(*record.versions)}
        if now == {**record.inputs_sha256, **record.versions} or now.items() <= known.items():
            return folder
        known |= now


def _derive(tree: Tree, model: str, label: str, choices: list[str], folder: Path) -> None:
    options = [part for choice in choices for part in ("--structure", choice)]
    process = run_python(tree.root, "-m", "mehvar", "generate", model, *options, "--out", str(folder))
    if process.returncode:
        raise InputError(f"{label}: {model} cannot be derived by this version of mehvar: {last_line(process)}")


def _built(path: Path, top: Path, label: str) -> tuple[Path, list[str]]:
    """Return the generated folder of a Python file, run in the folder `top` in a process of its own, and what it read.

    Two versions of a file may import modules of one name and read tables at one relative path.
    """
    process = run_python(top, "-c", _BUILD, str(path))
    if process.returncode:
        message = last_line(process).partition(": ")[2]  # after the class of the exception
        raise InputError(message if label == str(path) else f"{label}: {message}")
    *_, read, folder = process.stdout.splitlines()
    return Path(folder), json.loads(read)


def _generated(folder: Path) -> dict[str, Path]:
    return {path.parent.name: path.parent for path in sorted(folder.glob(f"*/{_EQUATIONS}"))}


def _model_of(folder: Path) -> str:
    return str(_read(folder / _EQUATIONS).get("model", folder.name))


def _schema(folder: Path) -> object:
    path = folder / _EQUATIONS
    return _read(path).get("schema") if path.is_file() else None


def _read(path: Path) -> dict[str, object]:
    try:
        data = parse(path.read_text(encoding="utf-8"))
    except (SchemaError, UnicodeDecodeError) as error:
        raise InputError(f"{path} is damaged: {error}") from None
    return data if isinstance(data, dict) else {}
