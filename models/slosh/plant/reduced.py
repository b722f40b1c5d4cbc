# SPDX-License-Identifier: Apache-2.0
"""Equilibrium and reduced model, (18)-(26): the hull's accelerations are inputs, a_x is constant.

Equations (15), (16) are diagonal in the pendulums' accelerations and are solved one by one.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp

from ...mechanics import expanded, gradient
from ...system import Derivation, Expr
from ..states import DEMAND, Pendulum, rate, velocity
from .equations import ACCELERATIONS
from .pendulum import acceleration, angle_acceleration, contribution, instance, phi, phi_rate, theta, theta_rate

demand = sp.Matrix(DEMAND.symbols)
"""Demanded a_y, a_z and Omega' as u1..u5."""


@dataclass(frozen=True)
class AngleEquation:
    """Equation of one angle, D q'' + g.a + c.Omega' + k = 0, in generic symbols.

    Attributes
    ----------
    inertia, bias : Expr
        D and k.
    force, moment : sympy.Matrix
        g and c, the coefficients of the accelerations of O and of the axes.
    """

    inertia: Expr
    force: sp.Matrix
    moment: sp.Matrix
    bias: Expr


@dataclass(frozen=True)
class AngleRow:
    """Equation of one angle of one pendulum with named coefficients.

    Attributes
    ----------
    name, latex : str
        Name, such as "phi1", and LaTeX.
    pendulum : Pendulum
        Pendulum of the angle.
    speed : Symbol
        Rate of the angle.
    row : AngleEquation
        The equation in named coefficients.
    generic : AngleEquation
        The equation in the generic symbols, for differentiation.
    names : mapping
        Values of the generic symbols.
    """

    name: str
    latex: str
    pendulum: Pendulum
    speed: sp.Symbol
    row: AngleEquation
    generic: AngleEquation
    names: dict[sp.Symbol, Expr]


@functools.cache
def generic_rows(inertia: str) -> tuple[AngleEquation, AngleEquation]:
    """Split the derived equations (15), (16) into coefficients of the accelerations."""
    rows = []
    for left, second in zip(contribution(inertia).rows, angle_acceleration, strict=True):
        zero = dict.fromkeys((*ACCELERATIONS, *angle_acceleration), sp.S.Zero)
        *parts, own = gradient(left, (*ACCELERATIONS, second))
        force, moment = (sp.Matrix([_shorten(e) for e in parts[k : k + 3]]) for k in (0, 3))
        rows.append(AngleEquation(_shorten(own), force, moment, _shorten(left.xreplace(zero), turned=True)))
    return rows[0], rows[1]


def _shorten(expr: Expr, turned: bool = False) -> Expr:
    """Simplify with sin^2 + cos^2 = 1; if `turned`, use the rates W_t and W_n of the pendulum's frame."""
    S, C = sp.sin(theta), sp.cos(theta)
    if turned:
        along, across = sp.symbols("W_t W_n", real=True)
        in_plane = {rate[1]: S * along + C * across, rate[2]: C * along - S * across}
        expr = _shorten(expr.xreplace(in_plane))
        return expr.xreplace({along: rate[1] * S + rate[2] * C, across: rate[1] * C - rate[2] * S})
    for keep, drop in ((sp.cos(theta), sp.sin(theta)), (sp.sin(phi), sp.cos(phi))):
        powers = {drop**n: (1 - keep**2) ** (n // 2) * drop ** (n % 2) for n in range(2, 7)}
        expr = expanded(expanded(expr).xreplace(powers))
    return expr


def angle_rows(pendulums: Sequence[Pendulum], inertia: str, d: Derivation) -> tuple[AngleRow, ...]:
    """Name the coefficients in the equations of phi_i and theta_i, pendulum by pendulum."""
    generic = generic_rows(inertia)
    rows = []
    for k, pendulum in enumerate(pendulums, 1):
        names = instance(pendulum, k)
        for text, spelled, row, speed in zip(
            ("phi", "theta"), (r"\varphi", r"\theta"), generic, (phi_rate, theta_rate), strict=True
        ):
            latex = f"{spelled}_{{{k}}}"
            named = _named(row, names, f"{text}{k}", latex, d)
            rows.append(AngleRow(f"{text}{k}", latex, pendulum, names[speed], named, row, names))
    return tuple(rows)


def _named(row: AngleEquation, names: dict[sp.Symbol, Expr], angle: str, spelled: str, d: Derivation) -> AngleEquation:
    """Return an equation (25) or (26) of an angle with its coefficients as named definitions."""
    number = "(25)" if angle.startswith("phi") else "(26)"

    def name(text: str, value: Expr, title: str, unit: str) -> Expr:
        plain = value.xreplace(names)
        if plain.is_number:
            return plain
        return d.define(f"{text}_{angle}", plain, number, f"{title} {angle}", unit, rf"{text}^{{{spelled}}}")

    return AngleEquation(
        name("D", row.inertia, "inertia of", "kg m^2"),
        sp.Matrix(
            [
                name(f"g{axis}", e, f"a_{axis} in the equation of", "kg m")
                for axis, e in zip("xyz", row.force, strict=True)
            ]
        ),
        sp.Matrix(
            [
                name(f"c{axis}", e, f"Omega'_{axis} in the equation of", "kg m^2")
                for axis, e in zip("xyz", row.moment, strict=True)
            ]
        ),
        name("k", row.bias, "velocity terms of", "N m"),
    )


def longitudinal(thrust: Expr, left: Expr, d: Derivation) -> Expr:
    """Solve (9) at the equilibrium (18) for a_x, which is (19).

    Parameters
    ----------
    thrust : Expr
        F, along x without gimbal angles, N.
    left : Expr
        Left side of (9) with zero rates and straight pendulums, linear in a_x.
    d : Derivation
        Receives the steps.
    """
    d.section("Equilibrium")
    axial = acceleration[0]
    d.show("0", left - thrust, "(18)", "balance of forces along x at the equilibrium", "N")
    return d.define(
        "ax_eq", thrust / left.diff(axial), "(19)", "longitudinal acceleration at the equilibrium", "m/s^2", "a_x"
    )


def angle_accelerations(rows: Sequence[AngleRow], linear: Sequence[Expr], angular: Sequence[Expr]) -> tuple[Expr, ...]:
    """Solve (25), (26) for phi_i'' and theta_i'' with given a and Omega'."""
    accelerations = []
    for angle in rows:
        row = angle.row
        total = row.force.dot(sp.Matrix(linear)) + row.moment.dot(sp.Matrix(angular)) + row.bias
        accelerations.append(-total / row.inertia)
    return tuple(accelerations)


def reduced_velocity(axial: Expr, inputs: Sequence[Expr]) -> tuple[Expr, ...]:
    """Return V' of (20), (21), and v_x' from a = (a_x, u1, u2) by (17)."""
    linear = sp.Matrix([axial, *inputs[:2]]) - rate.cross(velocity)
    return tuple(linear)


def show_reduced(pendulum: Sequence[tuple[str, str, Expr]], d: Derivation) -> None:
    """Show (20)-(26).

    Parameters
    ----------
    pendulum : sequence of (str, str, Expr)
        Left side, number and right side of the equations of pendulum i, in the accelerations of O and of the axes.
    d : Derivation
        Receives the steps.
    """
    d.section("Reduced model")
    axial = sp.Symbol("a_x", real=True)
    for name, entry, number in zip("xyz", reduced_velocity(axial, demand), ("(20)", "(20)", "(21)"), strict=True):
        d.show(rf"\dot v_{name}", entry, number if name != "x" else "", f"reduced model: v_{name}", "m/s^2")
    for k in range(3):
        d.show(rf"\dot\Omega_{k + 1}", demand[2 + k], f"({22 + k})", "reduced model: body rate", "rad/s^2")
    inputs = dict(zip((*acceleration[1:], *ACCELERATIONS[3:]), demand, strict=True))
    for left, number, right in pendulum:
        d.show(left, right.xreplace(inputs), number, "reduced model: pendulum i", "rad/s^2")


def generic_accelerations(inertia: str) -> tuple[Expr, Expr]:
    """Return phi_i'' and theta_i'' for given a and Omega', in generic symbols: (25), (26)."""
    linear, angular = sp.Matrix(acceleration), sp.Matrix(ACCELERATIONS[3:])
    first, second = (
        -(row.force.dot(linear) + row.moment.dot(angular) + row.bias) / row.inertia for row in generic_rows(inertia)
    )
    return first, second
