# SPDX-License-Identifier: Apache-2.0
"""Gaussian elimination with named entries, so that expressions stay short.

Pivots depend only on the positions of structural zeros, so that single runs and lanes compute the same. Structural
zeros cost no operations.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import sympy as sp

Place = tuple[int, int]
Define = Callable[[str, int, int, sp.Expr], sp.Expr]
"""Function that names an entry of `L` or `U`, from row and column."""


class SingularError(ValueError):
    """Error for a matrix whose structural zeros or plain numbers make it singular."""


@dataclass(frozen=True)
class Factors:
    """A matrix as a product of lower and upper factors, in pivot order.

    Attributes
    ----------
    pivots : tuple of (row, column)
        In the order of elimination.
    lower, upper : mapping of (row, column) to Expr
        Entries that are not zero; the diagonal of `lower` is one.
    """

    pivots: tuple[Place, ...]
    lower: dict[Place, sp.Expr]
    upper: dict[Place, sp.Expr]

    def solution(self, right: Sequence[sp.Expr], define: Callable[[int, sp.Expr], sp.Expr]) -> list[sp.Expr]:
        """Return x with matrix x = right; `define` names each entry of x."""
        between: dict[int, sp.Expr] = {}
        for row, _ in self.pivots:
            between[row] = right[row] - sum(
                self.lower[row, k] * y for k, y in between.items() if (row, k) in self.lower
            )
        x: dict[int, sp.Expr] = {}
        for row, column in reversed(self.pivots):
            rest = sum(self.upper[row, k] * value for k, value in x.items() if (row, k) in self.upper)
            x[column] = define(column, (between[row] - rest) / self.upper[row, column])
        return [x[k] for k in range(len(right))]


def factors(matrix: sp.MatrixBase, define: Define) -> Factors:
    """Return the factors of a regular matrix; the factors of a symmetric matrix share quotients.

    Raises
    ------
    SingularError
        If no nonzero pivot exists.
    """
    pivots = _order({(i, j) for i in range(matrix.rows) for j in range(matrix.cols) if matrix[i, j] != 0}, matrix.rows)
    symmetric = matrix == matrix.T and all(row == column for row, column in pivots)
    lower: dict[Place, sp.Expr] = {}
    upper: dict[Place, sp.Expr] = {}
    for step, (row, column) in enumerate(pivots):
        done, rest = pivots[:step], pivots[step:]

        def entry(i: int, j: int, done: Sequence[Place] = done) -> sp.Expr:
            terms = (lower[i, r] * upper[r, j] for r, _ in done if (i, r) in lower and (r, j) in upper)
            return matrix[i, j] - sp.Add(*terms)

        for _, j in rest:
            value = entry(row, j)
            if value != 0:
                upper[row, j] = define("U", row, j, value)
        if (row, column) not in upper:
            raise SingularError(f"its pivot in row {row + 1}, column {column + 1} is zero")
        for i, _ in rest[1:]:
            value = upper.get((row, i), sp.S.Zero) if symmetric else entry(i, column)
            if value != 0:
                lower[i, row] = define("L", i, row, value / upper[row, column])
    return Factors(pivots, lower, upper)


def _order(full: set[Place], size: int) -> tuple[Place, ...]:
    """Return a pivot order with little fill-in, among the allowed pivots.

    Source: Markowitz, Management Science 3 (1957) 255. Diagonal pivots are preferred. Those of an inertia matrix are
    positive in any order; those of multipliers are negative once the motion is eliminated.
    """
    full, pivots = set(full), []
    rows, columns = set(range(size)), set(range(size))
    while rows:
        places = sorted((i, j) for i, j in full if i in rows and j in columns)
        places = [place for place in places if place[0] == place[1]] or places
        if not places:
            raise SingularError("no pivot is left, because too many of its entries are zero")
        below = {j: [i for i in rows if (i, j) in full] for j in columns}
        beside = {i: [j for j in columns if (i, j) in full] for i in rows}
        row, column = min(places, key=lambda at: (len(beside[at[0]]) - 1) * (len(below[at[1]]) - 1))
        full |= {(i, j) for i in below[column] for j in beside[row]}
        pivots.append((row, column))
        rows.remove(row)
        columns.remove(column)
    return tuple(pivots)
