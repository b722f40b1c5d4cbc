# SPDX-License-Identifier: Apache-2.0
"""Arrays of a store in Zarr's format, version 3: metadata, and chunks as bytes.

The library zarr reads these files too, but its import takes longer than a small batch.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Read = Callable[[str], "bytes | None"]
"""Function that returns a file of a store by its name; None if it is absent."""

ROOT = "zarr.json"
"""File name of the metadata of a group or an array."""
STATUS = "status"
"""Variable with how each run ended."""
NOT_RUN = 255
"""Status of a run that is not stored."""
_TEXT = "string"
_FILLS: Mapping[str, float | str] = {"float64": "NaN", "int64": 0, "int8": 0, "uint8": NOT_RUN, _TEXT: ""}
"""Value of missing chunks, as in JSON, by Zarr's name of a type."""


@dataclass(frozen=True)
class Array:
    """An array of up to two dimensions, cut into chunks.

    Attributes
    ----------
    name : str
        Its folder.
    dtype : str
        Zarr's name of the type.
    dimensions : tuple of str
        Names of the dimensions; the first of a variable is "run".
    shape, chunk : tuple of int
        Size of the array and of a chunk.
    attributes : mapping
        Unit, description and the like.
    """

    name: str
    dtype: str
    dimensions: tuple[str, ...]
    shape: tuple[int, ...]
    chunk: tuple[int, ...]
    attributes: Mapping[str, Any]

    @property
    def of_runs(self) -> bool:
        """True for a variable with one row per run, False for a coordinate."""
        return self.dimensions[0] == "run"

    def metadata(self) -> dict[str, Any]:
        """Return the array's metadata."""
        return {
            "shape": list(self.shape),
            "data_type": self.dtype,
            "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": list(self.chunk)}},
            "chunk_key_encoding": {"name": "default", "configuration": {"separator": "/"}},
            "fill_value": _FILLS[self.dtype],
            "codecs": self._codecs(),
            "attributes": dict(self.attributes),
            "dimension_names": list(self.dimensions),
            "zarr_format": 3,
            "node_type": "array",
            "storage_transformers": [],
        }

    def block(self, read: Read, block: int, columns: slice = slice(None)) -> NDArray[Any]:
        """Return the rows of a block, and some of their columns."""
        rows = min(self.shape[0] - block * self.chunk[0], self.chunk[0])
        if len(self.shape) == 1:
            return self._decoded(read(self._key(block)))[:rows]
        first, last, _ = columns.indices(self.shape[1])
        start, stop = first // self.chunk[1], -(-last // self.chunk[1])
        pieces = [self._decoded(read(self._key(block, k))) for k in range(start, stop)]
        skipped = start * self.chunk[1]
        return np.concatenate(pieces, axis=1)[:rows, first - skipped : last - skipped]

    def files(self, block: int, values: NDArray[Any]) -> Iterator[tuple[str, bytes]]:
        """Yield names and contents of the files of a block."""
        if len(self.shape) == 1:
            yield self._key(block), self._encoded(values)
            return
        for k, first in enumerate(range(0, self.shape[1], self.chunk[1])):
            yield self._key(block, k), self._encoded(values[:, first : first + self.chunk[1]])

    def _key(self, *place: int) -> str:
        return "/".join((self.name, "c", *map(str, place)))

    def _type(self) -> np.dtype[Any]:
        return np.dtype(object) if self.dtype == _TEXT else np.dtype(self.dtype).newbyteorder("<")

    def _codecs(self) -> list[dict[str, Any]]:
        if self.dtype == _TEXT:
            return [{"name": "vlen-utf8", "configuration": {}}]
        wide = np.dtype(self.dtype).itemsize > 1  # single bytes have no order
        numbers = {"name": "bytes", **({"configuration": {"endian": "little"}} if wide else {})}
        compressed = {"name": "zstd", "configuration": {"level": 1, "checksum": True}}
        return [numbers, compressed] if self.of_runs else [numbers]

    def _empty(self) -> NDArray[Any]:
        fill = _FILLS[self.dtype]
        return np.full(self.chunk, math.nan if fill == "NaN" else fill, dtype=self._type())

    def _encoded(self, values: NDArray[Any]) -> bytes:
        """Return the bytes of a chunk; the last one is filled up to the size of the others."""
        from numcodecs import VLenUTF8, Zstd

        if values.shape != self.chunk:  # at the end of the array
            whole = self._empty()
            whole[tuple(slice(size) for size in values.shape)] = values
            values = whole
        if self.dtype == _TEXT:
            return bytes(VLenUTF8().encode(values))
        content = values.astype(self._type()).tobytes()
        return bytes(Zstd(level=1, checksum=True).encode(content)) if self.of_runs else content

    def _decoded(self, content: bytes | None) -> NDArray[Any]:
        """Return the values of a chunk; a missing one has the fill value."""
        from numcodecs import VLenUTF8, Zstd

        if content is None:
            return self._empty()
        if self.dtype == _TEXT:
            texts: NDArray[Any] = VLenUTF8().decode(content)
            return texts.reshape(self.chunk)
        plain = Zstd().decode(content) if self.of_runs else content
        return np.frombuffer(plain, dtype=self._type()).reshape(self.chunk)


def group_metadata(attributes: Mapping[str, Any], arrays: Mapping[str, Array]) -> dict[str, Any]:
    """Return metadata of the group. They repeat the metadata of all arrays, because xarray reads them first."""
    listed = {name: arrays[name].metadata() for name in sorted(arrays, key=str.casefold)}
    return {
        "attributes": dict(attributes),
        "zarr_format": 3,
        "consolidated_metadata": {"kind": "inline", "must_understand": False, "metadata": listed},
        "node_type": "group",
    }


def read_group(content: bytes | None) -> tuple[dict[str, Any], dict[str, Array]]:
    """Return the attributes and arrays of a group from its metadata.

    Raises
    ------
    ValueError, LookupError, TypeError or RecursionError
        If it is missing, or not what `group_metadata` returns for some arrays.
    """
    if content is None:
        raise ValueError(f"it has no {ROOT}")
    facts = json.loads(content)
    listed: dict[str, Any] = facts["consolidated_metadata"]["metadata"]
    arrays = {name: _array(name, metadata) for name, metadata in listed.items()}
    attributes: dict[str, Any] = facts["attributes"]
    if facts != group_metadata(attributes, arrays):
        raise ValueError("its arrays are stored in a format that mehvar does not write")
    return attributes, arrays


def _array(name: str, facts: Mapping[str, Any]) -> Array:
    chunk = facts["chunk_grid"]["configuration"]["chunk_shape"]
    dimensions, shape = tuple(facts["dimension_names"]), tuple(facts["shape"])
    known = facts["data_type"] in _FILLS and all(type(size) is int and size > 0 for size in (*shape, *chunk))
    if not (known and 0 < len(dimensions) == len(shape) == len(chunk) < 3):
        raise ValueError(f"{name} is stored in a format that mehvar does not write")
    return Array(name, facts["data_type"], dimensions, shape, tuple(chunk), facts["attributes"])


def text(metadata: Mapping[str, Any]) -> bytes:
    """Return metadata as Zarr writes them."""
    return json.dumps(metadata, indent=2).encode()
