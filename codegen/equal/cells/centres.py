# SPDX-License-Identifier: Apache-2.0
"""Centres of narrow features, such as the bump exp(-s^2 (f - c)^2) at a zero of f - c."""

from __future__ import annotations

from collections.abc import Iterator

from ..pool import Pool
from .slopes import slope

_NARROW = frozenset(
    ("exp", "tanh", "sinh", "cosh", "atan", "asinh", "log", "sin", "cos", "tan", "acos", "asin", "atan2")
)
"""Functions that may change only in a narrow region, near a zero or extremum of their operand."""
_BROAD = 3
"""Largest exponent of a power whose change is as wide as that of its base."""
_MOST = 24
"""Largest number of centres; each costs one line per name."""


def centres(pool: Pool, roots: tuple[int, int], known: tuple[int, ...]) -> list[int]:
    """Return the nodes that are zero at the centre of a narrow feature; nodes of only one side come first.

    Parameters
    ----------
    pool : Pool
        Pool of both expressions.
    roots : (int, int)
        Nodes of both expressions.
    known : tuple of int
        Nodes at whose zeros lines have points anyway.
    """
    first, second = ({*pool.reached(root)} for root in roots)
    nodes = (*sorted(first ^ second), *sorted(first & second))
    zeros = dict.fromkeys(zero for node in nodes if _is_narrow(pool, node) for zero in _zeros(pool, node))
    return [k for k in zeros if k not in known and pool.names(k)][:_MOST]


def _is_narrow(pool: Pool, node: int) -> bool:
    """Return True for a function that may change in a narrow region; not for a root or a small power."""
    operation, *operands = pool.nodes[node]
    if operation != "pow":
        return operation in _NARROW
    exponent = pool.constant(operands[1])
    return exponent is None or not 0 < exponent <= _BROAD


def _zeros(pool: Pool, node: int) -> Iterator[int]:
    """Yield the parts of a function's operand, and the operand's derivatives.

    The operand may have an extremum at the centre instead of a zero, such as an expanded square.
    """
    operand = pool.operands(node)[0]
    inner = pool.reached(operand)
    yield from (k for k in inner if pool.nodes[k][0] in ("add", "sym", "sin", "cos"))
    slopes = (slope(pool, operand, k) for k in pool.names(operand).values())
    yield from (k for k in slopes if k is not None and pool.constant(k) is None)
