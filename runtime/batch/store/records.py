# SPDX-License-Identifier: Apache-2.0
"""Records of a store, of each block, and of the end, flushed to disk.

A record is a file that lists other files with their digests, and a digest of itself. It is written after its files
are on disk, so that a listed file is either intact or damaged.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import secrets
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any

from mehvar.base.errors import InputError

FOLDER = "records"
STORE, END = f"{FOLDER}/store.json", f"{FOLDER}/end.json"
FORMAT = 2
_PARTIAL = ".partial"
"""Ending of unfinished files."""
_NEW_FILE = os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_CLOEXEC | getattr(os, "O_BINARY", 0)
_LEFTOVER = re.compile(rf".+\.(?:[0-9a-f]{{16}}|[0-9a-f]{{32}}){re.escape(_PARTIAL)}")
"""Pattern of unfinished files by Zarr or `replace_file`; others may be the user's."""
_SELF = "sha256"
CURE = "to repair the store, use the original command with --resume (resume=True)"


class DamageError(InputError):
    """A file of a store is missing or changed. The message names its block and runs."""


@dataclass(frozen=True)
class Record:
    """Facts and file digests.

    Attributes
    ----------
    about : mapping
        Any JSON values.
    digests : mapping of str to str
        SHA-256 of files, by path in the store.
    """

    about: Mapping[str, Any]
    digests: Mapping[str, str]

    def content(self) -> bytes:
        """Return the bytes of the record's file; equal records give equal bytes."""
        facts = {"about": self.about, "files": self.digests}
        return _text({**facts, _SELF: digest(_text(facts))})


class Records:
    """Records of a store, each checked to belong to the batch.

    An invalid record of a block or of the end is a text with the reason, such as "of another batch".

    Attributes
    ----------
    store : Record
        Record of the store.
    end : Record, str or None
        Record of the end; None if the batch has not ended.

    Raises
    ------
    InputError
        If the record of the store is missing, changed or of another version. Nothing else identifies the batch.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.store = _store_record(folder)
        self.end = self._read(END)
        self._seals = dict(self.end.digests) if isinstance(self.end, Record) else {}

    def block(self, block: int) -> Record | str | None:
        """Return the record of a block; None if the block is not stored."""
        name = block_record(block)
        record = self._read(name)
        if record is None:
            return "missing" if name in self._seals else None
        if isinstance(record, str):
            return record
        if record.about.get("block") != block:
            return "of another block"
        if name in self._seals and self._seals[name] != digest(record.content()):
            return "not the record that the end of the batch lists"
        return record

    def remove(self, block: int) -> None:
        """Remove a block's record, also for the end record, which has its digest."""
        name = block_record(block)
        self._seals.pop(name, None)
        (self.folder / name).unlink(missing_ok=True)

    def _read(self, name: str) -> Record | str | None:
        place = self.folder / name
        record = read_record(place)
        if record is None:
            return "changed" if os.path.lexists(place) else None
        if any(record.about[key] != self.store.about[key] for key in ("batch", "chunk")):
            return "of another batch"
        return record


def block_record(block: int) -> str:
    """Return the path of the record of a block."""
    return f"{FOLDER}/{block}.json"


def digest(content: Any) -> str:
    """Return the digest of bytes or of an object with a buffer."""
    return hashlib.sha256(content).hexdigest()


def file_digest(path: Path) -> str | None:
    """Return the digest of a file; None if it is unreadable, a pipe or a device."""
    if not path.is_file():
        return None
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError:
        return None


def read_record(path: Path) -> Record | None:
    """Return the record at a path; None if it is missing or damaged."""
    try:
        content = path.read_bytes() if path.is_file() else b""
        facts = json.loads(content)
        record = Record(facts["about"], facts["files"])
        inside = all(PurePosixPath(name).is_relative_to(".") and ".." not in name.split("/") for name in record.digests)
        return record if inside and _is_about_a_store(record.about) and record.content() == content else None
    except (OSError, ValueError, LookupError, TypeError, AttributeError, RecursionError):
        return None


def _store_record(folder: Path) -> Record:
    """Return the record of a store; refuse one of another version, and one that is not intact."""
    path = folder / STORE
    record = read_record(path)
    if record is not None:
        return record
    try:
        number = json.loads(path.read_bytes())["about"]["format"] if path.is_file() else FORMAT
    except (OSError, ValueError, LookupError, TypeError, RecursionError):
        number = FORMAT
    if number != FORMAT:
        raise InputError(f"{folder} is a batch store of another version: its format is {number!r}")
    raise DamageError(f"{folder} is damaged: {STORE} is missing or changed, so that nothing identifies its batch")


def _is_about_a_store(about: Mapping[str, Any]) -> bool:
    """Return True if facts have the types that `Layout.about` writes, for a store, its end or a block."""
    own = ("block", "first", "last") if "block" in about else ("runs",)
    counts = {name: about[name] for name in ("format", "chunk", *own)}
    refusals = about.get("refusals", {})
    return (
        all(type(value) is int and value >= 0 for value in counts.values())
        and counts["format"] == FORMAT
        and counts["chunk"] > 0
        and type(about["batch"]) is str
        and all(run.isdigit() and type(text) is str for run, text in refusals.items())
    )


def write_record(folder: Path, name: str, record: Record) -> None:
    """Write a record, and return when it is on the disk."""
    replace_file(folder, name, record.content())
    force([(folder / name).parent])


def replace_file(folder: Path, name: str, content: bytes) -> None:
    """Write a file of a store by renaming. Its bytes are on the disk before its name."""
    write_file(folder / name, content, forced=True)


def write_file(path: Path, content: bytes, forced: bool = False) -> None:
    """Write a file by renaming, with its folders; `forced` first flushes its bytes to disk."""
    temporary = f"{path}.{secrets.token_hex(8)}{_PARTIAL}"
    try:
        handle = os.open(temporary, _NEW_FILE, 0o666)
    except FileNotFoundError:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle = os.open(temporary, _NEW_FILE, 0o666)
    with os.fdopen(handle, "wb") as file:
        file.write(content)
        if forced:
            file.flush()
            os.fsync(handle)
    Path(temporary).replace(path)


def leftovers(folder: Path) -> list[Path]:
    """Return the unfinished files of killed processes."""
    return [path for path in folder.rglob(f"*{_PARTIAL}") if _LEFTOVER.fullmatch(path.name)]


def force_files(folder: Path, names: Iterable[str]) -> None:
    """Flush files and all folders on their paths to disk."""
    files = list(names)
    folders = {name[:k] for name in files for k, letter in enumerate(name) if letter == "/"}
    force([folder / name for name in (*files, *sorted(folders), "")])


def force(paths: Iterable[Path]) -> None:
    """Flush files and directory entries to disk."""
    for path in paths:
        handle = os.open(path, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def _text(facts: Mapping[str, Any]) -> bytes:
    return (json.dumps(facts, indent=1, sort_keys=True, ensure_ascii=False) + "\n").encode()
