# SPDX-License-Identifier: Apache-2.0
"""Lock of a store: a locked file with the name of the only process that may write."""

from __future__ import annotations

import os
import platform
import time
from pathlib import Path

from mehvar.base.errors import InputError

from ...interrupts import deferred

FILE = "lock"
_PLAIN = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)
"""Flags for opening a lock file: links are not followed, and pipes do not block."""
_LOOKS, _LOOK = 200, 0.005
"""Number of attempts of a writer, and seconds between them. Readers hold the lock for microseconds, but on two busy
cores four of them blocked a writer for 0.1 s.
"""
_LONGEST = 256
"""Bytes of a file that names a process: a host name has at most 255."""


class Lock:
    """Right to write into a folder, until release or end of the process.

    The file is removed at the end; the file of a killed process is not locked.

    Parameters
    ----------
    folder : Path
        An existing folder.
    name : str
        Name of the folder in messages.

    Raises
    ------
    InputError
        If another process has it; the message names that process.
    OSError
        If the folder cannot be written.
    """

    def __init__(self, folder: Path, name: str) -> None:
        self._place, self._handle = folder / FILE, -1
        self._handle = _locked(self._place, name)
        os.ftruncate(self._handle, 0)
        os.write(self._handle, f"process {os.getpid()} on {platform.node()}\n".encode())

    def __del__(self) -> None:
        """Release the lock if it is still held."""
        if self._handle >= 0:
            os.close(self._handle)

    def follow(self, folder: Path) -> None:
        """Follow a renamed folder."""
        self._place = folder / FILE

    @deferred()
    def release(self) -> None:
        """Release the lock."""
        self._place.unlink(missing_ok=True)
        os.close(self._handle)
        self._handle = -1


def lock_owner(folder: Path) -> str | None:
    """Return the process that currently writes into a folder; None without one."""
    try:
        handle = os.open(folder / FILE, os.O_RDONLY | _PLAIN)
    except OSError:
        return None
    try:
        return None if _lock(handle, alone=False) else _name(handle)
    finally:
        os.close(handle)


def is_abandoned(folder: Path) -> bool:
    """Return True if the lock names the process that made this folder, and this process has ended.

    A lock without a name may belong to a process that is about to lock it.
    """
    try:
        return bool((folder / FILE).read_bytes()) and lock_owner(folder) is None
    except OSError:
        return False


def _locked(place: Path, name: str) -> int:
    """Return the handle of the locked file; the name that was locked must still be that of the file."""
    while True:
        handle = os.open(place, os.O_RDWR | os.O_CREAT | os.O_APPEND | _PLAIN, 0o666)
        if not _locks(handle):
            writer = _name(handle)
            os.close(handle)
            raise InputError(f"another process is writing {name}: {writer}")
        if _is_still(handle, place):
            return handle
        os.close(handle)  # another process has just released this file


def _name(handle: int) -> str:
    return os.pread(handle, _LONGEST, 0).decode(errors="replace").strip() or "it has not said which"


def _is_still(handle: int, place: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(handle), place.stat())
    except FileNotFoundError:
        return False


def _locks(handle: int) -> bool:
    for _ in range(_LOOKS):
        if _lock(handle):
            return True
        time.sleep(_LOOK)
    return False


def _lock(handle: int, alone: bool = True) -> bool:
    """Lock a file until it is closed. Return False if another process has it, True also if locks are not supported.

    Without `alone` the lock is shared, so that several processes can check a file at once.
    """
    try:
        import fcntl

        fcntl.flock(handle, (fcntl.LOCK_EX if alone else fcntl.LOCK_SH) | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except (ImportError, OSError):
        return True
    return True
