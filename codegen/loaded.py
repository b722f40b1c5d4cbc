# SPDX-License-Identifier: Apache-2.0
"""What a model loads while it is derived, beside its own folder and the tool: modules, and files that it reads."""

from __future__ import annotations

import builtins
import contextlib
import os
import sys
import sysconfig
from collections import defaultdict
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

_IMPORTS: defaultdict[str, set[str]] = defaultdict(set)
"""For each module that was executed under `tracing`, those that it imports: it is executed once in a process."""
_LIBRARIES = tuple(Path(sysconfig.get_path(name)).resolve() for name in ("stdlib", "platstdlib", "purelib", "platlib"))
_INSTALLED = {"site-packages", "dist-packages"}
"""Where libraries live, of this environment and of one below it: of these the versions count."""
_opened: set[str] | None = None


@contextlib.contextmanager
def tracing(root: Path, package: str) -> Iterator[Callable[[], dict[str, Path]]]:
    """Watch what is imported and opened; the value returns the files so far, by their path from `root`.

    Parameters
    ----------
    root : Path
        Folder with models/ and generated/. Of files that are only read, those below it count.
    package : str
        Name of the model's package, whose imports count even where they were executed before.
    """
    global _opened
    before, original = set(sys.modules), builtins.__import__

    def imported(name: str, *arguments: Any, **keywords: Any) -> Any:
        module = original(name, *arguments, **keywords)
        importer = (arguments[0] or {}).get("__name__", "") if arguments else ""
        _IMPORTS[importer] |= _names(module, name, *arguments[2:4])
        return module

    _hook()
    builtins.__import__, _opened = imported, set()
    opened = _opened
    try:
        yield lambda: _files(root, (set(sys.modules) - before) | _closure(package), opened)
    finally:
        builtins.__import__, _opened = original, None


def _names(module: Any, name: str, wanted: Any = None, level: int = 0) -> set[str]:
    """Return the modules that an import statement names."""
    base = getattr(module, "__name__", name)
    whole = {base} if level or wanted else {name, base}
    return whole | {f"{base}.{part}" for part in wanted or ()}


def _closure(package: str) -> set[str]:
    """Return the modules that a package needs, directly or not."""
    stack = [name for name in _IMPORTS if name == package or name.startswith(f"{package}.")]
    seen: set[str] = set()
    while stack:
        name = stack.pop()
        if name not in seen:
            seen.add(name)
            stack += _IMPORTS.get(name, ())
    return seen


def _files(root: Path, modules: set[str], opened: set[str]) -> dict[str, Path]:
    sources = (getattr(sys.modules.get(name), "__file__", None) for name in modules)
    code = {Path(file).resolve() for file in sources if file and file.endswith(".py")}
    data = {path for path in (Path(name).resolve() for name in opened) if path.is_relative_to(root.resolve())}
    ours = Path(__file__).resolve().parents[1]
    files = {path for path in code | data if path.is_file() and not _is_library(path)}
    return {
        Path(os.path.relpath(path, root.resolve())).as_posix(): path
        for path in sorted(files)
        if not _is_ours(path, ours) and not _is_written(path, root.resolve())
    }


def _is_library(path: Path) -> bool:
    return any(path.is_relative_to(folder) for folder in _LIBRARIES) or not _INSTALLED.isdisjoint(path.parts)


def _is_ours(path: Path, ours: Path) -> bool:
    """Whether a file is of this program, whose files are inputs by rule."""
    rooms = ("mehvar", "codegen", "runtime", "models", "generated", "tests")
    return path.is_relative_to(ours) and path.relative_to(ours).parts[0] in rooms


def _is_written(path: Path, root: Path) -> bool:
    """Whether a file is one that generation or Python writes."""
    inner = path.relative_to(root).parts if path.is_relative_to(root) else ()
    return bool(inner) and (inner[0] == "generated" or "__pycache__" in inner or inner[0].startswith("."))


def _hook() -> None:
    """Note what is opened for reading; such a hook stays until the process ends, so that there is only one."""
    if _hook.__dict__.setdefault("placed", False):
        return
    _hook.__dict__["placed"] = True

    def note(event: str, arguments: tuple[Any, ...]) -> None:
        if event == "open" and _opened is not None and isinstance(arguments[0], str):
            _opened.add(arguments[0])

    sys.addaudithook(note)
