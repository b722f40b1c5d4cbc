# SPDX-License-Identifier: Apache-2.0
"""Decision if two expressions are equal, with a reason and, if they differ, a point.

Methods are tried from cheap to expensive: the same node; the same value in the finite field, with arbitrary functions
in place of maxima, absolute values and the like; ordinary real points; cells with fixed branches. Without branches,
different values in the field prove that expressions differ. With branches, expressions count as equal only after
every joint state of the branches was reached, excluded, or proved equal in the field. If the field cannot prove
equality in a cell, real points inside the cell decide.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import mpmath

from . import reals
from .domains import Domains
from .meaning import Expression, Flat, Meaning
from .points import SEED, FieldPoints, RealPoints, differ
from .pool import Pool
from .proofs.intervals import Bounds
from .proofs.known import KnownSigns
from .sampler import PointSampler
from .shared import INEXACT, Shared
from .verdicts import Verdict

if TYPE_CHECKING:
    from .cells.cells import Cells

_COMPARED = 64
"""Number of real points that are compared before the branches are examined. They miss one of four equally likely
joint states in one of 10^8 cases.
"""
_LOOKS, _LOOK_DIGITS = 8, 12
"""Numbers of points and digits with which presumably equal parts of both sides are paired before the comparison.
Fewer points pair unequal parts; with more digits, rounding separates equal parts.
"""
_FEW = 16
"""Number of points with values on both sides from which agreement counts; fewer may not reach all branches."""
_LEAST = Fraction(1, 10**300)
"""Smallest positive number in proofs with doubles: smaller doubles have fewer digits."""


class EqualityTest:
    """Test of equality, which evaluates at fixed sequences of points and caches the values.

    Parameters
    ----------
    pool : Pool
        Pool of all expressions.
    positive : callable
        True for a positive free name.
    sampler : PointSampler
        Draws real values of free names.
    seed : int
        Seed of the points of the field.

    Attributes
    ----------
    field : FieldPoints
        Points of the finite field.
    real : RealPoints
        Real points.
    known : KnownSigns
        Proofs about signs.
    written_out : Flat
        Expands an expression until all names are free.
    """

    def __init__(self, pool: Pool, positive: Callable[[str], bool], sampler: PointSampler, seed: int = SEED) -> None:
        self.pool = pool
        self.positive = positive
        self.sampler = sampler
        self.field = FieldPoints(pool, positive, seed)
        self.real = RealPoints(sampler)
        self.written_out = Flat(pool)
        self._free = Meaning(pool, lambda _: None)
        self.known = KnownSigns(self._bounds(), self.field, self.real, self._free)
        self._domain = Domains(pool, self.known)
        self._shared = Shared(pool, self._values_of, self._look_of, self._points_of)

    def decide(self, old: Expression, new: Expression) -> Verdict:
        """Decide whether two expressions are the same function."""
        if old[1] == new[1] and old[0] is new[0]:
            return Verdict(True, "node identity")
        return self.where_defined(self._by_values(old, new), old, new)

    def where_defined(self, verdict: Verdict, old: Expression, new: Expression) -> Verdict:
        """Compare the domains of two sides: the verdict is "different" if only one has a value at some point."""
        if verdict.equal is False:
            return verdict
        first, second = (self._domain(self.written_out(side)) for side in (old, new))
        if first == second:
            return verdict
        outcome = self._by_cells(self._domain.product(first), self._domain.product(second))
        if outcome.equal:
            return replace(verdict, how=f"{verdict.how}; both sides exist together at {outcome.how}")
        if verdict.equal is None and outcome.equal is None:
            return verdict
        how = "where both sides exist they are equal, but " if verdict.equal else ""
        how += "only one of them does at a point" if outcome.equal is False else f"of their domains: {outcome.how}"
        point = outcome.point and {**self._drawn(old, new), **outcome.point}
        return Verdict(outcome.equal, how, point=point)

    def is_never_zero(self, expression: Expression) -> bool:
        """Return True if an expression is provably never zero within the bounds of its names."""
        return self.known.is_never_zero(self.written_out(expression))

    def _drawn(self, *sides: Expression) -> dict[str, Fraction]:
        """Return drawn values of all names that expressions depend on."""
        point = self.sampler.point(0)
        return {name: point[name] for side in sides for name in side[0].free(side[1])}

    def _bounds(self) -> Bounds:
        """Return the bounds of all free names; the lower bound of a positive name is above zero."""
        bounds = {name: row[:2] for name, row in self.sampler.names.items()}
        return {
            name: (_LEAST if low == 0 and self.positive(name) else low, high) for name, (low, high) in bounds.items()
        }

    def _by_values(self, old: Expression, new: Expression) -> Verdict:
        """Decide if two expressions have equal values at all points where both have a value."""
        equal = self.field.same(old, new)
        if equal:
            return Verdict(True, self.field.how(old, new))
        if equal is False and all(self.field[0][meaning].exact(root) for meaning, root in (old, new)):
            return Verdict(False, self.field.how())
        return self._by_reals(old, new)

    def _by_reals(self, old: Expression, new: Expression) -> Verdict:
        """Decide by points with 50 digits, also where only one side exists; without a difference, by branches."""
        matches = 0
        for worlds in self.real.where([old, new], _COMPARED):
            matches += 1
            if differ(worlds, old, new):
                return Verdict(False, f"a point with {reals.DIGITS} digits")
        if matches >= _FEW:
            return self._by_branches(old, new)
        for side, other, name in ((old, new, "old"), (new, old, "new")):
            alone = sum(1 for worlds in self.real.where([side], _FEW) if worlds.value(other) is None)
            if alone == _FEW:
                return Verdict(False, f"only the {name} side exists at {alone} points")
        return Verdict(None, f"no difference, but both sides exist at only {matches} of the points tried")

    def _by_branches(self, old: Expression, new: Expression) -> Verdict:
        """Decide by cells, and name the functions that only points decide."""
        roots = self.written_out(old), self.written_out(new)
        if roots[0] == roots[1]:
            return Verdict(True, "the same expression with all definitions inserted")
        verdict = self._by_parts(*roots)
        if not verdict.points:
            return verdict
        used = {self.pool.nodes[node][0] for node in self.pool.reached(*roots)} & INEXACT or {"roots"}
        evidence = f"compared at {verdict.points} points with {reals.DIGITS} digits: {', '.join(sorted(used))}"
        return replace(
            verdict, how=f"{verdict.how}; {evidence} {'is' if len(used) == 1 else 'are'} not decided exactly"
        )

    def _by_parts(self, old: int, new: int) -> Verdict:
        """Decide by cells with equal parts merged, if needed with free numbers in place of common parts."""
        sides = self._shared.united(old, new)
        if sides[0] == sides[1]:
            return Verdict(True, "the same expression with equal parts merged")
        cells = self._cells(*sides)
        if outcome := cells.walk():
            return outcome
        if not cells.are_proved():
            *simpler, points = self._shared.freed(*sides)
            if tuple(simpler) != sides and (verdict := self._by_cells(*simpler)).equal:
                return replace(verdict, points=min(filter(None, (points, verdict.points)), default=0))
        return cells.settle()

    def _by_cells(self, old: int, new: int) -> Verdict:
        """Decide by cells."""
        if old == new:
            return Verdict(True, "the same expression with equal parts merged")
        cells = self._cells(old, new)
        return cells.walk() or cells.settle()

    def _cells(self, old: int, new: int) -> Cells:
        from .cells.cells import Cells  # imports numpy, which most comparisons do not need

        return Cells((old, new), self._domain.inside(old, new), self.known, self.real, self.field, self._free)

    def _points_of(self, old: int, new: int) -> int | None:
        """Return the number of agreeing points; 0 if equality is proved, None if the sides are not equal."""
        verdict = self._by_cells(old, new)
        return verdict.points if verdict.equal else None

    def _values_of(self, node: int) -> tuple[Any, ...]:
        """Return enough field values of a node to identify equal nodes."""
        return self.field.values(self._free, node, self.field.count((self._free, node)))

    def _look_of(self, node: int) -> tuple[str, ...]:
        """Return an expression's values at a few real points; parts with the same values are paired."""
        values = (self.real[number].value((self._free, node)) for number in range(_LOOKS))
        return tuple(mpmath.nstr(value, _LOOK_DIGITS) for value in values if value is not None)
