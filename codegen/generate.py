# SPDX-License-Identifier: Apache-2.0
"""Write generated/MODEL/ when its sources have changed, whole or not at all; tell what is stale.

Deriving needs SymPy and CasADi; finding out that nothing has changed needs neither.
"""

from __future__ import annotations

import hashlib
import importlib
import json
import sys
import tempfile
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from models.system import System

_TOOL = Path(__file__).parent
_COMPARING = _TOOL / "diff"
"""Reads generated text and writes none."""


class GenerateError(ValueError):
    """A model that cannot be generated as asked."""


@dataclass(frozen=True)
class Report:
    """What became of one model.

    Attributes
    ----------
    model : str
        Its name.
    written : tuple of str
        Files that were written, or that would be.
    reasons : tuple of str
        Why: sources that changed, files that are missing or were edited.
    """

    model: str
    written: tuple[str, ...] = ()
    reasons: tuple[str, ...] = ()

    @property
    def stale(self) -> bool:
        """Whether anything differed from the sources."""
        return bool(self.reasons)


@dataclass(frozen=True)
class Tree:
    """Where models are read from and generated text is written to.

    Attributes
    ----------
    root : Path
        Folder with models/ and generated/.
    """

    root: Path

    @property
    def models(self) -> tuple[str, ...]:
        """Names of the models in this tree."""
        found = (self.root / "models").glob("*/__init__.py")
        return tuple(sorted(path.parent.name for path in found))

    def sources(self, model: str) -> dict[str, str]:
        """Return the SHA-256 of each file that the model's generated text depends on."""
        shared = (self.root / "models").glob("*.py")
        own = (p for p in (self.root / "models" / model).rglob("*") if p.suffix in (".py", ".toml"))
        tool = (p for p in _TOOL.rglob("*") if p.suffix in (".py", ".j2") and _COMPARING not in p.parents)
        names = {p: p.relative_to(self.root).as_posix() for p in (*shared, *own)}
        names |= {p: "codegen/" + p.relative_to(_TOOL).as_posix() for p in tool}
        return {name: _sha256(path) for path, name in sorted(names.items(), key=lambda item: item[1])}


def find_tree(start: Path) -> Tree | None:
    """Return the nearest folder at or above `start` that has models/ and generated/."""
    for folder in (start, *start.parents):
        if (folder / "models" / "system.py").is_file() and (folder / "generated").is_dir():
            return Tree(folder)
    return None


def installed_tree() -> Tree:
    """Return the tree that this package was installed with."""
    return Tree(_TOOL.parent)


def check(tree: Tree, model: str) -> Report:
    """Compare generated/MODEL with its sources, without deriving anything."""
    folder = tree.root / "generated" / model
    reasons = _reasons(tree, model, folder)
    names = sorted(_texts_of(model)) if reasons else []
    return Report(model, tuple(names), reasons)


def generate(
    tree: Tree,
    model: str,
    out: Path | None = None,
    structure: Mapping[str, str] | None = None,
    casadi: bool = False,
) -> Report:
    """Derive a model and write its texts, unless they are up to date.

    Parameters
    ----------
    tree : Tree
        Where the model lives.
    model : str
        Its name.
    out : Path, optional
        Folder to write instead of generated/MODEL.
    structure : mapping, optional
        Structural choices that differ from the defaults.
    casadi : bool
        Write CasADi's own C too, for tools that expect its calling convention.

    Raises
    ------
    GenerateError
        If the model or a structural choice is not known.
    OSError
        If the folder cannot be written; what was there stays whole.
    """
    folder = out or tree.root / "generated" / model
    chosen = dict(structure or {})
    reasons = _reasons(tree, model, folder, chosen, casadi)
    if not reasons:
        return Report(model)
    texts = derive(tree, model, chosen, casadi)
    write(folder, texts)
    return Report(model, tuple(texts), reasons)


def derive(tree: Tree, model: str, structure: Mapping[str, str] | None = None, casadi: bool = False) -> dict[str, str]:
    """Derive a model and return every text of its generated folder, manifest last.

    Raises
    ------
    GenerateError
        If the model or a structural choice is not known.
    VerificationError
        If the form that is evaluated is not the one that was derived.
    """
    sources = tree.sources(model)
    system = system_of(tree, model, structure or {})
    from codegen.equations import equations_json
    from codegen.functions import generate_functions
    from codegen.manifest import manifest
    from codegen.page import equations_markdown
    from codegen.texts import printed, texts
    from codegen.verify import verify

    verify(system)
    graphs = generate_functions(system)
    functions = printed(graphs)
    written = texts(system, functions)
    written["equations.json"] = equations_json(system)
    written["equations.md"] = equations_markdown(system)
    if casadi:
        from codegen.casadi_c import casadi_c

        written |= casadi_c(system.name, graphs)
    hashes = {name: hashlib.sha256(text.encode()).hexdigest() for name, text in written.items()}
    written["manifest.json"] = manifest(system, functions, sources, hashes)
    return written


def load_model(tree: Tree, model: str) -> ModuleType:
    """Import a model's package from the tree it lives in.

    Raises
    ------
    GenerateError
        If there is no such model, or this process has imported another tree's models before.
    """
    if model not in tree.models:
        raise GenerateError(f"model {model!r} is not known in {tree.root / 'models'}; known: {', '.join(tree.models)}")
    if str(tree.root) not in sys.path:
        sys.path.insert(0, str(tree.root))
    package = importlib.import_module(f"models.{model}")
    if not Path(package.__file__ or "").is_relative_to(tree.root):
        raise GenerateError(
            f"models is already imported from {Path(package.__file__ or '').parents[2]}; use a new process"
        )
    return package


def system_of(tree: Tree, model: str, structure: Mapping[str, str]) -> System:
    """Derive a model and check it, without writing anything.

    Raises
    ------
    GenerateError
        If the model or a structural choice is not known.
    ModelError
        If the model's text is wrong.
    """
    package = load_model(tree, model)
    choices: Mapping[str, tuple[str, ...]] = package.STRUCTURE
    for name, value in structure.items():
        if name not in choices:
            raise GenerateError(f"{model} has no structure {name!r}; it has: {', '.join(choices) or 'none'}")
        if value not in choices[name]:
            raise GenerateError(f"structure {name} = {value!r} is not one of {', '.join(choices[name])}")
    from models.check import check as check_system
    from models.check import no_branching

    with no_branching():
        system: System = package.system(**structure)
    check_system(system)
    return system


def _reasons(
    tree: Tree, model: str, folder: Path, structure: Mapping[str, str] | None = None, casadi: bool = False
) -> tuple[str, ...]:
    """Say why a generated folder does not match its sources; empty when it does."""
    path = folder / "manifest.json"
    if not path.is_file():
        return (f"{path} is missing",)
    try:
        recorded = json.loads(path.read_text(encoding="utf-8"))
        before, files = recorded["inputs_sha256"], recorded["files_sha256"]
        was = recorded["structure"]
    except (json.JSONDecodeError, KeyError, TypeError, UnicodeDecodeError):
        return (f"{path} is damaged",)
    reasons = [f"{name} {change}" for name, change in _changes(before, tree.sources(model))]
    reasons += [f"structure {k} was {was.get(k)!r}" for k, v in (structure or {}).items() if was.get(k) != v]
    if casadi and f"{model}_casadi.c" not in files:
        reasons.append(f"{model}_casadi.c was not asked for before")
    for name, digest in files.items():
        if not (folder / name).is_file():
            reasons.append(f"{name} is missing")
        elif _sha256(folder / name) != digest:
            reasons.append(f"{name} was edited by hand")
    return tuple(reasons)


def _changes(before: Mapping[str, str], now: Mapping[str, str]) -> Iterable[tuple[str, str]]:
    for name in sorted({*before, *now}):
        if name not in before:
            yield name, "is new"
        elif name not in now:
            yield name, "is gone"
        elif before[name] != now[name]:
            yield name, "changed"


def _texts_of(model: str) -> list[str]:
    return [
        f"{model}.c",
        f"{model}_jac.c",
        f"{model}.h",
        f"{model}.py",
        "equations.json",
        "equations.md",
        "manifest.json",
    ]


def write(folder: Path, texts: Mapping[str, str]) -> None:
    """Write all files under temporary names, then rename them, the manifest last: what is half done shows as stale."""
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=".writing-", dir=folder) as scratch:
        for name, text in texts.items():
            (Path(scratch) / name).write_text(text, encoding="utf-8", newline="\n")
        for name in texts:
            (Path(scratch) / name).replace(folder / name)


def _sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()
