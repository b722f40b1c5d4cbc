# SPDX-License-Identifier: Apache-2.0
"""Files of a store: in a folder, each checked against its record when read, or in memory."""

from __future__ import annotations

import shutil
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, TypeAlias

from .arrays import Read
from .layout import Layout
from .records import (
    CURE,
    END,
    FOLDER,
    STORE,
    DamageError,
    Record,
    Records,
    block_record,
    digest,
    file_digest,
    force_files,
    replace_file,
    write_file,
    write_record,
)


class Memory:
    """Files of a store in memory."""

    def __init__(self, layout: Layout) -> None:
        self._files, self._blocks = layout.files(), dict[int, Mapping[str, Any]]()

    def read(self, name: str) -> bytes | None:
        """Return a file; None if it is absent."""
        return self._files.get(name)

    def about(self, block: int) -> Mapping[str, Any] | None:
        """Return the facts about a stored block; None if it is not stored."""
        return self._blocks.get(block)

    def write(self, block: int, files: Iterable[tuple[str, bytes]], about: Mapping[str, Any]) -> None:
        """Keep the files of a block and its facts."""
        self._files.update(files)
        self._blocks[block] = about

    def end(self, layout: Layout) -> Memory:
        """Forget the runs that are not in a layout."""
        self._files |= layout.files()
        self._blocks = {block: about for block, about in self._blocks.items() if block < layout.blocks}
        return self


class Folder:
    """Files of a store in a folder.

    A chunk of a block without a record counts as absent, because its writer is active or was killed.
    """

    def __init__(self, root: Path) -> None:
        self.root = root
        self._records = Records(root)
        self.record = self._records.store
        self._blocks: dict[int, Record] = {}

    def about(self, block: int) -> Mapping[str, Any] | None:
        """Return the facts about a stored block; None if it is not stored.

        Raises
        ------
        DamageError
            If its record is not intact, or of another block or batch.
        """
        record = self._block(block)
        return None if record is None else record.about

    def read(self, name: str) -> bytes | None:
        """Return a file, or None for a file that no record lists.

        Raises
        ------
        DamageError
            If it is missing or changed.
        """
        where, record = "", self.record
        if name not in record.digests:
            block = _block_of(name)
            # before the file: a writer writes the record last
            of_block = None if block is None else self._block(block)
            if block is None or of_block is None:
                return None
            where, record = self._where(block), of_block
        try:
            content = (self.root / name).read_bytes()
        except (FileNotFoundError, NotADirectoryError, IsADirectoryError):
            raise self._damage(f"{where}{name} is missing") from None
        if digest(content) != record.digests.get(name, ""):
            raise self._damage(f"{where}{name} is changed")
        return content

    def write(self, block: int, files: Iterable[tuple[str, bytes]], about: Mapping[str, Any]) -> None:
        """Write the files of a block, and its record when they are on disk."""
        self._blocks.pop(block, None)
        self._records.remove(block)
        digests = {}
        for name, content in files:
            write_file(self.root / name, content)
            digests[name] = digest(content)
        force_files(self.root, digests)
        write_record(self.root, block_record(block), Record(about, digests))

    def end(self, layout: Layout) -> Folder:
        """Write the record of the end, and remove later runs."""
        names = [block_record(block) for block in range(layout.blocks)]
        digests = {name: digest((self.root / name).read_bytes()) for name in names}
        write_record(self.root, END, Record(layout.about(runs=layout.n), digests))
        if layout.n == self.record.about["runs"]:
            return self
        lay_again(self.root, layout, self.record)
        remove_beyond(self.root, layout.blocks)
        return Folder(self.root)

    def _block(self, block: int) -> Record | None:
        if block not in self._blocks:
            record = self._records.block(block)
            if isinstance(record, str):
                raise self._damage(f"{self._where(block)}{block_record(block)} is {record}")
            if record is None:
                return None
            self._blocks[block] = record
        return self._blocks[block]

    def _where(self, block: int) -> str:
        chunk, runs = self.record.about["chunk"], self.record.about["runs"]
        return f"block {block} (runs {block * chunk} to {min((block + 1) * chunk, runs) - 1}): "

    def _damage(self, what: str) -> DamageError:
        return DamageError(f"{self.root} is damaged: {what}; {CURE}")


Files: TypeAlias = Memory | Folder
"""Files of a store by their names. A block is stored once its facts are written."""


def lay_again(folder: Path, layout: Layout, record: Record) -> None:
    """Rewrite everything except runs and files with a matching record."""
    kept = record.digests if record.about["runs"] == layout.n else {}
    digests = {}
    for name, content in layout.files().items():
        if kept.get(name, "") == file_digest(folder / name):
            digests[name] = kept[name]
        else:
            replace_file(folder, name, content)
            digests[name] = digest(content)
    force_files(folder, digests)
    write_record(folder, STORE, layout.record(digests))


def remove_beyond(folder: Path, blocks: int) -> None:
    """Remove the blocks from a number on, records first, because chunks without record do not count."""
    for path in (*folder.glob(f"{FOLDER}/*.json"), *folder.glob("*/c/*")):
        if path.stem.isdigit() and int(path.stem) >= blocks:  # a coordinate has only chunk 0
            shutil.rmtree(path) if path.is_dir() else path.unlink()


def zarr_store(read: Read) -> Any:
    """Return a store that Zarr reads; `read` checks each file."""
    from zarr.storage import MemoryStore

    class Checked(MemoryStore):
        async def get(self, key: str, prototype: Any = None, *_: Any, **__: Any) -> Any:
            """Return a file; parts are never requested, because the arrays have no shards."""
            content = read(key)
            return None if content is None else prototype.buffer.from_bytes(content)

    return Checked(read_only=True)


def _block_of(name: str) -> int | None:
    """Return the block of a chunk; None for other names, such as files that Zarr looks for."""
    parts = name.split("/")
    return int(parts[2]) if len(parts) > 2 and parts[1] == "c" and parts[2].isdigit() else None
