# SPDX-License-Identifier: Apache-2.0
"""Inputs over time from a file: a result or a table."""

from __future__ import annotations

import csv
import os
import re
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from mehvar.base.errors import InputError, bad_value, unknown_name
from mehvar.base.manifest import Manifest

from ...arguments import number
from ...files import checked_ending
from ...model.functions import FloatArray
from ..formats import open_result
from .inputs import commands_act_later

if TYPE_CHECKING:
    import xarray

Table = dict[str, tuple[FloatArray, FloatArray]]


def read_inputs(path: str | os.PathLike[str], manifest: Manifest) -> Table | xarray.Dataset:
    """Read inputs of an open loop from a file.

    Parameters
    ----------
    path : path
        A result in NetCDF, or a CSV table with a column `t` and a column `NAME` or `u_NAME` per input. A unit in
        brackets after a name must be the model's. Other columns are ignored if the table is a result. Of a result's
        inputs and commands the inputs are read, as a table has no delay; but the commands of a plant with delays or an
        actuator.
    manifest : Manifest
        Manifest of the model.

    Raises
    ------
    InputError
        If the file cannot be read or has an unknown ending, a column is missing or occurs twice, a unit is wrong, or
        a cell is not a number.
    """
    if checked_ending("inputs", path, [".nc", ".csv"]) == ".nc":
        return open_result(path)
    names = [q.name for q in manifest.inputs]
    columns, units = _columns(path)
    kinds = ("u_cmd_", "u_", "") if commands_act_later(manifest) else ("u_", "u_cmd_", "")
    table = {name: next((f"{kind}{name}" for kind in kinds if f"{kind}{name}" in columns), "") for name in names}
    table = {name: column for name, column in table.items() if column}
    if all(name == column for name, column in table.items()):
        for column in columns:
            if column not in ("t", *names):
                raise unknown_name(f"input of {manifest.model}", column, names, os.fspath(path))
    for name, column in table.items():
        if name in columns and column != name:
            raise bad_value(f"columns of {path}", f"{name}, {column}", f"one column of {name}")
    expected = {"t": "s"} | {table[q.name]: q.unit for q in manifest.inputs if q.name in table}
    for column, unit in expected.items():
        if units[column] not in (None, unit):
            raise bad_value(f"unit of {column} in {path}", units[column], f"{unit}, or left out")
    return {name: (columns["t"], columns[column]) for name, column in table.items()}


def _columns(path: str | os.PathLike[str]) -> tuple[dict[str, FloatArray], dict[str, str | None]]:
    """Return the columns of a table, and the units in brackets after their names."""
    try:
        with Path(path).open(encoding="utf-8-sig", newline="") as file:
            head, *rows = [*csv.reader(file)] or [[]]
    except (OSError, UnicodeDecodeError, csv.Error, ValueError) as error:
        raise InputError(f"cannot read {path}: {getattr(error, 'strerror', None) or error}") from error
    titles = [re.fullmatch(r"\s*(.*?)\s*(?:\[(.*)\])?\s*", title, re.DOTALL) for title in head]
    names = [title[1] for title in titles if title]
    if len(names) != len({*names}):
        raise bad_value(f"columns of {path}", ", ".join(names), "one of each name")
    if "t" not in names:
        raise bad_value(f"columns of {path}", ", ".join(names), "t, in seconds, and inputs, separated by commas")
    if not rows:
        raise bad_value(f"rows of {path}", 0, "one or more")
    numbers = np.empty((len(rows), len(names)))
    for k, row in enumerate(rows):
        values = [value for cell in row if (value := number(cell)) is not None]
        if not len(row) == len(values) == len(names):
            raise bad_value(f"line {k + 2} of {path}", ",".join(row), f"{len(names)} numbers")
        numbers[k] = values
    return dict(zip(names, numbers.T, strict=True)), {title[1]: title[2] for title in titles if title}
