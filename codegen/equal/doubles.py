# SPDX-License-Identifier: Apache-2.0
"""Evaluation at a hundred thousand points in double precision, to find possible differences."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from fractions import Fraction
from functools import reduce
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .pool import Pool, fraction
from .sampler import PointSampler

Array = NDArray[np.float64]
TURNS = 4
"""Number of turns in each direction over which angles are drawn: seven of eight points show a missing wrap."""
_DECADES = (0.5, 3.0, 6.0)
"""Decades around one from which numbers are drawn if they lack a default and two bounds. The first decade reaches a
table that starts at Mach 1, the second a table that ends at 300.
"""
_CHUNK = 2048
"""Number of points per pass, so that values of a few thousand nodes stay in the processor's cache."""
_APART = 1e-9
"""Relative difference of doubles above which 50 digits decide. A tenth would check more rounding, ten times would
miss smaller differences.
"""

_FUNCTIONS: dict[str, Callable[..., Any]] = {
    "sin": np.sin, "cos": np.cos, "tan": np.tan, "exp": np.exp, "sinh": np.sinh, "cosh": np.cosh, "tanh": np.tanh,
    "asin": np.arcsin, "acos": np.arccos, "atan": np.arctan, "atan2": np.arctan2, "log": np.log, "abs": np.abs,
    "asinh": np.arcsinh, "acosh": np.arccosh, "atanh": np.arctanh, "floor": np.floor, "ceiling": np.ceil,
    "sign": np.sign, "mod": np.mod, "sec": lambda a: 1 / np.cos(a),
    "strictlessthan": np.less, "lessthan": np.less_equal, "strictgreaterthan": np.greater,
    "greaterthan": np.greater_equal, "equality": np.equal, "unequality": np.not_equal,
    "not": np.logical_not,
}  # fmt: skip
_MANY: dict[str, Any] = {
    "add": np.add, "mul": np.multiply, "max": np.maximum, "min": np.minimum,
    "and": np.logical_and, "or": np.logical_or,
}  # fmt: skip


def values(pool: Pool, nodes: Sequence[int], point: Mapping[str, Array]) -> dict[int, Any]:
    """Return the values of nodes, sorted with operands first; NaN for nodes without a value."""
    found: dict[int, Any] = {}
    with np.errstate(all="ignore"):
        for node in nodes:
            found[node] = _value(pool, node, found, point)
    return found


def _value(pool: Pool, node: int, found: Mapping[int, Any], point: Mapping[str, Array]) -> Any:
    """Return a node's values at all points from those of its operands; NaN if it has none."""
    operation, *rest = pool.nodes[node]
    if operation == "sym":
        return point[rest[0]]
    if operation == "num":
        return _double(rest[0])
    if operation == "const":
        return {"pi": np.pi, "E": np.e, "True": True, "False": False}.get(rest[0], np.nan)
    operands = [found[o] for o in pool.operands(node)]
    if operation == "exprcondpair":
        return operands
    if operation == "piecewise":
        return _piecewise(operands)
    if operation == "pow":
        return _power(operands[0], operands[1], pool.constant(rest[1]))
    if operation in _MANY:
        return reduce(_MANY[operation], operands)
    return _FUNCTIONS[operation](*operands) if operation in _FUNCTIONS else np.nan


def _double(text: str) -> float:
    try:
        return float(fraction(text))
    except OverflowError:
        return np.inf if fraction(text) > 0 else -np.inf


def _power(base: Any, exponent: Any, exact: Fraction | None) -> Any:
    if exact is None:
        return np.power(base, exponent)
    if exact == 2:
        return base * base
    if exact.denominator == 2:
        return np.power(np.sqrt(base), float(exact.numerator))
    return np.power(base, float(exact))


def _piecewise(pairs: Sequence[Any]) -> Any:
    result: Any = np.nan
    for value, condition in reversed(pairs):
        result = np.where(condition, value, result)
    return result


def draw(names: Iterable[str], sampler: PointSampler, count: int, seed: int) -> dict[str, Array]:
    """Draw values of names within bounds: angles over several turns, others over decades or around defaults."""
    generator = np.random.default_rng(seed)
    return {name: _drawn(generator, sampler, name, count) for name in sorted(names)}


def _drawn(generator: np.random.Generator, sampler: PointSampler, name: str, count: int) -> Array:
    """Draw values of a name: evenly between two bounds, else over decades, turns and around the default."""
    low, high, default = sampler.names.get(name, (None, None, None))
    bounds = (-np.inf if low is None else float(low), np.inf if high is None else float(high))
    if low is not None and high is not None:
        return generator.uniform(*bounds, count)
    decades = generator.choice(_DECADES, count)
    size = 10.0 ** generator.uniform(-decades, decades)
    drawn = size * generator.choice((-1.0, 1.0), count)
    if name in sampler.angles:
        drawn = np.where(generator.random(count) < 0.75, generator.uniform(-1, 1, count) * TURNS * 2 * np.pi, drawn)
    if default:
        drawn = np.where(generator.random(count) < 0.5, float(default) * generator.uniform(0.5, 2, count), drawn)
    return _inside(drawn, *bounds)


def _inside(drawn: Array, low: float, high: float) -> Array:
    drawn = np.where(drawn < low, low + (low - drawn), drawn)
    return np.where(drawn > high, high - (drawn - high), drawn)


def apart(a: Any, b: Any) -> tuple[Array, int]:
    """Return the relative differences of values, with zero for rounding, and the number of pairs with values."""
    with np.errstate(all="ignore"):
        gap = np.abs(np.atleast_1d(a) - b)
        size = np.abs(a) + np.abs(b)
        # a comparison with NaN is false
        return np.where(gap > _APART * size, gap / size, 0.0), int(np.count_nonzero(gap >= 0))


def suspects(
    pool: Pool, pairs: Sequence[tuple[int, int]], sampler: PointSampler, count: int, most: int, seed: int
) -> tuple[dict[int, list[dict[str, Fraction]]], list[int]]:
    """Return the points at which the doubles of two expressions differ.

    Parameters
    ----------
    pairs : sequence of (int, int)
        Nodes with free names only.
    count, most : int
        Number of drawn points; limit on returned points per pair, largest differences first.

    Returns
    -------
    points : dict
        By the number of the pair.
    seen : list of int
        Number of points at which both sides of each pair have a value.
    """
    nodes = pool.reached(*(node for pair in pairs for node in pair))
    names = {pool.nodes[node][1] for node in nodes if pool.nodes[node][0] == "sym"}
    worst: list[list[tuple[float, int, int]]] = [[] for _ in pairs]
    seen = [0] * len(pairs)
    for part in range(0, count, _CHUNK):
        found = values(pool, nodes, draw(names, sampler, _CHUNK, seed + part))
        for number, (a, b) in enumerate(pairs):
            sizes, both = apart(found[a], found[b])
            seen[number] += both
            top = np.argsort(sizes)[-most:] if np.any(sizes) else ()
            worst[number] = sorted([*worst[number], *((float(sizes[k]), part, int(k)) for k in top if sizes[k])])[
                -most:
            ]
    return {
        number: [_point(names, sampler, seed + part, k) for _, part, k in rows] for number, rows in enumerate(worst)
    }, seen


def _point(names: Iterable[str], sampler: PointSampler, seed: int, k: int) -> dict[str, Fraction]:
    return {name: Fraction(float(column[k])) for name, column in draw(names, sampler, _CHUNK, seed).items()}
