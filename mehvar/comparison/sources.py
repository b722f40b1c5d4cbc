# SPDX-License-Identifier: Apache-2.0
"""What OLD and NEW mean: a git revision, a folder, or what models/ derives now; as generated folders to read."""

from __future__ import annotations

import itertools
import json
import os
import subprocess
import sys
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from mehvar import cache
from mehvar.codegen.equations import SCHEMA
from mehvar.codegen.generate import Tree, check, find_tree, inputs, installed_tree
from mehvar.errors import InputError
from mehvar.manifest import read_manifest
from mehvar.names import WORK
from mehvar.terminal import working
from mehvar.versions import installed

from .git import Revision, find_revision, in_repository

_EQUATIONS = "equations.json"
_HERE = Path(__file__).parents[2]


@dataclass(frozen=True)
class Version:
    """One side of a comparison.

    Attributes
    ----------
    label : str
        What to call it.
    folders : mapping
        Generated folder of each model that is compared, with equations.json and manifest.json.
    models : tuple of str
        Every model that the version has.
    single : bool
        Whether the user named one generated folder, so that nothing else is to be compared.
    """

    label: str
    folders: Mapping[str, Path]
    models: tuple[str, ...]
    single: bool = False


class Sources:
    """Resolves versions; what git holds is unpacked below `scratch`, which the caller removes."""

    def __init__(self, scratch: Path, model: str | None = None) -> None:
        self.scratch = scratch
        self.model = model
        self.tree = find_tree(Path.cwd()) or installed_tree()

    def version(self, text: str) -> Version:
        """Return the version that a user calls `text`.

        Raises
        ------
        InputError
            If it is neither `work`, a folder with equations nor a git revision, or if its models cannot be derived.
        """
        folder = Path(text)
        if text == WORK:
            return self._of_tree(self.tree, WORK)
        if (folder / _EQUATIONS).is_file():
            model = _model_of(folder)
            return Version(text, {model: folder}, (model,), single=True)
        if (folder / "generated").is_dir():
            return self._of_tree(Tree(folder.resolve()), text)
        if folder.is_dir() and (inner := _generated(folder)):
            return Version(text, self._chosen(inner), tuple(inner))
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

    def _chosen(self, folders: Mapping[str, Path]) -> dict[str, Path]:
        return {name: path for name, path in folders.items() if self.model in (None, name)}

    def _of_tree(self, tree: Tree, label: str) -> Version:
        """Return generated/ where it is up to date, and what models/ derives where it is not."""
        if not tree.models:
            generated = _generated(tree.root / "generated")
            return Version(label, self._chosen(generated), tuple(generated))
        folders = self._chosen({name: tree.root / "generated" / name for name in tree.models})
        stale = [name for name in folders if check(tree, name).stale]
        return Version(label, folders | derive(tree, stale, label), tree.models)

    def _of_revision(self, revision: Revision) -> Version:
        """Return the committed generated/, and what models/ derives where that is missing or of an older schema."""
        root = self.scratch / revision.commit
        models = revision.models()
        folders = self._chosen({name: root / "generated" / name for name in models})
        revision.extract([f"generated/{name}" for name in folders], root)
        old = [name for name, folder in folders.items() if _schema(folder) != SCHEMA]
        if old:
            revision.extract(["models"], root)
            (root / "generated").mkdir(parents=True, exist_ok=True)
            derivable = [name for name in old if name in Tree(root).models]
            folders = {name: folder for name, folder in folders.items() if name not in old}
            folders |= derive(Tree(root), derivable, revision.label)
        return Version(revision.label, folders, models)


def derive(tree: Tree, models: list[str], label: str) -> dict[str, Path]:
    """Derive models with this codegen, each in a process of its own; what was derived before is in the cache.

    Raises
    ------
    InputError
        If a model cannot be derived; the message ends with what the derivation said.
    """
    if not models:
        return {}
    with working(f"deriving {', '.join(models)} of {label}"), ThreadPoolExecutor(os.cpu_count()) as pool:
        folders = list(pool.map(lambda name: _derived(tree, name, label), models))
    return dict(zip(models, folders, strict=True))


def _derived(tree: Tree, model: str, label: str) -> Path:
    """Return what a model derives now; what it loads is known from the folder that was derived before."""
    known = {**tree.sources(model), **installed("sympy", "casadi")}
    while True:
        key = cache.key(*itertools.chain(*sorted(known.items())))
        folder = cache.entry("derived", f"{model}-{key}", lambda folder: _derive(tree, model, label, folder))
        record = read_manifest(folder)
        now = {**inputs(tree, model, record), **installed(*record.versions)}
        if now == {**record.inputs_sha256, **record.versions} or now.items() <= known.items():
            return folder
        known |= now


def _derive(tree: Tree, model: str, label: str, folder: Path) -> None:
    path = os.pathsep.join([str(_HERE), *filter(None, [os.environ.get("PYTHONPATH")])])
    process = subprocess.run(
        [sys.executable, "-P", "-m", "mehvar", "generate", model, "--out", str(folder)],
        cwd=tree.root,
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        text=True,
    )
    if process.returncode:
        reason = (process.stderr.strip() or process.stdout.strip()).splitlines()[-1:]
        raise InputError(f"{label}: {model} cannot be derived by this version of mehvar: {''.join(reason)}")


def _generated(folder: Path) -> dict[str, Path]:
    return {path.parent.name: path.parent for path in sorted(folder.glob(f"*/{_EQUATIONS}"))}


def _model_of(folder: Path) -> str:
    return str(_read(folder / _EQUATIONS).get("model", folder.name))


def _schema(folder: Path) -> object:
    path = folder / _EQUATIONS
    return _read(path).get("schema") if path.is_file() else None


def _read(path: Path) -> dict[str, object]:
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except (json.JSONDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"{path} is damaged: {error}") from None
    return data if isinstance(data, dict) else {}
