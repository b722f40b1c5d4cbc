# SPDX-License-Identifier: Apache-2.0
"""Derivatives of smooth expressions; those of logarithms and inverse functions are algebraic, as the field needs."""

from __future__ import annotations

from fractions import Fraction
from functools import partial

from ..equations.document import reached
from .branches import BRANCHING
from .pool import Pool

_MOST = 400
"""Largest number of nodes of a differentiated expression; larger ones take seconds."""


def names(pool: Pool, root: int) -> set[int]:
    """Return the names in an expression."""
    return {node for node in reached(pool.nodes, [root]) if pool.nodes[node][0] == "sym"}


def slope(pool: Pool, root: int, name: int) -> int | None:
    """Return the derivative of an expression with respect to a name; None if a part has no implemented derivative."""
    nodes = reached(pool.nodes, [root])
    if len(nodes) > _MOST:
        return None
    slopes: dict[int, int] = {}
    zero = pool.number(0)
    for node in nodes:
        parts = [slopes.get(operand) for operand in pool.operands(node)]
        if pool.nodes[node][0] in ("sym", "num", "const"):
            slopes[node] = pool.number(int(node == name))
        elif None not in parts and all(part == zero for part in parts):
            slopes[node] = zero
        elif pool.nodes[node][0] in BRANCHING or (found := _chain(pool, node, slopes)) is None:
            return None
        else:
            slopes[node] = found
    return slopes[root]


def _chain(pool: Pool, node: int, slopes: dict[int, int]) -> int | None:
    """Return a node's derivative from those of its operands; None if a derivative is missing."""
    operation = pool.nodes[node][0]
    operands = pool.operands(node)
    times, total, number = partial(_many, pool, "mul"), partial(_many, pool, "add"), pool.number
    if any(operand not in slopes for operand in operands):
        return None
    if operation == "add":
        return total(*(slopes[operand] for operand in operands))
    if operation == "mul":
        return total(
            *(times(slopes[o], *(other for m, other in enumerate(operands) if m != k)) for k, o in enumerate(operands))
        )
    first = operands[0]
    if operation == "pow":
        exponent = pool.constant(operands[1])
        return None if exponent is None else times(number(exponent), pool.power(first, exponent - 1), slopes[first])
    if operation == "atan2":
        y, x = operands
        size = total(pool.power(y, Fraction(2)), pool.power(x, Fraction(2)))
        gain = total(times(x, slopes[y]), times(number(-1), y, slopes[x]))
        return times(gain, pool.power(size, Fraction(-1)))
    outer = _outer(pool, operation, node, first)
    return None if outer is None else times(outer, slopes[first])


def _outer(pool: Pool, operation: str, node: int, operand: int) -> int | None:
    """Return the derivative of a function of one operand."""
    times, total, number = partial(_many, pool, "mul"), partial(_many, pool, "add"), pool.number
    square = pool.power(operand, Fraction(2))
    minus = times(number(-1), square)
    half = Fraction(-1, 2)
    if operation in ("exp", "sinh", "cosh"):
        return pool.intern({"exp": "exp", "sinh": "cosh", "cosh": "sinh"}[operation], operand)
    if operation == "sin":
        return pool.intern("cos", operand)
    if operation == "cos":
        return times(number(-1), pool.intern("sin", operand))
    if operation in ("tan", "tanh"):
        own = pool.power(node, Fraction(2))
        return total(number(1), own if operation == "tan" else times(number(-1), own))
    if operation == "log":
        return pool.power(operand, Fraction(-1))
    if operation in ("atan", "atanh"):
        return pool.power(total(number(1), square if operation == "atan" else minus), Fraction(-1))
    if operation in ("asin", "acos"):
        return times(number(1 if operation == "asin" else -1), pool.power(total(number(1), minus), half))
    if operation in ("asinh", "acosh"):
        return pool.power(total(square, number(1 if operation == "asinh" else -1)), half)
    return None


def _many(pool: Pool, operation: str, *parts: int) -> int:
    return pool.many(operation, parts)
