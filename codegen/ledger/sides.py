# SPDX-License-Identifier: Apache-2.0
"""Sides of relations, also matrices, as nodes for `codegen.equal`."""

from __future__ import annotations

from collections.abc import Callable
from functools import reduce
from typing import TypeAlias

import sympy as sp
from sympy.matrices.expressions.matexpr import MatrixElement

from mehvar.base.errors import MehvarError
from mehvar.models.paper import Cross, Side

from ..equal.pool import Pool
from ..equal.reals import OPERATIONS
from ..equations.graph import Graph

Matrix: TypeAlias = list[list[int]]
"""Nodes of the entries, row by row."""


class UnknownFunctionError(MehvarError, LookupError):
    """An equation contains a function that cannot be evaluated to the required digits."""


class Sides(Graph):
    """Converter of SymPy expressions and matrices to nodes, entry by entry.

    Parameters
    ----------
    pool : Pool
        Receives the nodes.
    """

    def __init__(self, pool: Pool) -> None:
        super().__init__()
        self.pool = pool
        self._numbers: list[int] = []

    def entries(self, side: Side) -> list[int]:
        """Return the nodes of a side: one for a number, all entries row by row for a matrix.

        Raises
        ------
        UnknownFunctionError
            If it contains a function that cannot be evaluated.
        """
        matrix = self._matrix(side)
        self._numbers = self.pool.copy(self.nodes, before=self._numbers)
        return [self._numbers[node] for row in matrix for node in row]

    def _parts(self, expr: sp.Basic) -> tuple[str, list[int | str]]:
        """Return operation and operands; an entry or the trace of a matrix is an expression of its entries."""
        if isinstance(expr, sp.Trace):
            matrix = self._matrix(expr.arg)
            return self._again(self._combined("add", *(matrix[k][k] for k in range(len(matrix)))))
        if isinstance(expr, MatrixElement):
            return self._again(self._matrix(expr.parent)[int(expr.i)][int(expr.j)])
        operation, operands = super()._parts(expr)
        if operation not in OPERATIONS:
            raise UnknownFunctionError(
                f"no 50-digit value for {type(expr).__name__} in {expr}; functions known: {', '.join(OPERATIONS)}"
            )
        return operation, operands

    def _again(self, node: int) -> tuple[str, list[int | str]]:
        operation, *operands = self.nodes[node]
        return operation, operands

    def _combined(self, operation: str, *operands: int) -> int:
        """Return a sum or a product."""
        return operands[0] if len(operands) == 1 else self._store(operation, list(operands))

    def _matrix(self, side: Side) -> Matrix:
        if isinstance(side, sp.MatrixBase):
            return [[self.add(entry) for entry in row] for row in side.tolist()]
        for kind, carried_out in self._operations().items():
            if isinstance(side, kind):
                return carried_out(side)
        return [[self.add(side)]]

    def _operations(self) -> dict[type, Callable[..., Matrix]]:
        """Return for each operation on matrices the function that returns the entries of its result as nodes."""
        return {
            sp.Identity: lambda side: self._matrix(side.as_explicit()),
            sp.ZeroMatrix: lambda side: self._matrix(side.as_explicit()),
            sp.MatAdd: lambda side: reduce(self._sum, map(self._matrix, side.args)),
            sp.MatMul: lambda side: reduce(self._product, map(self._matrix, side.args)),
            sp.Transpose: lambda side: [list(column) for column in zip(*self._matrix(side.arg), strict=True)],
            sp.Inverse: lambda side: self._inverse(self._matrix(side.arg)),
            sp.MatPow: lambda side: reduce(self._product, [self._matrix(side.base)] * int(side.exp)),
            Cross: lambda side: self._cross(*map(self._matrix, side.args)),
        }

    def _sum(self, a: Matrix, b: Matrix) -> Matrix:
        pairs = (zip(*rows, strict=True) for rows in zip(a, b, strict=True))
        return [[self._combined("add", *pair) for pair in row] for row in pairs]

    def _product(self, a: Matrix, b: Matrix) -> Matrix:
        for one, other in ((a, b), (b, a)):
            if len(one) == len(one[0]) == 1 != len(other) * len(other[0]):  # a number times a matrix
                return [[self._combined("mul", one[0][0], entry) for entry in row] for row in other]
        columns = list(zip(*b, strict=True))
        return [[self._scalar(row, column) for column in columns] for row in a]

    def _scalar(self, row: list[int], column: tuple[int, ...]) -> int:
        return self._combined("add", *(self._combined("mul", *pair) for pair in zip(row, column, strict=True)))

    def _difference(self, a: int, b: int) -> int:
        return self._combined("add", a, self._combined("mul", self.add(sp.S.NegativeOne), b))

    def _cross(self, a: Matrix, b: Matrix) -> Matrix:
        (x, y), turns = ([row[0] for row in side] for side in (a, b)), ((1, 2), (2, 0), (0, 1))
        return [
            [self._difference(self._combined("mul", x[i], y[j]), self._combined("mul", x[j], y[i]))]
            for i, j in (turns if len(x) == 3 else ((0, 1),))
        ]

    def _inverse(self, matrix: Matrix) -> Matrix:
        """Return the inverse of a matrix with two or three rows, by cofactors and determinant."""
        size = range(len(matrix))
        one_over = self._store("pow", [self._determinant(matrix), self.add(sp.S.NegativeOne)])
        return [[self._combined("mul", self._cofactor(matrix, j, i), one_over) for j in size] for i in size]

    def _determinant(self, matrix: Matrix) -> int:
        if not matrix:
            return self.add(sp.S.One)
        first = (self._combined("mul", matrix[0][k], self._cofactor(matrix, 0, k)) for k in range(len(matrix)))
        return self._combined("add", *first)

    def _cofactor(self, matrix: Matrix, row: int, column: int) -> int:
        rest = [[*entries[:column], *entries[column + 1 :]] for k, entries in enumerate(matrix) if k != row]
        sign = self.add(sp.Integer((-1) ** (row + column)))
        return self._combined("mul", sign, self._determinant(rest))
