# SPDX-License-Identifier: Apache-2.0
"""Locations of models: a checkout of mehvar, the installed package, or a user's project."""

from __future__ import annotations

import contextlib
import hashlib
import importlib
import importlib.util
import re
import sys
import tomllib
import traceback
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import ModuleType

from mehvar.base import errors
from mehvar.base.errors import MehvarError, unknown_name
from mehvar.base.manifest import FILE
from mehvar.base.schema import parse_toml
from mehvar.base.versions import project_root

_TOOL = Path(__file__).resolve().parent
_SHARED = tuple(Path(errors.__file__).with_name(f"{name}.py") for name in ("constants", "manifest", "names", "schema"))
"""Sources outside of `codegen` and `models` that affect generated code: identifiers and the manifest's schema."""
_COMPARING = re.compile(
    r"codegen/(diff|equal|ledger)/|codegen/equations/(document|mathml)\.py|models/(paper|notation)\.py"
)
"""Modules for comparisons, which do not affect generated code."""


PLANT = "plant.toml"
"""File in the folder of a user's law that names its plant."""
ROOMS = frozenset(("arrays", "check", "estimation", "forms", "parts"))
"""Folders below models/ that belong to the vocabulary."""


class GenerateError(MehvarError, ValueError):
    """Error for an unknown model or choice."""


@dataclass(frozen=True)
class Tree:
    """Folder with models and generated files.

    Attributes
    ----------
    root : Path
        Folder with models/ and generated/, and with papers/ if there are ledgers.
    """

    root: Path

    @property
    def has_vocabulary(self) -> bool:
        """True for a checkout of mehvar; other trees use the installed vocabulary."""
        return (self.root / "models" / "system.py").is_file()

    @property
    def models(self) -> tuple[str, ...]:
        """Names of the models of this tree."""
        names = {path.parent.name for path in (self.root / "models").glob("*/__init__.py")}
        return tuple(sorted(names - ROOMS if self.has_vocabulary else names))

    @property
    def papers(self) -> tuple[str, ...]:
        """Names of the models whose paper has a folder in this tree."""
        return tuple(sorted(path.parent.name for path in (self.root / "papers").glob("*/__init__.py")))

    @property
    def orphans(self) -> dict[str, str]:
        """Generated folders without a model, and models without `__init__.py`, each with the missing path."""
        models, rooms = self.root / "models", ROOMS if self.has_vocabulary else ()
        marks = (*models.glob("*/system.py"), *models.glob("*/parameters.toml"))
        names = {path.parent.name for path in (*marks, *(self.root / "generated").glob(f"*/{FILE}"))}
        return {
            name: f"{models / name / '__init__.py' if (models / name).is_dir() else models / name} is missing"
            for name in sorted(names - {*self.models, *rooms})
        }

    def plant(self, model: str) -> tuple[Tree, str] | None:
        """Return tree and name of the plant of a user's law; None for a complete system.

        Raises
        ------
        GenerateError
            If plant.toml names no plant.
        """
        file = self.root / "models" / model / PLANT
        if not file.is_file():
            return None
        try:
            name = parse_toml(file.read_text(encoding="utf-8-sig"))["plant"]
        except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError, KeyError) as error:
            raise GenerateError(f'{file}: must be one line, plant = "MODEL": {error}') from error
        own = {name: self for name in self.models if not (self.root / "models" / name / PLANT).is_file()}
        shipped = {name: installed_tree() for name in installed_tree().models}
        plants = {**shipped, **own}
        if not isinstance(name, str) or name not in plants:
            raise GenerateError(str(unknown_name("plant", name, plants, str(file))))
        return plants[name], name

    def sources(self, model: str, papers: bool = False) -> dict[str, str]:
        """Return the SHA-256 of each file on which the model's generated files depend.

        Parameters
        ----------
        model : str
            Its name.
        papers : bool
            Include the files on which the verdicts on its paper depend.
        """
        vocabulary = (self.root if self.has_vocabulary else _TOOL.parent) / "models"
        own = _texts(self.root / "models" / model) + (_texts(self.root / "papers" / model) if papers else [])
        plant = self.plant(model)
        under = [] if plant is None else _texts(plant[0].root / "models" / plant[1])
        tool = (p for p in _TOOL.rglob("*") if p.suffix in (".py", ".j2"))
        ours = (*vocabulary.glob("*.py"), *(path for room in ROOMS for path in (vocabulary / room).rglob("*.py")))
        names = {p: "models/" + p.relative_to(vocabulary).as_posix() for p in ours}
        names |= {p: p.relative_to(self.root).as_posix() for p in own}
        names |= {p: p.relative_to(plant[0].root).as_posix() for p in under if plant}
        names |= {p: "codegen/" + p.relative_to(_TOOL).as_posix() for p in tool}
        names |= {p: "mehvar/base/" + p.name for p in _SHARED}
        names = {p: name for p, name in names.items() if papers or not _COMPARING.match(name)}
        return {name: sha256(path) for path, name in sorted(names.items(), key=lambda item: item[1])}


def _texts(folder: Path) -> list[Path]:
    return [path for path in folder.rglob("*") if path.suffix in (".py", ".toml") and path.is_file()]


def find_tree(start: Path) -> Tree | None:
    """Return the project at or above `start`."""
    root = project_root(start)
    return None if root is None else Tree(root)


def installed_tree() -> Tree:
    """Return the tree of the installed package."""
    return Tree(_TOOL.parent)


def load_model(tree: Tree, model: str) -> ModuleType:
    """Import a model's package from its tree.

    Raises
    ------
    GenerateError
        If there is no such model, or this process has already imported models of another tree.
    """
    if model not in tree.models:
        raise GenerateError(f"model {model!r} is not known in {tree.root / 'models'}; known: {', '.join(tree.models)}")
    folder = tree.root / "models" / model
    if not tree.has_vocabulary:
        with own_text(folder):
            package = _load_by_path(folder, _name_of(folder))
        vars(package).setdefault("STRUCTURE", {})  # a model without choices may leave it out
        return package
    prefer_vocabulary(tree)
    with own_text(folder):
        package = importlib.import_module(f"mehvar.models.{model}")
    if not Path(package.__file__ or "").resolve().is_relative_to(tree.root.resolve()):
        raise GenerateError(
            f"mehvar.models is already imported from {Path(package.__file__ or '').parents[2]}; start a new process"
        )
    return package


def load_paper(tree: Tree, model: str, part: str) -> ModuleType:
    """Import a part of the folder papers/MODEL of a tree, as papers.MODEL.PART.

    Raises
    ------
    GenerateError
        If this process has already imported a folder of another tree under that name.
    ModelError
        If its code has an error.
    """
    folder, name = tree.root / "papers" / model, f"papers.{model}"
    with own_text(folder):
        package = _load_by_path(folder, name)
        if not Path(package.__file__ or "").resolve().is_relative_to(folder.resolve()):
            raise GenerateError(f"{name} is already imported from {package.__file__}; start a new process")
        return importlib.import_module(f"{name}.{part}")


@contextlib.contextmanager
def own_text(folder: Path) -> Iterator[None]:
    """Convert an exception in a model's code into one line with its last location in the folder and the error.

    Raises
    ------
    ModelError
        With the exception as its cause.
    """
    try:
        yield
    except MehvarError:
        raise
    except (Exception, SystemExit) as error:
        from mehvar.models.quantities import ModelError, place

        file, line = _last_place(error, folder)
        raise ModelError(f"{place(file, line)}: {_one_line(error, folder)}") from error


def _last_place(error: BaseException, folder: Path) -> tuple[str, int]:
    if isinstance(error, SyntaxError) and error.filename:
        return error.filename, error.lineno or 1
    frames = traceback.extract_tb(error.__traceback__)
    inside = [frame for frame in frames if Path(frame.filename).resolve().is_relative_to(folder.resolve())]
    return (inside[-1].filename, inside[-1].lineno or 1) if inside else (str(folder / "__init__.py"), 1)


def _one_line(error: BaseException, folder: Path) -> str:
    """Return the error on one line; a missing module of the model is shown as a file."""
    package = _name_of(folder)
    if isinstance(error, ModuleNotFoundError) and error.name:
        for own in (f"{package}.", f"mehvar.models.{folder.name}.", f"papers.{folder.name}."):
            if error.name.startswith(own):
                file = folder.joinpath(*error.name.removeprefix(own).split(".")).with_suffix(".py")
                return f"imports {file}, which does not exist"
    notes = (f". {note}" for note in getattr(error, "__notes__", ()))
    text = " ".join("".join((str(error), *notes)).split()).replace(package, folder.name)
    return f"{type(error).__name__}: {text}" if text else type(error).__name__


def package_name(tree: Tree, model: str) -> str:
    """Return the import name of a model's package."""
    return f"mehvar.models.{model}" if tree.has_vocabulary else _name_of(tree.root / "models" / model)


def _name_of(folder: Path) -> str:
    return f"mehvar_own_{hashlib.sha256(str(folder).encode()).hexdigest()[:12]}_{folder.name}"


def prefer_vocabulary(tree: Tree) -> None:
    """Make another checkout's vocabulary importable as mehvar.models, unless mehvar's own is already imported."""
    if tree.has_vocabulary and tree != installed_tree() and "mehvar.models" not in sys.modules:
        sys.meta_path.insert(0, _Vocabulary(tree.root / "models"))


_SHARED_NAMES = ("cache", "constants", "errors", "manifest", "names", "schema", "units", "versions")
_MOVED = {
    "mehvar.notebook": "mehvar.base",
    "mehvar.notebook.display": "mehvar.base.display",
    **{f"mehvar.{name}": f"mehvar.base.{name}" for name in _SHARED_NAMES},
}
"""Modules by their former names, which older vocabularies import."""


class _Vocabulary(MetaPathFinder, Loader):
    """Importer of mehvar.models from another checkout, with names that older checkouts use."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def find_spec(self, fullname: str, *_: object) -> ModuleSpec | None:
        if fullname == "mehvar.models":
            file = self.folder / "__init__.py"
            return importlib.util.spec_from_file_location(fullname, file, submodule_search_locations=[str(self.folder)])
        if fullname.split(".")[0] == "models" or fullname in _MOVED:
            return ModuleSpec(fullname, self)
        return None

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        module = importlib.import_module(_MOVED.get(spec.name, f"mehvar.{spec.name}"))
        spec.loader_state = module.__spec__
        return module

    def exec_module(self, module: ModuleType) -> None:
        """Restore the specification of a module that was executed under its own name."""
        assert module.__spec__ is not None
        module.__spec__ = module.__spec__.loader_state


def _load_by_path(folder: Path, name: str) -> ModuleType:
    """Import a folder under any module name."""
    if name in sys.modules:
        return sys.modules[name]
    spec = importlib.util.spec_from_file_location(
        name, folder / "__init__.py", submodule_search_locations=[str(folder)]
    )
    if spec is None or spec.loader is None or not (folder / "__init__.py").is_file():
        raise GenerateError(f"{folder} lacks __init__.py")
    package = sys.modules[name] = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(package)
    except BaseException:
        del sys.modules[name]
        raise
    return package


def sha256(path: Path) -> str:
    """Return the SHA-256 of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()
