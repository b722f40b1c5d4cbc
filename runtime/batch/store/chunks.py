# SPDX-License-Identifier: Apache-2.0
"""Files of a store, each checked against its record when read."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .paths import clear_path
from .records import CURE, STORE, DamageError, Proof, Record, WrongRecord, block_record, digest, write_file

if TYPE_CHECKING:
    from pathlib import Path

    from .arrays import Files


class Chunks:
    """Files of a store in a folder.

    A chunk of a block without a record counts as absent, because its writer is active or was killed.

    Attributes
    ----------
    root : Path
        The folder.
    digests : dict of str to str
        Digests of the files written since it was last emptied.
    """

    def __init__(self, root: Path) -> None:
        self.root = root
        self.digests: dict[str, str] = {}
        self._proof = Proof(self.root)
        self._blocks: dict[int, Record] = {}

    @property
    def record(self) -> Record:
        """Record of the store.

        Raises
        ------
        DamageError
            If no intact one exists.
        """
        if self._proof.store is None:
            raise DamageError(f"{self.root} is damaged: {STORE} is missing or changed; {CURE}")
        return self._proof.store

    def block(self, block: int) -> Record | None:
        """Return the record of a block; None if the block is not stored.

        Raises
        ------
        DamageError
            If it is not intact, or of another block or batch.
        """
        if block not in self._blocks:
            record = self._proof.block(block)
            if isinstance(record, WrongRecord):
                raise self._damage(f"{self._where(block)}{block_record(block)} is {record.what}")
            if record is None:
                return None
            self._blocks[block] = record
        return self._blocks[block]

    def forget(self, block: int) -> None:
        """Discard a cached record whose block is rewritten; its digest in the end record no longer counts."""
        self._blocks.pop(block, None)
        self._proof.unseal(block)

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
            of_block = None if block is None else self.block(block)
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

    def write(self, name: str, content: bytes) -> None:
        """Write a file and keep its digest."""
        clear_path(self.root, name)
        self.digests[name] = digest(content)
        write_file(self.root / name, content)

    def _where(self, block: int) -> str:
        return f"block {block} ({runs_text(block, self.record)}): "

    def _damage(self, what: str) -> DamageError:
        return DamageError(f"{self.root} is damaged: {what}; {CURE}")


class Memory(dict[str, bytes]):
    """Files of a store in memory."""

    def read(self, name: str) -> bytes | None:
        """Return a file; None if it is absent."""
        return self.get(name)

    def write(self, name: str, content: bytes) -> None:
        """Keep a file."""
        self[name] = content


def zarr_store(files: Files) -> Any:
    """Return files as a store that Zarr reads; `files` checks each of them."""
    from zarr.storage import MemoryStore

    class Checked(MemoryStore):
        async def get(self, key: str, prototype: Any = None, *_: Any, **__: Any) -> Any:
            """Return a file; parts are never requested, because the arrays have no shards."""
            content = files.read(key)
            return None if content is None else prototype.buffer.from_bytes(content)

    return Checked(read_only=True)


def _block_of(name: str) -> int | None:
    """Return the block of a chunk; None for other names, such as files that Zarr looks for."""
    parts = name.split("/")
    return int(parts[2]) if len(parts) > 2 and parts[1] == "c" and parts[2].isdigit() else None


def runs_text(block: int, store: Record) -> str:
    """Return the runs of a block as text for messages."""
    chunk = store.about["chunk"]
    return f"runs {block * chunk} to {min((block + 1) * chunk, store.about['runs']) - 1}"
