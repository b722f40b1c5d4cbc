# SPDX-License-Identifier: Apache-2.0
"""Derivatives of roots and inverse functions of saturated arguments: zero in place of 0 * inf.

For asin(Min(1, v)) with v > 1 the chain rule multiplies the infinite slope of the outer function by the zero slope of
the inner one. The product is not a number, but the derivative is zero.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import casadi as ca

from .function import sx_instructions

_STEEP = frozenset({ca.OP_SQRT, ca.OP_ASIN, ca.OP_ACOS})
"""Functions with infinite slope at an end of their domain."""
_STEPS = frozenset({
    ca.OP_LT, ca.OP_LE, ca.OP_EQ, ca.OP_NE, ca.OP_NOT, ca.OP_AND, ca.OP_OR, ca.OP_SIGN, ca.OP_FLOOR, ca.OP_CEIL,
})  # fmt: skip
"""Functions that are constant between jumps."""


@dataclass(frozen=True)
class Plateaus:
    """Results of a function in which symbols replace steep functions of locally constant arguments.

    Attributes
    ----------
    values : list of SX
        Results to differentiate.
    """

    values: list[ca.SX]
    _symbols: list[ca.SX]
    _constants: list[ca.SX]

    def filled(self, derivatives: list[ca.SX]) -> list[ca.SX]:
        """Replace the symbols in derivatives by their functions."""
        if not self._symbols:
            return derivatives
        constants, symbols = ca.vertcat(*self._constants), ca.vertcat(*self._symbols)
        filled: list[ca.SX] = ca.substitute(derivatives, [symbols], [constants])
        return filled


def plateaus(function: ca.Function, arguments: list[ca.SX], varying: Collection[int]) -> Plateaus:
    """Evaluate a function so that its derivatives are zero in saturation.

    Parameters
    ----------
    function : casadi.Function
        An SX function.
    arguments : list of SX
        Arguments of the evaluation.
    varying : collection of int
        Positions of the arguments of differentiation.
    """
    if not _saturable(function, varying):
        return Plateaus(function.call(arguments), [], [])
    walk = _Walk()
    values = [ca.SX(function.sparsity_out(k)) for k in range(function.n_out())]
    for k, (op, of, to) in enumerate(sx_instructions(function)):
        if op == ca.OP_OUTPUT:
            values[to[0]].nz[to[1]] = walk.value[of[0]]
        elif op == ca.OP_CONST:
            walk.put(to[0], ca.SX(function.instruction_constant(k)), ca.SX(1))
        elif op == ca.OP_INPUT:
            walk.put(to[0], arguments[of[0]].nz[of[1]], ca.SX(of[0] not in varying))
        else:
            walk.apply(op, to[0], of)
    if not walk.symbols:
        return Plateaus(function.call(arguments), [], [])
    return Plateaus(values, walk.symbols, walk.constants)


def _saturable(function: ca.Function, varying: Collection[int]) -> bool:
    """Return True if a steep function has an argument that may be constant in places, judged without graphs."""
    always: dict[int, bool | None] = {}  # None: in places
    for op, of, to in sx_instructions(function):
        if op == ca.OP_OUTPUT:
            continue
        if op == ca.OP_CONST or op in _STEPS:
            constant: bool | None = True
        elif op == ca.OP_INPUT:
            constant = of[0] not in varying
        else:
            operands = [always[a] for a in of]
            if op in _STEEP and operands[0] is None:
                return True
            if op == ca.OP_IF_ELSE_ZERO:
                constant = operands[1] or None
            elif op in (ca.OP_FMIN, ca.OP_FMAX):
                constant = all(operands) or (None if any(o is not False for o in operands) else False)
            else:
                constant = False if False in operands else None if None in operands else True
        always[to[0]] = constant
    return False


class _Walk:
    """Value of each register of a function, and the condition under which it is locally constant."""

    def __init__(self) -> None:
        self.value: dict[int, ca.SX] = {}
        self.symbols: list[ca.SX] = []
        self.constants: list[ca.SX] = []
        self._plain: dict[int, ca.SX] = {}
        self._constant: dict[int, ca.SX] = {}

    def put(self, to: int, value: ca.SX, constant: ca.SX, plain: ca.SX | None = None) -> None:
        self.value[to], self._constant[to] = value, constant
        self._plain[to] = value if plain is None else plain

    def apply(self, op: int, to: int, of: list[int]) -> None:
        value, plain = (_applied(op, [values[k] for k in of]) for values in (self.value, self._plain))
        constant = _constant(op, [self._plain[k] for k in of], [self._constant[k] for k in of])
        if op in _STEEP and not constant.is_constant():
            symbol = ca.SX.sym(f"plateau{len(self.symbols)}")
            self.symbols.append(symbol)
            self.constants.append(plain)
            value = ca.if_else(constant, symbol, value)
        self.put(to, value, constant, plain)


def _applied(op: int, values: list[ca.SX]) -> ca.SX:
    return ca.SX.unary(op, *values) if len(values) == 1 else ca.SX.binary(op, *values)


def _constant(op: int, values: list[ca.SX], constant: list[ca.SX]) -> ca.SX:
    """Return the condition under which an operation's result is locally constant."""
    if op in _STEPS:
        return ca.SX(1)
    if op in (ca.OP_FMIN, ca.OP_FMAX):
        first = ca.lt(*values) if op == ca.OP_FMIN else ca.gt(*values)
        other = ca.gt(*values) if op == ca.OP_FMIN else ca.lt(*values)
        return _or(_or(_and(first, constant[0]), _and(other, constant[1])), _and(*constant))
    if op == ca.OP_IF_ELSE_ZERO:
        return _or(ca.logic_not(values[0]), constant[1])
    result = constant[0]
    for other in constant[1:]:
        result = _and(result, other)
    return result


def _and(a: ca.SX, b: ca.SX) -> ca.SX:
    if a.is_constant():
        return b if a.is_one() else a
    if b.is_constant():
        return a if b.is_one() else b
    return ca.logic_and(a, b)


def _or(a: ca.SX, b: ca.SX) -> ca.SX:
    if a.is_constant():
        return a if a.is_one() else b
    if b.is_constant():
        return b if b.is_one() else a
    return ca.logic_or(a, b)
