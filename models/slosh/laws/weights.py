# SPDX-License-Identifier: Apache-2.0
"""Pendulum terms of V1 (27) and of its derivative (29).

Each term contains a weighted squared rate and a product with Omega that cancels the rate's coupling to Omega'. The
printed products lack factors (m_i, parts of l^2), so that (29) would not hold; here they come from (25), (26).

With D the inertia of the pendulums' rates q and c their coupling to Omega', V1 = 1/2 (r1 v_y^2 + r2 v_z^2 + r3 a_1^2 +
r5 a_2^2 + r7 a_3^2 + Omega^T f Omega) + 1/2 sum m r (q + c^T Omega/D)^2, with f of (29): V1 is positive definite if
and only if f is.
"""

from __future__ import annotations

import functools

import sympy as sp

from ...mechanics import time_derivative
from ...system import Derivation, Expr
from ..bobs import slip_symbols
from ..plant.ball import arm_acceleration, arm_rate, contribution, direction
from ..plant.equations import ACCELERATIONS
from ..plant.pendulum import GENERIC, acceleration, angular_acceleration, phi, phi_rate, theta, theta_rate
from ..plant.reduced import AngleRow, demand
from ..states import Pendulum, rate
from .controllers import Form, collect, derivative_form, mapped, placed

_speed, _inertia, _inertia_rate, _bias, _weight, _axial = sp.symbols("q' D D' k W a_x", real=True)
_force, _moment, _moment_rate = (sp.Matrix(sp.symbols(names, real=True)) for names in ("g_:3", "c_:3", "c'_:3"))


def row_value(speed: Expr, inertia: Expr, moment: sp.Matrix, weight: Expr) -> Expr:
    """Return the terms of V1 (27) for one angle: squared rate, and its product with the coupling to Omega."""
    return weight * (speed**2 + 2 * speed * moment.dot(rate) / inertia) / 2


@functools.cache
def row_form() -> Form:
    """Derive (29) for the terms of one angle, with symbolic D q'' + g.a + c.Omega' + k = 0 (25), (26)."""
    push = _force.dot(sp.Matrix([_axial, *demand[:2]])) + _moment.dot(sp.Matrix(demand[2:])) + _bias
    rates = {_speed: -push / _inertia, _inertia: _inertia_rate}
    rates |= dict(zip((*rate, *_moment), (*demand[2:], *_moment_rate), strict=True))
    return mapped(derivative_form(row_value(_speed, _inertia, _moment, _weight), rates), sp.factor)


def angle_form(angle: AngleRow, weight: Expr, axial: Expr, d: Derivation) -> tuple[Expr, Form]:
    """Return the term of V1 (27) for one angle and its contribution to (29)."""
    row = angle.row
    values = {_speed: angle.speed, _inertia: row.inertia, _bias: row.bias, _axial: axial}
    values[_weight] = d.define(
        f"W_{angle.name}", angle.pendulum.mass * weight, "(27)", "weight of the rate of", "s^2", rf"W^{{{angle.latex}}}"
    )
    values |= dict(zip((*_force, *_moment), (*row.force, *row.moment), strict=True))
    moving = (_inertia_rate, *_moment_rate)
    for symbol, (name, expr) in zip(moving, _row_rates(angle), strict=True):
        values[symbol] = (
            expr
            if expr.is_number
            else d.define(
                f"{name}_{angle.name}",
                expr,
                "",
                "rate of a coefficient of (25), (26)",
                latex=rf"{{{sp.latex(symbol)}}}^{{{angle.latex}}}",
            )
        )
    return row_value(angle.speed, row.inertia, row.moment, values[_weight]), placed(row_form(), values)


def _row_rates(angle: AngleRow) -> list[tuple[str, Expr]]:
    """Return D' and c' in the equation of an angle."""
    turning = {phi: phi_rate, theta: theta_rate}
    generic = angle.generic
    return [
        (name, time_derivative(expr, turning).xreplace(angle.names))
        for name, expr in zip(("Dd", "cdx", "cdy", "cdz"), (generic.inertia, *generic.moment), strict=True)
    ]


_slip, _rest = (sp.Matrix(sp.symbols(names, real=True)) for names in ("s'_x s'_y s'_z", "k_x k_y k_z"))


_first = sp.Symbol("ml_i", real=True)


@functools.cache
def ball_form() -> tuple[Expr, Form, sp.Matrix]:
    """Derive (29) for W/2 (|s'|^2 + 2 s'.(C Omega)/D), where C Omega' couples Omega' to s''.

    Returns
    -------
    value : Expr
        The term of V1.
    form : Form
        Its derivative.
    rest : sympy.Matrix
        Meaning of k_x, k_y, k_z in it: the terms without accelerations in D s'' + row = lambda s.
    """
    turned = angular_acceleration.cross(direction) + rate.cross(_slip)
    relative = dict(zip((*arm_acceleration, *arm_rate), (*turned, *(_slip + rate.cross(direction))), strict=True))
    constants = {GENERIC.inertia: _inertia - _first * GENERIC.length, GENERIC.mass: _first / GENERIC.length}
    row = contribution().rows.xreplace(relative).xreplace(constants).applyfunc(sp.expand)
    forward, coupling = row.jacobian(acceleration), row.jacobian(angular_acceleration)
    push = forward * sp.Matrix([_axial, *demand[:2]]) + coupling * sp.Matrix(demand[2:]) + _rest
    free = -push / _inertia
    whole = free - direction * (direction.dot(free) + _slip.dot(_slip))
    joined = _slip.dot(coupling * rate) / _inertia
    rates = dict(zip((*direction, *_slip, *rate), (*_slip, *whole, *demand[2:]), strict=True))
    # s' has no component along s, so the multiplier does no work in s'.s''
    form = collect(_weight * (_slip.dot(free) + time_derivative(joined, rates)))
    rest = row.xreplace(dict.fromkeys(ACCELERATIONS, sp.S.Zero))
    return _weight * (_slip.dot(_slip) / 2 + joined), mapped(form, sp.factor), rest


def ball_term(
    bob: Pendulum, k: int, names: dict[sp.Symbol, Expr], weight: Expr, axial: Expr, d: Derivation
) -> tuple[Expr, Form]:
    """Return the term of V1 for a bob on a ball joint and its contribution to (29)."""
    value, form, rest = ball_form()
    named = names | dict(zip(_slip, slip_symbols(bob), strict=True)) | {_axial: axial}

    def name(text: str, expr: Expr, title: str, unit: str, latex: str) -> sp.Symbol:
        return d.define(f"{text}{k}", expr, "(27)", f"{title} {k}", unit, latex)

    named[_weight] = name("W_s", bob.mass * weight, "weight of the rate of arm", "s^2", f"W_{{{k}}}")
    named[_first] = name("ml", bob.mass * bob.length, "first moment of pendulum", "kg m", f"m_{{{k}}}l_{{{k}}}")
    named[_inertia] = name("D_s", bob.mass * bob.length**2 + bob.inertia, "inertia of pendulum", "kg m^2", f"D_{{{k}}}")
    for symbol, entry, axis in zip(_rest, rest, "xyz", strict=True):
        latex = f"k_{{{k}{axis}}}"
        named[symbol] = name(f"k_s{axis}", entry.xreplace(named), "velocity terms of arm", "N m", latex)
    return value.xreplace(named), placed(form, named)
