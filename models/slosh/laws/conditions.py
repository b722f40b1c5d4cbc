# SPDX-License-Identifier: Apache-2.0
"""Conditions on parameters and initial states before a run, with messages."""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from ...system import Condition, Expr, Group, Quantity
from ..states import Pendulum


def constraints(p: Group, scenario: Group) -> tuple[Condition, ...]:
    """Return the conditions on parameters and initial state."""
    triangle = Condition(
        sp.Min(p.J_y + p.J_z - p.J_x, p.J_z + p.J_x - p.J_y, p.J_x + p.J_y - p.J_z),
        "J_x = {J_x:g}, J_y = {J_y:g}, J_z = {J_z:g} kg m^2 are no moments of inertia of a body: "
        "each must be smaller than the other two together",
    )
    return (triangle, *(_in_radians(q) for q in scenario if q.unit == "rad"))


def _in_radians(angle: Quantity) -> Condition:
    name = angle.name
    return Condition(
        2 * sp.pi - sp.Abs(angle.symbol),
        f"{name} = {{{name}:g}} rad is more than a full turn; angles are given in radians (30 degrees are 0.5236 rad)",
    )


def law_constraints(
    name: str, p: Group, c: Group, pendulums: Sequence[Pendulum], inertia: str
) -> tuple[Condition, ...]:
    """Return the conditions of a law: sufficient thrust and, for V1, an invertible matrix f of (29)."""
    thrust = Condition(
        p.F, f"F = {{F:g}} N: {name} steers by the direction of the thrust and divides by F; it must be positive"
    )
    if name == "lyapunov-v2":
        return (thrust,)
    bound = sp.Add(*(_largest_correction(bob, inertia, c) for bob in pendulums))
    weights = "r9 = {r9:g} s^2/kg is" if inertia == "ball" else "r9 = {r9:g}, r10 = {r10:g} s^2/kg are"
    message = (
        f"{weights} too large beside "
        "r4 = {r4:g}, r6 = {r6:g}, r8 = {r8:g} s^2/rad^2: "
        "the matrix f of (29) may lose its inverse"
    )
    return (thrust, Condition(sp.Min(c.r4, c.r6, c.r8) - bound, message))


def _largest_correction(bob: Pendulum, inertia: str, c: Group) -> Expr:
    """Return a bound on a pendulum's effect on the eigenvalues of f, the sum of m r |c|^2/D^2 with D_theta >= I."""
    whole = bob.mass * bob.length**2 + bob.inertia
    if inertia == "ball":
        return bob.mass * c.r9 * (1 + bob.mass * bob.length * sp.Abs(bob.pivot) / whole) ** 2
    swing = bob.mass * bob.length * (bob.length + sp.Abs(bob.pivot)) + bob.inertia
    of_phi = c.r9 * (swing**2 + bob.inertia**2) / whole**2
    of_theta = c.r10 * (swing**2 + whole**2) / bob.inertia**2
    return bob.mass * (of_phi + of_theta)
