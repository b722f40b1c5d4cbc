# SPDX-License-Identifier: Apache-2.0
"""Cache of derived models and compiled libraries. A folder's name is a hash of all inputs of its contents.

An entry is filled under another name and then renamed, so that it is complete or absent. It stores digests of its
files. A damaged entry is detected and made again.
"""

from __future__ import annotations

import atexit
import hashlib
import os
import secrets
import shutil
import stat
import tempfile
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

from mehvar.base.errors import BuildError, InputError

_DIGESTS = ".sha256"
_PRIVATE, _WRITABLE = 0o700, 0o022
"""File mode of new entries; mode bits for writing by group and others."""
_OWN: list[Path] = []
"""Temporary folder of this process, after its first use."""
_TRIES = 3
"""Number of attempts to make an entry, because a user may empty the cache during an attempt."""


def key(*parts: str | Mapping[str, str]) -> str:
    """Return a hash of all inputs of an entry: texts, and texts by name in any order."""
    digest = hashlib.sha256()
    for part in parts:
        text = (part if isinstance(part, str) else repr(sorted(part.items()))).encode()
        digest.update(len(text).to_bytes(8, "little") + text)
    return digest.hexdigest()[:32]


def find(kind: str, name: str) -> Path | None:
    """Return the folder of an undamaged entry that no other user could have written; None if there is no such entry."""
    for root in _roots():
        entry = root / kind / name
        if is_private(root) and is_private(root / kind) and _is_ours(entry):
            return entry
    return None


def entry(kind: str, name: str, fill: Callable[[Path], object]) -> Path:
    """Return the folder of an entry; make the entry if it is missing or damaged.

    Parameters
    ----------
    kind : str
        Kind of entry, such as "libraries".
    name : str
        Name of its subject with the `key` of all inputs.
    fill : callable
        Writes the files into the empty folder that it receives. It is called again if the cache is emptied meanwhile.

    Raises
    ------
    InputError
        If $MEHVAR_CACHE is set and cannot be written.
    BuildError
        If the cache is emptied again and again.
    """
    return find(kind, name) or _made(kind, name, fill)


def discard(folder: Path) -> None:
    """Remove an undamaged entry that is useless, such as a library that the loader refuses."""
    shutil.rmtree(folder, ignore_errors=True)


def cache_folder() -> Path:
    """Return the folder for new entries, made if necessary; only this user can write it.

    It is $MEHVAR_CACHE, or `mehvar` below $XDG_CACHE_HOME or ~/.cache, or else a new one with a random name, which is
    removed at the end of the process.

    Raises
    ------
    InputError
        If $MEHVAR_CACHE is set and cannot be written, or others could write it too.
    """
    for folder in _roots():
        try:
            folder.mkdir(parents=True, exist_ok=True, mode=_PRIVATE)
            tempfile.TemporaryFile(dir=folder).close()
            reason = _exposure(folder)
        except OSError as error:
            reason = error.strerror or str(error)
        if not reason:
            return folder
        if os.environ.get("MEHVAR_CACHE"):
            raise InputError(f"$MEHVAR_CACHE must be a folder that only you can write to: {folder}: {reason}")
    return _own_temporary()


def is_private(folder: Path) -> bool:
    """Return True for a folder of this user that no other user can write to."""
    try:
        return not _exposure(folder)
    except OSError:
        return False


def _made(kind: str, name: str, fill: Callable[[Path], object]) -> Path:
    """Return the new folder of an entry, moved once it is filled; start again if someone clears the cache meanwhile."""
    for _ in range(_TRIES):
        place = cache_folder() / kind / name
        scratch = place.with_name(f"build-{secrets.token_hex(8)}")
        place.parent.mkdir(mode=_PRIVATE, parents=True, exist_ok=True)
        if reason := _exposure(place.parent):
            raise InputError(f"the cache cannot be used: {place.parent}: {reason}, or remove the folder")
        scratch.mkdir(mode=_PRIVATE)
        try:
            fill(scratch)
            (scratch / _DIGESTS).write_text(_digests(scratch), encoding="utf-8")
            _make_private(scratch)
            return _moved(scratch, place)
        except (BuildError, OSError):
            if scratch.is_dir():
                raise
        finally:
            shutil.rmtree(scratch, ignore_errors=True)
    raise BuildError(f"the folder {place.parent} disappeared {_TRIES} times while {name} was written")


def _moved(scratch: Path, place: Path) -> Path:
    """Rename a finished entry to its final place.

    If a faster process has made the entry, keep that one unless it is damaged.
    """
    if not _is_ours(place):
        discard(place)
    try:
        scratch.rename(place)
    except OSError:
        if not _is_ours(place):
            raise
    return place


def _is_ours(entry: Path) -> bool:
    try:
        alone = not any(_writer(path, path.stat()) for path in entry.rglob("*"))
    except OSError:  # another process has just removed it
        return False
    return alone and is_private(entry) and _is_whole(entry)


def _make_private(folder: Path) -> None:
    """Remove the write permission of group and others, which a wide umask may have set."""
    for path in folder.rglob("*"):
        path.chmod(path.stat().st_mode & ~_WRITABLE)


def _is_whole(folder: Path) -> bool:
    try:
        return (folder / _DIGESTS).read_text(encoding="utf-8", errors="replace") == _digests(folder)
    except OSError:
        return False


def _digests(folder: Path) -> str:
    """Return the checksums of a folder's files, one line per file in the format of `sha256sum`."""
    return "".join(
        f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.relative_to(folder).as_posix()}\n"
        for path in sorted(_files(folder))
    )


def _files(folder: Path) -> Iterator[Path]:
    return (path for path in folder.rglob("*") if path.is_file() and path.name != _DIGESTS)


def _roots() -> list[Path]:
    """Return the folders that may hold cache entries, the preferred one first."""
    if own := os.environ.get("MEHVAR_CACHE"):
        return [Path(own).expanduser().absolute()]
    return [*_home_cache(), *_OWN]


def _home_cache() -> list[Path]:
    base = os.environ.get("XDG_CACHE_HOME")
    try:
        return [(Path(base) if base and Path(base).is_absolute() else Path.home() / ".cache") / "mehvar"]
    except RuntimeError:  # a user without a home
        return []


def _own_temporary() -> Path:
    """Return a temporary folder of this process."""
    if not _OWN or not _OWN[0].is_dir():
        _OWN[:] = [Path(tempfile.mkdtemp(prefix="mehvar-"))]
        atexit.register(shutil.rmtree, _OWN[0], ignore_errors=True)
    return _OWN[0]


def _exposure(folder: Path) -> str:
    """Return a description of how other users could have written to a folder, or an empty text."""
    status = folder.stat()
    return _writer(folder, status) if stat.S_ISDIR(status.st_mode) else "it is no folder"


def _writer(path: Path, status: os.stat_result) -> str:
    """Return a description of the other users that may write to a file or folder, or an empty text."""
    if not hasattr(os, "getuid"):
        return ""  # a system without owners
    if status.st_uid != os.getuid():
        return f"it belongs to the user with the number {status.st_uid}"
    if status.st_mode & _WRITABLE:
        return f"others may write it (mode {stat.S_IMODE(status.st_mode):o}): chmod go-w {path}"
    return ""
