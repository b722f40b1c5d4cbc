# SPDX-License-Identifier: Apache-2.0
"""Record of files, folders and variables that a model's code reads during derivation.

The record has opened files, missing files, listed folders and environment variables; if one of them changes, the
model is stale. Programs and network connections are refused, because later changes of their answers would stay
unnoticed.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import os
import sys
import sysconfig
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from types import FrameType
from typing import Any

ABSENT = ""
"""Digest of a missing file or variable."""
_VARIABLE = "environment:"
_SYSTEM = ("/proc/", "/dev/", "/sys/")
"""Folders of the operating system, which do not count as inputs."""
_REFUSED = {
    **dict.fromkeys(
        ("subprocess.Popen", "os.system", "os.exec", "os.posix_spawn", "os.fork"), "the model starts a program"
    ),
    **dict.fromkeys(("socket.connect", "socket.getaddrinfo"), "the model contacts another machine"),
}
_OPENING, _LISTING = ("open", "sqlite3.connect"), ("os.listdir", "os.scandir")
_EVENTS = frozenset((*_OPENING, *_LISTING, *_REFUSED))
"""Audited events that count; a derivation causes 50 000 others."""
_LIBRARIES = tuple(Path(sysconfig.get_path(name)).resolve() for name in ("stdlib", "platstdlib", "purelib", "platlib"))
_INSTALLED = {"site-packages", "dist-packages"}
"""Folders of installed libraries, of which only the versions count as inputs."""


@dataclass(frozen=True)
class Requests:
    """Recorded requests: absolute paths and names of variables.

    Attributes
    ----------
    root : str
        Folder with models/ and generated/, with a separator at its end.
    callers : frozenset of frames
        Frames that run the derivation, whose requests are mehvar's and not the model's.
    opened, sought, listed, variables : set of str
        Files possibly read, files that the model's code requested, folders that it listed, and variables that it read.
    """

    root: str
    callers: frozenset[FrameType]
    opened: set[str] = field(default_factory=set)
    sought: set[str] = field(default_factory=set)
    listed: set[str] = field(default_factory=set)
    variables: set[str] = field(default_factory=set)

    def note(self, name: str) -> None:
        """Record a file that the model's code requests."""
        if not name.startswith(_SYSTEM):
            self.opened.add(name)
            self.sought.add(name)

    def answers(self) -> dict[str, str]:
        """Return the current digests of the requests, by names as in `answer`, without existing files."""
        root = Path(self.root)
        folders = {f"{_relative(root, name)}/" for name in self.listed if not os.path.isfile(name)}  # noqa: PTH113
        missing = {_relative(root, name) for name in self.sought if not os.path.exists(name)}  # noqa: PTH110
        names = folders | missing | {f"{_VARIABLE}{name}" for name in self.variables}
        return {name: answer(root, name) or ABSENT for name in sorted(names) if not is_written(root / name, root)}


OURS = Path(__file__).resolve().parents[1]
_requests: Requests | None = None


def answer(root: Path, name: str) -> str | None:
    """Return the current digest of a file, of a folder's list of names, or of a variable.

    Parameters
    ----------
    root : Path
        Folder that relative paths start from.
    name : str
        A path, which for a folder ends with a slash, or `environment:` and the name of a variable.
    """
    if name.startswith(_VARIABLE):
        value = os.environ.get(name.removeprefix(_VARIABLE))
        return None if value is None else hashlib.sha256(value.encode()).hexdigest()
    path = root / name
    if name.endswith("/"):
        return _listing(path) if path.is_dir() else None
    if path.is_dir():  # where the model found nothing
        return _listing(path)
    return hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else None


def _listing(folder: Path) -> str:
    """Return the digest of a folder's list of names, except those that Python and generation write."""
    names = sorted(path.name for path in folder.iterdir() if path.name not in ("__pycache__", "generated"))
    return hashlib.sha256("\n".join(names).encode()).hexdigest()


def _relative(root: Path, name: str) -> str:
    """Return a path from the root; a link that leads nowhere keeps its own name, as it may lead elsewhere later."""
    path = Path(name)
    whole = path.parent.resolve() / path.name if path.is_symlink() and not path.exists() else path.resolve()
    return Path(os.path.relpath(whole, root)).as_posix()


@contextlib.contextmanager
def watching(root: Path) -> Iterator[Requests]:
    """Record the requests of code below a folder, except mehvar's own.

    Raises
    ------
    ModelError
        Inside the context, when such code starts a program or opens a network connection.
    """
    global _requests
    _hook()
    stat, variable = os.stat, type(os.environ).__getitem__
    _requests = Requests(f"{root.resolve()}{os.sep}", frozenset(_stack()))
    os.stat, type(os.environ).__getitem__ = _noting_files(stat), _noting_variables(variable)  # type: ignore[method-assign]
    try:
        yield _requests
    finally:
        os.stat, type(os.environ).__getitem__ = stat, variable  # type: ignore[method-assign]
        _requests = None


def _stack() -> Iterator[FrameType]:
    frame: FrameType | None = sys._getframe(1)
    while frame is not None:
        yield frame
        frame = frame.f_back


def _noting_files(stat: Callable[..., os.stat_result]) -> Callable[..., os.stat_result]:
    """Return a replacement for `os.stat` that records paths, because tests for existence call it."""

    def noting(path: Any, *arguments: Any, **keywords: Any) -> os.stat_result:
        if _requests is not None and isinstance(path, str | os.PathLike) and _reader(_requests):
            _requests.note(_absolute(path))
        return stat(path, *arguments, **keywords)

    return noting


def _noting_variables(get: Callable[[Any, str], str]) -> Callable[[Any, str], str]:
    def noting(environment: Any, name: str) -> str:
        if _requests is not None and _reader(_requests):
            _requests.variables.add(name)
        return get(environment, name)

    return noting


def _hook() -> None:
    """Install the audit hook once; it stays until the process ends."""
    if not _hook.__dict__.setdefault("placed", False):
        _hook.__dict__["placed"] = True
        sys.addaudithook(_note)


def _note(event: str, arguments: tuple[Any, ...]) -> None:
    """Record what the model's code opens and lists; refuse programs and network, whose results may change."""
    if _requests is None or event not in _EVENTS:
        return
    if name := opened_file(event, arguments):
        if name.startswith(_requests.root):
            _requests.opened.add(name)
        if _reader(_requests):
            _requests.note(name)
    elif event in _LISTING and not isinstance(arguments[0], int | bytes):
        name = _absolute(arguments[0] or ".")
        if not name.startswith(_SYSTEM) and _reader(_requests):
            _requests.listed.add(name)
    elif event in _REFUSED and (frame := _reader(_requests)):
        from mehvar.models.quantities import ModelError, place

        raise ModelError(
            f"{place(frame.f_code.co_filename, frame.f_lineno)}: {_REFUSED[event]}, whose result may "
            "change: store the result in a file in the model's folder"
        )


def opened_file(event: str, arguments: tuple[Any, ...]) -> str:
    """Return the absolute path of the file that an audited event opens, also as a database; empty for others."""
    if event not in _OPENING or not isinstance(arguments[0], str | os.PathLike):
        return ""
    name = os.fsdecode(arguments[0])
    if event == "sqlite3.connect":
        name = name.removeprefix("file:").partition("?")[0]
    return "" if name in ("", ":memory:") else _absolute(name)


def _absolute(name: str | os.PathLike[str]) -> str:
    return os.path.abspath(name)  # noqa: PTH100, called for each file that is opened


def _reader(requests: Requests) -> FrameType | None:
    """Return the frame of a model's code behind the current request, directly or through a library."""
    root = requests.root
    for frame in _stack():
        file = frame.f_code.co_filename
        if frame in requests.callers:
            return None
        if file.startswith("<frozen importlib"):  # an import, whose file belongs to a module
            return None
        if file.startswith(root) and _is_of_model(file, root):
            return frame
    return None


@functools.cache
def _is_of_model(file: str, root: str) -> bool:
    """Return True for a model's file below `root`; cached, because a derivation calls it thousands of times."""
    path = Path(file)
    return not (is_ours(path) or is_copy(path, root) or is_library(path))


def is_library(path: Path) -> bool:
    """Return True if a file belongs to an installed library."""
    return any(path.is_relative_to(folder) for folder in _LIBRARIES) or not _INSTALLED.isdisjoint(path.parts)


def is_ours(path: Path) -> bool:
    """Return True if a file belongs to mehvar, whose files always count as inputs."""
    rooms = ("mehvar", "codegen", "runtime", "models", "generated", "tests")
    return path.is_relative_to(OURS) and path.relative_to(OURS).parts[0] in rooms


def is_copy(path: Path, root: str | Path) -> bool:
    """Return True if a file below `root` is another checkout's copy of a file of mehvar."""
    counterpart = OURS / path.relative_to(root)
    return is_ours(counterpart) and os.path.lexists(counterpart)  # `lstat`, because `stat` may be the recording one


def is_written(path: Path, root: Path) -> bool:
    """Return True if generation or Python writes a file."""
    if sys.pycache_prefix is not None and path.is_relative_to(sys.pycache_prefix):
        return True
    inner = path.relative_to(root).parts if path.is_relative_to(root) else ()
    return bool(inner) and (inner[0] == "generated" or "__pycache__" in inner or inner[0].startswith("."))
