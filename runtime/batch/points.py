# SPDX-License-Identifier: Apache-2.0
"""Given points of a batch: lists of values, grids of lists, tables of points."""

from __future__ import annotations

import itertools
import os
import warnings
from collections.abc import Mapping
from typing import Any, Literal

import numpy as np

from mehvar.base.errors import InputError, bad_value

from ..arguments import number as text_number
from ..model.functions import unmasked
from ..model.parameters import number
from .dispersions import read_dispersions

GivenDesign = Literal["grid"]


def lists_as_distributions(vary: Mapping[str, Any], origin: str) -> dict[str, str]:
    """Return lists of values as texts of dispersions, and texts unchanged.

    Parameters
    ----------
    vary : mapping of str to str or sequence of float
        Distributions and lists, by name.
    origin : str
        Origin of the values in error messages.

    Raises
    ------
    InputError
        For a value that is neither a text nor a list of finite numbers.
    """
    for names, values in vary.items():
        if not isinstance(values, str) and not _is_list(values):
            allowed = 'a text such as "normal(50, 2)", or a list, tuple or array of numbers'
            raise bad_value(names, values, allowed, origin)
    return {
        names: values if isinstance(values, str) else _text(names, values, origin) for names, values in vary.items()
    }


def grid(vary: Mapping[str, Any], origin: str) -> dict[str, list[float]]:
    """Return lists with every combination of the given lists; the last name varies fastest.

    Raises
    ------
    InputError
        Without a list, or for a distribution.
    """
    for names, values in vary.items():
        if not _is_list(values):
            raise bad_value(names, values, 'a list of values, since design = "grid" combines lists', origin)
    if not vary:
        raise bad_value("design", "grid", "left out unless vary has lists", origin)
    rows = itertools.product(*map(_elements, vary.values()))
    return dict(zip(vary, map(list, zip(*rows, strict=True)), strict=True))


def columns_of(points: Any, origin: str) -> dict[str, list[float]]:
    """Return the columns of a table of points with one row per run.

    Parameters
    ----------
    points : path, pandas.DataFrame or mapping of str to sequence of float
        A CSV file with names in its first line, or columns by name.
    origin : str
        Origin of the points in error messages.

    Raises
    ------
    InputError
        For a file that cannot be read, a table without a row, or a cell that is no finite number.
    """
    if isinstance(points, str | os.PathLike):
        points, origin = _csv(points), str(points)
    if not hasattr(points, "items"):
        raise bad_value("points", points, "a CSV file, a pandas.DataFrame, or columns by name", origin)
    columns = {str(name).strip(): np.atleast_1d(unmasked(values).astype(object)) for name, values in points.items()}
    if not columns or not all(len(values) for values in columns.values()):
        raise bad_value("points", "a table without a row", "at least one row with names above it", origin)
    return {
        name: [_value(name, value, f"{origin}, row {row}") for row, value in enumerate(values, 1)]
        for name, values in columns.items()
    }


def count(vary: Mapping[str, str], origin: str) -> int | None:
    """Return the number of runs in listed values; None without listed values."""
    return next((d.listed for d in read_dispersions(vary, origin) if d.listed), None)


def _csv(path: str | os.PathLike[str]) -> Any:
    """Return the table of a CSV file; refuse rows whose last cells pandas would drop."""
    import pandas as pd

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", pd.errors.ParserWarning)  # rows longer than the first line lose their ends
            return pd.read_csv(path, skipinitialspace=True, index_col=False)
    except pd.errors.ParserWarning:
        allowed = "a CSV file whose rows have as many cells as its first line has names"
        raise bad_value("points", os.fspath(path), allowed) from None
    except (OSError, ValueError) as error:  # pandas' errors of parsing are ValueErrors
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"points = {os.fspath(path)!r} cannot be read as CSV: {reason}") from error


def _value(name: str, value: Any, origin: str) -> float:
    """Return a cell of a table; a column that contains a text consists of texts."""
    read = text_number(value.strip()) if isinstance(value, str) else None
    return number(name, value if read is None else read, origin)


def _is_list(values: Any) -> bool:
    """Return True for any sequence with one index, such as a range or a column of a table."""
    try:
        return np.ndim(values) == 1
    except (ValueError, TypeError):  # rows of different lengths, or a table
        return False


def _text(names: str, values: Any, origin: str) -> str:
    if not len(values):
        raise bad_value(names, values, "a list with one value for each run", origin)
    return f"values({', '.join(repr(number(names, value, origin)) for value in _elements(values))})"


def _elements(values: Any) -> Any:
    return unmasked(values) if hasattr(values, "__array__") else values
