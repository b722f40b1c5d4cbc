# SPDX-License-Identifier: Apache-2.0
"""Layout of a store without runs: arrays, names and attributes in Zarr's form."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .arrays import NOT_RUN as NOT_RUN
from .arrays import ROOT, Array, group_metadata, text
from .arrays import STATUS as STATUS
from .attributes import NAMES, batch_hash
from .records import FORMAT, Record

_SUMMARY = re.compile(r"^(final|minimum|maximum|events)\((\w+)\)$")
"""Pattern of a name of one number per run in its summary."""
_LARGEST_CHUNK = 2**22
"""Largest number of bytes in a chunk of series. Half as many double the number of files, but short reads then
decompress half as much.
"""


@dataclass(frozen=True)
class Variable:
    """An array with one row per run. `size` is the length of a second dimension."""

    name: str
    dtype: str
    dimension: str = ""
    size: int = 0
    attributes: Mapping[str, Any] = field(default_factory=dict)

    def array(self, n: int, chunk: int) -> Array:
        """Return the array of n runs, in blocks of `chunk` runs; long series are cut in time too."""
        if not self.dimension:
            return Array(self.name, self.dtype, ("run",), (n,), (chunk,), self.attributes)
        piece = self.size
        if self.dimension == "t":
            piece = max(1, min(self.size, _LARGEST_CHUNK // (chunk * np.dtype(self.dtype).itemsize)))
        return Array(self.name, self.dtype, ("run", self.dimension), (n, self.size), (chunk, piece), self.attributes)


@dataclass(frozen=True)
class Coordinate:
    """Coordinate of a second dimension: names or numbers, such as instants."""

    values: Sequence[str] | NDArray[np.float64]
    attributes: Mapping[str, Any] = field(default_factory=dict)

    def array(self, name: str) -> Array:
        """Return its array, stored as one chunk."""
        shape = (len(self.values),)
        dtype = "float64" if isinstance(self.values, np.ndarray) else "string"
        return Array(name, dtype, (name,), shape, shape, self.attributes)


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
    attributes : mapping
        Attributes of the group, any JSON values. A store is continued only with the same `IDENTITY` among them.
    """

    n: int
    chunk: int
    variables: Sequence[Variable]
    coordinates: Mapping[str, Coordinate]
    attributes: Mapping[str, Any] = field(default_factory=dict)

    @property
    def batch(self) -> str:
        """Hash of the identity, which every record contains."""
        return batch_hash(self.attributes, self.chunk)

    @property
    def blocks(self) -> int:
        """Number of blocks."""
        return -(-self.n // self.chunk)

    def about(self, **more: Any) -> dict[str, Any]:
        """Return the facts in every record: batch and runs per block."""
        return {"format": FORMAT, "batch": self.batch, "chunk": self.chunk, **more}

    def files(self) -> dict[str, bytes]:
        """Return all files except those of blocks, and records, by name."""
        names = [variable.name for variable in self.variables]
        attributes = {**dict(zip(NAMES, (FORMAT, names), strict=True)), **self.attributes}
        arrays = {variable.name: variable.array(self.n, self.chunk) for variable in self.variables}
        arrays |= {name: coordinate.array(name) for name, coordinate in self.coordinates.items()}
        files = {ROOT: text(group_metadata(attributes, arrays))}
        files |= {f"{name}/{ROOT}": text(array.metadata()) for name, array in arrays.items()}
        for name, coordinate in self.coordinates.items():
            numbers = isinstance(coordinate.values, np.ndarray)
            files |= arrays[name].files(0, np.array(coordinate.values, dtype=np.float64 if numbers else object))
        return files

    def record(self, digests: Mapping[str, str]) -> Record:
        """Return the record of these files by their digests."""
        return Record(self.about(runs=self.n), digests)


class Runs:
    """Runs of a batch, stored in blocks of `chunk` runs."""

    n: int
    chunk: int

    def has(self, block: int) -> bool:
        """Return True if a run of a block is stored."""
        raise NotImplementedError

    def blocks(self) -> int:
        """Return the number of blocks, stored or not."""
        return -(-self.n // self.chunk)

    def runs(self, block: int) -> range:
        """Return the run numbers of a block."""
        return range(block * self.chunk, min((block + 1) * self.chunk, self.n))

    def stored(self) -> list[int]:
        """Return the blocks that are stored, in order."""
        return [block for block in range(self.blocks()) if self.has(block)]


def number_units(variables: Iterable[Variable], coordinate: Callable[[str], Coordinate]) -> dict[str, str]:
    """Return the unit of every number of a run by its name in conditions."""
    wide = coordinate("variable")
    units = dict(zip(wide.values, wide.attributes.get("units", ()), strict=False))
    numbers: dict[str, str] = {}
    for variable in variables:
        if not variable.dimension and variable.name not in (STATUS, "violated", "steps"):
            numbers[variable.name] = variable.attributes.get("units", "1")
        elif variable.dimension in ("state", "variable", "event"):
            names = coordinate(variable.dimension).values
            numbers |= {f"{variable.name}({of})": units.get(of, "1") for of in names}
    return numbers


def array_of(number: str, coordinate: Callable[[str], Coordinate]) -> tuple[str, int | None]:
    """Return the array with a number of a run, and its column there; None for an array of one dimension."""
    match = _SUMMARY.match(number)
    if not match:
        return number, None
    array, of = match.groups()
    dimension = {"final": "state", "events": "event"}.get(array, "variable")
    return array, list(coordinate(dimension).values).index(of)
