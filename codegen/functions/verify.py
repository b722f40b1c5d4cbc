# SPDX-License-Identifier: Apache-2.0
"""Check of the efficient form against CasADi's functions and the derived equations."""

from __future__ import annotations

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from mehvar.base.errors import MehvarError
from mehvar.base.names import CLOCK
from mehvar.models.check.entries import graph
from mehvar.models.check.vectors import vectors
from mehvar.models.system import TIME, Group, Parameter, System

from .lower import LoweringError, missing_counterpart, to_casadi

POINTS = 40
"""Number of points. A wrong term shows at each; forty also reach both branches of a switch."""
TOLERANCE = 1e-12
"""Relative tolerance; rounding is 1e-15 in the largest shipped model."""


class VerificationError(MehvarError, ValueError):
    """The right-hand side to generate differs from the derived one."""


def check_counterparts(system: System) -> None:
    """Refuse functions and relations without counterpart in CasADi.

    Raises
    ------
    LoweringError
        With file, line and row.
    """
    rows = [(f"{step.origin}: definition {step.symbol.name!r}", step.expr) for step in system.definitions_in_order]
    rows += [(vector.row(k), entry) for vector in vectors(system) for k, entry in enumerate(vector.entries)]
    for where, entry in rows:
        for node in graph(entry):
            if problem := missing_counterpart(node):
                raise LoweringError(f"{where}: {problem}")


def verify(system: System) -> None:
    """Compare x' of the efficient form with x' of the derived equations at random points.

    Rates that differ by rounding count as the same if they solve the equations to 1e-12 of their terms. A mass matrix
    with entries of very different sizes causes such rounding.

    States and inputs are drawn from [-1, 1], parameters within 20 % of their defaults and inside their bounds.

    Raises
    ------
    VerificationError
        If they differ by more than 1e-12 max(1, |x'|_inf) at a point, or the derived equations determine no x' there.
        The message names point and state.
    """
    if not system.residual:
        return
    forms, project = _forms(system), _projection(system)
    generator = np.random.default_rng(0)
    names = list(system.rates)
    for point in range(POINTS):
        x, u, p = (_draw(group, generator) for group in (system.states, system.inputs, system.parameters))
        rates, residual, slope = (np.array(value) for value in forms(project(x, p), u, p))
        try:
            error = np.abs(np.linalg.solve(slope, residual)).ravel()
        except np.linalg.LinAlgError as singular:
            raise VerificationError(
                f"{system.origin}: residual does not determine {', '.join(names)}: its derivative with respect to "
                f"{', '.join(str(rate) for rate in system.rates.values())} is singular at random point {point}"
            ) from singular
        bound = TOLERANCE * max(1.0, float(np.abs(rates).max()))
        worst = int(error.argmax())
        solves = np.abs(residual) <= TOLERANCE * (np.abs(slope) @ np.abs(rates))
        if not error[worst] <= bound and not solves.all():
            raise VerificationError(
                f"{system.origin}: {names[worst]}' of rhs differs from the derived equations "
                f"by {error[worst]:.2e} (allowed {bound:.2e}) at random point {point}"
            )


def _forms(system: System) -> ca.Function:
    """Return functions of (x, u, p): efficient rates, their residual, and its derivative with respect to the rates."""
    groups = (system.states, system.inputs, system.parameters)
    vectors = [ca.SX.sym(group.name, len(group)) for group in groups]
    symbols = {
        symbol: vector[k]
        for group, vector in zip(groups, vectors, strict=True)
        for k, symbol in enumerate(group.symbols)
    }
    clock = next((symbols[q.symbol] for q in system.states if q.name == CLOCK), None)
    symbols |= {} if clock is None else {TIME.symbol: clock}
    rates = ca.SX.sym("rates", len(system.rates))
    rate_symbols = {symbol: rates[k] for k, symbol in enumerate(system.rates.values())}
    by_state = dict(zip((q.name for q in system.states), system.rhs, strict=True))
    value = ca.vertcat(*to_casadi([by_state[name] for name in system.rates], symbols, system.definitions))
    residual = ca.vertcat(*to_casadi(system.residual, symbols | rate_symbols, system.definitions))
    slope = ca.densify(ca.jacobian(residual, rates))
    return ca.Function("forms", vectors, [value, *ca.substitute([residual, slope], [rates], [value])])


def _projection(system: System) -> ca.Function:
    """Return the map from x, p to the projected x."""
    x, p = ca.SX.sym("x", len(system.states)), ca.SX.sym("p", len(system.parameters))
    symbols = {symbol: x[k] for k, symbol in enumerate(system.states.symbols)}
    symbols |= {symbol: p[k] for k, symbol in enumerate(system.parameters.symbols)}
    moved = to_casadi(system.projection or system.states.symbols, symbols, system.definitions)
    return ca.Function("project", [x, p], [ca.vertcat(*moved)])


def _draw(group: Group, generator: np.random.Generator) -> NDArray[np.float64]:
    return np.array([_value(q, generator) for q in group])


def _value(quantity: object, generator: np.random.Generator) -> float:
    if not isinstance(quantity, Parameter) or not isinstance(quantity.default, float):
        return float(generator.uniform(-1, 1))
    # near the default, where masses and lengths still make a body
    value = quantity.default * generator.uniform(0.8, 1.2)
    return value if value in quantity.bounds else quantity.default
