# SPDX-License-Identifier: Apache-2.0
"""Evaluate SymPy definitions with mpmath, without CasADi: an independent check of every generated function."""

import functools
import sys
from collections.abc import Mapping

import mpmath
import sympy as sp

mpmath.mp.dps = 40
sys.setrecursionlimit(20_000)  # definitions nest a few hundred deep


class HighPrecision:
    """Values of expressions at one point, each symbol given by a number or a definition."""

    def __init__(self, values: Mapping[sp.Symbol, object], definitions: Mapping[sp.Symbol, sp.Basic]) -> None:
        self._memo = {symbol: mpmath.mpf(value) for symbol, value in values.items()}
        self._definitions = definitions

    def __call__(self, expr: sp.Basic) -> object:
        if expr not in self._memo:
            self._memo[expr] = self._evaluate(expr)
        return self._memo[expr]

    def _evaluate(self, expr):
        if isinstance(expr, sp.Symbol):
            return self(sp.sympify(self._definitions[expr]))
        if isinstance(expr, sp.Piecewise):
            return self(next(value for value, condition in expr.args if self(condition)))
        if expr in (sp.true, sp.false):
            return bool(expr)
        if isinstance(expr, sp.Float):
            return mpmath.mpf(str(expr))
        if not expr.args:
            return mpmath.mpf(sp.N(expr, 45)._mpf_) if not expr.is_Rational else mpmath.mpf(expr.p) / expr.q
        return _operation(expr.func, len(expr.args))(*(self(argument) for argument in expr.args))


@functools.cache
def _operation(head, count):
    symbols = [sp.Dummy() for _ in range(count)]
    return sp.lambdify(symbols, head(*symbols, evaluate=False), "mpmath")
