# SPDX-License-Identifier: Apache-2.0
"""Comparison of expressions without branches in the finite field."""

from __future__ import annotations

from .. import field
from ..meaning import Meaning
from ..points import POINTS, FieldPoints
from .slopes import slope

_SIGNS = 64
"""Number of sign choices of roots that are compared at a field point: all choices of six roots."""


class SmoothTest:
    """Test of equality of expressions with free names and without branches.

    Parameters
    ----------
    points : FieldPoints
        Points of the field.
    free : Meaning
        Meaning in which all names are free.
    """

    def __init__(self, points: FieldPoints, free: Meaning) -> None:
        self.points = points
        self._free = free

    def __call__(self, old: int, new: int) -> bool | None:
        """Return True if two expressions are equal; None if the field proves neither equality nor difference."""
        equal = self._same(old, new)
        if equal is not False:
            return equal
        return False if self.are_apart(old, new) or self._have_other_slopes(old, new) else None

    def are_equal(self, old: int, new: int) -> bool:
        """Return True if two expressions are equal for any functions in place of those unknown to the field."""
        return self._same(old, new) is True

    def are_apart(self, old: int, new: int) -> bool:
        """Return True if the field proves a difference, at some point and for all signs of the roots."""
        world = self.points[0][self._free]
        if not all(world.exact(root, rooted=True) for root in (old, new)):
            return False
        if all(world.exact(root) for root in (old, new)):
            return self._same(old, new) is False
        return any(self._never_meet(old, new, number) for number in range(POINTS))

    def _never_meet(self, old: int, new: int, number: int) -> bool:
        """Return True if two expressions differ at a field point for all signs of their roots."""
        waiting = [field.Roots()]
        for _ in range(_SIGNS):
            roots = waiting.pop()
            world = self.points.at(number, roots=roots)[self._free]
            a, b = world.defined(old), world.defined(new)
            if a is None or b is None or a == b:
                return False
            waiting += roots.others()
            if not waiting:
                return True
        return False

    def _have_other_slopes(self, old: int, new: int) -> bool:
        """Return True if the field proves that derivatives differ, which reveals differences between the test points.

        The field does not know logarithms and arcs, but it knows their derivatives.
        """
        pool = self.points.pool
        for name in sorted(pool.names(old, new).values()):
            first, second = (slope(pool, root, name) for root in (old, new))
            if first is not None and second is not None and self.are_apart(first, second):
                return True
        return False

    def _same(self, old: int, new: int) -> bool | None:
        return old == new or self.points.same((self._free, old), (self._free, new))
