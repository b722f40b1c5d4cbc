# SPDX-License-Identifier: Apache-2.0
"""Lines through a point along one name, with points on both sides of every place where a condition changes."""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from .. import doubles
from ..doubles import Array
from ..pool import Pool
from ..proofs.intervals import Bounds
from .conditions import Conditions

Spot = dict[str, float]
"""A point."""
Columns = Mapping[str, Array]
"""Values of each name at several points."""
_SIXTEENTHS = 16
"""Number of parts into which a bracket is divided at each step. 13 steps give the 52 bits of a double."""
_CUTS = 14
_MOST_PLACES = 64
"""Largest number of places on one line, more than a table has. A floor has infinitely many, which are sampled."""
_BESIDE = 1e-12
"""Relative distance of test points from a place where a condition changes. It is above rounding, and after any larger
shift points lie between the old and new place.
"""
_GRID = tuple(
    sign * digit * 10.0**decade for sign in (-1, 1) for decade in range(-9, 40, 1) for digit in (1.0, 2.0, 5.0)
)
"""Grid points on a line between which sign changes are searched for, besides the expressions' constants."""
_TURN = tuple(np.linspace(-doubles.TURNS, doubles.TURNS, 129) * 2 * np.pi)


@dataclass
class Work:
    """Limit on node evaluations in double precision."""

    pool: Pool
    left: int

    def values(self, nodes: Sequence[int], point: Columns) -> dict[int, Any]:
        """Return the values of nodes at points."""
        self.left -= count_of(point) * len(nodes)
        return doubles.values(self.pool, nodes, point)


class Lines:
    """Lines on which the conditions of two expressions change.

    Parameters
    ----------
    conditions : Conditions
        The conditions.
    bounds : Bounds
        Bounds of names.
    angles : set of str
        Names of angles.
    work : Work
        Limit on evaluations.
    """

    def __init__(self, conditions: Conditions, bounds: Bounds, angles: frozenset[str], work: Work) -> None:
        self.conditions = conditions
        self._bounds = bounds
        self._angles = angles
        self._work = work
        self._draw = random.Random(1)

    def with_conditions(self, conditions: Conditions) -> Lines:
        """Return lines on which other conditions change."""
        return Lines(conditions, self._bounds, self._angles, self._work)

    def points(self, base: Spot, name: str, inner: int = 0) -> Columns:
        """Return points along a name: on and beside each place where a condition changes, and between places.

        `inner` is the number of further points between two places.
        """
        grid = self._grid(base, name)
        ends = _places(lambda places: self._signs(base, name, places), grid)
        beside = np.concatenate([ends * (1 - _BESIDE) - 1e-300, ends * (1 + _BESIDE) + 1e-300])
        between = (ends[1:] + ends[:-1]) / 2
        outer = np.array([ends[0] - abs(ends[0]) - 1, ends[-1] + abs(ends[-1]) + 1]) if len(ends) else grid[::16]
        parts = [ends, beside, between, outer]
        if inner:
            shares = [self._draw.random() for _ in range(inner)]
            parts += [grid[self._draw.randrange(8) :: 8], *(ends[:-1] + (ends[1:] - ends[:-1]) * s for s in shares)]
        return self._along(base, name, self._allowed(name, np.unique(np.concatenate(parts))))

    def zero(self, node: int, base: Spot, name: str) -> Spot | None:
        """Return the zero of a node that is nearest to zero on a line; None if it has none there."""
        nodes = self.conditions.pool.reached(node)

        def signs(places: Array) -> Array:
            found = self._work.values(nodes, self._along(base, name, places))[node]
            row: Array = np.sign(np.broadcast_to(np.asarray(found, dtype=float), len(places)))
            return row[None]

        places = _places(signs, self._grid(base, name))
        return {**base, name: float(min(places, key=abs))} if len(places) else None

    def _signs(self, base: Spot, name: str, places: Array) -> Array:
        """Return the signs of all conditions at places on a line; NaN without a value."""
        found = self._work.values(self.conditions.nodes, self._along(base, name, places))
        return self.conditions.signs(found, len(places))

    def _grid(self, base: Spot, name: str) -> Array:
        turn = _TURN if name in self._angles else ()
        low, high = self._bounds.get(name, (None, None))
        inner = np.linspace(float(low), float(high), 65) if low is not None and high is not None else ()
        return self._allowed(name, np.unique(np.array([*_GRID, *turn, *inner, *self.conditions.numbers, base[name]])))

    def _allowed(self, name: str, values: Array) -> Array:
        low, high = self._bounds.get(name, (None, None))
        inside = np.isfinite(values)
        if low is not None:
            inside &= values >= float(low)
        if high is not None:
            inside &= values <= float(high)
        return values[inside]

    def _along(self, base: Spot, name: str, values: Array) -> Columns:
        names = self.conditions.names
        return {other: values if other == name else np.full(len(values), base[other]) for other in names}


def spot(point: Columns, k: int) -> Spot:
    """Return a single point of several."""
    return {name: float(column[k]) for name, column in point.items()}


def count_of(point: Columns) -> int:
    """Return the number of points; a point without names is one."""
    return len(next(iter(point.values()))) if point else 1


def _places(signs_at: Callable[[Array], Array], grid: Array) -> Array:
    """Return the places on a line where a row of signs is zero on the grid, or changes between its points."""
    signs = signs_at(grid)
    rows, columns = np.nonzero(signs[:, 1:] * signs[:, :-1] < 0)
    if len(rows) > _MOST_PLACES:
        keep = np.linspace(0, len(rows) - 1, _MOST_PLACES).astype(int)
        rows, columns = rows[keep], columns[keep]
    low, high = grid[columns], grid[columns + 1]
    parts = np.linspace(0, 1, _SIXTEENTHS + 1)
    for _ in range(_CUTS if len(rows) else 0):
        cuts = low[:, None] + (high - low)[:, None] * parts
        own = signs_at(cuts.ravel()).reshape(-1, *cuts.shape)[rows, np.arange(len(rows))]
        first = np.argmax(own[:, 1:] * own[:, :1] <= 0, axis=1)
        low, high = cuts[np.arange(len(rows)), first], cuts[np.arange(len(rows)), first + 1]
    return np.unique(np.concatenate([(low + high) / 2, grid[np.any(signs == 0, axis=0)]]))
