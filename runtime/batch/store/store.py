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
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mehvar.base.errors import InputError, MehvarError

from ...interrupts import deferred
from .arrays import ROOT, Array, Files, read_array
from .attributes import NAMES, check_attributes, check_batch, check_variables
from .chunks import Chunks, Memory, zarr_store
from .layout import STATUS, Layout, Variable
from .lock import Lock, is_abandoned, lock_owner
from .paths import clear_path, remove_special_files, special_files
from .records import (
    CURE,
    END,
    FOLDER,
    STORE,
    DamageError,
    Record,
    block_record,
    check_format,
    digest,
    file_digest,
    force,
    leftovers,
    read_record,
    replace_file,
    write_file,
    write_record,
)
from .verification import (
    Verification,
    check_identified,
    checked_attributes,
    listed,
    own_files,
    settled,
    store_folder,
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


class Store:
    """An open store.

    Attributes
    ----------
    path : Path or None
        Its folder; None for a store in memory.
    attributes : mapping
        Attributes set at creation.
    chunk, n : int
        Runs per block, and runs in all.
    """

    def __init__(self, files: Chunks | Memory, layout: Layout | None = None, lock: Lock | None = None) -> None:
        self._files, self._layout, self._lock = files, layout, lock
        self._writes = False
        self._chunks = None if isinstance(files, Memory) else files
        self.path = None if isinstance(files, Memory) else files.root
        self.attributes = _attributes(files)
        self._arrays = _arrays(files, self.attributes["variables"])
        self._status = self._arrays[STATUS]
        self._memory: dict[int, Mapping[str, Any]] = {}
        self.chunk = self._status.chunk[0]

    @property
    def n(self) -> int:
        """Number of runs, stored or not."""
        return self._status.shape[0]

    @property
    def name(self) -> str:
        """Name for messages."""
        return str(self.path) if self.path else "the store in memory"

    def blocks(self) -> int:
        """Return the number of blocks."""
        return -(-self.n // self.chunk)

    @property
    def width(self) -> int:
        """Number of runs that are computed together."""
        return self.chunk

    def runs(self, block: int) -> range:
        """Return the run numbers of a block."""
        return range(block * self.chunk, min((block + 1) * self.chunk, self.n))

    def stored(self) -> list[int]:
        """Return the blocks that are stored, in order.

        Raises
        ------
        DamageError
            If a record is damaged or belongs to another block or batch.
        """
        if self._chunks is None:
            return sorted(self._memory)
        return [block for block in range(self.blocks()) if self.has(block)]

    def has(self, block: int) -> bool:
        """Return True if a block is stored.

        Raises
        ------
        DamageError
            If its record is damaged or belongs to another block or batch.
        """
        return block in self._memory if self._chunks is None else self._chunks.block(block) is not None

    def about(self, block: int) -> Mapping[str, Any]:
        """Return the facts in the record of a stored block."""
        if self._chunks is None:
            return self._memory[block]
        record = self._chunks.block(block)
        if record is None:
            raise DamageError(f"{self.name} is damaged: {block_record(block)} is missing")
        return record.about

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
        try:
            if self._chunks is not None:
                self._chunks.forget(block)
                clear_path(self._chunks.root, block_record(block))
                (self._chunks.root / block_record(block)).unlink(missing_ok=True)
                self._chunks.digests.clear()
            for name, array in values.items():
                self._arrays[name].write(self._files, block, array)
            if self._chunks is None or self._layout is None:
                self._memory[block] = about
                return
            _force_files(self._chunks.root, self._chunks.digests)
            facts = self._layout.about(block=block, first=runs.start, last=runs.stop - 1, **about)
            write_record(self._chunks.root, block_record(block), Record(facts, dict(self._chunks.digests)))
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
        if self._chunks is None or self._layout is None:
            self._cut(n)
            return
        blocks = -(-n // self.chunk)
        try:
            folder = self._chunks.root
            names = [block_record(block) for block in range(blocks)]
            digests = {name: digest((folder / name).read_bytes()) for name in names}
            write_record(folder, END, Record(self._layout.about(runs=n), digests))
            if n < self.n:
                self._layout = replace(self._layout, n=n)
                _lay_again(folder, self._layout, None)
                _remove_beyond(folder, blocks)
                self._open_again()
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
        selection = self.stored() if blocks is None else blocks
        out = np.empty((sum(len(self.runs(b)) for b in selection), *array.shape[1:]), array.dtype)
        place = 0
        for block in selection:
            runs = self.runs(block)
            with self._reading(name, f", block {block}"):
                out[place : place + len(runs)] = array.block(self._files, block)
            place += len(runs)
        return out

    def coordinate(self, name: str) -> NDArray[Any]:
        """Return a coordinate or other variable without run dimension."""
        with self._reading(name):
            return self._array(name).block(self._files, 0)

    def series(self, name: str, first: int, last: int, blocks: Sequence[int]) -> NDArray[np.float64]:
        """Return samples first ... last - 1 of a stored series, shape (runs, samples)."""
        array = self._array(name)
        with self._reading(name):
            return np.concatenate([array.block(self._files, block, slice(first, last)) for block in blocks])

    def variables(self) -> dict[str, Variable]:
        """Return the variables of the store, by name."""
        variables: dict[str, Variable] = {}
        for name, array in self._arrays.items():
            first, *rest = array.dimensions
            second, size = (rest[0], array.shape[1]) if rest else ("", 0)
            if first == "run":
                variables[name] = Variable(name, array.dtype, second, size, dict(array.attributes))
        return dict(sorted(variables.items()))

    def array_attributes(self) -> dict[str, dict[str, Any]]:
        """Return the attributes of each variable and coordinate."""
        return {name: dict(array.attributes) for name, array in self._arrays.items()}

    @deferred()
    def dataset(self) -> xarray.Dataset:
        """Return the store as an xarray dataset; values are read and verified at first use."""
        import xarray

        names: list[str] = self.attributes["variables"]
        # otherwise xarray would convert numbers with a unit such as "days since 2000"
        opened: xarray.Dataset = xarray.open_zarr(zarr_store(self._files), chunks=None, decode_times=False)
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

    def _cut(self, n: int) -> None:
        if self._layout is not None and n < self.n:
            self._layout = replace(self._layout, n=n)
            self._layout.build(self._files)
            self._arrays = _arrays(self._files, self.attributes["variables"])
            self._status = self._arrays[STATUS]
            self._memory = {block: about for block, about in self._memory.items() if block < self.blocks()}

    def _open_again(self) -> None:
        if self.path is not None:
            self._files = self._chunks = Chunks(self.path)
            self._arrays = _arrays(self._files, self.attributes["variables"])
            self._status = self._arrays[STATUS]

    def _array(self, name: str) -> Array:
        if name not in self._arrays:
            raise InputError(f"{self.name} is damaged: it has no variable {name}")
        return self._arrays[name]

    @contextlib.contextmanager
    def _reading(self, name: str, where: str = "") -> Iterator[None]:
        """Convert a codec's error about an invalid chunk into an error that names the file."""
        with deferred():
            try:
                yield
            except MehvarError:
                raise
            except Exception as error:
                what = " ".join(str(error).split())
                raise InputError(f"{self.name} is damaged: {name}{where} cannot be read: {what}") from error


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
        files = Memory()
        layout.build(files)
        return Store(files, layout)
    _refuse_existing(path)
    if not path.parent.is_dir():
        raise InputError(f"cannot write {path}: the folder {path.parent} does not exist")
    try:
        _remove_abandoned(path)
        return _open_for_writing(path, layout, _created(path, layout))
    except OSError as error:
        raise OSError(error.errno or 0, f"cannot write {path}: {_reason(error)}") from error


@deferred()
def resume(path: Path, layout: Layout, compare: Callable[[Mapping[str, Any]], None]) -> Store:
    """Repair a store's metadata, names and instants, and open it to continue, locked by this process.

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
        If there is no store, another process is writing it, or no intact part identifies it as this batch.
    StoreError
        If it cannot be written.
    """
    store_folder(path)
    _layout_there(path, layout, compare)
    try:
        lock = Lock(path, str(path))
        try:
            remove_special_files(path)
            for leftover in leftovers(path):
                leftover.unlink()
            return _open_for_writing(path, _mended(path, layout, compare), lock)
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
    if not (folder / FOLDER).is_dir():
        raise InputError(f"{folder} is not a batch store: it has no records")
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
    if files := special_files(folder):
        check_identified(folder)
        return DamageError(f"{folder} is damaged: {listed(files)}; {CURE}")
    check_format(folder / STORE)
    try:
        chunks = Chunks(folder)
        attributes = _attributes(chunks)
        check_attributes(attributes)
        check_batch(attributes, chunks.record.about)
        store = Store(chunks)
        numbers = [name for name, v in store.variables().items() if not v.dimension and v.dtype == "float64"]
        check_variables(store.attributes, numbers, store.array_attributes())
        return store
    except DamageError as error:
        return error
    except InputError:
        raise
    except Exception as error:  # for a folder that is not a store, parsers raise anything
        raise InputError(f"{folder} is not a batch store: {' '.join(str(error).split())}") from error


def _attributes(files: Files) -> dict[str, Any]:
    content = files.read(ROOT)
    if content is None:
        raise ValueError(f"it has no {ROOT}")
    attributes: dict[str, Any] = json.loads(content)["attributes"]
    return attributes


def _arrays(files: Files, variables: Sequence[str]) -> dict[str, Array]:
    """Return variables and the coordinates of their second dimensions, by name."""
    arrays = {name: read_array(files, name) for name in variables}
    dimensions = {name for array in arrays.values() for name in array.dimensions[1:]}
    return arrays | {name: read_array(files, name) for name in sorted(dimensions)}


def _created(path: Path, layout: Layout) -> Lock:
    """Create a store under a temporary name; rename it when it is complete on disk."""
    scratch = path.with_name(f".{path.name}.{secrets.token_hex(8)}{_NEW}")
    scratch.mkdir()
    try:
        lock = Lock(scratch, str(path))
        files = layout.files()
        record = layout.record({name: digest(content) for name, content in files.items()})
        for name, content in {**files, STORE: record.content()}.items():
            write_file(scratch / name, content)
        _force_files(scratch, [*files, STORE])
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


def _open_for_writing(path: Path, layout: Layout, lock: Lock) -> Store:
    return Store(Chunks(path), layout, lock)


def _mended(path: Path, layout: Layout, compare: Callable[[Mapping[str, Any]], None]) -> Layout:
    """Repair metadata, names and instants, complete an unfinished end, and return the layout."""
    layout, record, files = _layout_there(path, layout, compare)
    if record is None or files or record.about["runs"] != layout.n:
        _lay_again(path, layout, record)
    _remove_beyond(path, -(-layout.n // layout.chunk))
    return layout


def _layout_there(
    path: Path, layout: Layout, compare: Callable[[Mapping[str, Any]], None]
) -> tuple[Layout, Record | None, Mapping[str, str]]:
    """Return the layout of a store to continue, its record, and the damage to files outside of blocks.

    Raises
    ------
    InputError
        If the intact part of the folder does not identify it as this batch.
    """
    proof, files = own_files(path)
    record = proof.store
    if record is not None and ROOT not in files:
        attributes = checked_attributes(path, record)
        compare(attributes)
        own = {name: value for name, value in attributes.items() if name not in (*layout.identity, *NAMES)}
        layout = replace(layout, chunk=record.about["chunk"], attributes=own)
    else:
        layout = replace(layout, chunk=_chunk_by_evidence(path, layout, compare))
    if isinstance(proof.end, Record) and proof.end.about["batch"] == layout.batch:
        layout = replace(layout, n=proof.end.about["runs"])
    return layout, record, files


def _chunk_by_evidence(path: Path, layout: Layout, compare: Callable[[Mapping[str, Any]], None]) -> int:
    """Return the runs per block of a store with damaged attributes, if its intact part identifies the batch."""
    records = [record for file in (path / FOLDER).glob("*.json") if (record := read_record(file)) is not None]
    for record in records:
        if record.about["batch"] != replace(layout, chunk=record.about["chunk"]).batch:
            raise InputError(f"{path} is damaged, and its records belong to another batch: it cannot be repaired")
    if records:
        return int(records[0].about["chunk"])
    compare(checked_attributes(path, None))
    return _chunk_by_metadata(path) or layout.chunk


def _chunk_by_metadata(path: Path) -> int:
    """Return the runs per block from a variable's metadata, unverified; 0 if that is missing."""
    try:
        metadata = json.loads((path / STATUS / ROOT).read_bytes())
        runs = metadata["chunk_grid"]["configuration"]["chunk_shape"][0]
    except (OSError, ValueError, LookupError, TypeError, RecursionError):
        return 0
    return runs if type(runs) is int and 0 < runs <= metadata["shape"][0] else 0


def _lay_again(folder: Path, layout: Layout, record: Record | None) -> None:
    """Rewrite everything except runs and files with a matching record."""
    kept = record.digests if record is not None and record.about["runs"] == layout.n else {}
    digests = {}
    for name, content in layout.files().items():
        if kept.get(name, "") == file_digest(folder / name):
            digests[name] = kept[name]
        else:
            replace_file(folder, name, content)
            digests[name] = digest(content)
    _force_files(folder, digests)
    write_record(folder, STORE, layout.record(digests))


def _remove_beyond(folder: Path, blocks: int) -> None:
    """Remove the blocks from a number on, records first, because chunks without record do not count."""
    for path in (*folder.glob(f"{FOLDER}/*.json"), *folder.glob("*/c/*")):
        if path.stem.isdigit() and int(path.stem) >= blocks and path.parent.parent.name not in _coordinates(folder):
            shutil.rmtree(path) if path.is_dir() else path.unlink()


def _coordinates(folder: Path) -> set[str]:
    """Return the variables whose chunks are not blocks; the store's record lists them."""
    record = read_record(folder / STORE)
    return {name.split("/")[0] for name in (record.digests if record else ()) if "/c/" in name}


def _force_files(folder: Path, names: Iterable[str]) -> None:
    """Flush files and all folders on their paths to disk."""
    files = list(names)
    folders = {name[:k] for name in files for k, letter in enumerate(name) if letter == "/"}
    force([folder / name for name in (*files, *sorted(folders), "")])


def _store_error(error: OSError, name: str) -> StoreError:
    return StoreError(error.errno or errno.EIO, f"cannot write {name}: {_reason(error)}")


def _reason(error: OSError) -> str:
    return error.strerror or str(error)
