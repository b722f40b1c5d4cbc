# SPDX-License-Identifier: Apache-2.0
"""Mass matrices: `mass` x' = `rhs`.

If the matrix is regular, definitions solve for the rates, and every method, backend and tool gets the plain form x' =
... (decision 0031). A state whose column is zero is algebraic: its row is an equation 0 = ..., which only linearly
implicit methods fulfil.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import sympy as sp

from ..derivation import Derivation
from ..quantities import ModelError, Quantity
from ..system import Expr, System
from .elimination import SingularError, factors


def with_mass(system: System) -> System:
    """Return a system whose `rhs` has rates and algebraic residuals; the same system if it has no mass matrix.

    With algebraic states, a diagonal of ones and zeros remains as the mass matrix. The equations as declared become
    the residual, against which generation checks the solved form.
    """
    if system.mass is None or has_rates(system):
        return system
    algebraic = algebraic_rows(system)
    moving = [k for k in range(len(system.states)) if k not in algebraic]
    states, right = ([of[k] for k in moving] for of in (system.states.quantities, system.rhs))
    steps = _Steps(system, states)
    matrix = steps.matrix(system.mass.extract(moving, moving))
    try:
        solution = dict(zip(moving, steps.solution(matrix, right), strict=True))
    except SingularError as error:
        raise ModelError(f"{system.origin}: mass is singular: {error}; {_ADVICE}") from None
    rates = _rates(system, states)
    left = matrix * sp.Matrix(rates) - sp.Matrix(right)
    return replace(
        system,
        mass=_ones(system) if algebraic else None,
        steps=tuple(steps.derivation.steps),
        rhs=tuple(solution.get(k, row) for k, row in enumerate(system.rhs)),
        rates={q.name: rate for q, rate in zip(states, rates, strict=True)},
        residual=tuple(left),
    )


class _Steps:
    """Named expressions of the solution; names contain the states of row and column."""

    def __init__(self, system: System, states: Sequence[Quantity]) -> None:
        self.derivation = Derivation(system.steps)
        self._names = [q.name for q in states]
        self._latex = [q.latex or sp.latex(q.symbol) for q in states]

    def matrix(self, mass: sp.MatrixBase) -> sp.Matrix:
        """Name the entries of the matrix; equal entries across the diagonal share a name."""
        self.derivation.section("Mass matrix")
        named = sp.zeros(*mass.shape)
        for i in range(mass.rows):
            for j in range(mass.cols):
                alike = j < i and mass[i, j] == mass[j, i]
                named[i, j] = named[j, i] if alike else self._entry("M", i, j, mass[i, j])
        return named

    def solution(self, matrix: sp.Matrix, right: Sequence[Expr]) -> list[Expr]:
        """Return the rates that solve the equations with this matrix and right side."""
        self.derivation.section("Rates from the mass matrix")
        return factors(matrix, self._entry).solution(right, self._rate)

    def _entry(self, letter: str, i: int, j: int, value: Expr) -> Expr:
        """Name an entry of the matrix or of a factor, unless it is a number or already named."""
        if value.is_Number or (letter != "M" and value.is_Atom):
            return value
        row, column = self._names[i], self._names[j]
        what, name = ("", "mass") if letter == "M" else (f"factor {letter} of the ", f"mass_{letter}")
        return self.derivation.define(
            f"{name}_{row}_{column}",
            value,
            title=f"{what}mass matrix, row of {row}, column of {column}",
            latex=rf"{letter}_{{{self._latex[i]},{self._latex[j]}}}",
        )

    def _rate(self, k: int, value: Expr) -> Expr:
        if value.is_Atom:
            return value
        name, latex = self._names[k], rf"\dot{{{self._latex[k]}}}"
        return self.derivation.define(f"mass_rate_{name}", value, title=f"rate of {name}", latex=latex)


_ADVICE = "an algebraic state has a column and a row of zeros"


def algebraic_rows(system: System) -> tuple[int, ...]:
    """Return the indices of algebraic states, whose columns in the mass matrix are zero.

    Raises
    ------
    ModelError
        If the rows of these states are not zero.
    """
    mass = system.mass
    if mass is None:
        return ()
    rows = {k for k in range(mass.rows) if all(entry == 0 for entry in mass.row(k))}
    columns = {k for k in range(mass.cols) if all(entry == 0 for entry in mass.col(k))}
    if rows != columns:
        name = system.states.quantities[min(rows ^ columns)].name
        zero, full = ("column", "row") if columns - rows else ("row", "column")
        raise ModelError(
            f"{system.origin}: mass is singular: the {zero} of {name!r} is zero and its {full} is not; {_ADVICE}"
        )
    return tuple(sorted(columns))


def mass_rows(system: System, rates: Sequence[sp.Symbol]) -> tuple[Expr, ...]:
    """Return mass times rates, one expression per row."""
    assert system.mass is not None
    return tuple(system.mass * sp.Matrix(rates))


def has_rates(system: System) -> bool:
    """Return True if the mass matrix is diagonal with ones and zeros, so that `rhs` contains the rates."""
    return bool(system.mass == _ones(system))


def _ones(system: System) -> sp.Matrix:
    algebraic = algebraic_rows(system)
    return sp.diag(*(0 if k in algebraic else 1 for k in range(len(system.states))))


def _rates(system: System, states: Sequence[Quantity]) -> list[sp.Symbol]:
    """Return a new symbol for the rate of each state."""
    groups = (system.states, system.inputs, system.parameters)
    taken = {q.name for group in groups for q in group} | {symbol.name for symbol in system.definitions}
    names = []
    for q in states:
        name = f"{q.name}_rate"
        while name in taken:
            name += "_"
        names.append(name)
    return [sp.Symbol(name, real=True) for name in names]
