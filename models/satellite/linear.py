# SPDX-License-Identifier: Apache-2.0
"""Linear model (8)-(11), derived from the nonlinear one, and its exact sampled form (43)-(45)."""

from __future__ import annotations

import functools

import sympy as sp

from ..mechanics import angular_velocity, time_derivative
from ..system import Derivation, Expr, Group
from .dynamics import (
    AXES,
    angles,
    euler_rotation,
    gravity_gradient,
    inertia_matrix,
    torque_excess,
    total_inertia,
)
from .orbit import circular_turning
from .wheels import Wheels

_RATES = sp.symbols(r"\dot\varphi \dot\theta \dot\psi", real=True)
_ACCELERATIONS = sp.symbols(r"\ddot\varphi \ddot\theta \ddot\psi", real=True)
_PRINTED_B = ("0.307 + 0.0586 q^-1", "0.305 + 0.0411 q^-1", "0.302 + 0.0404 q^-1")


def linear_torques(plant: Group, wheels: Wheels) -> tuple[Expr, Expr, Expr]:
    """Return the control torque for motion near the orbit axes, to first order in angles and rates."""
    rotation, scale = euler_rotation(), sp.Symbol("epsilon")
    motion = dict(zip((*angles, *_RATES), (*_RATES, *_ACCELERATIONS), strict=True))
    relative = angular_velocity(rotation, dict(zip(angles, _RATES, strict=True)))
    rate = relative + rotation * circular_turning(plant.omega0)
    acceleration = rate.applyfunc(lambda expr: time_derivative(expr, motion))
    pull = gravity_gradient(rotation, total_inertia(plant, wheels), plant.omega0**2)
    torque = torque_excess(inertia_matrix(plant), rate, acceleration, wheels.momentum) - pull
    small = {s: scale * s for s in (*angles, *_RATES, *_ACCELERATIONS)}
    return tuple(_first_order(expr.subs(small, simultaneous=True), scale) for expr in torque)


def _first_order(expr: Expr, scale: sp.Symbol) -> Expr:
    return sp.expand(expr.subs(scale, 0) + sp.diff(expr, scale).subs(scale, 0))


def show_linear_model(plant: Group, wheels: Wheels, d: Derivation) -> None:
    """Show (8)-(11): the paper's terms, the neglected roll-yaw coupling, and terms of stored momentum."""
    d.section("Linear model")
    no_momentum = dict.fromkeys(wheels.momenta, 0)
    for k, torque in enumerate(linear_torques(plant, wheels)):
        name, axis = "xyz"[k], AXES[k]
        own = {angles[k], _RATES[k], _ACCELERATIONS[k]}
        without = torque.subs(no_momentum)
        coupling = sp.Add(*(t for t in sp.Add.make_args(without) if not own & t.free_symbols))
        principal = sp.collect(sp.expand(without - coupling), [angles[k], _ACCELERATIONS[k]], sp.factor)
        d.show(
            f"T_{name}",
            principal,
            f"({8 + k})",
            f"{axis}: kept by the paper (printed with the first derivative)",
            "N m",
        )
        remainder = sp.collect(coupling, _RATES, sp.factor)
        if remainder is not sp.S.Zero:
            title = f"{axis}: roll-yaw coupling, dropped by the paper"
            d.show(rf"T_{{{name},\mathrm{{dropped}}}}", remainder, f"({8 + k})", title, "N m")
        momentum = sp.expand(torque - without)
        d.show(
            rf"T_{{{name},\mathrm{{stored}}}}",
            momentum,
            f"({8 + k})",
            f"{axis}: added by momentum in the wheels",
            "N m",
        )
        _show_state_space(k, principal, remainder, plant, d)


def _show_state_space(k: int, principal: Expr, remainder: Expr, plant: Group, d: Derivation) -> None:
    """Show the entries of A and B of (11) in the row of one acceleration; x is three angles, then three rates."""
    inertia = inertia_matrix(plant)[k, k]
    row = k + 4
    stiffness = -sp.expand(principal).coeff(angles[k]) / inertia
    d.show(f"A_{{{row}{k + 1}}}", sp.factor(stiffness), "(11)", f"stiffness of {AXES[k]}", "1/s^2")
    d.show(f"B_{{{row}{k + 1}}}", 1 / inertia, "(11)", f"torque to acceleration of {AXES[k]}", "1/kg/m^2")
    for j in range(3):
        entry = -sp.expand(remainder).coeff(_RATES[j]) / inertia
        if entry is not sp.S.Zero:
            d.show(f"A_{{{row}{j + 4}}}", sp.factor(entry), "(11)", "coupling, zero in the paper", "1/s")


@functools.cache
def pulse_transfer(
    inertia: Expr, period: Expr, frequency: Expr | None = None
) -> tuple[tuple[Expr, Expr, Expr], tuple[Expr, Expr]]:
    """Discretise I y'' + I w^2 y = u exactly with a zero-order hold of u.

    Parameters
    ----------
    inertia, period : Expr
        I and the sampling period.
    frequency : Expr, optional
        w; a double integrator without it.

    Returns
    -------
    tuple of Expr, tuple of Expr
        Coefficients of A(q^-1) and of B(q^-1) in A y(k) = q^-1 B u(k), the lowest power first.
    """
    stiffness = sp.S.Zero if frequency is None else frequency**2
    generator = sp.Matrix([[0, 1, 0], [-stiffness, 0, 1 / inertia], [0, 0, 0]])
    step = (generator * period).exp().applyfunc(lambda entry: sp.simplify(entry.rewrite(sp.cos)))
    state, push = step[:2, :2], step[:2, 2]
    trace, determinant = sp.simplify(state.trace()), sp.simplify(state.det())
    first = push[0]
    second = (state * push)[0] - trace * push[0]
    return (sp.S.One, -trace, determinant), (sp.simplify(first), sp.simplify(second))


def show_sampled_model(plant: Group, d: Derivation) -> None:
    """Show (43)-(45), and the result that b0 = b1 also with stiffness."""
    d.section("Sampled model")
    frequency, inertia = sp.symbols("w I", positive=True)
    A, B = pulse_transfer(inertia, plant.Ts, frequency)
    d.show("A", _polynomial(A), "(43)-(45)", "A(q^-1) of an axis with stiffness I w^2")
    title = "B(q^-1) of the same: b0 = b1, so its zero is -1 at any stiffness"
    d.show("B", sp.factor(_polynomial(B)), "(43)-(45)", title, "rad/N/m")
    for k, axis in enumerate(AXES):
        A, B = pulse_transfer(inertia_matrix(plant)[k, k], plant.Ts)
        number = f"({43 + k})"
        d.show(rf"A_{{\mathrm{{{axis}}}}}", _polynomial(A), number, f"A(q^-1) of {axis}, as printed")
        printed = f"B(q^-1) of {axis}; printed {_PRINTED_B[k]}, whose first coefficient is not this one"
        d.show(rf"B_{{\mathrm{{{axis}}}}}", sp.factor(_polynomial(B)), number, printed, "rad/N/m")


def _polynomial(coefficients: tuple[Expr, ...]) -> Expr:
    delays = (sp.S.One, *sp.symbols("q^{-1} q^{-2}", real=True))
    return sp.Add(*(c * delay for c, delay in zip(coefficients, delays, strict=False)))


def nominal_gain(inertia: Expr, period: Expr) -> Expr:
    """Return b0 = b1 of an axis without stiffness, rad/(N m)."""
    return pulse_transfer(inertia, period)[1][0]
