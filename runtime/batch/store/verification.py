# SPDX-License-Identifier: Apache-2.0
"""Verification of a store's files against their records, without reading arrays."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from mehvar.base.errors import InputError, bad_value

from .arrays import ROOT
from .attributes import check_attributes, check_batch
from .lock import FILE as LOCK
from .lock import lock_owner
from .paths import entries, is_plain, special_files
from .records import (
    END,
    FOLDER,
    STORE,
    Proof,
    Record,
    WrongRecord,
    block_record,
    check_format,
    file_digest,
    read_record,
)

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
        Totals. If no record has them, runs is None and blocks counts those with a record.
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
    runs: int | None
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
    proof, files = own_files(folder)
    if isinstance(proof.end, WrongRecord):
        files[END] = proof.end.what
    if proof.store is not None and ROOT not in files:
        checked_attributes(folder, proof.store)
    return _blocks(proof, files, writer)


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
    if not (folder / FOLDER).is_dir() and not (folder / ROOT).exists():
        raise InputError(f"{folder} is not a batch store: it has no records")
    return folder


def own_files(folder: Path) -> tuple[Proof, dict[str, str]]:
    """Return the records of a store, and the damage to its record and files, including foreign paths.

    Raises
    ------
    InputError
        If the store has another version, or nothing in the folder identifies the batch.
    """
    check_format(folder / STORE)
    proof = Proof(folder)
    check_identified(folder)
    files = {STORE: _state(folder, STORE)} if proof.store is None else _differences(folder, proof.store.digests)
    return proof, files | special_files(folder)


def check_identified(folder: Path) -> None:
    """Refuse a folder whose records and attributes identify no batch; it cannot be repaired."""
    if any(map(read_record, (folder / FOLDER).glob("*.json"))):
        return
    try:
        checked_attributes(folder, None)
    except InputError as error:
        raise InputError(f"{folder} is not a batch store: it names no batch") from error


def checked_attributes(folder: Path, store: Record | None) -> dict[str, Any]:
    """Return the checked attributes of a store from its file.

    Raises
    ------
    InputError
        If they are not those of a batch, or contradict an intact record.
    """
    if not is_plain(folder, ROOT):
        raise InputError(f"{folder} is not a batch store: it has no {ROOT}")
    try:
        attributes: dict[str, Any] = json.loads((folder / ROOT).read_bytes())["attributes"]
        check_attributes(attributes)
        if store is not None:
            check_batch(attributes, store.about)
    except (OSError, ValueError, LookupError, TypeError, RecursionError) as error:
        raise InputError(f"{folder} is not a batch store: {' '.join(str(error).split())}") from error
    return attributes


def listed(files: Mapping[str, str]) -> str:
    """Return the damage of files on one line, with the first names."""
    shown = [f"{name} is {what}" for name, what in list(files.items())[:_SHOWN]]
    more = len(files) - len(shown)
    return ", ".join([*shown, *([f"and {more} more files"] if more > 0 else [])])


def _blocks(proof: Proof, files: dict[str, str], writer: str | None) -> Verification:
    folder, store = proof.folder, proof.store
    end = proof.end if isinstance(proof.end, Record) else None
    runs, chunk, count = _extent(folder, store, end)
    whole, missing, damaged = [], [], []
    known = {STORE, END, LOCK, *_files(store), *_files(end)}
    for block in range(count):
        record = proof.block(block)
        known |= {block_record(block), *_files(record)}
        if record is None:
            missing.append(block)
            continue
        state = (
            {block_record(block): record.what}
            if isinstance(record, WrongRecord)
            else _differences(folder, record.digests)
        )
        if state:
            last = (block + 1) * chunk - 1
            damaged.append(BlockDamage(block, block * chunk, last if runs is None else min(last, runs - 1), state))
        else:
            whole.append(block)
    if store is not None and store.about["runs"] != runs:
        files[STORE] = "older than the end of the batch"
    blocks = (tuple(whole), tuple(missing), tuple(damaged))
    others = () if store is None else tuple(_others(folder, known))
    return Verification(str(folder), runs, count, *blocks, files, end is not None, writer, others)


def _others(folder: Path, known: Collection[str]) -> Iterator[str]:
    """Yield the paths of unknown plain files."""
    yield from (name for name, entry in entries(folder) if name not in known and entry.is_file(follow_symlinks=False))


def _extent(folder: Path, store: Record | None, end: Record | None) -> tuple[int | None, int, int]:
    """Return total runs, runs per block and number of blocks from any intact record."""
    record = end or store
    if record is not None:
        runs, chunk = record.about["runs"], record.about["chunk"]
        return runs, chunk, -(-runs // chunk)
    known = [record for path in (folder / FOLDER).glob("*.json") if (record := read_record(path)) is not None]
    return None, known[0].about["chunk"] if known else 0, max((r.about.get("block", -1) + 1 for r in known), default=0)


def _files(record: Record | WrongRecord | None) -> Iterable[str]:
    return record.digests if isinstance(record, Record) else ()


def _differences(folder: Path, digests: Mapping[str, str]) -> dict[str, str]:
    return {name: _state(folder, name) for name, value in digests.items() if file_digest(folder / name) != value}


def _state(folder: Path, name: str) -> str:
    place = folder / name
    return "a folder" if place.is_dir() else "changed" if place.exists() else "missing"
