# SPDX-License-Identifier: Apache-2.0
"""The files of a store as Zarr reads and writes them: each that is read is held against the record that lists it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from zarr.storage import LocalStore, WrapperStore

from .places import make_place
from .records import CURE, STORE, DamageError, Record, block_record, digest, read_record

if TYPE_CHECKING:
    from pathlib import Path

    from zarr.abc.buffer import Buffer
    from zarr.abc.store import ByteRequest
    from zarr.core.buffer import BufferPrototype


class Chunks(WrapperStore[LocalStore]):
    """A folder of Zarr's.

    A chunk of a block without a record does not exist: somebody is writing it, or was killed.

    Attributes
    ----------
    digests : dict of str to str
        Of the files written since it was emptied.
    """

    def __init__(self, store: LocalStore) -> None:
        super().__init__(store)
        self.digests: dict[str, str] = {}
        self._records: dict[str, Record | None] = {}

    @property
    def root(self) -> Path:
        """The folder."""
        return self._store.root

    def record(self, name: str) -> Record | None:
        """Return a record; None if there is none that is whole."""
        if self._records.get(name) is None:
            self._records[name] = read_record(self.root / name)
        return self._records[name]

    def forget(self, name: str) -> None:
        """Read a record again when it is needed."""
        self._records.pop(name, None)

    async def get(self, key: str, prototype: BufferPrototype, byte_range: ByteRequest | None = None) -> Buffer | None:
        """Return a file; Zarr asks for parts of one only where an array has shards, which these have not."""
        content = await super().get(key, prototype, byte_range)
        known = self.record(STORE)
        if known is None:
            raise DamageError(f"{self.root} is damaged: {STORE} is missing or changed; {CURE}")
        expected = known.digests.get(key)
        if expected is not None:
            self._compare(key, content, expected, "")
            return content
        name = key.split("/")
        if len(name) < 3 or name[1] != "c":
            return content
        block = int(name[2])
        if not (self.root / block_record(block)).exists():
            return None
        record = self.record(block_record(block))
        where = f"block {block} ({runs_text(block, known)}): "
        if record is None:
            raise DamageError(f"{self.root} is damaged: {where}{block_record(block)} is changed; {CURE}")
        self._compare(key, content, record.digests.get(key, ""), where)
        return content

    async def set(self, key: str, value: Buffer) -> None:
        """Write a file, and keep its digest."""
        make_place(self.root, key)
        self.digests[key] = digest(value.as_buffer_like())
        await super().set(key, value)

    def _compare(self, key: str, content: Buffer | None, expected: str, where: str) -> None:
        if content is None or digest(content.as_buffer_like()) != expected:
            what = "missing" if content is None else "changed"
            raise DamageError(f"{self.root} is damaged: {where}{key} is {what}; {CURE}")


def runs_text(block: int, store: Record) -> str:
    """Return the runs of a block as messages name them."""
    chunk = store.about["chunk"]
    return f"runs {block * chunk} to {min((block + 1) * chunk, store.about['runs']) - 1}"
