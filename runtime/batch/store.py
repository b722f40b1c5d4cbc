# SPDX-License-Identifier: Apache-2.0
"""A batch on disk: a Zarr group whose blocks of runs are either complete or absent.

One chunk of every variable is one block of runs. Zarr renames each chunk into place whole; the chunk of `status` comes
last, and a block counts as stored when it is there. Whatever else a killed process left behind is written again with
the same bytes.
"""

from __future__ import annotations

import contextlib
import errno
import hashlib
import json
import os
import shutil
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from mehvar.errors import InputError, MehvarError

if TYPE_CHECKING:
    import xarray
    import zarr

STATUS = "status"
NOT_RUN = 255
FORMAT = 1
_DIGEST = "sha256"
_LARGEST_CHUNK = 2**22
"""Bytes of a chunk of series, which is held in memory and compressed whole: half as many make twice the files, and a
reader of a few samples decompresses half as much."""


@dataclass(frozen=True)
class Variable:
    """An array of a store: one row per run, or none of the runs' dimension for a coordinate.

    `size` is the length of a second dimension.
    """

    name: str
    dtype: str
    dimension: str = ""
    size: int = 0
    attributes: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Coordinate:
    """What stands along a second dimension: names, or numbers such as instants."""

    values: Sequence[str] | NDArray[np.float64]
    attributes: Mapping[str, Any] = field(default_factory=dict)


class StoreError(MehvarError, OSError):
    """The store cannot take the next block; what it has is kept."""

    exit_status = 3
    resumable = True

    def __str__(self) -> str:
        return str(self.strerror)


class Store:
    """An open store.

    Attributes
    ----------
    path : Path or None
        Where it is; None for one in memory.
    attributes : mapping
        Whatever was said at creation.
    chunk, n : int
        Runs per block, and runs in all.
    """

    def __init__(self, group: Any, path: Path | None) -> None:
        self._group = group
        self.path = path
        self.attributes: dict[str, Any] = dict(group.attrs)
        self._arrays = _arrays(group)
        self._status = self._arrays[STATUS]
        self.chunk = int(self._status.chunks[0])

    @property
    def n(self) -> int:
        """Runs in all, stored or not."""
        return int(self._status.shape[0])

    @property
    def name(self) -> str:
        """How messages call it."""
        return str(self.path) if self.path else "the store in memory"

    def blocks(self) -> int:
        """Return the number of blocks."""
        return -(-self.n // self.chunk)

    def runs(self, block: int) -> range:
        """Return the runs of a block."""
        return range(block * self.chunk, min((block + 1) * self.chunk, self.n))

    def stored(self) -> list[int]:
        """Return the blocks that are stored, in order."""
        if self.path is not None:
            folder = self.path / STATUS / "c"
            names = [entry.name for entry in folder.iterdir()] if folder.is_dir() else []
            return sorted(int(name) for name in names if name.isdigit() and int(name) < self.blocks())
        return [block for block in range(self.blocks()) if self._status[block * self.chunk] != NOT_RUN]

    def write(self, block: int, values: Mapping[str, NDArray[Any]]) -> None:
        """Store a block, its status last.

        Raises
        ------
        StoreError
            If the disk is full or cannot be written; the message says which store.
        """
        rows = slice(self.runs(block).start, self.runs(block).stop)
        names = [name for name in values if name != STATUS]
        try:
            for name in (*names, STATUS):
                self._arrays[name][rows] = values[name]
        except OSError as error:
            raise StoreError(error.errno or errno.EIO, f"cannot write {self.name}: {_reason(error)}") from error

    def read(self, name: str, blocks: Sequence[int] | None = None) -> NDArray[Any]:
        """Return a variable's values for the stored runs of some blocks, or of all stored blocks."""
        array = self._array(name)
        selection = self.stored() if blocks is None else blocks
        out = np.empty((sum(len(self.runs(b)) for b in selection), *array.shape[1:]), dtype=array.dtype)
        place = 0
        for block in selection:
            runs = self.runs(block)
            with self._reading(name, f", block {block}"):
                out[place : place + len(runs)] = array[runs.start : runs.stop]
            place += len(runs)
        return out

    def coordinate(self, name: str) -> NDArray[Any]:
        """Return a variable that is not one row per run."""
        with self._reading(name):
            values: NDArray[Any] = self._array(name)[:]
        return values

    def series(self, name: str, first: int, last: int, blocks: Sequence[int]) -> NDArray[np.float64]:
        """Return the samples first ... last - 1 of a stored series, shape (runs, samples)."""
        array = self._array(name)
        with self._reading(name):
            return np.concatenate([array[self.runs(b).start : self.runs(b).stop, first:last] for b in blocks])

    def _array(self, name: str) -> Any:
        if name not in self._arrays:
            raise InputError(f"{self.name} is damaged: it has no variable {name}")
        return self._arrays[name]

    @contextlib.contextmanager
    def _reading(self, name: str, where: str = "") -> Iterator[None]:
        """Turn whatever Zarr and its codecs raise over a damaged chunk into an error that says which."""
        try:
            yield
        except Exception as error:
            what = " ".join(str(error).split())
            raise InputError(f"{self.name} is damaged: {name}{where} cannot be read: {what}") from error

    def variables(self) -> dict[str, Variable]:
        """Return what the store holds, by name."""
        variables: dict[str, Variable] = {}
        for name, array in self._arrays.items():
            first, *rest = array.metadata.dimension_names
            second, size = (rest[0], array.shape[1]) if rest else ("", 0)
            if first == "run":
                variables[name] = Variable(name, str(array.dtype), second, size, dict(array.attrs))
        return dict(sorted(variables.items()))

    def cut(self, n: int) -> None:
        """Keep the first n runs only, a whole number of blocks."""
        arrays = [array for name, array in self._arrays.items() if name != STATUS]
        for array in (*arrays, self._status):
            if array.metadata.dimension_names[0] == "run" and array.shape[0] > n:
                array.resize((n, *array.shape[1:]))
        _consolidate(self._group)

    def dataset(self) -> xarray.Dataset:
        """Open it with xarray; values are read when they are used."""
        import xarray

        names: list[str] = self.attributes["variables"]
        opened: xarray.Dataset = xarray.open_zarr(self._group.store, chunks=None)
        ordered: xarray.Dataset = opened[names]
        return ordered

    @contextlib.contextmanager
    def writing(self) -> Iterator[None]:
        """Keep other processes from writing, and remove what a killed one left half written.

        Raises
        ------
        InputError
            If another process is writing.
        StoreError
            If the store cannot be written at all.
        """
        if self.path is None:
            yield
            return
        with (self.path / "zarr.json").open("rb") as file:
            if not _lock(file):
                raise InputError(f"another process is writing {self.path}")
            try:
                for leftover in self.path.rglob("*.partial"):
                    leftover.unlink()
            except OSError as error:
                raise StoreError(error.errno or 0, f"cannot write {self.name}: {_reason(error)}") from error
            yield


def create(
    path: Path | None,
    n: int,
    chunk: int,
    variables: Sequence[Variable],
    coordinates: Mapping[str, Coordinate],
    **attributes: Any,
) -> Store:
    """Make a store without runs; it appears under its name when it is complete.

    Parameters
    ----------
    path : Path or None
        A new folder; None keeps the store in memory.
    n, chunk : int
        Runs in all and in one block.
    variables : sequence of Variable
        What the store holds for each run; `status` is one of them.
    coordinates : mapping
        Names and instants along second dimensions, by dimension.
    **attributes
        Of the group; whatever JSON can say.

    Raises
    ------
    InputError
        If there is something of that name, or no folder to put it into.
    OSError
        If it cannot be written.
    """
    if path is None:
        import zarr

        return _fill(zarr.storage.MemoryStore(), None, n, chunk, variables, coordinates, attributes)
    if path.exists() or path.is_symlink():
        raise InputError(f"{path} exists already: continue it with --resume (resume=True) or choose another name")
    if not path.parent.is_dir():
        raise InputError(f"cannot write {path}: the folder {path.parent} does not exist")
    temporary = path.with_name(f".{path.name}.new")
    try:
        if temporary.exists():
            shutil.rmtree(temporary)
        _fill(temporary, path, n, chunk, variables, coordinates, attributes)
        temporary.rename(path)
    except OSError as error:
        raise OSError(error.errno or 0, f"cannot write {path}: {_reason(error)}") from error
    finally:
        shutil.rmtree(temporary, ignore_errors=True)
    return open_store(path)


def open_store(path: str | os.PathLike[str]) -> Store:
    """Open a store.

    Raises
    ------
    InputError
        If there is none, or it is not a batch of this version.
    """
    import zarr

    folder = Path(path)
    if not folder.is_dir():
        raise InputError(f"no batch store {folder}")
    try:
        group = zarr.open_group(folder, mode="r+", use_consolidated=False)
        if group.attrs.get("mehvar_batch") != FORMAT:
            raise ValueError(f"mehvar_batch = {group.attrs.get('mehvar_batch')!r} in its attributes, not {FORMAT}")
        if group.attrs.get(_DIGEST, digest := _digest(group)) != digest:
            raise ValueError("it is damaged: its attributes are not those it was made with")
        return Store(group, folder)
    except Exception as error:  # a damaged store makes Zarr and its parsers raise anything
        raise InputError(f"{folder} is not a batch store: {' '.join(str(error).split())}") from error


def _arrays(group: Any) -> dict[str, Any]:
    """Return the variables and the coordinates along their second dimensions, by name.

    One after the other: opened all at once, several damaged ones leave errors behind that nobody collects.
    """
    arrays = {name: group[name] for name in group.attrs["variables"]}
    dimensions = {name for array in arrays.values() for name in array.metadata.dimension_names[1:]}
    return arrays | {name: group[name] for name in sorted(dimensions) if name in group}


def _digest(group: Any) -> str:
    """Return a hash of all that a store says about itself but its number of runs, which a stop rule may cut."""
    arrays = {name: {**array.metadata.to_dict(), "shape": None} for name, array in _arrays(group).items()}
    attributes = {name: value for name, value in group.attrs.items() if name != _DIGEST}
    return hashlib.sha256(json.dumps([attributes, arrays], sort_keys=True, default=str).encode()).hexdigest()


def _fill(
    target: Any,
    path: Path | None,
    n: int,
    chunk: int,
    variables: Sequence[Variable],
    coordinates: Mapping[str, Coordinate],
    attributes: Mapping[str, Any],
) -> Store:
    import zarr

    group = zarr.create_group(
        target,
        zarr_format=3,
        attributes={"mehvar_batch": FORMAT, "variables": [v.name for v in variables], **attributes},
    )
    for variable in variables:
        _array(group, variable, n, chunk)
    for name, coordinate in coordinates.items():
        text = not isinstance(coordinate.values, np.ndarray)
        values = np.array(coordinate.values, dtype=object if text else np.float64)
        array = group.create_array(
            name,
            shape=values.shape,
            chunks=values.shape,
            dtype="string" if text else "float64",
            fill_value="" if text else np.nan,
            compressors=None,
            dimension_names=[name],
            attributes=dict(coordinate.attributes),
        )
        array[:] = values
    group.attrs[_DIGEST] = _digest(group)
    _consolidate(group)
    return Store(group, path)


def _array(group: zarr.Group, variable: Variable, n: int, chunk: int) -> None:
    from zarr.codecs import ZstdCodec

    second = (variable.size,) if variable.dimension else ()
    width = np.dtype(variable.dtype).itemsize
    piece = second
    if variable.dimension == "t":
        piece = (max(1, min(variable.size, _LARGEST_CHUNK // (chunk * width))),)
    group.create_array(
        variable.name,
        shape=(n, *second),
        chunks=(chunk, *piece),
        dtype=variable.dtype,
        fill_value=np.nan if variable.dtype.startswith("float") else NOT_RUN if variable.name == STATUS else 0,
        compressors=[ZstdCodec(level=1, checksum=True)],
        dimension_names=["run", *([variable.dimension] if variable.dimension else [])],
        attributes=dict(variable.attributes),
    )


def _consolidate(group: zarr.Group) -> None:
    """Copy all metadata into the group's own, where xarray looks for it first."""
    import zarr

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # Zarr 3 has no word on consolidated metadata yet; readers may ignore it
        zarr.consolidate_metadata(group.store, zarr_format=3)


def _lock(file: BinaryIO) -> bool:
    """Lock a file until it is closed; false when another process has. File systems without locks are trusted."""
    try:
        import fcntl

        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except (ImportError, OSError):
        return True
    return True


def _reason(error: OSError) -> str:
    return error.strerror or str(error)
