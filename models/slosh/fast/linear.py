# SPDX-License-Identifier: Apache-2.0
"""Symmetric positive definite equations: factorised once and solved as a list of definitions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp

from ...system import Derivation, Expr


@dataclass(frozen=True)
class Factors:
    """Factors of K = L D L^T with unit lower triangular L.

    Attributes
    ----------
    lower : tuple of tuple of Expr
        Row i holds L_ij for j < i; a structural zero stays zero.
    pivots : tuple of Expr
        D.
    """

    lower: tuple[tuple[Expr, ...], ...]
    pivots: tuple[Expr, ...]

    def leading(self, size: int) -> Factors:
        """Return the factors of the leading block."""
        return Factors(self.lower[:size], self.pivots[:size])


def factorise(matrix: sp.Matrix, name: str, d: Derivation) -> Factors:
    """Factorise a symmetric positive definite matrix from its lower triangle.

    Parameters
    ----------
    matrix : sympy.Matrix
        Entries, best symbols.
    name : str
        Begins the names of the definitions.
    d : Derivation
        Receives the steps.
    """
    size = matrix.rows
    rest = {(i, j): matrix[i, j] for i in range(size) for j in range(i + 1)}
    lower: list[list[Expr]] = [[] for _ in range(size)]
    pivots: list[Expr] = []
    for j in range(size):
        pivot = d.define(f"{name}_D{j + 1}", rest[j, j], title=f"pivot {j + 1}", latex=rf"D^{{{name}}}_{j + 1}")
        pivots.append(pivot)
        for i in range(j + 1, size):
            lower[i].append(_factor(name, i, j, rest[i, j] / pivot, d))
        for i in range(j + 1, size):
            for k in range(j + 1, i + 1):
                rest[i, k] = rest[i, k] - lower[i][j] * rest[k, j]
    return Factors(tuple(map(tuple, lower)), tuple(pivots))


def _factor(name: str, i: int, j: int, value: Expr, d: Derivation) -> Expr:
    """Name an entry of L, unless it is a structural zero."""
    if value is sp.S.Zero:
        return value
    return d.define(f"{name}_L{i + 1}{j + 1}", value, title="factor", latex=rf"L^{{{name}}}_{{{i + 1}{j + 1}}}")


def solve(factors: Factors, right: Sequence[Expr], name: str, d: Derivation) -> tuple[Expr, ...]:
    """Solve K x = right with the factors of K.

    Parameters
    ----------
    factors : Factors
        Of K.
    right : sequence of Expr
        Right side.
    name : str
        Begins the names of the definitions.
    d : Derivation
        Receives the steps.
    """
    forward: list[Expr] = []
    for i, (entry, row) in enumerate(zip(right, factors.lower, strict=True)):
        reduced = entry - sp.Add(*(a * b for a, b in zip(row, forward, strict=False)))
        forward.append(d.define(f"{name}_y{i + 1}", reduced, title="forward step", latex=rf"y^{{{name}}}_{i + 1}"))
    solution: list[Expr] = []
    for i in reversed(range(len(forward))):
        later = zip(range(i + 1, len(forward)), solution, strict=True)
        value = forward[i] / factors.pivots[i] - sp.Add(*(factors.lower[k][i] * x for k, x in later))
        symbol = d.define(f"{name}_x{i + 1}", value, title="backward step", latex=rf"x^{{{name}}}_{i + 1}")
        solution.insert(0, symbol)
    return tuple(solution)
