# SPDX-License-Identifier: Apache-2.0
"""Signs that expressions with free names provably never have, alone or together."""

from __future__ import annotations

from .. import field
from ..branches import Atom
from ..meaning import Meaning
from ..points import FieldPoints, RealPoints
from . import linear
from .intervals import Bounds
from .signs import Signs

_SQUARES = 64
"""Number of field points at which all values of a square must be squares; other functions pass once in 2^64 cases."""


class KnownSigns:
    """Proofs about signs, with cached answers.

    Parameters
    ----------
    bounds : Bounds
        Bounds of free names.
    points : FieldPoints
        Points of the field.
    real : RealPoints
        Real points.
    free : Meaning
        Meaning in which all names are free.
    """

    def __init__(self, bounds: Bounds, points: FieldPoints, real: RealPoints, free: Meaning) -> None:
        self.pool = points.pool
        self.bounds = bounds
        self.parts = Signs(self.pool, bounds)
        self.ranges = self.parts.ranges
        self._points = points
        self._real = real
        self._free = free
        self._impossible: dict[tuple[Atom, ...], bool] = {}
        self._squares: dict[int, bool] = {}

    def exclude(self, required: tuple[Atom, ...]) -> bool:
        """Return True if signs provably exclude each other, directly or as signs of parts."""
        return self.are_impossible(required) or all(map(self.are_impossible, self.parts.splits(required)))

    def are_impossible(self, required: tuple[Atom, ...]) -> bool:
        """Return True if signs provably exclude each other, without their parts."""
        if required not in self._impossible:
            self._impossible[required] = (
                linear.impossible(self.pool, required, self.bounds)
                or self.ranges.exclude(required)
                or any(sign and self.never_has(node, sign) for node, sign in required)
            )
        return self._impossible[required]

    def is_positive(self, node: int) -> bool:
        """Return True if an expression is provably nowhere negative."""
        return self.ranges.never_have(node, -1)

    def is_never_zero(self, root: int) -> bool:
        """Return True if an expression is provably never zero."""
        stack = [root]
        while stack:
            operation, *operands = self.pool.nodes[node := stack.pop()]
            if operation == "mul":
                stack += operands
            elif operation == "pow":
                stack.append(operands[0])
            elif operation != "exp" and not self.ranges.never_have(node, 0):
                return False
        return True

    def is_zero(self, node: int) -> bool:
        """Return True if an expression without branches is zero at the points of the field."""
        return all(value == 0 for value in self._points.values(self._free, node))

    def never_has(self, node: int, sign: int) -> bool:
        """Return True if an expression never has this sign, because it or its negative is a square.

        An expression whose values at many field points are squares is a number times a square. A real point gives the
        sign of the number.
        """
        if node not in self._squares:
            self._squares[node] = self._is_square(node)
        if not self._squares[node]:
            return False
        worlds = next(iter(self._real.where([(self._free, node)], 1)), None)
        value = None if worlds is None else worlds[self._free].value(node)
        return value is not None and bool(value * sign < 0)

    def _is_square(self, node: int) -> bool:
        """Return True if the values of an expression, or of its negative, are squares at all field points."""
        signs: set[int] = set()
        for number in range(_SQUARES):
            value = self._points[number][self._free].defined(node)
            signs.add(field.sign(value) if isinstance(value, int) else 0)
            if len(signs) > 1 or 0 in signs:
                return False
        return True
