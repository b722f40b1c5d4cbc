# SPDX-License-Identifier: Apache-2.0
"""Interpolation as an expression, with exact derivatives on every backend.

Bisection finds the piece. Every piece is evaluated before one is selected, because the lanes of a batch run in step.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp

from ..arguments import expression
from ..quantities import wrong

Column = Sequence[sp.Expr]


@dataclass(frozen=True)
class TableLookup:
    """A table of parameters, called with one expression per axis.

    Parameters
    ----------
    name : str
        Name of the table.
    over : tuple of str
        Names of the arrays with its points, one per axis.
    at : tuple of sequences of Expr
        The points along each axis.
    values : sequence of Expr
        Row by row.
    form, outside : str
        See `curve`.
    """

    name: str
    over: tuple[str, ...]
    at: tuple[Column, ...]
    values: Column
    form: str
    outside: str

    def __call__(self, *places: sp.Expr) -> sp.Expr:
        """Return the interpolated value of the table.

        Raises
        ------
        ModelError
            If the number of arguments differs from the number of axes, or an argument is no expression.
        """
        if len(places) != len(self.over):
            raise wrong(f"places of {self.name}", places, f"one for each axis: {', '.join(self.over)}")
        x = [expression(f"place along {axis}", place) for axis, place in zip(self.over, places, strict=True)]
        if len(self.at) == 1:
            return curve(x[0], self.at[0], self.values, self.form, self.outside)
        width = len(self.at[1])  # a row for each point of the first axis
        rows = [self.values[k : k + width] for k in range(0, len(self.values), width)]
        columns = [curve(x[1], self.at[1], row, self.form, self.outside) for row in rows]
        return curve(x[0], self.at[0], columns, self.form, self.outside)


def curve(x: sp.Expr, at: Column, values: Column, form: str, outside: str) -> sp.Expr:
    """Return the value at x of an interpolating function.

    Parameters
    ----------
    x : Expr
        Where.
    at, values : sequence of Expr
        Two points or more, `at` increasing.
    form : {"linear", "cubic"}
        Straight lines, or cubic polynomials with one slope at each point, which are monotone where the data are.
    outside : {"hold", "line"}
        Beyond the first and last points: their value, or the tangent at them.
    """
    steps = [b - a for a, b in itertools.pairwise(at)]
    rises = [(b - a) / h for (a, b), h in zip(itertools.pairwise(values), steps, strict=True)]
    if form == "linear":
        pieces = [v + rise * (x - a) for a, v, rise in zip(at, values, rises, strict=False)]
        first, last = rises[0], rises[-1]
    else:
        slopes = _slopes(steps, rises)
        pieces = [_cubic(x - at[i], values[i], steps[i], rises[i], *slopes[i : i + 2]) for i in range(len(steps))]
        first, last = slopes[0], slopes[-1]
    line = 1 if outside == "line" else 0
    below, above = (values[k] + line * slope * (x - at[k]) for k, slope in ((0, first), (-1, last)))
    return _bisected(x, at, [below, *pieces, above])


def _bisected(x: sp.Expr, knots: Column, pieces: Sequence[sp.Expr]) -> sp.Expr:
    """Select the piece that contains x by bisection; at a knot, the upper piece."""
    if len(pieces) == 1:
        return pieces[0]
    middle = len(pieces) // 2
    below, above = _bisected(x, knots[: middle - 1], pieces[:middle]), _bisected(x, knots[middle:], pieces[middle:])
    return sp.Piecewise((below, x < knots[middle - 1]), (above, True), evaluate=False)


def _cubic(along: sp.Expr, v: sp.Expr, h: sp.Expr, rise: sp.Expr, left: sp.Expr, right: sp.Expr) -> sp.Expr:
    """Return the cubic Hermite polynomial on an interval of length h with start value v."""
    bend, twist = (3 * rise - 2 * left - right) / h, (left + right - 2 * rise) / h**2
    return v + along * (left + along * (bend + along * twist))


def _slopes(steps: Column, rises: Column) -> list[sp.Expr]:
    """Return the slopes at the points that make the cubics monotone.

    Fritsch & Butland, SIAM J. Sci. Stat. Comput. 5 (1984) 300, as SciPy's `PchipInterpolator` has them.
    """
    if len(steps) == 1:
        return [rises[0], rises[0]]
    inner = [_harmonic(*sides) for sides in zip(steps, steps[1:], rises, rises[1:], strict=False)]
    return [_end(*steps[:2], *rises[:2]), *inner, _end(*steps[:-3:-1], *rises[:-3:-1])]


def _harmonic(h: sp.Expr, k: sp.Expr, before: sp.Expr, after: sp.Expr) -> sp.Expr:
    """Return the weighted harmonic mean of two slopes; zero if their signs differ."""
    total = (h + 2 * k) * after + (2 * h + k) * before
    return sp.Piecewise((3 * (h + k) * before * after / total, before * after > 0), (0, True))


def _end(h: sp.Expr, k: sp.Expr, near: sp.Expr, far: sp.Expr) -> sp.Expr:
    """Return the end slope of a parabola through three points, limited to 0 to 3 times the end secant."""
    slope = ((2 * h + k) * near - h * far) / (h + k)
    return sp.Piecewise((0, slope * near <= 0), (3 * near, slope * near > 3 * near**2), (slope, True))
