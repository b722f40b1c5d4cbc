# SPDX-License-Identifier: Apache-2.0
"""Files of a store as Zarr reads and writes them; each file is checked against its record when read."""

from __future__ import annotations

from typing import TYPE_CHECKING

from zarr.storage import LocalStore, WrapperStore

from .places import make_place
from .records import CURE, STORE, DamageError, Proof, Record, Stray, block_record, digest

if TYPE_CHECKING:
    from pathlib import Path

    from zarr.abc.buffer import Buffer
    from zarr.abc.store import ByteRequest
    from zarr.core.buffer import BufferPrototype


class Chunks(WrapperStore[LocalStore]):
    """A folder as a Zarr store.

    A chunk of a block without a record counts as absent: its writer is still at work, or was killed.

    Attributes
    ----------
    digests : dict of str to str
        Digests of the files written since it was last emptied.
    """

    def __init__(self, store: LocalStore) -> None:
        super().__init__(store)
        self.digests: dict[str, str] = {}
        self._proof = Proof(self.root)
        self._blocks: dict[int, Record] = {}

    @property
    def root(self) -> Path:
        """The folder."""
        return self._store.root

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
            if isinstance(record, Stray):
                raise self._damage(f"{self._where(block)}{block_record(block)} is {record.what}")
            if record is None:
                return None
            self._blocks[block] = record
        return self._blocks[block]

    def forget(self, block: int) -> None:
        """Discard a cached record, as its block is rewritten; its digest in the end record no longer counts."""
        self._blocks.pop(block, None)
        self._proof.unseal(block)

    async def get(self, key: str, prototype: BufferPrototype, byte_range: ByteRequest | None = None) -> Buffer | None:
        """Return a file; parts of files are never requested, as the arrays have no shards."""
        where, record = "", self.record
        if key not in record.digests:
            block = _block_of(key)
            if block is None:
                return await super().get(key, prototype, byte_range)
            # before the file: a writer writes the record last
            of_block = self.block(block)
            if of_block is None:
                return None
            where, record = self._where(block), of_block
        content = await super().get(key, prototype, byte_range)
        if content is None or digest(content.as_buffer_like()) != record.digests.get(key, ""):
            raise self._damage(f"{where}{key} is {'missing' if content is None else 'changed'}")
        return content

    async def set(self, key: str, value: Buffer) -> None:
        """Write a file and keep its digest."""
        make_place(self.root, key)
        self.digests[key] = digest(value.as_buffer_like())
        await super().set(key, value)

    def _where(self, block: int) -> str:
        return f"block {block} ({runs_text(block, self.record)}): "

    def _damage(self, what: str) -> DamageError:
        return DamageError(f"{self.root} is damaged: {what}; {CURE}")


def _block_of(key: str) -> int | None:
    """Return the block of a chunk; None for other names, such as files that Zarr looks for."""
    name = key.split("/")
    return int(name[2]) if len(name) > 2 and name[1] == "c" else None


def runs_text(block: int, store: Record) -> str:
    """Return the runs of a block as text for messages."""
    chunk = store.about["chunk"]
    return f"runs {block * chunk} to {min((block + 1) * chunk, store.about['runs']) - 1}"
