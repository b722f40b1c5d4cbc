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
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import Any

from mehvar.versions import installed

_IMPORTS: defaultdict[str, set[str]] = defaultdict(set)
"""For each module that was executed under `tracing`, those that it imports: it is executed once in a process."""
_LIBRARIES = tuple(Path(sysconfig.get_path(name)).resolve() for name in ("stdlib", "platstdlib", "purelib", "platlib"))
_INSTALLED = {"site-packages", "dist-packages"}
"""Where libraries live, of this environment and of one below it: of these the versions count."""
_SYSTEM = ("/proc/", "/dev/", "/sys/")
"""What the system answers, which is no input."""
_opened: set[str] | None = None
_root = ""


@dataclass(frozen=True)
class Trace:
    """What has been loaded so far.

    Attributes
    ----------
    files : callable
        The files, by their path from the root.
    libraries : callable
        The versions of the distributions that the model's own texts import, by name.
    """

    files: Callable[[], dict[str, Path]]
    libraries: Callable[[], dict[str, str]]


@contextlib.contextmanager
def tracing(root: Path, package: str) -> Iterator[Trace]:
    """Watch what is imported and opened.

    Parameters
    ----------
    root : Path
        Folder with models/ and generated/. Of files that are only read, those below it count, and those elsewhere that
        a text below it opens.
    package : str
        Name of the model's package, whose imports count even where they were executed before.
    """
    global _opened, _root
    before, original = set(sys.modules), builtins.__import__

    def imported(name: str, *arguments: Any, **keywords: Any) -> Any:
        module = original(name, *arguments, **keywords)
        importer = (arguments[0] or {}).get("__name__", "") if arguments else ""
        _IMPORTS[importer] |= _names(module, name, *arguments[2:4])
        return module

    _hook()
    builtins.__import__, _opened, _root = imported, set(), f"{root.resolve()}{os.sep}"
    opened = _opened
    try:
        yield Trace(
            lambda: _files(root, (set(sys.modules) - before) | _closure(package), opened),
            lambda: _libraries(root, _closure(package)),
        )
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
    data = {Path(name).resolve() for name in opened}
    ours = Path(__file__).resolve().parents[1]
    files = {path for path in code | data if path.is_file() and not _is_library(path)}
    return {
        Path(os.path.relpath(path, root.resolve())).as_posix(): path
        for path in sorted(files)
        if not _is_ours(path, ours) and not _is_written(path, root.resolve())
    }


def _libraries(root: Path, modules: set[str]) -> dict[str, str]:
    """Return the distributions that modules below `root`, this program's own and copies aside, import by name."""
    from importlib.metadata import packages_distributions

    root, ours, named = root.resolve(), Path(__file__).resolve().parents[1], set()
    for name in modules:
        file = getattr(sys.modules.get(name), "__file__", None)
        path = Path(file).resolve() if file else None
        if path is None or _is_library(path) or not path.is_relative_to(root):
            continue
        counterpart = ours / path.relative_to(root)
        if not (_is_ours(counterpart, ours) and counterpart.is_file()):
            named |= {imported.partition(".")[0] for imported in _IMPORTS.get(name, ())}
    named -= {*sys.stdlib_module_names, "mehvar"}
    distributions = packages_distributions() if named else {}
    return installed(*sorted({owner for name in named for owner in distributions.get(name, ())}))


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
            name = os.path.abspath(arguments[0])  # noqa: PTH100, called for each file that is opened
            if name.startswith(_root) or (not name.startswith(_SYSTEM) and _is_read_below(_root)):
                _opened.add(name)

    sys.addaudithook(note)


def _is_read_below(root: str) -> bool:
    """Whether a text below `root`, this program's own aside, is what opens a file now, itself or through a library."""
    ours = Path(__file__).resolve().parents[1]
    frame: FrameType | None = sys._getframe(2)
    while frame is not None:
        file = frame.f_code.co_filename
        if file.startswith("<frozen importlib"):  # an import, whose file is a module's
            return False
        if file.startswith(root) and not (_is_ours(Path(file), ours) or _is_library(Path(file))):
            return True
        frame = frame.f_back
    return False
