# SPDX-License-Identifier: Apache-2.0
"""A matrix before the rates: `mass` x' = `rhs`.

Where it is regular the rates are solved for, in definitions, and every method, backend and tool has the plain form
x' = ... (decision 0031). A state whose column is zero is algebraic: its row is an equation 0 = ..., which only a
linearly implicit method can keep.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import sympy as sp

from ..derivation import Derivation
from ..quantities import ModelError
from ..system import Expr, System
from .elimination import SingularError, factors


def with_mass(system: System) -> System:
    """Return a system whose `rhs` has the rates, and of algebraic states what is zero; the same one without a mass.

    Of a mass with algebraic states the diagonal stays, ones and zeros. The equations as declared are the residual,
    which generation holds the solved form against.
    """
    mass = system.mass
    if mass is None or has_rates(system):
        return system
    names, printed = [q.name for q in system.states], [q.latex or sp.latex(q.symbol) for q in system.states]
    moving = [k for k in range(len(names)) if k not in algebraic_rows(system)]
    steps = Derivation(system.steps)
    steps.section("Mass matrix")
    named = sp.zeros(*mass.shape)
    for i in moving:
        for j in moving:
            twin = named[j, i] if j < i and mass[i, j] == mass[j, i] else None
            title = f"mass matrix, row of {names[i]}, column of {names[j]}"
            latex = rf"M_{{{printed[i]},{printed[j]}}}"
            named[i, j] = twin or _named(steps, f"mass_{names[i]}_{names[j]}", mass[i, j], title, latex)
    steps.section("Rates from the mass matrix")

    def factor(half: str, i: int, j: int, value: Expr) -> Expr:
        i, j = moving[i], moving[j]
        title = f"factor {half} of the mass matrix, row of {names[i]}, column of {names[j]}"
        latex = rf"{half}_{{{printed[i]},{printed[j]}}}"
        return _named(steps, f"mass_{half}_{names[i]}_{names[j]}", value, title, latex)

    def rate(k: int, value: Expr) -> Expr:
        k = moving[k]
        return _named(steps, f"mass_rate_{names[k]}", value, f"rate of {names[k]}", rf"\dot{{{printed[k]}}}")

    right = [system.rhs[k] for k in moving]
    matrix = named.extract(moving, moving)
    try:
        rates_of = dict(zip(moving, factors(matrix, factor).solution(right, rate), strict=True))
    except SingularError as error:
        raise ModelError(f"{system.origin}: mass is singular: {error}; {_ADVICE}") from None
    rates = _rates(system)
    left = named * sp.Matrix(rates)
    return replace(
        system,
        mass=_ones(system) if len(moving) < len(names) else None,
        steps=tuple(steps.steps),
        rhs=tuple(rates_of.get(k, row) for k, row in enumerate(system.rhs)),
        rates={names[k]: rates[k] for k in moving},
        residual=tuple(left[k] - system.rhs[k] for k in moving),
    )


_ADVICE = "an algebraic state has a column and a row of zeros"


def algebraic_rows(system: System) -> tuple[int, ...]:
    """Return the places of the states whose rates stand nowhere: their columns are zero.

    Raises
    ------
    ModelError
        If the rows there are not zero too.
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
    """Return mass times rates, one expression a row."""
    assert system.mass is not None
    return tuple(system.mass * sp.Matrix(rates))


def has_rates(system: System) -> bool:
    """Tell whether a mass has ones and zeros on its diagonal alone: `rhs` has the rates."""
    return bool(system.mass == _ones(system))


def _ones(system: System) -> sp.Matrix:
    algebraic = algebraic_rows(system)
    return sp.diag(*(0 if k in algebraic else 1 for k in range(len(system.states))))


def _rates(system: System) -> list[sp.Symbol]:
    """Return a symbol for the rate of each state, under a name that nothing else has."""
    groups = (system.states, system.inputs, system.parameters)
    taken = {q.name for group in groups for q in group} | {symbol.name for symbol in system.definitions}
    names = []
    for q in system.states:
        name = f"{q.name}_rate"
        while name in taken:
            name += "_"
        names.append(name)
    return [sp.Symbol(name, real=True) for name in names]


def _named(steps: Derivation, name: str, value: Expr, title: str, latex: str) -> Expr:
    """Name an expression; a number needs no name."""
    return value if value.is_Number else steps.define(name, value, title=title, latex=latex)
