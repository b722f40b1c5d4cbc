# SPDX-License-Identifier: Apache-2.0
"""Common parts of two sides in different forms, each of which becomes one node or free number.

Parts with the same value in the field become one node. Parts with the same values at some real points are compared. If
they are the same function, such as one arc written in two ways, a free number replaces them on both sides. If the sides
are equal for every value of that number, they are equal. Conditions on it are linear, so that contradictions can be
proved.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Sequence
from fractions import Fraction
from itertools import product
from math import prod
from typing import Any

from .branches import BRANCHING, COMPARISONS, STEPS, difference, replaced_nodes
from .pool import Pool

INEXACT = STEPS | {"log", "asin", "acos", "atan", "atan2", "asinh", "acosh", "atanh", "erf"}
"""Functions that the field replaces by pseudorandom functions of their operands."""
_NO_NUMBER = COMPARISONS | {"and", "or", "not", "exprcondpair", "const"}
_TWO = 2
_FEW = 8
"""Largest number of distinct values of a part that a choice of values can replace."""
_MOST = 12
"""Largest number of compared pairs of parts, each of which may cost as much as a question."""


class Shared:
    """Finder of common parts of two expressions with free names.

    Parameters
    ----------
    pool : Pool
        Pool of the expressions.
    values : callable
        Values of an expression in the field, None for missing ones; equal values prove equality.
    look : callable
        Values of an expression at some real points.
    same : callable
        Number of points at which two expressions agree; 0 if equality is proved, None if they may differ.
    """

    def __init__(
        self,
        pool: Pool,
        values: Callable[[int], tuple[Any, ...]],
        look: Callable[[int], tuple[str, ...]],
        same: Callable[[int, int], int | None],
    ) -> None:
        self.pool = pool
        self._values = values
        self._look = look
        self._same = same

    def united(self, *roots: int) -> tuple[int, ...]:
        """Return expressions with equal parts merged, steps as floors, and logarithms expanded."""
        numbers: dict[int, int] = {}
        known: dict[tuple[Any, ...], int] = {}
        for node in self.pool.reached(*roots):
            operation, *operands = self.pool.nodes[node]
            parts = [numbers[o] if isinstance(o, int) else o for o in operands]
            number = self._rebuilt(operation, parts) if self.pool.operands(node) else node
            if operation not in _NO_NUMBER and None not in (values := self._values(number)):
                number = known.setdefault(values, number)
            numbers[node] = number
        return tuple(numbers[root] for root in roots)

    def _rebuilt(self, operation: str, parts: Sequence[Any]) -> int:
        """Return an operation on rebuilt operands; ceilings and remainders become floors, which may be equal."""
        pool, minus = self.pool, self.pool.number(-1)
        if operation == "ceiling":
            return pool.many("mul", [minus, self._floor(pool.many("mul", [minus, parts[0]]))])
        if operation == "mod":
            whole = self._floor(pool.many("mul", [parts[0], self._inverse(parts[1])]))
            return difference(pool, parts[0], pool.many("mul", [parts[1], whole]))
        if operation == "log":
            return self._logarithm(parts[0])
        if operation in ("add", "mul"):
            return pool.many(operation, parts)
        return pool.intern(operation, *parts)

    def _logarithm(self, of: int) -> int:
        """Return a logarithm as a sum of logarithms of positive factors, with exponents as coefficients."""
        pool = self.pool
        factors = pool.factors(of)
        apart = [k for k in factors if pool.nodes[k][0] == "exp" or (pool.constant(k) or 0) > 0]
        rest = pool.many("mul", [k for k in factors if k not in apart]) if len(apart) < len(factors) else None
        terms = [pool.operands(k)[0] if pool.nodes[k][0] == "exp" else pool.intern("log", k) for k in apart]
        if rest is not None:
            base, exponent = pool.raised(rest)
            if base != rest and exponent.numerator % 2:
                inner = self._logarithm(base)
                terms.append(pool.many("mul", [pool.number(exponent), inner]))
            else:
                terms.append(pool.intern("log", rest))
        return pool.many("add", terms)

    def _floor(self, of: int) -> int:
        return self.pool.intern("floor", *self.united(of))

    def _inverse(self, of: int) -> int:
        value = self.pool.constant(of)
        return self.pool.power(of, Fraction(-1)) if not value else self.pool.number(1 / value)

    def freed(self, old: int, new: int) -> tuple[int, int, int]:
        """Return both sides with a free name in place of each common part, and the points at which these parts agreed.

        The number of points is zero where the field proves it.
        """
        first, second = self._parts(old), self._parts(new)
        common = [node for node in first & second if self.pool.nodes[node][0] in BRANCHING]
        free = {node: self._free(node, self._range(node)) for node in common}
        others = defaultdict[tuple[str, ...], list[int]](list)
        for node in sorted(second - first):
            others[self._look(node)].append(node)
        points, left = list[int](), _MOST
        for node in sorted(first - second):
            for other, factor in [(k, f) for f in (1, -1) for k in others[self._look(self._times(node, f))]]:
                sides = (
                    replaced_nodes(self.pool, node, free),
                    self._times(replaced_nodes(self.pool, other, free), factor),
                )
                if other in free or left == 0 or len({*self.united(*sides)}) == 1:
                    continue
                left -= 1
                if (count := self._same(*sides)) is not None:
                    values = min(map(self._range, sides), key=lambda values: len(values) or _FEW)
                    free[node] = self._free(node, values)
                    free[other] = self._times(free[node], factor)
                    points.append(count)
                    break
        ends = self.united(*(replaced_nodes(self.pool, root, free) for root in (old, new)))
        return ends[0], ends[1], min(filter(None, points), default=0)

    def _times(self, node: int, factor: int) -> int:
        return node if factor == 1 else self.pool.many("mul", [node, self.pool.number(factor)])

    def _parts(self, root: int) -> set[int]:
        """Return the numeric parts of an expression that the field cannot evaluate."""
        opaque: dict[int, bool] = {}
        for node in self.pool.reached(root):
            operation = self.pool.nodes[node][0]
            opaque[node] = operation in INEXACT | BRANCHING or any(opaque[k] for k in self.pool.operands(node))
        return {node for node, is_opaque in opaque.items() if is_opaque and self.pool.nodes[node][0] not in _NO_NUMBER}

    def _free(self, node: int, values: frozenset[Fraction]) -> int:
        """Return a free number in place of a part, or a choice between two values if the part has only these."""
        name = self.pool.intern("sym", f"shared part {node}")
        if len(values) != _TWO:
            return name
        is_positive = self.pool.intern("strictgreaterthan", name, self.pool.number(0))
        conditions = (is_positive, self.pool.intern("const", "True"))
        pairs = zip(map(self.pool.number, sorted(values)), conditions, strict=True)
        return self.pool.intern("piecewise", *(self.pool.intern("exprcondpair", *pair) for pair in pairs))

    def _range(self, root: int) -> frozenset[Fraction]:
        """Return the possible values of a part if its form limits them to a few, else nothing."""
        ranges: dict[int, frozenset[Fraction]] = {}
        for node in self.pool.reached(root):
            operation, value = self.pool.nodes[node][0], self.pool.constant(node)
            parts = [ranges[k] for k in self.pool.operands(node)]
            if operation == "sign":
                parts = [frozenset((Fraction(-1), Fraction(1)))]
            elif operation == "exprcondpair":
                parts = parts[:1]
            elif value is not None:
                parts = [frozenset((value,))]
            elif operation not in ("add", "mul", "piecewise") or not all(parts) or prod(map(len, parts)) > _FEW**2:
                parts = []
            if operation in ("add", "mul") and parts:
                total = sum if operation == "add" else prod
                found = frozenset(map(Fraction, map(total, product(*parts))))
            else:
                found = frozenset[Fraction]().union(*parts)
            ranges[node] = found if len(found) <= _FEW else frozenset()
        return ranges[root]
