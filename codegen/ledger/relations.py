# SPDX-License-Identifier: Apache-2.0
"""Tests of printed relations with the derived meaning of each symbol.

`codegen.equal` tests relations at random points with 50 digits, drawn from the bounds of the names. This finds every
difference except on a set of measure zero, in an unvisited branch, or below rounding. A small relation that passes is
expanded. It is proved if both forms are equal or their difference vanishes in normal form.
"""

from __future__ import annotations

import functools
from collections.abc import Iterable, Iterator
from fractions import Fraction
from itertools import chain
from typing import Any

import sympy as sp

from mehvar.models.derivation import Expr
from mehvar.models.mechanics import reduce_sines
from mehvar.models.paper import Case, Relation, Side, frozen, symbols_of

from ..equal.meaning import Expression
from ..equal.points import Worlds, inside
from ..equal.pool import ways
from ..equal.reals import DIGITS, holds
from ..equal.sampler import Point
from ..equal.verdicts import VISIBLE, Counterexample, Verdict, shown, simplified
from .meanings import Meanings
from .sides import entries

_POINTS, _BRANCHED_POINTS, _INEQUALITY_POINTS = 16, 64, 128
"""Numbers of test points: without branches, with branches, for inequalities. With branches, a branch taken once in
ten draws is missed by 64 points in 1 of 850 cases, by 32 in 1 of 29. An inequality that fails in 1/20 of its domain
is missed once in 700. Half as many points give the same verdicts on the triangle's paper; one of each misses one of
27 misprints. Without branches, 16 suffice."""
_FEW = 4
"""Number of points that are tested before a proof, because a difference nearly always shows at the first point."""
_DRAWS = 100
"""Number of attempts per point, enough for domains of a few hundredths."""
_WRITTEN_OUT, _PROVABLE = 750, 250
"""Limits on operations of expanded sides and of the normal form of their difference. Of 258 relations of triangle
and slosh, 133 are proved (122 with half, 152 with twice the limits) and the others tested. No verdict depends on the
limits; the time changes by at most a fifth. A normal form's cost has no bound, so the limits stay small."""
_BRANCHING = (sp.Abs, sp.sign, sp.Max, sp.Min, sp.Piecewise, sp.atan2, sp.acos, sp.asin)
_ANGLES = frozenset(("atan2", "acos", "asin"))
"""Functions with jumps or a bounded domain that are not piecewise."""
_UNEVALUATED = (sp.Integral, sp.Derivative, sp.Limit, sp.Sum, sp.UnevaluatedExpr)


def compare(relation: Relation, meanings: Meanings, left: Side | None = None, right: Side | None = None) -> Verdict:
    """Decide if a relation holds.

    Parameters
    ----------
    relation : Relation
        Its cases, domain and tolerance always apply.
    meanings : Meanings
        Meanings of the names.
    left, right : Expr or Matrix, optional
        Sides to compare in place of the printed ones.
    """
    left = relation.left if left is None else left
    right = relation.right if right is None else right
    verdicts = [_decide(_Test(relation, meanings, case, left, right)) for case in relation.cases]
    failed = [verdict for verdict in verdicts if not verdict.equal]
    if failed:
        return next((verdict for verdict in failed if verdict.equal is False), failed[0])
    return Verdict(True, _weakest(verdict.how for verdict in verdicts))


def residuals(relation: Relation, meanings: Meanings) -> tuple[Expr, Expr]:
    """Expand the printed and the derived residual of an equation of motion into terms, for the first case.

    Even powers of sines are replaced by cosines, so that equal terms look equal.
    """
    test = _Test(relation, meanings, relation.cases[0], relation.left, relation.right)
    printed, derived = (entries(test.meanings.written_out(side))[0] for side in test.sides)
    return reduce_sines(printed), reduce_sines(derived)


def _weakest(hows: Iterable[str]) -> str:
    """Return the weakest evidence among several cases, which holds for all."""
    distinct = list(dict.fromkeys(hows))
    return next((how for how in distinct if not how.startswith("proved")), distinct[0])


def _decide(test: _Test) -> Verdict:
    """Compare shape, random points and forms of both sides in one case."""
    shapes = [_shape(side) for side in test.sides]
    if shapes[0] != shapes[1]:
        return Verdict(False, f"proved: {_named(shapes[0])} cannot equal {_named(shapes[1])}")
    if any(side.has(sp.oo, -sp.oo, sp.nan, sp.zoo) for side in test.sides):
        same = test.sides[0] == test.sides[1]
        return Verdict(same, "proved: " + ("both are infinite" if same else f"{test.sides[0]} is not {test.sides[1]}"))
    count = 0
    for worlds in test.points():
        if test.differ(worlds):
            return Verdict(False, f"differs with {DIGITS} digits", test.counterexample(worlds))
        count += 1
        if count == min(_FEW, test.count) and test.op == "=" and not test.within and (proof := test.proof()):
            return Verdict(True, proof)
    if count < test.count:
        return Verdict(None, f"only {count} of {test.count} points were found at which both sides exist")
    if test.op != "=":
        return Verdict(True, f"tested at {count} random points" if test.free else "compared as numbers")
    if not test.free:
        return Verdict(True, f"compared as numbers, within {test.within}" if test.within else "compared as numbers")
    return Verdict(True, f"tested at {count} random points with {DIGITS} digits")


class _Test:
    """Test of a relation in one case, with both sides, meanings of names and random points."""

    def __init__(self, relation: Relation, meanings: Meanings, case: Case, left: Side, right: Side) -> None:
        self.meanings = meanings.case(case)
        self.op, self.within = relation.op, Fraction(str(relation.within))
        sides = (left, right) if relation.against is None else (left - right, relation.against)
        self.sides = tuple(self._carried_out(side) for side in sides)
        self._equality, self._write = meanings.equality, meanings.names.as_text
        first, second = map(self.meanings.expressions, self.sides)
        self._pairs = list(zip(first, second, strict=False))
        """Pairs of entries of both sides; sides of different shape are not compared."""
        self._domain = [e for expr in relation.domain for e in self.meanings.expressions(self._carried_out(expr))]
        places = [*chain(*self._pairs), *self._domain]
        self.free = sorted({name for meaning, root in places for name in meaning.free(root)})
        branched = any(self._branches(meaning, root) for meaning, root in chain(*self._pairs))
        self.count = _BRANCHED_POINTS if branched else _POINTS
        if self.op != "=":
            self.count = _INEQUALITY_POINTS
        if not self.free:
            self.count = 1

    def _carried_out(self, side: Side) -> Side:
        """Evaluate integrals, derivatives and limits with the meanings of their contents."""
        side = frozen(side)
        return self.meanings.written_out(side).doit() if side.has(*_UNEVALUATED) else side

    def _branches(self, meaning: Any, root: int) -> bool:
        pool = self._equality.pool
        return any(ways(pool, node) or pool.nodes[node][0] in _ANGLES for node in meaning.cone(root))

    def proof(self) -> str:
        """Return the method that proves equality, if any, for a relation small enough to expand."""
        sizes: dict[Expr, int] = {}
        if max(self._size(side, sizes) for side in self.sides) > _WRITTEN_OUT:
            return ""
        left, right = (entries(self.meanings.written_out(side)) for side in self.sides)
        if left == right:
            return "proved: both sides are the same expression"
        if all(_vanishes(a - b) for a, b in zip(left, right, strict=True)):
            return "proved: the difference vanishes in normal form"
        return ""

    def _size(self, side: Side, sizes: dict[Expr, int]) -> int:
        """Count the operations of an expanded side; `sizes` holds the counts of names."""
        size = _operations(side)
        for symbol in symbols_of(side):
            if symbol in self.meanings.of:
                if symbol not in sizes:
                    sizes[symbol] = self._size(self.meanings.of[symbol], sizes)
                size += sizes[symbol] * (1 if isinstance(side, sp.MatrixBase) else side.count(symbol))
        return size

    def points(self) -> Iterator[Worlds]:
        """Yield reproducible points of the domain at which both sides exist."""
        places = list(chain(*self._pairs))
        return self._equality.real.where(places, self.count, self._domain, _DRAWS, hopeless=self.count * _DRAWS)

    def differ(self, worlds: Worlds, visible: bool = False) -> bool:
        """Return True if the relation fails at a point; with `visible`, only if printed digits show it."""
        return any(self._apart(worlds, left, right, visible) for left, right in self._pairs)

    def _apart(self, worlds: Worlds, left: Expression, right: Expression, visible: bool = False) -> bool:
        (a, size), (b, other) = ((worlds[m].value(root), worlds[m].size(root)) for m, root in (left, right))
        if holds(self.op, (a, size), (b, other), self.within):
            return False
        return not visible or bool(abs(a - b) > VISIBLE * (abs(a) + abs(b)))

    def _fails(self, point: Point) -> bool:
        """Return True if the relation visibly fails at a point of the domain."""
        worlds = self._equality.real.at(point)
        places = chain(*self._pairs)
        if not inside(worlds, self._domain) or any(worlds[m].defined(root) is None for m, root in places):
            return False
        return self.differ(worlds, visible=True)

    def counterexample(self, worlds: Worlds) -> Counterexample:
        """Return a point of failure with simple numbers and many zeros."""
        drawn = next(iter(worlds)).point
        point = simplified({name: drawn[name] for name in self.free}, self._equality.sampler.simple, self._fails)
        worlds = self._equality.real.at(point)
        left, right = next(pair for pair in self._pairs if self._apart(worlds, *pair))
        values = shown(worlds, left, right)
        members = [(s, meaning) for s, meaning in self.meanings.overrides.items() if not meaning.args]
        shown_members = tuple((self._write(symbol), self._write(meaning)) for symbol, meaning in members)
        shown_names = tuple((self._write(self.meanings.symbol(name)), str(value)) for name, value in point.items())
        return Counterexample((*shown_members, *shown_names), *values)


def _shape(side: Side) -> tuple[int, int]:
    return tuple(map(int, side.shape)) if isinstance(side, sp.MatrixBase | sp.MatrixExpr) else (1, 1)  # type: ignore[return-value]


@functools.lru_cache(maxsize=4096)
def _operations(side: Side) -> int:
    return int(sp.count_ops(side))


def _named(shape: tuple[int, int]) -> str:
    return "a number" if shape == (1, 1) else f"a {shape[0]} x {shape[1]} matrix"


def _vanishes(difference: Expr) -> bool:
    """Return True if a difference is zero as a polynomial in cosines, sines and roots, with their squares reduced."""
    if difference.has(*_BRANCHING) or sp.count_ops(difference) > _PROVABLE:
        return False
    numerator = sp.fraction(sp.together(sp.expand_trig(difference)))[0]
    return bool(reduce_sines(sp.expand(numerator)) == 0)
