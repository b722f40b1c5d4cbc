# SPDX-License-Identifier: Apache-2.0
"""A store without runs: its arrays, names and attributes as Zarr keeps them."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .attributes import NAMES, batch_hash
from .records import FORMAT, STORE, Record, file_digest

if TYPE_CHECKING:
    import zarr

STATUS = "status"
NOT_RUN = 255
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


@dataclass(frozen=True)
class Layout:
    """All of a store but its runs.

    Attributes
    ----------
    n, chunk : int
        Runs in all and in one block.
    variables : sequence of Variable
        What is held for each run; `status` is one of them.
    coordinates : mapping
        Names and instants along second dimensions, by dimension.
    identity : mapping of str to str
        What all blocks have in common; a store whose identity is another is not continued.
    attributes : mapping
        Of the group besides; whatever JSON can say.
    """

    n: int
    chunk: int
    variables: Sequence[Variable]
    coordinates: Mapping[str, Coordinate]
    identity: Mapping[str, str] = field(default_factory=dict)
    attributes: Mapping[str, Any] = field(default_factory=dict)

    @property
    def batch(self) -> str:
        """A hash of the identity, which every record holds."""
        return batch_hash(self.identity, self.chunk)

    def about(self, **more: Any) -> dict[str, Any]:
        """Return what every record says: of which batch, and how many runs a block has."""
        return {"format": FORMAT, "batch": self.batch, "chunk": self.chunk, **more}

    def build(self, target: Any) -> zarr.Group:
        """Write it into a folder or a store of Zarr's."""
        import zarr

        names = [variable.name for variable in self.variables]
        attributes = {**dict(zip(NAMES, (FORMAT, names), strict=True)), **self.attributes, **self.identity}
        group = zarr.create_group(target, zarr_format=3, attributes=attributes)
        for variable in self.variables:
            _array(group, variable, self.n, self.chunk)
        for name, coordinate in self.coordinates.items():
            _coordinate(group, name, coordinate)
        consolidate(group)
        return group

    def build_files(self, folder: Path) -> None:
        """Write it into an empty folder, with the record of the store."""
        self.build(folder)
        (folder / STORE).parent.mkdir()
        (folder / STORE).write_bytes(self.record(folder).content())

    def record(self, folder: Path) -> Record:
        """Return the record of what `build` has written."""
        own = [
            *folder.rglob("zarr.json"),
            *(path for name in self.coordinates for path in (folder / name).rglob("c/*")),
        ]
        digests = {path.relative_to(folder).as_posix(): file_digest(path) or "" for path in sorted(own)}
        return Record(self.about(runs=self.n), digests)


def consolidate(group: zarr.Group) -> None:
    """Copy all metadata into the group's own, where xarray looks for it first."""
    import zarr

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # Zarr 3 has no word on consolidated metadata yet; readers may ignore it
        zarr.consolidate_metadata(group.store, zarr_format=3)


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


def _coordinate(group: zarr.Group, name: str, coordinate: Coordinate) -> None:
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
