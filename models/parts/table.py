# SPDX-License-Identifier: Apache-2.0
"""Strict reader of a table with a part's numbers, their units and sources.

A table is a TOML file with an entry for each field of the part, and a list of tables for a field that is a list:

    mass = { unit = "kg", default = 8.0, source = "paper: data sheet" }

    [[modes]]
    frequency = { unit = "rad/s", default = 2.0, source = "paper: modal test" }
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mehvar.base.errors import suggestion, value_text
from mehvar.base.schema import read
from mehvar.base.units import dimension, radians

from ..quantities import ModelError
from ..tables import place_in, read_toml
from .values import Kind, Value, check_numbers, kinds


@dataclass(frozen=True)
class _Entry:
    unit: str
    default: Any
    source: str
    bounds: str = ""


def read_table(path: str | Path, of: type, lists: Mapping[str, type]) -> dict[str, Any]:
    """Return the fields of a part from its table.

    Parameters
    ----------
    path : str or Path
        A TOML file.
    of : type
        Class of the part.
    lists : mapping of str to type
        Fields that are lists, with the class of their entries.

    Raises
    ------
    ModelError
        If the file cannot be read, or has an unknown field or a wrong unit.
    """
    file = Path(path)
    table = read_toml(file)
    rows = {name: table.pop(name) for name in lists if name in table}
    result: dict[str, Any] = _fields(file, of, table)
    for name, entries in rows.items():
        if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
            raise ModelError(f"{place_in(file, name)}: {name}: must be a list of tables, [[{name}]]")
        result[name] = [_made(file, lists[name], entry, f"{name} {k}") for k, entry in enumerate(entries, 1)]
    return result


def _made(file: Path, of: type, entry: Mapping[str, Any], where: str) -> Any:
    missing = [name for name in kinds(of) if name not in entry]
    if missing:
        raise ModelError(f"{file}: {where}: {missing[0]!r} is missing")
    return of(**_fields(file, of, entry, f"{where}, "))


def _fields(file: Path, of: type, table: Mapping[str, Any], where: str = "") -> dict[str, Any]:
    declared = kinds(of)
    for name in table:
        if name not in declared:
            raise ModelError(
                f"{place_in(file, name)}: {where}{name!r} is not a field of {of.__name__}{suggestion(name, declared)}"
            )
    return {name: _entry(declared[name], row, f"{place_in(file, name)}: {where}{name}") for name, row in table.items()}


def _entry(kind: Kind, row: object, where: str) -> Any:
    """Return the number of a row, with unit and source; a direction along an axis stays a constant."""
    if not isinstance(row, dict):
        raise ModelError(
            f"{where} = {value_text(row)}: must be {{ unit = {kind.unit!r}, default = ..., source = ... }}"
        )
    try:
        entry = read(_Entry, row, "table")
        unit, default = entry.unit, entry.default
        fits = dimension(unit) == dimension(kind.unit) and radians(unit) == radians(kind.unit)
    except ValueError as error:
        raise ModelError(f"{where}: {error}") from error
    if not fits:
        raise ModelError(f"{where}: unit = {unit!r}: must be {kind.unit!r}")
    check_numbers(kind, default, where)
    along_axis = kind.form == "direction" and isinstance(default, list) and sum(v != 0 for v in default) == 1
    return default if along_axis else _valued(default, entry.source, entry.bounds)


def _valued(default: Any, source: str, bounds: str) -> Any:
    """Return a number or rows of numbers with unit and source; zeros in rows are structural."""
    if isinstance(default, list):
        return [0 if entry == 0 else _valued(entry, source, bounds) for entry in default]
    return Value(default, bounds, source)
