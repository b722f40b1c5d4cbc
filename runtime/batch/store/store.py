# SPDX-License-Identifier: Apache-2.0
"""Batch on disk: a Zarr group whose blocks of runs are either recorded or absent.

A block of runs is one chunk of each variable. When all its chunks are on disk, its record with their digests is
written. A block counts as stored if its record exists. Other files of a killed process are written again with the
same bytes.
"""

from __future__ import annotations

import contextlib
import errno
import glob
import json
import os
import secrets
import shutil
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mehvar.base.errors import InputError, MehvarError

from ...interrupts import deferred
from .arrays import ROOT, Array, read_group
from .attributes import NAMES
from .files import Files, Folder, Memory, lay_again, remove_beyond, zarr_store
from .layout import STATUS, Coordinate, Layout, Runs, Variable
from .lock import Lock, is_abandoned, lock_owner
from .records import (
    CURE,
    STORE,
    DamageError,
    Record,
    block_record,
    digest,
    force,
    force_files,
    leftovers,
    write_file,
)
from .verification import (
    Verification,
    listed,
    own_files,
    settled,
    store_folder,
    stored_group,
    verification_now,
    verify,
)

if TYPE_CHECKING:
    import xarray

_NEW = ".new"
"""Ending of an unfinished store."""


class StoreError(MehvarError, OSError):
    """Error if the next block cannot be stored; stored blocks stay."""

    exit_status = 3
    resumable = True

    def __str__(self) -> str:
        return str(self.strerror)


class Store(Runs):
    """An open store.

    Attributes
    ----------
    path : Path or None
        Its folder; None for a store in memory.
    attributes : mapping
        Attributes set at creation.
    n, chunk : int
        Runs in all, stored or not, and per block.
    """

    def __init__(self, files: Files, layout: Layout | None = None, lock: Lock | None = None) -> None:
        self.path = files.root if isinstance(files, Folder) else None
        self.name = str(self.path) if self.path else "the store in memory"
        self._layout, self._lock, self._writes = layout, lock, False
        self._open(files)

    def _open(self, files: Files) -> None:
        self._files = files
        self.attributes, self._arrays = read_group(files.read(ROOT))
        status = self._arrays[STATUS]
        self.n, self.chunk = status.shape[0], status.chunk[0]

    @property
    def width(self) -> int:
        """Number of runs that were computed together."""
        return self.chunk

    def has(self, block: int) -> bool:
        """Return True if a block is stored.

        Raises
        ------
        DamageError
            If its record is damaged or belongs to another block or batch.
        """
        return self._files.about(block) is not None

    def about(self, block: int) -> Mapping[str, Any]:
        """Return the facts in the record of a stored block."""
        about = self._files.about(block)
        if about is None:
            raise DamageError(f"{self.name} is damaged: {block_record(block)} is missing")
        return about

    def verify(self) -> Verification:
        """Check every file against its record; a store in memory has no files."""
        if self.path is not None:
            return verification_now(self.path, None) if self._writes else verify(self.path)
        whole = self.stored()
        missing = sorted(set(range(self.blocks())) - set(whole))
        return Verification(self.name, self.n, self.blocks(), tuple(whole), tuple(missing), (), {}, not missing)

    @deferred()
    def write(self, block: int, values: Mapping[str, NDArray[Any]], **about: Any) -> None:
        """Store a block on disk: first its chunks, then its record.

        Parameters
        ----------
        block : int
            Number of the block.
        values : mapping
            Values of each variable.
        **about
            Further facts for its record.

        Raises
        ------
        StoreError
            If the disk is full or cannot be written; the message names the store.
        """
        runs = self.runs(block)
        facts = self._writable().about(block=block, first=runs.start, last=runs.stop - 1, **about)
        files = (file for name, array in values.items() for file in self._arrays[name].files(block, array))
        try:
            self._files.write(block, files, facts)
        except OSError as error:
            raise _store_error(error, self.name) from error

    @deferred()
    def end(self, n: int) -> None:
        """End the batch after its first n runs, in whole blocks; remove later runs.

        Raises
        ------
        StoreError
            If it cannot be written.
        """
        self._layout = replace(self._writable(), n=n)
        try:
            self._open(self._files.end(self._layout))
        except OSError as error:
            raise _store_error(error, self.name) from error

    def read(self, name: str, blocks: Sequence[int] | None = None) -> NDArray[Any]:
        """Return a variable's values in stored runs, of some or all blocks.

        Raises
        ------
        DamageError
            If a chunk is missing or changed.
        """
        array = self._array(name)
        return self._columns(array, slice(0, sum(array.shape[1:])), self.stored() if blocks is None else blocks)

    def series(self, name: str, first: int, last: int, blocks: Sequence[int]) -> NDArray[np.float64]:
        """Return samples first ... last - 1 of a stored series, shape (runs, samples)."""
        return self._columns(self._array(name), slice(first, last), blocks)

    def _columns(self, array: Array, columns: slice, blocks: Sequence[int]) -> NDArray[Any]:
        """Return some columns of an array in the runs of some blocks."""
        width = (columns.stop - columns.start,) * (len(array.shape) - 1)
        out, place = np.empty((sum(len(self.runs(block)) for block in blocks), *width), array.dtype), 0
        for block in blocks:
            with self._reading(f"{array.name}, block {block}"):
                rows = array.block(self._files.read, block, columns)
            out[place : place + len(rows)] = rows
            place += len(rows)
        return out

    def variables(self) -> dict[str, Variable]:
        """Return the variables of the store, by name."""
        arrays = (array for _, array in sorted(self._arrays.items()) if array.of_runs)
        return {
            array.name: Variable(
                array.name, array.dtype, "".join(array.dimensions[1:]), sum(array.shape[1:]), array.attributes
            )
            for array in arrays
        }

    def coordinate(self, name: str) -> Coordinate:
        """Return the coordinate of a second dimension, empty if the batch has none."""
        if name not in self._arrays:
            return Coordinate([])
        with self._reading(name):
            array = self._arrays[name]
            return Coordinate(array.block(self._files.read, 0), array.attributes)

    @deferred()
    def dataset(self) -> xarray.Dataset:
        """Return the store as an xarray dataset; values are read and verified at first use."""
        import xarray

        names: list[str] = self.attributes["variables"]
        # otherwise xarray would convert numbers with a unit such as "days since 2000"
        opened: xarray.Dataset = xarray.open_zarr(zarr_store(self._files.read), chunks=None, decode_times=False)
        ordered: xarray.Dataset = opened[names]
        return ordered

    @contextlib.contextmanager
    def writing(self) -> Iterator[None]:
        """Prevent other processes from writing.

        Raises
        ------
        InputError
            If another process is writing; the message says which.
        """
        if self.path is None or self._layout is None:  # in memory, or opened to be read
            yield
            return
        lock, self._lock = self._lock or Lock(self.path, self.name), None
        self._writes = True
        try:
            yield
        finally:
            self._writes = False
            lock.release()

    def _writable(self) -> Layout:
        assert self._layout is not None, "the store was opened to be read"
        return self._layout

    def _array(self, name: str) -> Array:
        if name not in self._arrays:
            raise InputError(f"{self.name} is damaged: it has no variable {name}")
        return self._arrays[name]

    @contextlib.contextmanager
    def _reading(self, what: str) -> Iterator[None]:
        """Convert a codec's error about an invalid chunk into an error that names the file."""
        with deferred():
            try:
                yield
            except MehvarError:
                raise
            except Exception as error:
                reason = " ".join(str(error).split())
                raise InputError(f"{self.name} is damaged: {what} cannot be read: {reason}") from error


@deferred()
def create(path: Path | None, layout: Layout) -> Store:
    """Create an empty store, locked by this process, whose name appears when it is complete.

    Parameters
    ----------
    path : Path or None
        A new folder; None keeps the store in memory.
    layout : Layout
        Its contents.

    Raises
    ------
    InputError
        If the name exists already, or its parent folder does not.
    OSError
        If it cannot be written.
    """
    if path is None:
        return Store(Memory(layout), layout)
    _refuse_existing(path)
    if not path.parent.is_dir():
        raise InputError(f"cannot write {path}: the folder {path.parent} does not exist")
    try:
        _remove_abandoned(path)
        lock = _created(path, layout)
        return Store(Folder(path), layout, lock)
    except OSError as error:
        raise OSError(error.errno or 0, f"cannot write {path}: {_reason(error)}") from error


@deferred()
def resume(path: Path, layout: Layout, compare: Callable[[Mapping[str, Any]], None]) -> Store:
    """Open a store to continue it, locked by this process; repair its metadata, names and instants.

    `compare` must accept the folder before anything is changed. A complete store without write permission is opened
    for reading.

    Parameters
    ----------
    path : Path
        The store.
    layout : Layout
        The layout of a new store; the store's own attributes and block size are kept if they are intact.
    compare : callable
        Raises InputError for the attributes of a store that must not be continued.

    Raises
    ------
    InputError
        If there is no store, it is another batch, its record is not intact, it has links, pipes or devices, or
        another process is writing it.
    StoreError
        If it cannot be written.
    """
    store_folder(path)
    _layout_there(path, layout, compare)
    try:
        lock = Lock(path, str(path))
        try:
            for leftover in leftovers(path):
                leftover.unlink()
            layout = _mended(path, layout, compare)
            return Store(Folder(path), layout, lock)
        except BaseException:
            lock.release()
            raise
    except OSError as error:
        if verify(path).complete:
            return open_store(path)
        raise _store_error(error, str(path)) from error


def open_store(path: str | os.PathLike[str]) -> Store:
    """Open a store to read it.

    Raises
    ------
    InputError
        If there is no store, it has another version, or its metadata are damaged.
    """
    folder = store_folder(path)
    opened = settled(folder, lambda _: _opened(folder), lambda result: isinstance(result, Store))
    if isinstance(opened, Store):
        return opened
    if writer := lock_owner(folder):
        raise InputError(
            f"{folder} is being written by {writer}: its metadata are incomplete; try again later"
        ) from opened
    raise opened


@deferred()
def _opened(folder: Path) -> Store | DamageError:
    """Return a store whose files outside of blocks are intact, and are those of a batch."""
    try:
        records, damage = own_files(folder)
        if damage:
            raise DamageError(f"{folder} is damaged: {listed(damage)}; {CURE}")
        _, arrays = stored_group(folder, records.store)
        for name, array in arrays.items():
            if json.loads((folder / name / ROOT).read_bytes()) != array.metadata():
                raise InputError(f"{folder} is not a batch store: {name}/{ROOT} contradicts {ROOT}")
        return Store(Folder(folder))
    except DamageError as error:  # a writer is changing it
        return error
    except OSError as error:
        return DamageError(f"{folder} is damaged: {_reason(error)}; {CURE}")


def _created(path: Path, layout: Layout) -> Lock:
    """Create a store under a temporary name; rename it when it is complete on disk."""
    scratch = path.with_name(f".{path.name}.{secrets.token_hex(8)}{_NEW}")
    scratch.mkdir()
    try:
        lock = Lock(scratch, str(path))
        files = layout.files()
        files[STORE] = layout.record({name: digest(content) for name, content in files.items()}).content()
        for name, content in files.items():
            write_file(scratch / name, content)
        force_files(scratch, files)
        try:
            scratch.rename(path)
        except OSError:
            _refuse_existing(path)  # another process was first
            raise
        lock.follow(path)
        force([path.parent])
        return lock
    finally:
        shutil.rmtree(scratch, ignore_errors=True)


def _refuse_existing(path: Path) -> None:
    if not path.exists() and not path.is_symlink():
        return
    if writer := lock_owner(path):
        raise InputError(f"another process is writing {path}: {writer}")
    raise InputError(f"{path} exists already: continue it with --resume (resume=True) or choose another name")


def _remove_abandoned(path: Path) -> None:
    """Remove leftovers of killed processes that created this store."""
    for scratch in path.parent.glob(f".{glob.escape(path.name)}.*{_NEW}"):
        if is_abandoned(scratch):
            shutil.rmtree(scratch, ignore_errors=True)


def _mended(path: Path, layout: Layout, compare: Callable[[Mapping[str, Any]], None]) -> Layout:
    """Repair metadata, names and instants, complete an unfinished end, and return the layout."""
    layout, record, damage = _layout_there(path, layout, compare)
    if damage or record.about["runs"] != layout.n:
        lay_again(path, layout, record)
    remove_beyond(path, layout.blocks)
    return layout


def _layout_there(
    path: Path, layout: Layout, compare: Callable[[Mapping[str, Any]], None]
) -> tuple[Layout, Record, Mapping[str, str]]:
    """Return the layout of a store to continue, its record, and the damage to files outside of blocks.

    Raises
    ------
    InputError
        If the store is another batch, or its record is not intact.
    """
    records, damage = own_files(path)
    layout = replace(layout, chunk=records.store.about["chunk"])
    if ROOT not in damage:
        attributes, _ = stored_group(path, records.store)
        compare(attributes)
        layout = replace(layout, attributes={k: v for k, v in attributes.items() if k not in NAMES})
    elif layout.batch != records.store.about["batch"]:
        raise InputError(f"{path} is damaged, and its records belong to another batch: it cannot be repaired")
    if isinstance(records.end, Record):
        layout = replace(layout, n=records.end.about["runs"])
    return layout, records.store, damage


def _store_error(error: OSError, name: str) -> StoreError:
    return StoreError(error.errno or errno.EIO, f"cannot write {error.filename2 or name}: {_reason(error)}")


def _reason(error: OSError) -> str:
    return error.strerror or str(error)
