# SPDX-License-Identifier: Apache-2.0
"""Kinds of arrays: declaration, element names, and value under the array's name."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from mehvar.base.errors import value_text
from mehvar.base.names import typeset

from ..quantities import Group, ModelError, Parameter, ParameterArray

if TYPE_CHECKING:  # tables of numbers are read without SymPy
    import sympy as sp

    from .curves import TableLookup

SYMMETRIC = ("symmetric", "positive definite")
INCREASING = "increasing"
LINES = ("linear", "cubic")
OUTSIDE = ("hold", "line")
"""Keywords of a parameter table: forms of arrays, interpolation, and extrapolation beyond the points."""


@dataclass(frozen=True)
class Tensor(ParameterArray):
    """A vector or matrix. Of a symmetric matrix, the elements on and above the diagonal are parameters.

    Parameters
    ----------
    form : str
        "symmetric" or "positive definite" of a matrix, "increasing" of a vector, or nothing.
    """

    form: str = ""

    def places(self) -> Iterator[tuple[int, ...]]:
        """Yield the indices of the elements that are parameters, counted from one."""
        for place in super().places():
            if self.form not in SYMMETRIC or place[0] <= place[1]:
                yield place

    def of(self, group: Group) -> sp.Matrix:
        """Return the matrix of the elements' symbols; a vector is a column."""
        import sympy as sp

        symbols = group.elements(self.name)
        rows, columns = (*self.shape, 1)[:2]
        return sp.Matrix(rows, columns, lambda i, j: symbols[self._place(i + 1, j + 1)])

    def _place(self, i: int, j: int) -> tuple[int, ...]:
        place = (i, j)[: len(self.shape)]
        return tuple(sorted(place)) if self.form in SYMMETRIC else place


@dataclass(frozen=True)
class Table(ParameterArray):
    """Table of values with interpolation, called as in `p.thrust(t)`.

    Parameters
    ----------
    form : {"linear", "cubic"}
        See `curves`.
    over : tuple of str
        For each axis, the array of its points.
    outside : {"hold", "line"}
        Extrapolation beyond the first and last points.
    """

    form: str
    over: tuple[str, ...]
    outside: str

    def of(self, group: Group) -> TableLookup:
        """Return the interpolating function of a table."""
        from .curves import TableLookup

        columns = [list(group.elements(axis).values()) for axis in (*self.over, self.name)]
        return TableLookup(self.name, self.over, tuple(columns[:-1]), columns[-1], self.form, self.outside)


def array_of(name: str, numbers: list[Any], form: str, over: Sequence[str], outside: str, where: str) -> ParameterArray:
    """Return the kind of array that an entry of a parameter table declares.

    Raises
    ------
    ModelError
        If the array has no numbers, its rows differ in length, or its form does not fit it.
    """
    shape = _shape(numbers, where)
    if over:
        return _table(name, shape, form, tuple(over), outside, where)
    allowed = ("", *SYMMETRIC) if len(shape) == 2 else ("", INCREASING)
    if form not in allowed or outside:
        key, value = ("outside", outside) if outside else ("form", form)
        names = "left out, or over given" if outside else f"left out or one of {', '.join(allowed[1:])}"
        raise ModelError(f"{where}: {key} = {value!r}: must be {names}")
    if form == INCREASING and not all(a < b for a, b in itertools.pairwise(numbers)):
        raise ModelError(f"{where}: default = {numbers}: must increase")
    if form in SYMMETRIC:
        _check_symmetric(numbers, shape, form, where)
    return Tensor(name, shape, form)


def _shape(numbers: list[Any], where: str) -> tuple[int, ...]:
    rows = [len(row) for row in numbers if isinstance(row, list)]
    if not numbers or 0 in rows or len(set(rows)) > 1 or len(rows) not in (0, len(numbers)):
        raise ModelError(
            f"{where}: default = {value_text(numbers)}: must be numbers, or rows of numbers of equal length"
        )
    return (len(numbers), *rows[:1])


def _table(name: str, shape: tuple[int, ...], form: str, over: tuple[str, ...], outside: str, where: str) -> Table:
    """Return the declaration of a table; refuse a default that does not have an axis of two values for each name."""
    if len(over) != len(shape):
        raise ModelError(f"{where}: over = {list(over)}: must be {len(shape)} names, one for each axis of default")
    forms = LINES if len(shape) == 1 else LINES[:1]
    for key, value, words in (("form", form, forms), ("outside", outside or OUTSIDE[0], OUTSIDE)):
        if value not in words:
            raise ModelError(f"{where}: {key} = {value!r}: must be {' or '.join(map(repr, words))}")
    if min(shape) < 2:
        raise ModelError(f"{where}: default has the shape {shape}: must be two values or more along each axis")
    return Table(name, shape, form, over, outside or OUTSIDE[0])


def _check_symmetric(numbers: list[list[float]], shape: tuple[int, ...], form: str, where: str) -> None:
    """Refuse a default that is not square and symmetric or, for that form, not positive definite."""
    if shape[0] != shape[1]:
        raise ModelError(f"{where}: form = {form!r}: leave it out, since default has the shape {shape}")
    for i, j in itertools.combinations(range(shape[0]), 2):
        if numbers[i][j] != numbers[j][i]:
            raise ModelError(
                f"{where}: form = {form!r} needs a symmetric default, but ({i + 1}, {j + 1}) is {numbers[i][j]:g} "
                f"and ({j + 1}, {i + 1}) is {numbers[j][i]:g}"
            )
    if form == SYMMETRIC[1] and not _is_positive_definite(numbers):
        raise ModelError(f"{where}: default = {numbers}: must be positive definite")


def _is_positive_definite(numbers: list[list[float]]) -> bool:
    """Return True if every pivot of an exact elimination is a positive number."""
    if not all(math.isfinite(number) for row in numbers for number in row):
        return False
    rows = [[Fraction(number) for number in row] for row in numbers]
    while rows:
        pivot, *rest = rows
        if pivot[0] <= 0:
            return False
        rows = [[b - a * row[0] / pivot[0] for a, b in zip(pivot[1:], row[1:], strict=True)] for row in rest]
    return True


def elements(whole: Parameter, array: ParameterArray, numbers: Sequence[Any]) -> Iterator[Parameter]:
    """Yield the parameters of an array's elements: I_1_2 is in row 1, column 2 of I.

    Parameters
    ----------
    whole : Parameter
        The array's entry: description, unit and source are common to all elements.
    array : ParameterArray
        Name and shape of the array.
    numbers : list, or list of lists
        Their defaults.
    """
    latex = whole.latex or typeset(whole.name)
    for place in array.places():
        default: Any = numbers
        for k in place:
            default = default[k - 1]
        indices = [str(k) for k in place]
        yield replace(
            whole,
            name="_".join((whole.name, *indices)),
            latex=f"{{{latex}}}_{{{','.join(indices)}}}",
            description=f"{whole.description}, element {','.join(indices)}",
            default=float(default),
            array=array,
        )
