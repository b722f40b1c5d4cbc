# SPDX-License-Identifier: Apache-2.0
"""Proofs by interval arithmetic that expressions never have some signs.

All intervals are rounded outward, so that a sign outside of an expression's interval is excluded.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction

from ..pool import Pool, fraction

Interval = tuple[float, float]
ALL: Interval = (-math.inf, math.inf)
_HALF_TURN = (0.0, math.nextafter(math.pi, 4.0))
_QUARTERS = (-math.nextafter(math.pi / 2, 2.0), math.nextafter(math.pi / 2, 2.0))
RANGES: dict[str, Interval] = {
    "sin": (-1.0, 1.0), "cos": (-1.0, 1.0), "tanh": (-1.0, 1.0), "sign": (-1.0, 1.0), "exp": (0.0, math.inf),
    "cosh": (1.0, math.inf), "acosh": (0.0, math.inf), "acos": _HALF_TURN, "atan2": (-_HALF_TURN[1], _HALF_TURN[1]),
    "atan": _QUARTERS, "asin": _QUARTERS,
}  # fmt: skip
"""Ranges of functions, rounded outwards."""
QUARTERS = {"acos": (0, 2), "asin": (-1, 1), "atan": (-1, 1), "atan2": (-2, 2)}
"""Exact ranges of inverse trigonometric functions in quarter turns."""
CONSTANTS: dict[str, Interval] = {
    name: (math.nextafter(value, 0.0), math.nextafter(value, 4.0)) for name, value in (("pi", math.pi), ("E", math.e))
}
_ODD = frozenset(("sinh", "tanh", "asinh", "atanh", "atan", "asin", "sign"))
"""Odd functions, which have the sign of their operand."""
_RISING: dict[str, tuple[Callable[[float], float], Interval]] = {
    "exp": (math.exp, ALL), "log": (math.log, (0.0, math.inf)), "atan": (math.atan, ALL), "tanh": (math.tanh, ALL),
    "asin": (math.asin, (-1.0, 1.0)), "acos": (math.acos, (-1.0, 1.0)), "sinh": (math.sinh, ALL),
    "asinh": (math.asinh, ALL), "acosh": (math.acosh, (1.0, math.inf)), "atanh": (math.atanh, (-1.0, 1.0)),
}  # fmt: skip
"""Monotonic functions with their domains; all increase except one."""
_CLOSE = 4
"""Number of units in the last place by which results of library functions are rounded outward; good libraries err by
one.
"""
_EXACT = 4
"""Largest exponent whose power is tested for exactness; higher powers are long numbers."""
Bounds = Mapping[str, tuple[Fraction | None, Fraction | None]]


class Ranges:
    """Intervals of expressions within the bounds of their names, cached.

    Parameters
    ----------
    pool : Pool
        Pool of the expressions.
    bounds : mapping
        Bounds of free names; None for a missing one.
    """

    def __init__(self, pool: Pool, bounds: Bounds) -> None:
        self.pool = pool
        self.bounds = bounds
        self._intervals: dict[int, Interval] = {}

    def __getitem__(self, root: int) -> Interval:
        return self.pool.cached(self._intervals, root, self._of)

    def exclude(self, atoms: Sequence[tuple[int, int]]) -> bool:
        """Return True if one of some nodes provably never has its sign: 1, -1, or 0 for zero."""
        return any(self.never_have(*atom) for atom in atoms)

    def never_have(self, node: int, sign: int) -> bool:
        """Return True if a node provably never has a sign."""
        low, high = self[node]
        return (low > 0 or high < 0) if sign == 0 else high <= 0 if sign > 0 else low >= 0

    def _of(self, node: int) -> Interval:
        """Return an interval of all values of a node, given those of its operands."""
        operation, *rest = self.pool.nodes[node]
        operands = [self._intervals[o] for o in self.pool.operands(node)]
        if operation == "num":
            return _exact(fraction(rest[0]))
        if operation == "const":
            return CONSTANTS.get(rest[0], ALL)
        if operation == "sym":
            low, high = self.bounds.get(rest[0], (None, None))
            return (-math.inf if low is None else _exact(low)[0], math.inf if high is None else _exact(high)[1])
        if operation == "add":
            return _sum(operands)
        if operation == "mul":
            return _both(_product(operands), self._share(node))
        if operation == "pow":
            return _power(operands[0], self.pool.constant(self.pool.operands(node)[1]))
        if operation in ("max", "min"):
            best = max if operation == "max" else min
            return best(low for low, _ in operands), best(high for _, high in operands)
        if operation == "abs":
            return _absolute(operands[0])
        if operation in ("floor", "ceiling"):
            return _rounded(operation, operands[0])
        if operation == "mod":
            return (0.0, operands[1][1]) if operands[1][0] > 0 else ALL
        if operation in _RISING:
            limits = RANGES.get(operation, ALL)
            return _both(_risen(operation, operands[0]), _odd(operands[0], limits) if operation in _ODD else limits)
        if operation in _ODD:
            return _odd(operands[0], RANGES.get(operation, ALL))
        if operation in RANGES:
            return RANGES[operation]
        if operation == "piecewise":
            pieces = [self._intervals[self.pool.operands(pair)[0]] for pair in self.pool.operands(node)]
            return min(low for low, _ in pieces), max(high for _, high in pieces)
        return ALL

    def _share(self, node: int) -> Interval:
        """Return bounds on the ratio of a part of a sum to the sum, such as the component of a unit vector."""
        factors = self.pool.operands(node)
        for part, other in (factors, factors[::-1]) if len(factors) == 2 else ():
            base, exponent = self._root_of(other)
            terms = self.pool.operands(base) if self.pool.nodes[base][0] == "add" else ()
            term = {Fraction(-1): part, Fraction(-1, 2): self.pool.power(part, Fraction(2))}.get(exponent)
            if term in terms and all(self._intervals[k][0] >= 0 for k in terms):
                return (0.0 if term == part else -1.0), 1.0
        return ALL

    def _root_of(self, node: int) -> tuple[int, Fraction]:
        """Return the base and the exponent of nested powers."""
        base, exponent = self.pool.raised(node)
        if base == node:
            return node, exponent
        inner, power = self._root_of(base)
        return inner, power * exponent


def _both(a: Interval, b: Interval) -> Interval:
    """Return the common part of two intervals; all numbers without one, as the expression then has no value."""
    low, high = max(a[0], b[0]), min(a[1], b[1])
    return (low, high) if low <= high else ALL


def _out(low: float, high: float) -> Interval:
    """Round outwards; NaN becomes an infinite bound."""
    low = -math.inf if math.isnan(low) else math.nextafter(low, -math.inf)
    high = math.inf if math.isnan(high) else math.nextafter(high, math.inf)
    return low, high


def _exact(value: Fraction) -> Interval:
    try:
        number = float(value)
    except OverflowError:
        return (1e308, math.inf) if value > 0 else (-math.inf, -1e308)
    return (number, number) if Fraction(number) == value else _out(number, number)


def _sum(parts: Sequence[Interval]) -> Interval:
    lows, highs = [a for a, _ in parts], [b for _, b in parts]
    low = -math.inf if -math.inf in lows else _total(lows)[0]
    return low, math.inf if math.inf in highs else _total(highs)[1]


def _total(values: Sequence[float]) -> Interval:
    """Return a sum, rounded outward only if inexact, so that 1 - 1 is exactly zero."""
    total = math.fsum(values)
    if not math.isfinite(total):
        return total, total
    return (total, total) if sum(map(Fraction, values)) == Fraction(total) else _out(total, total)


def _product(parts: Sequence[Interval]) -> Interval:
    """Return the interval of a product, rounded outwards unless exact; zero times infinity is zero."""
    low, high = 1.0, 1.0
    for a, b in parts:
        corners = [0.0 if u == 0 or v == 0 else u * v for u in (low, high) for v in (a, b)]
        zero = low == high == 0.0 or a == b == 0.0
        signed = _out(min(corners), max(corners))
        # a product of numbers of known signs has a sign despite rounding; a product with one is exact
        exact = all(abs(side) in (0.0, 1.0) for side in (a, b)) or all(abs(side) in (0.0, 1.0) for side in (low, high))
        low, high = (
            corner if exact or corner == 0.0 else rounded
            for corner, rounded in zip((min(corners), max(corners)), signed, strict=True)
        )
        if zero:
            low = high = 0.0
    return low, high


def _inverse(a: Interval) -> Interval:
    if a[0] == a[1] != 0.0 and Fraction(1 / a[0]) * Fraction(a[0]) == 1:
        return 1 / a[0], 1 / a[0]
    low, high = (1 / a[1] if a[1] else math.inf), (1 / a[0] if a[0] else -math.inf)
    if a[0] >= 0:
        high = math.inf if a[0] == 0 else high
        return max(0.0, math.nextafter(low, -math.inf)), math.nextafter(high, math.inf)
    return math.nextafter(low, -math.inf), min(0.0, math.nextafter(high, math.inf))


def _rounded(operation: str, operand: Interval) -> Interval:
    """Return the range of an interval's values after rounding down or up to integers."""
    low, high = operand
    function = math.floor if operation == "floor" else math.ceil
    return (
        float(function(low)) if math.isfinite(low) else low,
        float(function(high)) if math.isfinite(high) else high,
    )


def _risen(operation: str, operand: Interval) -> Interval:
    """Return the range of a monotonic function over an interval."""
    function, domain = _RISING[operation]
    low, high = (_at(function, value) for value in _both(operand, domain))
    if operation == "acos":
        low, high = high, low
    for _ in range(_CLOSE):
        low, high = _out(low, high)
    return low, high


def _at(function: Callable[[float], float], value: float) -> float:
    """Return a function's value or limit; overflow gives infinity."""
    try:
        return function(value)
    except OverflowError:
        return math.copysign(math.inf, value)
    except ValueError:  # at the end of a domain
        return math.copysign(math.inf, value - 0.5)


def _absolute(a: Interval) -> Interval:
    low, high = a
    return (0.0 if low <= 0 <= high else min(abs(low), abs(high))), max(abs(low), abs(high))


def _odd(operand: Interval, limits: Interval) -> Interval:
    low, high = limits
    return (max(low, 0.0) if operand[0] >= 0 else low), (min(high, 0.0) if operand[1] <= 0 else high)


def _power(base: Interval, exponent: Fraction | None) -> Interval:
    """Return the interval of a power with a constant exponent; None stands for any other exponent."""
    low, high = base
    if exponent is None:
        return ALL
    if exponent.denominator != 1:
        if exponent == Fraction(1, 2) and high >= 0:
            return _out(math.sqrt(max(low, 0.0)), 0.0)[0] if low > 0 else 0.0, _out(0.0, math.sqrt(high))[1]
        return (0.0, math.inf) if exponent.denominator % 2 == 0 else ALL
    count = int(exponent)
    if count < 0:
        whole = _power(base, Fraction(-count))
        return _inverse(whole) if whole[0] > 0 or whole[1] < 0 else (0.0, math.inf) if whole[0] == 0.0 else ALL
    if count % 2 == 0:
        small, large = _absolute(base)
        return max(0.0, _raised(small, count)[0]), _raised(large, count)[1]
    return _raised(low, count)[0], _raised(high, count)[1]


def _raised(value: float, count: int) -> Interval:
    """Return a power of a number, rounded outwards only if inexact."""
    try:
        power = math.pow(value, count)
    except OverflowError:
        power = math.copysign(math.inf, value) if count % 2 else math.inf
    exact = math.isfinite(power) and count <= _EXACT and Fraction(value) ** count == Fraction(power)
    return (power, power) if exact else _out(power, power)
