# SPDX-License-Identifier: Apache-2.0
"""Conditions of two expressions: the nodes at whose zeros branches change, or may change."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..branches import STEPS, atoms, branching
from ..doubles import Array
from ..pool import Pool
from ..proofs.signs import Signs

_ARCS = frozenset(("asin", "acos", "atan2"))


@dataclass(frozen=True)
class Conditions:
    """Nodes whose signs, or whole numbers, are constant in a cell.

    Attributes
    ----------
    pool : Pool
        Pool of the expressions.
    roots : (int, int)
        Both expressions.
    atoms : tuple of int
        Nodes at whose zeros a branch changes.
    signed : tuple of int
        Factors that decide the sign of an even root; those on one side only.
    turning : tuple of int
        Further nodes at whose zeros lines have points on both sides.
    """

    pool: Pool
    roots: tuple[int, int]
    atoms: tuple[int, ...]
    signed: tuple[int, ...]
    turning: tuple[int, ...]

    @classmethod
    def of(cls, pool: Pool, roots: tuple[int, int], parts: Signs) -> Conditions:
        """Return the conditions of two expressions."""
        zeros = tuple(dict.fromkeys(atom for node in branching(pool, roots) for atom in atoms(pool, node)))
        first, second = ({*pool.reached(root)} for root in roots)
        turns = (turn for arc in sorted(first | second) if pool.nodes[arc][0] in _ARCS for turn in _turns(pool, arc))
        deciding = (part for atom in zeros for part in sorted(parts.parts(atom)))
        turning = tuple(node for node in dict.fromkeys([*turns, *deciding]) if node not in zeros)
        return cls(pool, roots, zeros, tuple(_signed(pool, first, second)), turning)

    @cached_property
    def units(self) -> list[int]:
        """Branching nodes."""
        return branching(self.pool, self.roots)

    @cached_property
    def steps(self) -> list[int]:
        """Branching nodes with a whole number in place of a branch."""
        return [node for node in self.units if self.pool.nodes[node][0] in STEPS]

    @cached_property
    def nodes(self) -> list[int]:
        """Nodes of both expressions and of the conditions, operands first."""
        return self.pool.reached(*self.roots, *self.atoms, *self.signed, *self.turning)

    @cached_property
    def names(self) -> list[str]:
        """Names in the expressions."""
        return list(self.pool.names(*self.nodes))

    @cached_property
    def numbers(self) -> list[float]:
        """Numbers in the expressions, with both signs, and zero."""
        numbers = (self.pool.constant(k) for k in self.nodes)
        sizes = {abs(float(n)) for n in numbers if n and abs(n) < 10**300}
        return sorted({sign * size for size in sizes for sign in (1, -1)} | {0.0})

    def signs(self, values: Mapping[int, Any], count: int) -> Array:
        """Return a row of signs for each condition; for a whole number, a sign that changes with it."""
        rows = [values[k] for k in (*self.atoms, *self.signed, *self.turning)]
        with np.errstate(all="ignore"):  # without a value, no condition changes
            rows += [np.sin(np.pi * np.asarray(self._whole(step, values))) for step in self.steps]
        return np.sign(_table(rows, count))

    def patterns(self, values: Mapping[int, Any], count: int) -> Array:
        """Return a row for each point: the signs of conditions that decide a branch."""
        return np.sign(_table([values[k] for k in (*self.atoms, *self.signed)], count)).T.copy()

    def _whole(self, step: int, values: Mapping[int, Any]) -> Any:
        """Return what a step rounds to a whole number."""
        first, *rest = (values[k] for k in self.pool.operands(step))
        return first / rest[0] if rest else first


def _table(rows: Sequence[Any], count: int) -> Array:
    """Return values, each a number or one per point, as rows of equal length."""
    table: Array = np.array([np.broadcast_to(np.asarray(row, dtype=float), count) for row in rows], dtype=float)
    return table.reshape(-1, count)


def _signed(pool: Pool, first: set[int], second: set[int]) -> list[int]:
    """Return the factors on one side only that may decide the sign of an expression, if there are even roots."""
    rooted = any(pool.raised(node)[1].denominator % 2 == 0 for node in first | second)
    kinds = ("add", "sin", "cos", "tan", "sym")
    return [k for k in sorted(first ^ second) if rooted and pool.nodes[k][0] in kinds]


def _turns(pool: Pool, arc: int) -> list[int]:
    """Return the nodes that are zero where an arc changes its branch."""
    operands = pool.operands(arc)
    other = {"sin": "cos", "cos": "sin"}.get(pool.nodes[operands[0]][0])
    return [*operands, *([pool.intern(other, *pool.operands(operands[0]))] if other else [])]
