# SPDX-License-Identifier: Apache-2.0
"""Layout of a store without runs: arrays, names and attributes in Zarr's form."""

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
"""Bytes of a chunk of series, which is compressed as a whole in memory. Half as many double the files; short reads
then decompress half as much."""


@dataclass(frozen=True)
class Variable:
    """An array of a store: one row per run, or a coordinate without run dimension.

    `size` is the length of a second dimension.
    """

    name: str
    dtype: str
    dimension: str = ""
    size: int = 0
    attributes: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Coordinate:
    """Coordinate of a second dimension: names or numbers, such as instants."""

    values: Sequence[str] | NDArray[np.float64]
    attributes: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Layout:
    """All contents of a store except its runs.

    Attributes
    ----------
    n, chunk : int
        Runs in total and in one block.
    variables : sequence of Variable
        Variables of each run; `status` is one of them.
    coordinates : mapping
        Names and instants along second dimensions, by dimension.
    identity : mapping of str to str
        Everything that all blocks share; a store with another identity is not continued.
    attributes : mapping
        Other attributes of the group; any JSON values.
    """

    n: int
    chunk: int
    variables: Sequence[Variable]
    coordinates: Mapping[str, Coordinate]
    identity: Mapping[str, str] = field(default_factory=dict)
    attributes: Mapping[str, Any] = field(default_factory=dict)

    @property
    def batch(self) -> str:
        """Hash of the identity, which every record contains."""
        return batch_hash(self.identity, self.chunk)

    def about(self, **more: Any) -> dict[str, Any]:
        """Return the facts in every record: batch and runs per block."""
        return {"format": FORMAT, "batch": self.batch, "chunk": self.chunk, **more}

    def build(self, target: Any) -> zarr.Group:
        """Write the layout into a folder or a Zarr store."""
        import zarr
        from zarr.core.group import ConsolidatedMetadata, GroupMetadata

        names = [variable.name for variable in self.variables]
        attributes = {**dict(zip(NAMES, (FORMAT, names), strict=True)), **self.attributes, **self.identity}
        arrays = {variable.name: _array(variable, self.n, self.chunk) for variable in self.variables}
        arrays |= {name: _coordinate(name, coordinate) for name, coordinate in self.coordinates.items()}
        # all at once: writing each array and reading it again for the group's copy takes eight times as long
        listed = ConsolidatedMetadata(metadata=dict(sorted(arrays.items())))
        group = GroupMetadata(attributes=attributes, zarr_format=3, consolidated_metadata=listed)
        store = zarr.storage.LocalStore(target) if isinstance(target, Path) else target
        nodes: dict[str, Any] = dict(zarr.create_hierarchy(store=store, nodes={"": group, **arrays}))
        for name, coordinate in self.coordinates.items():
            nodes[name][:] = _values(coordinate)
        made: zarr.Group = nodes[""]
        return made

    def build_files(self, folder: Path) -> None:
        """Write the layout with the store's record into an empty folder."""
        self.build(folder)
        (folder / STORE).parent.mkdir()
        (folder / STORE).write_bytes(self.record(folder).content())

    def record(self, folder: Path) -> Record:
        """Return the record of the files written by `build`."""
        own = [
            *folder.rglob("zarr.json"),
            *(path for name in self.coordinates for path in (folder / name).rglob("c/*")),
        ]
        digests = {path.relative_to(folder).as_posix(): file_digest(path) or "" for path in sorted(own)}
        return Record(self.about(runs=self.n), digests)


def consolidate(group: zarr.Group) -> None:
    """Copy all metadata into the group's metadata, where xarray looks first."""
    import zarr

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # Zarr 3 does not specify consolidated metadata yet; readers may ignore it
        zarr.consolidate_metadata(group.store, zarr_format=3)


def _array(variable: Variable, n: int, chunk: int) -> Any:
    """Return the metadata of a variable."""
    second = (variable.size,) if variable.dimension else ()
    width = np.dtype(variable.dtype).itemsize
    piece = second
    if variable.dimension == "t":
        piece = (max(1, min(variable.size, _LARGEST_CHUNK // (chunk * width))),)
    fill: str | int = NOT_RUN if variable.name == STATUS else 0
    return _metadata(
        (n, *second),
        (chunk, *piece),
        variable.dtype,
        fill_value="NaN" if variable.dtype.startswith("float") else fill,
        codecs=[
            _bytes(variable.dtype),
            {"name": "zstd", "configuration": {"level": 1, "checksum": True}},
        ],
        dimension_names=["run", *([variable.dimension] if variable.dimension else [])],
        attributes=dict(variable.attributes),
    )


def _coordinate(name: str, coordinate: Coordinate) -> Any:
    """Return the metadata of a coordinate, stored as one chunk."""
    values = _values(coordinate)
    text = values.dtype == object
    return _metadata(
        values.shape,
        values.shape,
        "string" if text else "float64",
        fill_value="" if text else "NaN",
        codecs=[{"name": "vlen-utf8"} if text else _bytes("float64")],
        dimension_names=[name],
        attributes=dict(coordinate.attributes),
    )


def _values(coordinate: Coordinate) -> NDArray[Any]:
    text = not isinstance(coordinate.values, np.ndarray)
    return np.array(coordinate.values, dtype=object if text else np.float64)


def _bytes(dtype: str) -> dict[str, Any]:
    """Return the codec of numbers; single bytes have no byte order."""
    wide = np.dtype(dtype).itemsize > 1
    return {"name": "bytes", **({"configuration": {"endian": "little"}} if wide else {})}


def _metadata(shape: Sequence[int], chunks: Sequence[int], dtype: str, **more: Any) -> Any:
    """Return array metadata by the Zarr core specification, version 3."""
    from zarr.core.metadata.v3 import ArrayV3Metadata

    return ArrayV3Metadata.from_dict(
        {
            **{"zarr_format": 3, "node_type": "array", "shape": tuple(shape), "data_type": dtype},
            "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": tuple(chunks)}},
            "chunk_key_encoding": {"name": "default", "configuration": {"separator": "/"}},
            **more,
        }
    )
