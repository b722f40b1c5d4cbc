# SPDX-License-Identifier: Apache-2.0
"""Derivatives of smooth expressions; those of logarithms and inverse functions are algebraic, as the field needs."""

from __future__ import annotations

from fractions import Fraction

from ..pool import Pool

_MOST = 400
"""Largest number of nodes of a differentiated expression; larger ones take seconds."""

_RENAMED = {"exp": (1, "exp"), "sinh": (1, "cosh"), "cosh": (1, "sinh"), "sin": (1, "cos"), "cos": (-1, "sin")}
"""Functions whose derivative is a number times a function of the same operand."""
_ALGEBRAIC = {
    "tan": (1, 1, 1, Fraction(1)), "tanh": (1, 1, -1, Fraction(1)),
    "atan": (1, 1, 1, Fraction(-1)), "atanh": (1, 1, -1, Fraction(-1)),
    "asin": (1, 1, -1, Fraction(-1, 2)), "acos": (-1, 1, -1, Fraction(-1, 2)),
    "asinh": (1, 1, 1, Fraction(-1, 2)), "acosh": (1, -1, 1, Fraction(-1, 2)),
}  # fmt: skip
"""Numbers f, a, b, n of the derivative f (a + b z^2)^n; z is the value of `tan` and `tanh`, else the operand."""


def slope(pool: Pool, root: int, name: int) -> int | None:
    """Return the derivative of an expression with respect to a name; None if a part has no implemented derivative."""
    nodes = pool.reached(root)
    if len(nodes) > _MOST:
        return None
    slopes: dict[int, int] = {}
    zero = pool.number(0)
    for node in nodes:
        parts = [slopes[operand] for operand in pool.operands(node)]
        if all(part == zero for part in parts):
            slopes[node] = pool.number(int(node == name))
        elif (partials := _partials(pool, node)) is None:
            return None
        else:
            products = [pool.many("mul", pair) for pair in zip(partials, parts, strict=False)]
            slopes[node] = pool.many("add", products)
    return slopes[root]


def _partials(pool: Pool, node: int) -> list[int] | None:
    """Return the derivatives of an operation with respect to its operands, or None."""
    operation = pool.nodes[node][0]
    operands = pool.operands(node)
    one = pool.number(1)
    if operation == "add":
        return [one for _ in operands]
    if operation == "mul":
        return [pool.many("mul", [one, *operands[:k], *operands[k + 1 :]]) for k in range(len(operands))]
    if operation == "pow":
        power = pool.constant(operands[1])
        return None if power is None else [pool.many("mul", [operands[1], pool.power(operands[0], power - 1)])]
    if operation == "atan2":
        y, x = operands
        inverse = pool.power(pool.many("add", [pool.power(k, Fraction(2)) for k in operands]), Fraction(-1))
        return [pool.many("mul", [x, inverse]), pool.many("mul", [pool.number(-1), y, inverse])]
    if operation in _RENAMED:
        factor, other = _RENAMED[operation]
        return [pool.many("mul", [pool.number(factor), pool.intern(other, operands[0])])]
    if operation == "log":
        return [pool.power(operands[0], Fraction(-1))]
    if operation not in _ALGEBRAIC:
        return None
    factor, start, sign, exponent = _ALGEBRAIC[operation]
    square = pool.power(node if operation in ("tan", "tanh") else operands[0], Fraction(2))
    total = pool.many("add", [pool.number(start), pool.many("mul", [pool.number(sign), square])])
    return [pool.many("mul", [pool.number(factor), pool.power(total, exponent)])]
