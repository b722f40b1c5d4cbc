# SPDX-License-Identifier: Apache-2.0
"""What was made once and need not be made again: folders named after the contents that they follow from.

An entry is complete or absent: it is filled under another name and then renamed. The digests of its files stand in it,
so that a damaged one is told from a good one and made again.
"""

from __future__ import annotations

import hashlib
import os
import secrets
import shutil
import stat
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

from mehvar.errors import BuildError, InputError

_DIGESTS = ".sha256"
_TRIES = 3
"""Somebody who empties the cache while something is made does so once; three times in a row is something else."""


def key(*parts: str) -> str:
    """Return a hash of everything that decides an entry's contents."""
    digest = hashlib.sha256()
    for part in parts:
        text = part.encode()
        digest.update(len(text).to_bytes(8, "little") + text)
    return digest.hexdigest()[:32]


def find(kind: str, name: str) -> Path | None:
    """Return the folder of an undamaged entry, wherever one may be; None if there is none."""
    for folder in filter(_is_ours, _roots()):
        entry = folder / kind / name
        if _is_whole(entry):
            return entry
    return None


def entry(kind: str, name: str, fill: Callable[[Path], None]) -> Path:
    """Return the folder of an entry, made now if there is none or it is damaged.

    Parameters
    ----------
    kind : str
        What it is, as in "libraries".
    name : str
        What it is of, with the `key` of all that its contents follow from.
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
    """Remove an entry that is whole and yet of no use, such as a library that the loader refuses."""
    shutil.rmtree(folder, ignore_errors=True)


def cache_folder() -> Path:
    """Return the folder that new entries go to, made if necessary.

    It is $MEHVAR_CACHE, or `mehvar` below $XDG_CACHE_HOME or ~/.cache, or else a private temporary folder.

    Raises
    ------
    InputError
        If $MEHVAR_CACHE is set and cannot be written.
    """
    reasons = []
    for folder in _roots():
        try:
            folder.mkdir(parents=True, exist_ok=True, mode=0o700)
            tempfile.TemporaryFile(dir=folder).close()
        except OSError as error:
            reasons.append(f"{folder}: {error.strerror or error}")
            continue
        if _is_ours(folder):
            return folder
    if os.environ.get("MEHVAR_CACHE"):
        raise InputError(f"$MEHVAR_CACHE must be a folder that can be written: {reasons[0]}")
    return Path(tempfile.mkdtemp(prefix="mehvar-"))


def other_folders() -> list[Path]:
    """Return the folders besides `cache_folder` that entries are found in too."""
    first = cache_folder()
    return [folder for folder in _roots() if folder != first and folder.is_dir() and _is_ours(folder)]


def _made(kind: str, name: str, fill: Callable[[Path], None]) -> Path:
    for _ in range(_TRIES):
        place = cache_folder() / kind / name
        scratch = place.with_name(f"build-{secrets.token_hex(8)}")
        scratch.mkdir(parents=True)
        try:
            fill(scratch)
            (scratch / _DIGESTS).write_text(_digests(scratch), encoding="utf-8")
            return _moved(scratch, place)
        except (BuildError, OSError):
            if scratch.is_dir():
                raise
        finally:
            shutil.rmtree(scratch, ignore_errors=True)
    raise BuildError(f"the folder {place.parent} vanished each of {_TRIES} times that {name} was made")


def _moved(scratch: Path, place: Path) -> Path:
    """Rename a finished entry to its place, unless another process was first; a damaged one makes room."""
    if not _is_whole(place):
        discard(place)
    try:
        scratch.rename(place)
    except OSError:
        if not _is_whole(place):
            raise
    return place


def _is_whole(folder: Path) -> bool:
    try:
        return (folder / _DIGESTS).read_text(encoding="utf-8", errors="replace") == _digests(folder)
    except OSError:
        return False


def _digests(folder: Path) -> str:
    """Return a line for each file of a folder, in the form of `sha256sum`."""
    return "".join(
        f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.relative_to(folder).as_posix()}\n"
        for path in sorted(_files(folder))
    )


def _files(folder: Path) -> Iterator[Path]:
    return (path for path in folder.rglob("*") if path.is_file() and path.name != _DIGESTS)


def _roots() -> list[Path]:
    """Return the folders that may hold an entry, the preferred one first."""
    if own := os.environ.get("MEHVAR_CACHE"):
        return [Path(own).expanduser().absolute()]
    base = os.environ.get("XDG_CACHE_HOME")
    home = Path(base) if base and Path(base).is_absolute() else _home() / ".cache"
    return [home / "mehvar", _shared_temporary()]


def _home() -> Path:
    try:
        return Path.home()
    except RuntimeError:  # a user without a home
        return _shared_temporary()


def _shared_temporary() -> Path:
    user = str(os.getuid()) if hasattr(os, "getuid") else os.environ.get("USERNAME", "user")
    return Path(tempfile.gettempdir()) / f"mehvar-{user}"


def _is_ours(folder: Path) -> bool:
    """Whether nobody else can have put a library into a folder below a temporary folder that all share."""
    if folder != _shared_temporary() or not hasattr(os, "getuid"):
        return True
    try:
        status = folder.lstat()
    except OSError:
        return False
    return stat.S_ISDIR(status.st_mode) and status.st_uid == os.getuid() and not status.st_mode & 0o022
