# SPDX-License-Identifier: Apache-2.0
"""Converter of SymPy expressions to CasADi graphs, usable in any project."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterable, Mapping

import casadi as ca
import sympy as sp
from sympy.core.relational import Relational
from sympy.functions.elementary.piecewise import ExprCondPair

from mehvar.base.errors import MehvarError, value_text


class LoweringError(MehvarError, ValueError):
    """A SymPy expression without CasADi counterpart, or a symbol without value."""


_EXPRESSION = (sp.Basic, int, float)
_UNARY: dict[type[sp.Basic], int] = {
    sp.sin: ca.OP_SIN, sp.cos: ca.OP_COS, sp.tan: ca.OP_TAN, sp.asin: ca.OP_ASIN, sp.acos: ca.OP_ACOS,
    sp.atan: ca.OP_ATAN, sp.sinh: ca.OP_SINH, sp.cosh: ca.OP_COSH, sp.tanh: ca.OP_TANH, sp.asinh: ca.OP_ASINH,
    sp.acosh: ca.OP_ACOSH, sp.atanh: ca.OP_ATANH, sp.exp: ca.OP_EXP, sp.log: ca.OP_LOG, sp.Abs: ca.OP_FABS,
    sp.sign: ca.OP_SIGN, sp.floor: ca.OP_FLOOR, sp.ceiling: ca.OP_CEIL, sp.erf: ca.OP_ERF, sp.Not: ca.OP_NOT,
}  # fmt: skip
_FOLDED: dict[type[sp.Basic], int] = {
    sp.Add: ca.OP_ADD, sp.Mul: ca.OP_MUL, sp.Min: ca.OP_FMIN, sp.Max: ca.OP_FMAX, sp.And: ca.OP_AND, sp.Or: ca.OP_OR,
}  # fmt: skip
_BINARY: dict[type[sp.Basic], int] = {
    sp.atan2: ca.OP_ATAN2, sp.StrictLessThan: ca.OP_LT, sp.LessThan: ca.OP_LE, sp.Equality: ca.OP_EQ,
    sp.Unequality: ca.OP_NE,
}  # fmt: skip
_SWAPPED: dict[type[sp.Basic], int] = {sp.StrictGreaterThan: ca.OP_LT, sp.GreaterThan: ca.OP_LE}
"""CasADi's numbers of operations: a call by number takes a seventh of the time of a call by name."""
_OTHERS = (sp.Pow, sp.Mod, sp.Piecewise, ExprCondPair, sp.ITE, sp.Xor)
"""Operations with their own conversion."""


def to_casadi(
    expressions: Iterable[sp.Basic],
    symbols: Mapping[sp.Symbol, ca.SX],
    definitions: Mapping[sp.Symbol, sp.Basic] | None = None,
) -> list[ca.SX]:
    """Convert SymPy expressions to CasADi SX scalars with shared subexpressions.

    Parameters
    ----------
    expressions : iterable of sympy expressions
        Scalars; sums, products, powers, elementary functions, Min, Max, sign, Piecewise and relations are understood.
    symbols : mapping
        The SX scalar of each free symbol.
    definitions : mapping, optional
        Symbols that stand for further expressions, in any order; they are converted when first met.

    Returns
    -------
    list of casadi.SX
        One scalar per expression.

    Raises
    ------
    LoweringError
        If a function has no counterpart or a symbol has neither a value nor a definition.

    Examples
    --------
    >>> import casadi, sympy
    >>> x = sympy.Symbol("x")
    >>> to_casadi([sympy.sin(x) ** 2], {x: casadi.SX.sym("x")})
    [SX(sq(sin(x)))]
    """
    meanings = {} if definitions is None else definitions
    _check_table("symbols", symbols, ca.SX)
    _check_table("definitions", meanings, _EXPRESSION)
    if not isinstance(expressions, Iterable | sp.MatrixBase):  # a matrix has items, but no iterator
        raise LoweringError(f"expressions = {value_text(expressions)}: must be SymPy expressions, as in a list")
    converter = Converter(symbols, meanings)
    return [converter(_expression(value)) for value in expressions]


def _check_table(name: str, table: object, kind: type | tuple[type, ...]) -> None:
    """Refuse anything but a mapping from symbols to values of a type."""
    if not isinstance(table, Mapping):
        raise LoweringError(f"{name} = {value_text(table)}: must be a mapping of SymPy symbols")
    for symbol, value in table.items():
        if not isinstance(symbol, sp.Symbol) or not isinstance(value, kind):
            allowed = "a casadi.SX" if kind is ca.SX else "an expression"
            raise LoweringError(
                f"{name}[{value_text(symbol)}] = {value_text(value)}: must be {allowed} for a SymPy symbol"
            )


def _expression(value: object) -> sp.Basic:
    if not isinstance(value, _EXPRESSION):
        raise LoweringError(f"expressions hold {value_text(value)}: must be SymPy expressions or numbers")
    return sp.sympify(value)


def missing_counterpart(node: sp.Basic) -> str:
    """Return the reason why a node itself has no counterpart in CasADi, or an empty text."""
    if isinstance(node, sp.Piecewise) and node.args[-1].cond is not sp.true:
        return f"Piecewise without a last branch for all other cases: {node}"
    known = isinstance(node, _OTHERS) or type(node) in (*_UNARY, *_BINARY, *_SWAPPED, *_FOLDED)
    if known or not node.args or (isinstance(node, sp.Expr) and node.is_number):
        return ""
    what = "relation" if isinstance(node, Relational) else "function"
    return f"{what} {type(node).__name__!r} has no CasADi counterpart (in {node})"


class Converter:
    """Memoised conversion with an explicit stack, so that deep expressions do not exceed Python's recursion limit.

    Attributes
    ----------
    memo : dict
        The SX scalar of each converted expression, symbols among them.
    """

    def __init__(self, symbols: Mapping[sp.Symbol, ca.SX], definitions: Mapping[sp.Symbol, sp.Basic]) -> None:
        self.memo: dict[sp.Basic, ca.SX] = dict(symbols)
        self._definitions = definitions
        self._numbers: set[sp.Basic] = set()

    def __call__(self, root: sp.Basic) -> ca.SX:
        """Return the SX scalar of an expression.

        Raises
        ------
        LoweringError
            If a function has no counterpart or a symbol has neither a value nor a definition.
        """
        stack, entered = [root], set()
        while stack:
            node = stack[-1]
            if node in self.memo:
                stack.pop()
                continue
            waiting = [child for child in self._children(node) if child not in self.memo]
            if not waiting:
                self.memo[node] = self._convert(node)
                stack.pop()
            elif node in entered:
                raise LoweringError(f"{node} is defined by itself")
            else:
                entered.add(node)
                stack.extend(reversed(waiting))
        return self.memo[root]

    def _children(self, node: sp.Basic) -> tuple[sp.Basic, ...]:
        """Return the expressions to convert before a node; a symbol has its definition as child."""
        if isinstance(node, sp.Symbol):
            if node not in self._definitions:
                raise LoweringError(f"symbol {node.name!r} has neither a value nor a definition")
            return (sp.sympify(self._definitions[node]),)
        if isinstance(node, sp.Piecewise):
            return tuple(part for pair in node.args for part in pair.args)
        if isinstance(node, sp.ITE | sp.Xor):
            return (node.to_nnf(simplify=False),)
        return tuple(node.args)

    def _convert(self, node: sp.Basic) -> ca.SX:
        """Return the SX of a node from those of its children."""
        if isinstance(node, sp.Symbol | sp.ITE | sp.Xor):
            value = self.memo[self._children(node)[0]]
            if value.is_constant() and not math.isfinite(float(value)):
                raise LoweringError(f"definition {node} is always {value}, since it divides by zero")
            return value
        if node in (sp.true, sp.false):
            return ca.SX(1 if node is sp.true else 0)
        if isinstance(node, sp.Expr) and self._numbers.issuperset(node.args):
            # a number is evaluated as a whole, so that it is rounded once: 25 digits are right, a double holds 17
            self._numbers.add(node)
            return ca.SX(float(sp.N(node, 25)))
        if isinstance(node, sp.Pow):
            return self._power(node)
        if isinstance(node, sp.Piecewise):
            return self._piecewise(node)
        arguments = [self.memo[child] for child in node.args]
        if isinstance(node, sp.Mod):
            return _modulo(*arguments)
        kind = type(node)
        if kind in _UNARY:
            return ca.SX.unary(_UNARY[kind], *arguments)
        if kind in _BINARY:
            return ca.SX.binary(_BINARY[kind], *arguments)
        if kind in _SWAPPED:
            return ca.SX.binary(_SWAPPED[kind], *reversed(arguments))
        if kind in _FOLDED:
            return functools.reduce(functools.partial(ca.SX.binary, _FOLDED[kind]), arguments)
        raise LoweringError(missing_counterpart(node))

    def _power(self, node: sp.Pow) -> ca.SX:
        """Return a power: small whole and half exponents as products, which round less than pow."""
        base, exponent = self.memo[node.base], node.exp
        if not exponent.is_Rational:
            return ca.power(base, self.memo[exponent])
        # up to eleven multiplications, for 63; beyond any model's polynomials pow rounds less often
        if exponent.is_Integer and abs(int(exponent)) <= 64:
            return _integer_power(base, int(exponent))
        if exponent.q == 2 and abs(exponent.p) <= 9:
            return _integer_power(ca.sqrt(base), int(exponent.p))
        return ca.power(base, float(exponent))

    def _piecewise(self, node: sp.Piecewise) -> ca.SX:
        if problem := missing_counterpart(node):
            raise LoweringError(problem)
        result = self.memo[node.args[-1].expr]
        for pair in reversed(node.args[:-1]):
            result = ca.if_else(self.memo[pair.cond], self.memo[pair.expr], result)
        return result


def _modulo(dividend: ca.SX, divisor: ca.SX) -> ca.SX:
    """Return the remainder with the divisor's sign, like SymPy's Mod and unlike fmod."""
    rest = ca.fmod(dividend, divisor)
    return ca.if_else(rest * divisor < 0, rest + divisor, rest)


def _integer_power(base: ca.SX, exponent: int) -> ca.SX:
    """Return an integer power by repeated squaring, with a division for negative exponents."""
    result, square, power = None, base, abs(exponent)
    while power:
        if power & 1:
            result = square if result is None else ca.SX.binary(ca.OP_MUL, result, square)
        square, power = ca.SX.binary(ca.OP_MUL, square, square), power >> 1
    whole = ca.SX(1) if result is None else result
    return ca.SX.binary(ca.OP_DIV, ca.SX(1), whole) if exponent < 0 else whole
