# SPDX-License-Identifier: Apache-2.0
"""Evaluation with real numbers of 50 digits, at suitable points, with the branches that occur."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from fractions import Fraction
from math import prod
from typing import Any

import mpmath

from .field import Undefined
from .pool import Pool, fraction
from .sampler import Point
from .values import Lookup, World

DIGITS = 50
"""Number of guaranteed digits. Computation uses 90 digits, which leaves 40 for cancellation; see `apart`. More digits
slow every operation; fewer hide differences in rounding.
"""
_WORKING = 90
_ROUNDING = mpmath.mpf(10) ** -(_WORKING - 5)
"""Relative rounding error of one operation, with five digits reserved for mpmath's functions."""
_CONTEXT = mpmath.mp.clone()
_CONTEXT.dps = _WORKING
_LARGEST = 1300
"""Binary exponent above which a value counts as undefined, far above that of doubles, 1024."""

_FUNCTIONS: dict[str, Callable[..., Any]] = {
    "sin": _CONTEXT.sin, "cos": _CONTEXT.cos, "tan": _CONTEXT.tan, "exp": _CONTEXT.exp, "sinh": _CONTEXT.sinh,
    "cosh": _CONTEXT.cosh, "tanh": _CONTEXT.tanh, "asinh": _CONTEXT.asinh, "atan": _CONTEXT.atan,
    "atan2": _CONTEXT.atan2, "abs": abs, "erf": _CONTEXT.erf, "sec": _CONTEXT.sec,
}  # fmt: skip
_BOUNDED: dict[str, tuple[Callable[..., Any], Callable[[Any], bool]]] = {
    "asin": (_CONTEXT.asin, lambda x: abs(x) <= 1),
    "acos": (_CONTEXT.acos, lambda x: abs(x) <= 1),
    "log": (_CONTEXT.log, lambda x: x > 0),
    "acosh": (_CONTEXT.acosh, lambda x: x >= 1),
    "atanh": (_CONTEXT.atanh, lambda x: abs(x) < 1),
}
_STEPS: dict[str, Callable[..., Any]] = {
    "floor": _CONTEXT.floor, "ceiling": _CONTEXT.ceil, "mod": lambda a, b: a - b * _CONTEXT.floor(a / b),
}  # fmt: skip
_FUNCTIONS |= _STEPS
_TESTS: dict[str, Callable[[Any, Any], bool]] = {
    "strictlessthan": lambda a, b: bool(a < b),
    "lessthan": lambda a, b: bool(a <= b),
    "strictgreaterthan": lambda a, b: bool(a > b),
    "greaterthan": lambda a, b: bool(a >= b),
    "equality": lambda a, b: bool(a == b),
    "unequality": lambda a, b: bool(a != b),
}
OPERATIONS = tuple(
    sorted(
        {*_FUNCTIONS, *_BOUNDED, *_TESTS, "sym", "num", "const", "add", "mul", "pow", "and", "or", "not", "max", "min"}
        | {"sign", "piecewise", "exprcondpair"}
    )
)
"""All operations with a value."""
Sized = tuple[Any, int]
"""A value with the binary exponent of its largest part."""


class RealWorld(World[Any]):
    """Evaluation with real numbers.

    Parameters
    ----------
    point : mapping of str to Fraction
        The free names.
    """

    def __init__(self, pool: Pool, lookup: Lookup, point: Point) -> None:
        super().__init__(pool, lookup)
        self.point = point
        self.ways: dict[int, int] = {}
        """Branch of each branching node."""
        self._size: dict[int, int] = {}

    def size(self, root: int) -> int:
        """Return the binary exponent of an expression's largest part, which bounds its rounding error."""
        self.value(root)
        return self._size[root]

    def compute(self, node: int) -> Any:
        """Return the value of a node."""
        value, size = self._computed(node)
        if isinstance(value, _CONTEXT.mpf):
            _, mantissa, exponent, bits = value._mpf_
            if not mantissa and exponent:
                raise Undefined("not finite")
            size = max(size, exponent + bits)
            if size > _LARGEST:
                raise Undefined("too large")
        self._size[node] = size
        return value

    def _computed(self, node: int) -> tuple[Any, int]:
        """Return a node's value and the binary exponent of its largest part, from those of its operands."""
        operation, *operands = self.pool.nodes[node]
        if operation == "sym":
            target = self.lookup(operands[0])
            if target is None:
                return real(self.point[operands[0]]), 0
            return target[0].value(target[1]), target[0].size(target[1])  # type: ignore[attr-defined]
        if operation == "num":
            return _number(operands[0], _CONTEXT.dps), 0
        if operation == "const":
            return {"pi": +_CONTEXT.pi, "E": +_CONTEXT.e, "True": True, "False": False}[operands[0]], 0
        if operation == "piecewise":
            return self._piecewise(node, operands)
        values = [self.memo[o] for o in operands]
        size = max((self._size.get(o, 0) for o in operands), default=0)
        if operation == "exprcondpair":
            return tuple(values), self._size.get(operands[0], 0)
        if any(value is None for value in values):
            raise Undefined
        if self._is_on_a_step(operation, operands, values, size):
            values = self._on_a_step(operation, values)
        return self._strict(node, operation, values), size

    def _is_on_a_step(self, operation: str, operands: Sequence[int], values: Sequence[Any], size: int) -> bool:
        """Return True if a value lies within rounding of a jump, so that its side is unknown.

        Names and numbers are exact. Two computed values may be equal only because of rounding.
        """
        if operation in _TESTS:
            gap = values[0] - values[1]
        elif operation == "sign":
            gap = values[0]
        elif operation in _STEPS and all(values[1:]):
            whole = values[0] / values[1] if len(values) == 2 else values[0]
            gap = whole - _CONTEXT.nint(whole)
        else:
            return False
        exact = all(self.pool.nodes[k][0] in ("sym", "num") for k in operands)
        return vanishes(gap, size) and not exact and bool(gap or operation not in ("equality", "unequality", "sign"))

    def _on_a_step(self, _operation: str, _values: list[Any]) -> list[Any]:
        """Return the operands that are within rounding of a jump."""
        raise Undefined("within rounding of a step")

    def _strict(self, node: int, operation: str, values: list[Any]) -> Any:
        """Return the value of an operation, whose branch it records; it is undefined outside the real domain."""
        if operation == "add":
            return _CONTEXT.fsum(values)
        if operation == "mul":
            return prod(values)
        if operation == "pow":
            return self._power(values[0], values[1], self.pool.constant(self.pool.nodes[node][2]))
        if operation in _TESTS:
            return _TESTS[operation](*values)
        if operation in ("and", "or", "not"):
            return {"and": all(values), "or": any(values), "not": not values[0]}[operation]
        if operation in ("max", "min"):
            best = (max if operation == "max" else min)(values)
            self.ways[node] = values.index(best)
            return best
        if operation in ("abs", "sign"):
            self.ways[node] = int(values[0] > 0)
            return abs(values[0]) if operation == "abs" else _CONTEXT.sign(values[0])
        if operation in _BOUNDED:
            function, allowed = _BOUNDED[operation]
            if not allowed(values[0]):
                raise Undefined
            return function(values[0])
        if operation not in _FUNCTIONS:
            raise Undefined(operation)
        try:
            return _FUNCTIONS[operation](*values)
        except (ArithmeticError, ValueError) as error:
            raise Undefined from error

    def _power(self, base: Any, exponent: Any, exact: Fraction | None) -> Any:
        """Return a real power; whole and half exponents are exact, and negative bases have no others."""
        if base == 0 and exponent < 0:
            raise Undefined
        if exact is not None and exact.denominator == 1:
            return base ** int(exact)
        if exact is not None and exact.denominator == 2 and base >= 0:
            return _CONTEXT.sqrt(base) ** exact.numerator
        if base < 0 or base == exponent == 0:
            raise Undefined
        return base**exponent

    def _piecewise(self, node: int, operands: Sequence[int]) -> tuple[Any, int]:
        """Return value and size of the first case that applies; undefined if an earlier condition is."""
        for number, operand in enumerate(operands):
            pair = self.memo[operand]
            if pair is None or pair[1] is None:
                raise Undefined
            if pair[1]:
                self.ways[node] = number
                if pair[0] is None:
                    raise Undefined
                return pair[0], self._size.get(operand, 0)
        raise Undefined


class SteppedWorld(RealWorld):
    """Evaluation at a point on a step; values within rounding of the step count as on it."""

    def _on_a_step(self, operation: str, values: list[Any]) -> list[Any]:
        if operation in _TESTS:
            return [values[0], values[0]]
        divisor = values[1] if len(values) == 2 else 1
        return [_CONTEXT.nint(values[0] / divisor) * divisor, *values[1:]]


@functools.cache
def _number(text: str, digits: int) -> Any:  # noqa: ARG001, the same number with other digits is another value
    return real(fraction(text))


def real(value: Fraction) -> Any:
    """Return a fraction as a real number."""
    return _CONTEXT.mpf(value.numerator) / value.denominator


def floor(value: Any) -> int:
    """Return the largest integer below a value with all of its digits."""
    return int(_CONTEXT.floor(value))


def digits_doubled() -> Any:
    """Return a context in which evaluations have twice the digits."""
    return _CONTEXT.workdps(2 * _WORKING)


def apart(left: Sized, right: Sized, within: Fraction = Fraction(0)) -> bool:
    """Return True if two values, each with its size, differ by more than rounding and tolerance.

    Twice the size is used, because a second large part may have multiplied the error of the first, in up to 2^30
    operations. The difference itself may be known to 65 digits only.
    """
    (a, size), (b, other) = left, right
    if isinstance(a, bool | tuple) or isinstance(b, bool | tuple):
        return bool(a != b)
    limit = _CONTEXT.ldexp(_ROUNDING, 2 * max(size, other, 0) + 30)
    return bool(abs(a - b) > limit + abs(a) * _ROUNDING * 10**20 + (real(within) if within else 0))


def vanishes(value: Any, size: int) -> bool:
    """Return True if a value, given its size, is only rounding error."""
    return bool(abs(value) < _CONTEXT.ldexp(_CONTEXT.mpf(10) ** -DIGITS, size))


def holds(relation: str, left: Sized, right: Sized, within: Fraction = Fraction(0)) -> bool:
    """Return True if "=", "<", "<=", ">" or ">=" holds between two values with sizes."""
    if relation == "=":
        return not apart(left, right, within)
    less, greater = (left, right) if relation.startswith("<") else (right, left)
    return bool(less[0] < greater[0]) or (relation.endswith("=") and not apart(left, right))
