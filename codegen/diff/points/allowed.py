# SPDX-License-Identifier: Apache-2.0
"""Points within a version's constraints and limits; differences elsewhere affect no run."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction

from ...equal.equality import EqualityTest
from ...equal.meaning import Expression, Meaning
from ...equal.points import Worlds, differ, inside, one_exists
from ...equal.sampler import Point
from ...equal.verdicts import Verdict
from ..versions import Versions

CONDITIONS = frozenset(("constraint", "limit"))
"""Kinds of rows whose expression is positive in every run."""
_POINTS = 128
"""Number of drawn points. Half of them have default parameters, which fulfil constraints, so that some points remain
even with five independent inequalities; a quarter are whole numbers.
"""
_HALVINGS = 40
"""Halvings of the distance between two points, to 1e-12 of it: the width of an edge that is found."""

Test = Callable[[Worlds], bool]


class Allowed:
    """Constraints and limits of both versions on the names in expressions.

    Parameters
    ----------
    versions : Versions
        Rows of both sides.
    """

    def __init__(self, versions: Versions) -> None:
        self._equality: EqualityTest = versions.equality
        self._free = Meaning(versions.pool, lambda _: None)
        self._conditions = [
            [self._margin(meaning, item.root) for item in items if item.row.kind in CONDITIONS]
            for items, meaning in ((versions.olds, versions.before), (versions.news, versions.after))
        ]

    def _margin(self, meaning: Meaning, root: int) -> Expression:
        return self._free, self._equality.written_out((meaning, root))

    def test(self, *sides: Expression) -> Test:
        """Return a function that is true if a version allows given values of the expressions' names."""
        conditions = self._beside(sides)
        return lambda worlds: any(inside(worlds, margins) for margins in conditions)

    def _beside(self, sides: Sequence[Expression]) -> list[list[Expression]]:
        """Return the conditions of each version on the names in expressions."""
        names = {name for side in sides for name in self._free.free(self._equality.written_out(side))}
        return [[margin for margin in margins if names & {*self._free.free(margin[1])}] for margins in self._conditions]

    def where_allowed(self, verdict: Verdict, old: Expression, new: Expression) -> Verdict:
        """Return a verdict "different", or "undecided" if no allowed point shows the difference."""
        if not all(self._beside((old, new))):
            return verdict
        test = self.test(old, new)
        count = 0
        tried: list[tuple[Point, object]] = []
        for point in self._points(verdict.point):
            worlds = self._equality.real.stepped(point)  # as a name may be equal to a threshold
            if test(worlds):
                count += 1
                if differ(worlds, old, new) or one_exists(worlds, old, new):
                    return Verdict(False, verdict.how, point=point)
            tried.append((point, worlds[old[0]].defined(old[1])))
        if not count:
            return verdict
        for point in self._between(tried, old):
            worlds = self._equality.real.stepped(point)
            if test(worlds) and differ(worlds, old, new):
                return Verdict(False, verdict.how, point=point)
        return Verdict(None, f"they differ, but at none of {count} points that the constraints and limits allow")

    def _between(self, tried: Sequence[tuple[Point, object]], side: Expression) -> Iterator[Point]:
        """Yield the points of bisections between points with two values, as differences may be at their edge only.

        The shadow of a point-like Sun and that of its disc differ in the penumbra.
        """
        known = [(point, value) for point, value in tried if value is not None]
        for (low, first), (high, last) in itertools.pairwise(known):
            for _ in range(_HALVINGS if first != last else 0):
                middle = {name: (low[name] + high[name]) / 2 for name in low.keys() & high.keys()}
                yield middle
                value = self._equality.real.stepped(middle)[side[0]].defined(side[1])
                if value == first:
                    low = middle
                elif value == last:
                    high = middle
                else:
                    break

    def _points(self, known: Point | None) -> Iterator[Point]:
        """Yield the known point first, then drawn ones; every other has defaults, as narrow constraints need."""
        sampler = self._equality.sampler
        usual = {name: Fraction(row[2]) for name, row in sampler.names.items() if row[2] is not None}
        drawn = {} if known is None else {name: known[name] for name in known}
        yield from [{**sampler.point(0), **drawn}] * bool(drawn)
        for number in range(_POINTS):
            point = sampler.point(number)
            if number % 4 == 2:  # as delays, which are numbers of samples
                point = {name: Fraction(round(value)) for name, value in point.items()}
            yield {**point, **(usual if number % 2 else {})}
