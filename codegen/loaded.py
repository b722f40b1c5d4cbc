# SPDX-License-Identifier: Apache-2.0
"""Inputs of a derivation besides the model's folder and mehvar: modules, files, requests."""

from __future__ import annotations

import builtins
import contextlib
import os
import re
import sys
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

from mehvar.base.versions import installed

from .watch import is_copy, is_library, is_ours, is_written, watching

if TYPE_CHECKING:
    from importlib.metadata import Distribution

_IMPORTS: defaultdict[str, set[str]] = defaultdict(set)
"""Imports of each module that `tracing` executed; a process executes each module once."""


@dataclass(frozen=True)
class Trace:
    """Recorded inputs of a derivation.

    Attributes
    ----------
    files : callable
        Returns the files by their path from the root.
    libraries : callable
        Returns the versions of the distributions that the model's code imports.
    answers : callable
        Returns digests of the requests of the model's code, except for existing files; see `watch.answer`.
    """

    files: Callable[[], dict[str, Path]]
    libraries: Callable[[], dict[str, str]]
    answers: Callable[[], dict[str, str]]


@contextlib.contextmanager
def tracing(root: Path, package: str) -> Iterator[Trace]:
    """Record imports and opened files.

    Modules of libraries keep Python's own import statement, because a derivation executes 80 000 of them in SymPy.

    Parameters
    ----------
    root : Path
        Folder with models/ and generated/. Data files count if they are below it or if code below it opens them.
    package : str
        Name of the model's package, whose imports count even if they were executed before.
    """
    before, plain = set(sys.modules), SourceFileLoader.exec_module

    def execute(loader: SourceFileLoader, module: ModuleType) -> None:
        if not is_library(Path(loader.path).resolve()):
            vars(module)["__builtins__"] = {**vars(builtins), "__import__": _recording_import}
        plain(loader, module)

    SourceFileLoader.exec_module = execute  # type: ignore[method-assign, assignment]
    try:
        with watching(root) as requests:
            yield Trace(
                lambda: _files(root, (set(sys.modules) - before) | _closure(package), requests.opened),
                lambda: _libraries(root, _closure(package)),
                requests.answers,
            )
    finally:
        SourceFileLoader.exec_module = plain  # type: ignore[method-assign]


def _recording_import(
    name: str, globals: Any = None, locals: Any = None, fromlist: Sequence[str] | None = (), level: int = 0
) -> Any:
    """Import a module, and record its name for the importing one."""
    module = builtins.__import__(name, globals, locals, fromlist, level)
    _IMPORTS[globals.get("__name__", "") if globals else ""] |= _names(module, name, fromlist, level)
    return module


def _names(module: Any, name: str, wanted: Any = None, level: int = 0) -> set[str]:
    """Return the modules that an import statement names."""
    base = getattr(module, "__name__", name)
    whole = {base} if level or wanted else {name, base}
    return whole | {f"{base}.{part}" for part in wanted or ()}


def _closure(package: str) -> set[str]:
    """Return the modules that a package needs, directly or indirectly."""
    stack = [name for name in _IMPORTS if name == package or name.startswith(f"{package}.")]
    seen: set[str] = set()
    while stack:
        name = stack.pop()
        if name not in seen:
            seen.add(name)
            stack += _IMPORTS.get(name, ())
    return seen


def _files(root: Path, modules: set[str], opened: set[str]) -> dict[str, Path]:
    root, sources = root.resolve(), (getattr(sys.modules.get(name), "__file__", None) for name in modules)
    code = {Path(file) for file in sources if file and file.endswith(".py")}
    named = (path if path.is_relative_to(root) else path.resolve() for path in {*code, *map(Path, opened)})
    return {
        Path(os.path.relpath(path, root)).as_posix(): path
        for path in sorted(named)  # links by their own names, as they may lead elsewhere later
        if path.is_file() and not (is_library(path) or is_ours(path) or is_written(path, root))
    }


def _libraries(root: Path, modules: set[str]) -> dict[str, str]:
    """Return the distributions that modules below `root` import, except copies of mehvar and its own modules."""
    root, named = root.resolve(), set()
    for name in modules:
        file = getattr(sys.modules.get(name), "__file__", None)
        path = Path(file).resolve() if file else None
        if path is None or is_library(path) or not path.is_relative_to(root):
            continue
        if not is_copy(path, root):
            named |= {imported.partition(".")[0] for imported in _IMPORTS.get(name, ())}
    named -= {*sys.stdlib_module_names, "mehvar"}
    return installed(*sorted(_owners(named) if named else ()))


def _owners(modules: set[str]) -> set[str]:
    """Return the distributions that provide one of the given top-level modules.

    `importlib.metadata.packages_distributions` is not used, because it takes a second for 60 000 installed files.
    """
    from importlib.metadata import distributions

    # one pattern a module, each with a fixed beginning: alternatives take seven times as long to search
    tops = [re.compile(rf"\n{re.escape(module)}(?:/[^,\n]*)?\.py,") for module in modules]

    def has(distribution: Distribution) -> bool:
        if listed := distribution.read_text("top_level.txt"):
            return not modules.isdisjoint(listed.split())
        record = distribution.read_text("RECORD") or "".join(f"{file},\n" for file in distribution.files or ())
        return any(top.search(f"\n{record}") for top in tops)

    return {distribution.name for distribution in distributions() if has(distribution)}
