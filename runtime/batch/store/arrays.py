# SPDX-License-Identifier: Apache-2.0
"""Reader and writer of a store's arrays in Zarr's format, version 3.

The library zarr reads these files too, but its import takes longer than a small batch.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

ROOT = "zarr.json"
"""File name of the metadata of a group or an array."""
_TEXT = "string"
_NUMBERS = ("float64", "int64", "int8", "uint8")
_OWN = ("shape", "chunk_grid", "chunk_key_encoding", "fill_value", "codecs", "node_type", "zarr_format")
"""Metadata about the storage of an array."""


class Files(Protocol):
    """Files of a store by their names."""

    def read(self, name: str) -> bytes | None:
        """Return a file; None if it is absent."""

    def write(self, name: str, content: bytes) -> None:
        """Write a file."""


@dataclass(frozen=True)
class Array:
    """An array of up to two dimensions, cut into chunks.

    Attributes
    ----------
    name : str
        Its folder.
    shape, chunk : tuple of int
        Size of the array and of a chunk.
    dtype : str
        Zarr's name of the type.
    dimensions : tuple of str
        Names of the dimensions.
    attributes : mapping
        Unit, description and the like.
    fill : int or str
        Value of missing chunks, as in JSON.
    """

    name: str
    shape: tuple[int, ...]
    chunk: tuple[int, ...]
    dtype: str
    dimensions: tuple[str, ...]
    attributes: Mapping[str, Any]
    fill: int | str

    def metadata(self) -> dict[str, Any]:
        """Return the array's metadata."""
        return {
            "shape": list(self.shape),
            "data_type": self.dtype,
            "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": list(self.chunk)}},
            "chunk_key_encoding": {"name": "default", "configuration": {"separator": "/"}},
            "fill_value": self.fill,
            "codecs": self._codecs(),
            "attributes": dict(self.attributes),
            "dimension_names": list(self.dimensions),
            "zarr_format": 3,
            "node_type": "array",
            "storage_transformers": [],
        }

    def block(self, files: Files, block: int, columns: slice = slice(None)) -> NDArray[Any]:
        """Return the rows of a block, and some of their columns."""
        rows = min(self.shape[0] - block * self.chunk[0], self.chunk[0])
        if len(self.shape) == 1:
            return self._piece(files, (block,))[:rows]
        first, last, _ = columns.indices(self.shape[1])
        start, stop = first // self.chunk[1], -(-last // self.chunk[1])
        pieces = [self._piece(files, (block, k)) for k in range(start, stop)]
        skipped = start * self.chunk[1]
        return np.concatenate(pieces, axis=1)[:rows, first - skipped : last - skipped]

    def write(self, files: Files, block: int, values: NDArray[Any]) -> None:
        """Write the rows of a block."""
        if len(self.shape) == 1:
            files.write(self._key((block,)), self._encoded(values))
            return
        for k, first in enumerate(range(0, self.shape[1], self.chunk[1])):
            files.write(self._key((block, k)), self._encoded(values[:, first : first + self.chunk[1]]))

    def _piece(self, files: Files, place: tuple[int, ...]) -> NDArray[Any]:
        content = files.read(self._key(place))
        return self._empty() if content is None else self._decoded(content)

    def _key(self, place: tuple[int, ...]) -> str:
        return "/".join((self.name, "c", *map(str, place)))

    def _empty(self) -> NDArray[Any]:
        return np.full(self.chunk, math.nan if self.fill == "NaN" else self.fill, dtype=self._type())

    def _type(self) -> np.dtype[Any]:
        return np.dtype(object) if self.dtype == _TEXT else np.dtype(self.dtype).newbyteorder("<")

    def _codecs(self) -> list[dict[str, Any]]:
        if self.dtype == _TEXT:
            return [{"name": "vlen-utf8", "configuration": {}}]
        wide = np.dtype(self.dtype).itemsize > 1  # single bytes have no order
        numbers = {"name": "bytes", **({"configuration": {"endian": "little"}} if wide else {})}
        compressed = {"name": "zstd", "configuration": {"level": 1, "checksum": True}}
        return [numbers, compressed] if self._compressed else [numbers]

    @property
    def _compressed(self) -> bool:
        return self.dimensions[0] == "run"

    def _encoded(self, values: NDArray[Any]) -> bytes:
        from numcodecs import VLenUTF8, Zstd

        if values.shape != self.chunk:  # at the end of the array
            whole = self._empty()
            whole[tuple(slice(size) for size in values.shape)] = values
            values = whole
        if self.dtype == _TEXT:
            return bytes(VLenUTF8().encode(values))
        content = values.astype(self._type()).tobytes()
        return bytes(Zstd(level=1, checksum=True).encode(content)) if self._compressed else content

    def _decoded(self, content: bytes) -> NDArray[Any]:
        from numcodecs import VLenUTF8, Zstd

        if self.dtype == _TEXT:
            texts: NDArray[Any] = VLenUTF8().decode(content)
            return texts.reshape(self.chunk)
        plain = Zstd().decode(content) if self._compressed else content
        return np.frombuffer(plain, dtype=self._type()).reshape(self.chunk)


def read_array(files: Files, name: str) -> Array:
    """Return an array of a store by its metadata.

    Raises
    ------
    ValueError
        If they are missing or describe another format.
    """
    content = files.read(f"{name}/{ROOT}")
    if content is None:
        raise ValueError(f"the array {name!r} is missing")
    facts = json.loads(content)
    dtype, chunk = facts["data_type"], facts["chunk_grid"]["configuration"]["chunk_shape"]
    sizes, names = (facts["shape"], chunk), tuple(facts["dimension_names"])
    known = dtype in (_TEXT, *_NUMBERS) and all(type(k) is int and k > 0 for size in sizes for k in size)
    if known and 0 < len(names) == len(sizes[0]) == len(sizes[1]) < 3:
        array = Array(name, tuple(sizes[0]), tuple(chunk), dtype, names, facts["attributes"], facts["fill_value"])
        if all(facts[key] == value for key, value in array.metadata().items() if key in _OWN):
            return array
    raise ValueError(f"{name} is stored in a format that mehvar does not write")


def group_metadata(attributes: Mapping[str, Any], arrays: Mapping[str, Array]) -> dict[str, Any]:
    """Return metadata of the group. They repeat the metadata of all arrays, because xarray reads them first."""
    listed = {name: arrays[name].metadata() for name in sorted(arrays, key=str.casefold)}
    return {
        "attributes": dict(attributes),
        "zarr_format": 3,
        "consolidated_metadata": {"kind": "inline", "must_understand": False, "metadata": listed},
        "node_type": "group",
    }


def text(metadata: Mapping[str, Any]) -> bytes:
    """Return metadata as Zarr writes them."""
    return json.dumps(metadata, indent=2).encode()
