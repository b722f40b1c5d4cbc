# SPDX-License-Identifier: Apache-2.0
"""Equations of motion (1)-(17) for any number of pendulums, with energy and momentum.

The kinetic energy is a sum over hull, fixed fuel and pendulums, so each part is derived once and the pendulum's part is
copied for every pendulum. The derived equations are implicit and linear in the accelerations. The right-hand side
uses another form (fast/), which generation checks against them.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence

import sympy as sp

from ...mechanics import kirchhoff
from ...system import Derivation, Expr, Group
from ..states import GIMBALS, MOMENTS, rate, velocity
from .pendulum import Contribution, acceleration, angular_acceleration, frame_rates, galilean

ACCELERATIONS = (*acceleration, *angular_acceleration)
GIMBAL_ANGLES = tuple(q.symbol for q in GIMBALS)


def thrust(p: Group, angles: Sequence[Expr] = GIMBAL_ANGLES) -> sp.Matrix:
    """Return tau_t, the thrust in body axes for two gimbal angles, N; its magnitude is always F."""
    d1, d2 = angles
    return p.F * sp.Matrix([sp.cos(d1) * sp.cos(d2), sp.sin(d2), -sp.sin(d1) * sp.cos(d2)])


def gimbal_position(p: Group) -> sp.Matrix:
    """Return r_F, the point on the x axis where the thrust acts, m."""
    return sp.Matrix([-(p.b + p.d), 0, 0])


def applied_wrench(p: Group) -> sp.Matrix:
    """Return tau_t and tau_r about O, the right sides of (9)-(14)."""
    force = thrust(p)
    moment = sp.Matrix([q.symbol for q in MOMENTS]) + gimbal_position(p).cross(force)
    return sp.Matrix([*force, *moment])


def hull_energy(p: Group) -> Expr:
    """Return the kinetic energy of hull and fixed fuel, the first terms of (5)."""
    hull = velocity + rate.cross(sp.Matrix([-p.b, 0, 0]))
    fuel = velocity + rate.cross(sp.Matrix([-p.h0, 0, 0]))
    inertia = sp.diag(p.J_x + p.I0, p.J_y + p.I0, p.J_z + p.I0)
    return p.m * hull.dot(hull) / 2 + p.m0 * fuel.dot(fuel) / 2 + rate.dot(inertia * rate) / 2


def whole(own: Sequence[Expr], part: Sequence[Expr], copies: Sequence[Mapping[sp.Symbol, Expr]]) -> tuple[Expr, ...]:
    """Add one copy per pendulum of the generic contribution to that of hull and fixed fuel."""
    return tuple(
        sp.Add(mine, *(entry.xreplace(dict(copy)) for copy in copies)) for mine, entry in zip(own, part, strict=True)
    )


def hull_momentum(p: Group) -> tuple[Expr, ...]:
    """Return dT/dV, kg m/s, and dT/dOmega about O, kg m^2/s, of hull and fixed fuel."""
    energy = hull_energy(p)
    return tuple(energy.diff(symbol) for symbol in (*velocity, *rate))


@functools.cache
def hull_wrench(p: Group) -> tuple[Expr, ...]:
    """Return the hull's and fixed fuel's terms on the left sides of (9)-(14)."""
    force, moment = (galilean(side) for side in kirchhoff(hull_energy(p), velocity, rate, frame_rates()))
    return (*force, *moment)


def accelerations_of(k: int) -> tuple[sp.Symbol, sp.Symbol]:
    """Return the symbols of the angular accelerations of pendulum k."""
    return sp.Symbol(f"phi{k}_ddot", real=True), sp.Symbol(f"theta{k}_ddot", real=True)


def velocity_accelerations(rates: Mapping[sp.Symbol, Expr]) -> dict[sp.Symbol, Expr]:
    """Return a = V' + Omega x V (17) and Omega' from the rates of V and Omega."""
    linear = sp.Matrix([rates[v] for v in velocity]) + rate.cross(velocity)
    return dict(zip(ACCELERATIONS, (*linear, *(rates[w] for w in rate)), strict=True))


_BALANCES = (
    ("F_x", "(9)", "balance of forces along x", "N"),
    ("F_y", "(10)", "balance of forces along y", "N"),
    ("F_z", "(11)", "balance of forces along z", "N"),
    ("M_x", "(12)", "balance of moments about x", "N m"),
    ("M_y", "(13)", "balance of moments about y", "N m"),
    ("M_z", "(14)", "balance of moments about z", "N m"),
)


def show_equations(p: Group, part: Contribution, rows: Sequence[tuple[str, Expr]], d: Derivation) -> None:
    """Show the derivation: energy, dissipation and equations of motion with their numbers.

    A pendulum's terms appear once, with index i; the balances contain their sums over i.

    Parameters
    ----------
    p : Group
        Parameters of the plant.
    part : Contribution
        A pendulum's part, in generic symbols.
    rows : sequence of (str, Expr)
        Number and left side of the pendulum's own equations.
    d : Derivation
        Receives the steps.
    """
    d.section("Energy and dissipation")
    for axis, entry in zip("xyz", part.position, strict=True):
        d.show(rf"{axis}_i", entry, "(7)", f"position of bob i from O, {axis}", "m")
    total = sp.Symbol(r"\sum_{i} T_{i}", real=True)
    d.show("T", hull_energy(p) + total, "(5), (6)", "kinetic energy of hull, fixed fuel and pendulums", "J")
    d.show("T_i", part.energy, "(5), (6)", "kinetic energy of pendulum i", "J")
    d.show("R_i", part.dissipation, "(8)", "Rayleigh function of pendulum i", "W")
    d.section("Equations of motion")
    for place, (axis, entry) in enumerate(zip("xyz", acceleration, strict=True)):
        spelled = sp.Symbol(rf"\dot v_{axis}", real=True) + rate.cross(velocity)[place]
        d.show(sp.latex(entry), spelled, "(17)", f"acceleration of O along {axis}", "m/s^2")
    own, right = hull_wrench(p), applied_wrench(p)
    parts = (*part.force, *part.moment)
    for k, (name, number, title, unit) in enumerate(_BALANCES):
        d.show(f"{name}^{{(i)}}", parts[k], number, f"{title}: terms of pendulum i", unit)
        terms = sp.Symbol(rf"\sum_{{i}} {name}^{{(i)}}", real=True)
        d.show("0", own[k] + terms - right[k], number, title, unit)
    for number, row in rows:
        d.show("0", row, number, "equation of pendulum i", "N m")
