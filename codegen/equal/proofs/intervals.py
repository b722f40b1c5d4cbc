# SPDX-License-Identifier: Apache-2.0
"""Proofs by interval narrowing that signs of several expressions exclude each other.

All intervals are rounded outward, so that an empty interval is a proof. Without an empty interval nothing is proved.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction

from ...equations.document import reached
from ..pool import Pool, fraction

Interval = tuple[float, float]
ALL: Interval = (-math.inf, math.inf)
_ROUNDS = 8
"""Number of rounds of narrowing. Each propagates bounds by one operation, so that it limits a proof's depth."""
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
_UNDONE = {"exp": "log", "log": "exp", "sinh": "asinh", "asinh": "sinh", "atanh": "tanh"}
_CLOSE = 4
"""Number of units in the last place by which results of library functions are rounded outward; good libraries err by
one.
"""
_EXACT = 4
"""Largest exponent whose power is tested for exactness; higher powers are long numbers."""
Bounds = Mapping[str, tuple[Fraction | None, Fraction | None]]


class _EmptyError(Exception):
    """An empty interval."""


def impossible(pool: Pool, atoms: Sequence[tuple[int, int]], bounds: Bounds) -> bool:
    """Return True if nodes provably cannot have these signs together within the bounds of their names.

    Parameters
    ----------
    atoms : sequence of (int, int)
        Nodes and their signs: 1, -1, or 0 for zero.
    bounds : mapping
        Bounds of free names; None for a missing one.
    """
    nodes = reached(pool.nodes, [node for node, _ in atoms])
    box = dict.fromkeys(nodes, ALL)
    try:
        for node, sign in atoms:
            wanted = (0.0, 0.0) if sign == 0 else (0.0, math.inf) if sign > 0 else (-math.inf, 0.0)
            box[node] = _both(box[node], wanted)
        for _ in range(_ROUNDS):
            before = dict(box)
            for node in nodes:
                box[node] = _both(box[node], _forward(pool, node, box, bounds))
            for node, sign in atoms:
                if sign and box[node][0] == box[node][1] == 0.0:
                    return True
            for node in reversed(nodes):
                for operand, interval in _backward(pool, node, box):
                    box[operand] = _both(box[operand], interval)
            if box == before:
                return False
    except _EmptyError:
        return True
    return False


def _both(a: Interval, b: Interval) -> Interval:
    low, high = max(a[0], b[0]), min(a[1], b[1])
    if low > high:
        raise _EmptyError
    return low, high


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


def _forward(pool: Pool, node: int, box: Mapping[int, Interval], bounds: Bounds) -> Interval:
    """Return an interval of all values of a node, given intervals of its operands and bounds of names."""
    operation, *rest = pool.nodes[node]
    operands = [box[o] for o in pool.operands(node)]
    if operation == "num":
        return _exact(fraction(rest[0]))
    if operation == "const":
        return CONSTANTS.get(rest[0], ALL)
    if operation == "sym":
        low, high = bounds.get(rest[0], (None, None))
        return (-math.inf if low is None else _exact(low)[0], math.inf if high is None else _exact(high)[1])
    if operation == "add":
        return _sum(operands)
    if operation == "mul":
        return _both(_product(operands), _share(pool, node, box))
    if operation == "pow":
        return _power(operands[0], pool.constant(pool.operands(node)[1]))
    if operation in ("max", "min"):
        best = max if operation == "max" else min
        return best(low for low, _ in operands), best(high for _, high in operands)
    if operation == "abs":
        return _absolute(operands[0])
    if operation in ("floor", "ceiling"):
        return _whole(_both(_rounded(operation, operands[0]), box[node]))
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
        pieces = [box[pool.operands(pair)[0]] for pair in pool.operands(node)]
        return min(low for low, _ in pieces), max(high for _, high in pieces)
    return ALL


def _share(pool: Pool, node: int, box: Mapping[int, Interval]) -> Interval:
    """Return bounds on the ratio of a part of a sum to the sum, such as the component of a unit vector."""
    factors = pool.operands(node)
    for part, other in (factors, factors[::-1]) if len(factors) == 2 else ():
        base, exponent = _root_of(pool, other)
        terms = pool.operands(base) if pool.nodes[base][0] == "add" else ()
        term = {Fraction(-1): part, Fraction(-1, 2): pool.intern("pow", part, pool.number(2))}.get(exponent)
        if term in terms and all(box[k][0] >= 0 for k in terms):
            return (0.0 if term == part else -1.0), 1.0
    return ALL


def _root_of(pool: Pool, node: int) -> tuple[int, Fraction]:
    """Return the base and the exponent of a node."""
    power = Fraction(1)
    while pool.nodes[node][0] == "pow" and (exponent := pool.constant(pool.operands(node)[1])) is not None:
        node, power = pool.operands(node)[0], power * exponent
    return node, power


def _backward(pool: Pool, node: int, box: Mapping[int, Interval]) -> list[tuple[int, Interval]]:
    """Return the intervals of operands that follow from a node's interval."""
    operation = pool.nodes[node][0]
    operands = pool.operands(node)
    low, high = box[node]
    if operation == "add":
        rests = (_sum([box[o] for k, o in enumerate(operands) if k != n]) for n in range(len(operands)))
        return [(o, _sum([(low, high), (-b, -a)])) for o, (a, b) in zip(operands, rests, strict=True)]
    if operation == "mul":
        rests = (_product([box[o] for k, o in enumerate(operands) if k != n]) for n in range(len(operands)))
        return [
            (o, _product([(low, high), _inverse(rest)]))
            for o, rest in zip(operands, rests, strict=True)
            if rest[0] > 0 or rest[1] < 0
        ]
    if operation == "max":
        return [(o, (-math.inf, high)) for o in operands]
    if operation == "min":
        return [(o, (low, math.inf)) for o in operands]
    if operation == "abs":
        return [(operands[0], (-high, high))]
    if operation in _UNDONE:
        return [(operands[0], _risen(_UNDONE[operation], (low, high)))]
    if operation == "floor":
        return [(operands[0], (low, high + 1))]
    if operation == "ceiling":
        return [(operands[0], (low - 1, high))]
    if operation == "pow":
        return _root(operands[0], pool.constant(operands[1]), low, high)
    return []


def _root(base: int, exponent: Fraction | None, low: float, high: float) -> list[tuple[int, Interval]]:
    """Return the interval of a power's base if that of the power is known; empty if it narrows nothing."""
    if exponent is None or exponent <= 0 or (high == math.inf and low <= 0):
        return []
    if exponent == Fraction(1, 2):
        return [(base, (_raised(max(low, 0.0), 2)[0], _raised(high, 2)[1]))]
    if exponent.denominator == 2:
        return [(base, (0.0, math.inf))]
    if exponent.denominator == 1 and exponent % 2 == 0 and high >= 0:
        size = _out(0.0, high ** (1 / float(exponent)) * (1 + 1e-15))[1]
        return [(base, (-size, size))]
    return []


def _sum(parts: Sequence[Interval]) -> Interval:
    if any(math.isinf(v) for part in parts for v in part):
        low = -math.inf if any(a == -math.inf for a, _ in parts) else math.fsum(a for a, _ in parts)
        high = math.inf if any(b == math.inf for _, b in parts) else math.fsum(b for _, b in parts)
        return _out(low, high)
    return _total([a for a, _ in parts])[0], _total([b for _, b in parts])[1]


def _total(values: Sequence[float]) -> Interval:
    """Return a sum, rounded outward only if inexact, so that 1 - 1 is exactly zero."""
    total = math.fsum(values)
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


def _whole(a: Interval) -> Interval:
    """Return the whole numbers in an interval."""
    low, high = (float(f(v)) if math.isfinite(v) else v for f, v in zip((math.ceil, math.floor), a, strict=True))
    if low > high:
        raise _EmptyError
    return low, high


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
