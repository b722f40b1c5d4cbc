# SPDX-License-Identifier: Apache-2.0
"""Layout of a store without runs: arrays, names and attributes in Zarr's form."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .arrays import ROOT, Array, Files, group_metadata, text
from .attributes import NAMES, batch_hash
from .chunks import Memory
from .records import FORMAT, Record

STATUS = "status"
_SUMMARY = re.compile(r"^(final|minimum|maximum|events)\((\w+)\)$")
"""Pattern of a name of one number per run in its summary."""
NOT_RUN = 255
_LARGEST_CHUNK = 2**22
"""Largest number of bytes in a chunk of series. Half as many double the number of files, but short reads then
decompress half as much.
"""


@dataclass(frozen=True)
class Variable:
    """An array of a store, with one row per run, or a coordinate without run dimension.

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
        All that blocks have in common; a store is continued only with equal identity.
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

    def build(self, files: Files) -> None:
        """Write the layout."""
        names = [variable.name for variable in self.variables]
        attributes = {**dict(zip(NAMES, (FORMAT, names), strict=True)), **self.attributes, **self.identity}
        coordinates = {name: _coordinate(name, coordinate) for name, coordinate in self.coordinates.items()}
        arrays = {v.name: _array(v, self.n, self.chunk) for v in self.variables} | coordinates
        files.write(ROOT, text(group_metadata(attributes, arrays)))
        for name, array in arrays.items():
            files.write(f"{name}/{ROOT}", text(array.metadata()))
        for name, coordinate in self.coordinates.items():
            coordinates[name].write(files, 0, _values(coordinate))

    def files(self) -> dict[str, bytes]:
        """Return the files that `build` writes, by name."""
        files = Memory()
        self.build(files)
        return files

    def record(self, digests: Mapping[str, str]) -> Record:
        """Return the record of these files by their digests."""
        return Record(self.about(runs=self.n), digests)


def number_units(
    variables: Iterable[Variable], coordinate: Callable[[str], Iterable[str]], units: Mapping[str, str]
) -> dict[str, str]:
    """Return the unit of every number of a run by its name in conditions, with the units of what summaries are of."""
    numbers: dict[str, str] = {}
    for variable in variables:
        if not variable.dimension and variable.name not in (STATUS, "violated", "steps"):
            numbers[variable.name] = variable.attributes.get("units", "1")
        elif variable.dimension in ("state", "variable", "event"):
            numbers |= {f"{variable.name}({of})": units.get(of, "1") for of in coordinate(variable.dimension)}
    return numbers


def array_of(number: str, coordinate: Callable[[str], Iterable[str]]) -> tuple[str, int | None]:
    """Return the array with a number of a run, and its column there; None for an array of one dimension."""
    match = _SUMMARY.match(number)
    if not match:
        return number, None
    array, of = match.groups()
    dimension = {"final": "state", "events": "event"}.get(array, "variable")
    return array, list(coordinate(dimension)).index(of)


def _array(variable: Variable, n: int, chunk: int) -> Array:
    """Return the array of a variable."""
    shape = (n, variable.size) if variable.dimension else (n,)
    piece = shape[1:]
    if variable.dimension == "t":
        piece = (max(1, min(variable.size, _LARGEST_CHUNK // (chunk * np.dtype(variable.dtype).itemsize))),)
    fill: str | int = NOT_RUN if variable.name == STATUS else 0
    return Array(
        variable.name,
        shape,
        (chunk, *piece),
        variable.dtype,
        ("run", variable.dimension) if variable.dimension else ("run",),
        variable.attributes,
        "NaN" if variable.dtype.startswith("float") else fill,
    )


def _coordinate(name: str, coordinate: Coordinate) -> Array:
    """Return the array of a coordinate, stored as one chunk."""
    shape = (len(coordinate.values),)
    kind = ("float64", "NaN") if isinstance(coordinate.values, np.ndarray) else ("string", "")
    return Array(name, shape, shape, kind[0], (name,), coordinate.attributes, kind[1])


def _values(coordinate: Coordinate) -> NDArray[Any]:
    numbers = isinstance(coordinate.values, np.ndarray)
    return np.array(coordinate.values, dtype=np.float64 if numbers else object)
