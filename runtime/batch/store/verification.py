# SPDX-License-Identifier: Apache-2.0
"""Verification of a store's files against their records, without reading arrays."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from mehvar.base.errors import InputError, bad_value
from mehvar.base.schema import SchemaError

from .arrays import ROOT, Array, read_group
from .attributes import batch_hash, check_group
from .lock import FILE as LOCK
from .lock import lock_owner
from .records import END, FOLDER, STORE, DamageError, Record, Records, block_record, file_digest

T = TypeVar("T")

_LOOKS, _LOOK = 10, 0.1
"""Number of attempts at a store that is being written, and seconds between them. An early end rewrites metadata in
0.1 s. Readers do not wait for repairs, which take longer.
"""
_SHOWN = 3
"""Largest number of files per block, and of blocks, in a message."""


@dataclass(frozen=True)
class BlockDamage:
    """A block with files that contradict its record.

    Attributes
    ----------
    block : int
        Number of the block.
    first, last : int
        Its runs.
    files : mapping of str to str
        Paths of files, each "missing" or "changed".
    """

    block: int
    first: int
    last: int
    files: Mapping[str, str]

    def __str__(self) -> str:
        return f"block {self.block} (runs {self.first} to {self.last}): {listed(self.files)}"


@dataclass(frozen=True)
class Verification:
    """Result of `verify`.

    Attributes
    ----------
    store : str
        Its path.
    runs, blocks : int
        Totals.
    whole, missing : tuple of int
        Intact blocks, and blocks not yet written.
    damaged : tuple of BlockDamage
        All other blocks.
    files : mapping of str to str
        Damage of files outside the blocks: metadata, names, instants, the record of the end.
    ended : bool
        True if the batch ended and recorded its end.
    writer : str or None
        The process that is writing it now.
    others : tuple of str
        Files that no record lists: the user's, or leftovers of a killed process. They do not affect the verdict.
    """

    store: str
    runs: int
    blocks: int
    whole: tuple[int, ...]
    missing: tuple[int, ...]
    damaged: tuple[BlockDamage, ...]
    files: Mapping[str, str]
    ended: bool
    writer: str | None = None
    others: tuple[str, ...] = ()

    @property
    def sound(self) -> bool:
        """True if nothing is damaged, complete or not."""
        return not self.damaged and not self.files

    @property
    def complete(self) -> bool:
        """True if the store is undamaged and contains all runs."""
        return self.sound and self.ended and not self.missing

    def damage(self) -> list[str]:
        """Return one line about damaged files outside of the blocks, and one line per damaged block."""
        return [*([listed(self.files)] if self.files else []), *map(str, self.damaged)]

    def summary(self) -> str:
        """Return the first of these lines and the number of others."""
        lines = self.damage()
        more = f"; and {len(lines) - _SHOWN} more" if len(lines) > _SHOWN else ""
        return "; ".join(lines[:_SHOWN]) + more

    def facts(self) -> dict[str, Any]:
        """Return the result as JSON values."""
        damaged = [{"block": d.block, "first": d.first, "last": d.last, "files": dict(d.files)} for d in self.damaged]
        return {
            **{"store": self.store, "complete": self.complete, "sound": self.sound, "ended": self.ended},
            **{"runs": self.runs, "blocks": self.blocks, "whole": len(self.whole), "missing": list(self.missing)},
            **{"damaged": damaged, "files": dict(self.files), "writer": self.writer, "others": list(self.others)},
        }


def verify(path: str | os.PathLike[str]) -> Verification:
    """Check every file of a store against its record.

    Parameters
    ----------
    path : path
        A batch, finished or not.

    Returns
    -------
    Verification
        `complete` is True if everything is present and intact; `missing` and `damaged` list blocks.

    Raises
    ------
    InputError
        If there is no store of this version, or its attributes are not those of a batch.
    """
    folder = store_folder(path)
    return settled(folder, lambda writer: verification_now(folder, writer), lambda verification: verification.sound)


def settled(folder: Path, look: Callable[[str | None], T], is_sound: Callable[[T], bool]) -> T:
    """Return the result of `look`, called again while it finds damage and a process writes.

    Parameters
    ----------
    folder : Path
        The store.
    look : callable
        Called with the writing process, or None.
    is_sound : callable
        Called with the result of `look`.
    """
    for wait in (*(_LOOK,) * _LOOKS, 0.0):
        before = lock_owner(folder)
        result = look(before)
        if is_sound(result) or (before or lock_owner(folder)) is None:
            break
        time.sleep(wait)
    return result


def verification_now(folder: Path, writer: str | None) -> Verification:
    """Check every file once, also while a process writes: for the writer itself."""
    records, files = own_files(folder)
    if isinstance(records.end, str):
        files[END] = records.end
    if ROOT not in files:
        stored_group(folder, records.store)
    return _blocks(records, files, writer)


def store_folder(path: str | os.PathLike[str]) -> Path:
    """Return the folder of a store, intact or not.

    Raises
    ------
    InputError
        If there is none.
    """
    if not isinstance(path, str | os.PathLike):
        raise bad_value("path", path, "the path of a store", "the call")
    folder = Path(path)
    if not folder.is_dir():
        raise InputError(f"no batch store {folder}")
    if not (folder / FOLDER).is_dir():
        raise InputError(f"{folder} is not a batch store: it has no records")
    return folder


def own_files(folder: Path) -> tuple[Records, dict[str, str]]:
    """Return the records of a store, and the damage to files outside of blocks.

    Raises
    ------
    InputError
        If the store has links, pipes or devices, or another version, or its record is not intact.
    """
    special = {
        name: "a link" if entry.is_symlink() else "a pipe or a device"
        for name, entry in _entries(folder)
        if not (entry.is_file(follow_symlinks=False) or entry.is_dir(follow_symlinks=False))
    }
    if special:
        raise DamageError(f"{folder} is damaged: {listed(special)}; remove what is neither a file nor a folder")
    records = Records(folder)
    return records, _differences(folder, records.store.digests)


def _entries(folder: Path, above: str = "") -> Iterator[tuple[str, os.DirEntry[str]]]:
    """Yield the paths below a folder, in order, with their entries; links are not followed."""
    try:
        with os.scandir(folder / above) as listing:
            own = sorted(listing, key=lambda entry: entry.name)
    except OSError:
        return  # a writer has removed it
    for entry in own:
        yield f"{above}{entry.name}", entry
    for entry in own:
        if entry.is_dir(follow_symlinks=False):
            yield from _entries(folder, f"{above}{entry.name}/")


def stored_group(folder: Path, record: Record) -> tuple[dict[str, Any], dict[str, Array]]:
    """Return the checked attributes and arrays of a store from its file.

    Raises
    ------
    InputError
        If they are not those of a batch, or contradict the record.
    """
    try:
        attributes, arrays = read_group((folder / ROOT).read_bytes())
        check_group(attributes, arrays)
        if batch_hash(attributes, record.about["chunk"]) != record.about["batch"]:
            raise SchemaError(": do not match its records, which are of another batch", "its attributes")
    except (OSError, ValueError, LookupError, TypeError, AttributeError, RecursionError) as error:
        raise InputError(f"{folder} is not a batch store: {' '.join(str(error).split())}") from error
    return attributes, arrays


def listed(files: Mapping[str, str]) -> str:
    """Return the damage of files on one line, with the first names."""
    shown = [f"{name} is {what}" for name, what in list(files.items())[:_SHOWN]]
    more = len(files) - len(shown)
    return ", ".join([*shown, *([f"and {more} more files"] if more > 0 else [])])


def _blocks(records: Records, files: dict[str, str], writer: str | None) -> Verification:
    """Return the verification of all blocks, and of the files that no record lists."""
    folder, store = records.folder, records.store
    end = records.end if isinstance(records.end, Record) else None
    runs, chunk = (end or store).about["runs"], store.about["chunk"]
    count = -(-runs // chunk)
    whole, missing, damaged = [], [], []
    known = {STORE, END, LOCK, *_files(store), *_files(end)}
    for block in range(count):
        record, place = records.block(block), block_record(block)
        known |= {place, *_files(record)}
        if record is None:
            missing.append(block)
        elif state := {place: record} if isinstance(record, str) else _differences(folder, record.digests):
            damaged.append(BlockDamage(block, block * chunk, min((block + 1) * chunk, runs) - 1, state))
        else:
            whole.append(block)
    if store.about["runs"] != runs:
        files[STORE] = "older than the end of the batch"
    plain = (name for name, entry in _entries(folder) if entry.is_file(follow_symlinks=False))
    return Verification(
        store=str(folder),
        runs=runs,
        blocks=count,
        whole=tuple(whole),
        missing=tuple(missing),
        damaged=tuple(damaged),
        files=files,
        ended=end is not None,
        writer=writer,
        others=tuple(name for name in plain if name not in known),
    )


def _files(record: Record | str | None) -> Iterable[str]:
    return record.digests if isinstance(record, Record) else ()


def _differences(folder: Path, digests: Mapping[str, str]) -> dict[str, str]:
    return {name: _state(folder, name) for name, value in digests.items() if file_digest(folder / name) != value}


def _state(folder: Path, name: str) -> str:
    place = folder / name
    return "a folder" if place.is_dir() else "changed" if place.exists() else "missing"
