# SPDX-License-Identifier: Apache-2.0
"""Interpolation as an expression, with exact derivatives on every backend.

The piece is found by bisection. All pieces are evaluated and selected from, as lanes must do.
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
class Reading:
    """A table of parameters, called with one expression per axis.

    Parameters
    ----------
    name : str
        Of the table.
    over : tuple of str
        Of the arrays of its points.
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
            For another number of places than the table has axes, or what is no expression.
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
        Straight lines, or cubic polynomials with one slope at each point, monotone where the points are.
    outside : {"hold", "line"}
        Beyond the first and the last point their value, or the tangent there.
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
    """Return Hermite's cubic on an interval of length h, with start value v."""
    bend, twist = (3 * rise - 2 * left - right) / h, (left + right - 2 * rise) / h**2
    return v + along * (left + along * (bend + along * twist))


def _slopes(steps: Column, rises: Column) -> list[sp.Expr]:
    """Return slopes at the points for which the cubics are monotone.

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
    """Return the end slope of the parabola through three points, between zero and three times the rise there."""
    slope = ((2 * h + k) * near - h * far) / (h + k)
    return sp.Piecewise((0, slope * near <= 0), (3 * near, slope * near > 3 * near**2), (slope, True))
