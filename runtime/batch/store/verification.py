# SPDX-License-Identifier: Apache-2.0
"""Whether a store is what was written: every file held against the records, without reading an array."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mehvar.errors import InputError, bad_value

from .attributes import check_attributes, check_batch
from .lock import FILE as LOCK
from .lock import holder
from .places import foreign
from .records import (
    END,
    FOLDER,
    ROOT,
    STORE,
    Record,
    block_record,
    check_format,
    digest,
    file_digest,
    read_record,
)

_SHOWN = 3
"""Files of a block, and blocks, that a message names: as many as fit into a few lines of a terminal."""


@dataclass(frozen=True)
class BlockDamage:
    """A block whose files are not those that its record lists.

    Attributes
    ----------
    block : int
        Which.
    first, last : int
        Its runs.
    files : mapping of str to str
        Places of files to "missing" or "changed".
    """

    block: int
    first: int
    last: int
    files: Mapping[str, str]

    def __str__(self) -> str:
        return f"block {self.block} (runs {self.first} to {self.last}): {listed(self.files)}"


@dataclass(frozen=True)
class Verification:
    """What `verify` finds.

    Attributes
    ----------
    store : str
        Its path.
    runs, blocks : int
        In all. Where no record says how many, runs is None and blocks those that have a record.
    whole, missing : tuple of int
        Blocks that are as they were written, and those that have not been.
    damaged : tuple of BlockDamage
        The others.
    files : mapping of str to str
        What is wrong with files that belong to no block: metadata, names, instants, the record of the end.
    ended : bool
        Whether the batch came to its end, and said so.
    writer : str or None
        Who is writing it now.
    others : tuple of str
        Files that no record lists, so that nobody reads them: what was put beside, or what a killed process left of a
        block that is not stored. Whether the store is whole does not depend on them.
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
        """Whether nothing is damaged, finished or not."""
        return not self.damaged and not self.files

    @property
    def complete(self) -> bool:
        """Whether it is sound and holds all its runs."""
        return self.sound and self.ended and not self.missing

    def damage(self) -> list[str]:
        """Return a line for what belongs to no block and one for each damaged block."""
        return [*([listed(self.files)] if self.files else []), *map(str, self.damaged)]

    def summary(self) -> str:
        """Return the first of these lines, and how many there are."""
        lines = self.damage()
        more = f"; and {len(lines) - _SHOWN} more" if len(lines) > _SHOWN else ""
        return "; ".join(lines[:_SHOWN]) + more

    def facts(self) -> dict[str, Any]:
        """Return it as JSON has it."""
        damaged = [{"block": d.block, "first": d.first, "last": d.last, "files": dict(d.files)} for d in self.damaged]
        return {
            **{"store": self.store, "complete": self.complete, "sound": self.sound, "ended": self.ended},
            **{"runs": self.runs, "blocks": self.blocks, "whole": len(self.whole), "missing": list(self.missing)},
            **{"damaged": damaged, "files": dict(self.files), "writer": self.writer, "others": list(self.others)},
        }


def verify(path: str | os.PathLike[str]) -> Verification:
    """Hold every file of a store against the records of what was written.

    Parameters
    ----------
    path : path
        A batch, finished or not.

    Returns
    -------
    Verification
        `complete` is whether all of it is there and whole; `missing` and `damaged` name the blocks.

    Raises
    ------
    InputError
        If there is no store of this version, or its attributes are no batch's.
    """
    folder = store_folder(path)
    store, files = own_files(folder)
    end = read_record(folder / END)
    if (folder / END).exists() and end is None:
        files[END] = "changed"
    if store is not None and ROOT not in files:
        checked_attributes(folder, store)
    return _blocks(folder, store, end, files | foreign(folder))


def store_folder(path: str | os.PathLike[str]) -> Path:
    """Return the folder of a store, whole or not.

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
    if not (folder / FOLDER).is_dir() and not (folder / "zarr.json").exists():
        raise InputError(f"{folder} is not a batch store: it has no records")
    return folder


def own_files(folder: Path) -> tuple[Record | None, dict[str, str]]:
    """Return the record of a store, if it is whole, and what is wrong with it and the files that it lists.

    Raises
    ------
    InputError
        If the store is of another version.
    """
    check_format(folder / STORE)
    store = read_record(folder / STORE)
    if store is None:
        return None, {STORE: _state(folder, STORE)}
    return store, _differences(folder, store.digests)


def checked_attributes(folder: Path, store: Record | None) -> dict[str, Any]:
    """Return the attributes of a store as they stand in its file.

    Raises
    ------
    InputError
        If they are no batch's, or of another than its record says, if that is whole.
    """
    try:
        attributes: dict[str, Any] = json.loads((folder / ROOT).read_bytes())["attributes"]
        check_attributes(attributes)
        if store is not None:
            check_batch(attributes, store.about)
    except (OSError, ValueError, LookupError, TypeError, RecursionError) as error:
        raise InputError(f"{folder} is not a batch store: {' '.join(str(error).split())}") from error
    return attributes


def listed(files: Mapping[str, str]) -> str:
    """Return what is wrong with files in a line, the first ones by name."""
    shown = [f"{name} is {what}" for name, what in list(files.items())[:_SHOWN]]
    more = len(files) - len(shown)
    return ", ".join([*shown, *([f"and {more} more files"] if more > 0 else [])])


def _blocks(folder: Path, store: Record | None, end: Record | None, files: dict[str, str]) -> Verification:
    runs, chunk, count = _extent(folder, store, end)
    whole, missing, damaged = [], [], []
    for block in range(count):
        name = block_record(block)
        state = _block(folder, name, store, end)
        if state is None:
            missing.append(block)
        elif state:
            last = (block + 1) * chunk - 1
            damaged.append(BlockDamage(block, block * chunk, last if runs is None else min(last, runs - 1), state))
        else:
            whole.append(block)
    if store is not None and store.about["runs"] != runs:
        files[STORE] = "older than the end of the batch"
    blocks = (tuple(whole), tuple(missing), tuple(damaged))
    others = () if store is None else tuple(_others(folder, [store, *([end] if end else [])], count))
    return Verification(str(folder), runs, count, *blocks, files, end is not None, holder(folder), others)


def _others(folder: Path, records: Sequence[Record], blocks: int) -> Iterator[str]:
    """Yield the places of plain files that are neither records nor listed by one."""
    names = [block_record(block) for block in range(blocks)]
    listing = [*records, *(record for name in names if (record := read_record(folder / name)) is not None)]
    known = {STORE, END, LOCK, *names}.union(*(record.digests for record in listing))
    for parent, folders, files in os.walk(folder):
        folders.sort()
        for place in (Path(parent, name) for name in sorted(files)):
            name = place.relative_to(folder).as_posix()
            if name not in known and place.is_file() and not place.is_symlink():
                yield name


def _extent(folder: Path, store: Record | None, end: Record | None) -> tuple[int | None, int, int]:
    """Return runs in all and in a block, and blocks, from whichever record is whole."""
    record = end or store
    if record is not None:
        runs, chunk = record.about["runs"], record.about["chunk"]
        return runs, chunk, -(-runs // chunk)
    known = [record for path in (folder / FOLDER).glob("*.json") if (record := read_record(path)) is not None]
    return None, known[0].about["chunk"] if known else 0, max((r.about["block"] + 1 for r in known), default=0)


def _block(folder: Path, name: str, store: Record | None, end: Record | None) -> dict[str, str] | None:
    """Return what is wrong with a block: nothing, or files; None if it has not been written."""
    sealed = end.digests.get(name) if end else None
    if not (folder / name).exists():
        return {name: "missing"} if sealed else None
    record = read_record(folder / name)
    if record is None or (store and record.about["batch"] != store.about["batch"]):
        return {name: "changed"}
    if sealed not in (None, digest(record.content())):
        return {name: "not the one of the end"}
    return _differences(folder, record.digests)


def _differences(folder: Path, digests: Mapping[str, str]) -> dict[str, str]:
    return {name: _state(folder, name) for name, value in digests.items() if file_digest(folder / name) != value}


def _state(folder: Path, name: str) -> str:
    place = folder / name
    return "a folder" if place.is_dir() else "changed" if place.exists() else "missing"
