# SPDX-License-Identifier: Apache-2.0
"""Sides of relations, also matrices, as nodes for `codegen.equal`."""

from __future__ import annotations

from typing import Any

import sympy as sp

from mehvar.base.errors import MehvarError
from mehvar.models.derivation import Expr
from mehvar.models.paper import Side

from ..equal.pool import Pool
from ..equal.reals import OPERATIONS
from ..equations.graph import Graph


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
        nodes = [self.add(entry) for entry in entries(side)]
        self._numbers = self.pool.copy(self.nodes, before=self._numbers)
        return [self._numbers[node] for node in nodes]

    def _parts(self, expr: sp.Basic) -> tuple[str, list[int | str]]:
        operation, operands = super()._parts(expr)
        if operation not in OPERATIONS:
            raise UnknownFunctionError(
                f"no 50-digit value for {type(expr).__name__} in {expr}; functions known: {', '.join(OPERATIONS)}"
            )
        return operation, operands


def entries(side: Side) -> list[Expr]:
    """Return the entries of a side row by row, with operations on matrices carried out; a number has one entry."""
    if isinstance(side, sp.MatrixExpr) or side.has(sp.MatrixExpr, sp.Trace):
        side = side.replace(sp.Inverse, _inverse).doit()
    side = side.as_explicit() if isinstance(side, sp.MatrixExpr) else side
    return list(side) if isinstance(side, sp.MatrixBase) else [side]


def _inverse(matrix: Any, _: object) -> sp.MatrixBase:
    """Return the inverse by cofactors: it exists where the determinant is not zero, whatever the pivots are."""
    explicit = matrix.doit().as_explicit()
    return (explicit.adjugate() / explicit.det()).as_immutable()
