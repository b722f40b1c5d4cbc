# SPDX-License-Identifier: Apache-2.0
"""Values of SymPy expressions and matrices with 50 digits, symbols followed to their meanings as they are met."""

from __future__ import annotations

import functools
import operator
from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

import mpmath
import sympy as sp

from mehvar.errors import MehvarError
from mehvar.models.paper import Cross, Side

DIGITS = 50
_GUARD = 10

Value: TypeAlias = Any
"""mpmath.mpf, or mpmath.matrix."""

_FUNCTIONS: dict[type, Callable[..., Value]] = {
    sp.sin: mpmath.sin,
    sp.cos: mpmath.cos,
    sp.tan: mpmath.tan,
    sp.sec: mpmath.sec,
    sp.asin: mpmath.asin,
    sp.acos: mpmath.acos,
    sp.atan: mpmath.atan,
    sp.atan2: mpmath.atan2,
    sp.exp: mpmath.exp,
    sp.log: mpmath.log,
    sp.sign: mpmath.sign,
    sp.Abs: abs,
    sp.Max: max,
    sp.Min: min,
    sp.StrictLessThan: operator.lt,
    sp.LessThan: operator.le,
    sp.StrictGreaterThan: operator.gt,
    sp.GreaterThan: operator.ge,
    sp.Eq: operator.eq,
    sp.Ne: operator.ne,
    sp.And: lambda *args: all(args),
    sp.Or: lambda *args: any(args),
    sp.Not: operator.not_,
    sp.UnevaluatedExpr: lambda value: value,
    sp.Transpose: lambda matrix: matrix.T,
    sp.Trace: lambda matrix: mpmath.fsum(matrix[i, i] for i in range(matrix.rows)),
    sp.Inverse: lambda matrix, _: matrix**-1,
    sp.MatPow: lambda matrix, exponent: matrix ** int(exponent),
    Cross: lambda a, b: _cross(a, b),
}


class UnknownFunctionError(MehvarError, LookupError):
    """An equation has a function whose value cannot be computed to so many digits."""


class Evaluation:
    """All values at one point.

    Parameters
    ----------
    meanings : mapping
        What derived symbols stand for.
    values : mapping
        Exact values of the free ones.
    """

    def __init__(self, meanings: Mapping[sp.Basic, Side], values: Mapping[sp.Basic, sp.Rational]) -> None:
        self._meanings = meanings
        with mpmath.workdps(DIGITS + _GUARD):
            self._known: dict[sp.Basic, Value] = {s: mpmath.mpf(v.p) / v.q for s, v in values.items()}

    def value(self, expr: Side) -> Value:
        """Return the value of an expression or matrix.

        Raises
        ------
        ArithmeticError, TypeError, ValueError
            If it does not exist.
        UnknownFunctionError
            If the expression has a function that is not known here.
        """
        with mpmath.workdps(DIGITS + _GUARD):
            return self._value(expr)

    def _value(self, expr: Any) -> Value:
        found = self._known.get(expr)
        if found is None:
            found = self._known[expr] = self._work_out(expr)
        return found

    def _work_out(self, expr: Any) -> Value:
        if expr in self._meanings:
            return self._value(self._meanings[expr])
        if isinstance(expr, sp.Rational):
            return mpmath.mpf(expr.p) / expr.q
        if isinstance(expr, sp.Add | sp.MatAdd):
            return functools.reduce(operator.add, map(self._value, expr.args))
        if isinstance(expr, sp.Mul | sp.MatMul):
            return functools.reduce(operator.mul, map(self._value, expr.args))
        if isinstance(expr, sp.Pow):
            return _power(self._value(expr.base), expr.exp, self._value)
        if isinstance(expr, sp.MatrixBase):
            return mpmath.matrix([[self._value(entry) for entry in row] for row in expr.tolist()])
        return self._special(expr)

    def _special(self, expr: Any) -> Value:
        if isinstance(expr, sp.Piecewise):
            return next(self._value(value) for value, condition in expr.args if self._value(condition))
        if isinstance(expr, sp.Identity | sp.ZeroMatrix):
            return self._value(expr.as_explicit())
        if isinstance(expr, sp.matrices.expressions.matexpr.MatrixElement):
            return self._value(expr.parent)[int(expr.i), int(expr.j)]
        if expr in (sp.true, sp.false):
            return bool(expr)
        if type(expr) in _FUNCTIONS:
            return _FUNCTIONS[type(expr)](*map(self._value, expr.args))
        if expr.is_number:
            return mpmath.mpf(sp.N(expr, DIGITS + _GUARD))
        known = ", ".join(sorted(function.__name__ for function in _FUNCTIONS))
        raise UnknownFunctionError(f"no 50-digit value for {type(expr).__name__} in {expr}; functions known: {known}")


def _power(base: Value, exponent: sp.Expr, value: Callable[[sp.Expr], Value]) -> Value:
    if exponent == sp.Rational(1, 2):
        return mpmath.sqrt(base)
    return base ** int(exponent) if exponent.is_Integer else base ** value(exponent)


def _cross(a: Value, b: Value) -> Value:
    if a.rows == 2:
        return mpmath.matrix([[a[0] * b[1] - a[1] * b[0]]])
    turns = ((1, 2), (2, 0), (0, 1))
    return mpmath.matrix([[a[i] * b[j] - a[j] * b[i]] for i, j in turns])
