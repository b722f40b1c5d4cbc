# SPDX-License-Identifier: Apache-2.0
"""Positions and velocities of the masses in axes along rod 3, from rod lengths, rod rates and angular momentum.

Mass 1 is the origin, mass 2 lies on the first axis and mass 3 above it. Two positions X, V of the plane are sufficient.
The rotation follows from the angular momentum H = sum m_i X_i x X_i', which is linear in the rate of these axes.
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from ...derivation import vector
from ...mechanics import QUARTER_TURN, matrix_rate, planar_cross, time_derivative
from ...system import Derivation, Expr
from .bodies import ENDS, Bodies
from .states import MOMENTUM, lengths, rates


@dataclass(frozen=True)
class Motion:
    """The three rods as vectors in axes along rod 3.

    Attributes
    ----------
    bodies : Bodies
        The bodies with mass.
    places : tuple of Matrix
        X_i from the centre of mass.
    rods : tuple of Matrix
        D_k.
    inertia : Expr
        Moment of inertia about the centre of mass.
    turns : tuple of Expr
        Angular rate of each rod in the plane; the third is the rate of the axes.
    cosines : tuple of Expr
        Cosine of the angle at each mass.
    """

    bodies: Bodies
    places: tuple[sp.Matrix, ...]
    rods: tuple[sp.Matrix, ...]
    inertia: Expr
    turns: tuple[Expr, ...]
    cosines: tuple[Expr, ...]


def motion(bodies: Bodies, d: Derivation) -> Motion:
    """Return the masses' positions from the rod lengths, and their rotation from the angular momentum."""
    d.section("Masses in axes along rod 3")
    apex, apex_rate = _apex(d)
    corners = (sp.zeros(2, 1), sp.Matrix([lengths[2], 0]), sp.Matrix(apex))
    lumps, reduced = bodies.lumps, bodies.reduced
    centre = (lumps[1] * corners[1] + lumps[2] * corners[2]) / bodies.total
    rods = tuple(corners[j] - corners[i] for i, j in ENDS)
    moving = dict(zip((*apex, lengths[2]), (*apex_rate, rates[2]), strict=True))
    turn = sp.Symbol("turn")
    velocities = [matrix_rate(rod, moving) + turn * QUARTER_TURN * rod for rod in rods]
    momentum = sp.Add(*(m * planar_cross(r, v) for m, r, v in zip(reduced, rods, velocities, strict=True)))
    inertia = d.define(
        "inertia",
        sp.Add(*(m * length**2 for m, length in zip(reduced, lengths, strict=True))),
        title="moment of inertia about the centre of mass",
        latex="I",
        positive=True,
    )
    still = sp.expand(momentum).coeff(turn, 0)
    omega = d.define("omega", (MOMENTUM.symbol - still) / inertia, "(7)", "rate of rod 3", "rad/s", r"\omega_3")
    turns = [planar_cross(rods[k], velocities[k].subs(turn, 0)) / lengths[k] ** 2 + omega for k in (0, 1)]
    first = vector("turn*", turns, "rate of rod *", "rad/s", r"\omega_*", d, labels="12")
    between = [-rods[j].dot(rods[k]) / (lengths[j] * lengths[k]) for j, k in ENDS]
    title, latex = "cosine of the angle at mass *", r"\cos\alpha_*"
    cosines = tuple(vector("cos*", between, title, "", latex, d, "(16)", "123"))
    places = tuple(corner - centre for corner in corners)
    return Motion(bodies, places, rods, inertia, (*first, omega), cosines)


def _apex(d: Derivation) -> tuple[tuple[Expr, Expr], tuple[Expr, Expr]]:
    """Solve |X_3 - X_1| = l_2, |X_3 - X_2| = l_1 for the position of mass 3, and their derivatives for its velocity."""
    l1, l2, l3 = lengths
    x, y, x_rate, y_rate = sp.symbols("apex_x apex_y apex_x' apex_y'", real=True)
    circles = (x**2 + y**2 - l2**2, (x - l3) ** 2 + y**2 - l1**2)
    along = sp.solve(sp.expand(circles[0] - circles[1]), x)[0]
    along = d.define("apex_x", along, "(16)", "place of mass 3 along rod 3, from mass 1", latex="x_3")
    across = d.define(
        "apex_y", sp.sqrt(l2**2 - along**2), "(16)", "place of mass 3 across rod 3", latex="y_3", positive=True
    )
    moving = {x: x_rate, y: y_rate, **dict(zip(lengths, rates, strict=True))}
    balance = [time_derivative(circle, moving) for circle in (circles[0], circles[0] - circles[1])]
    first = sp.solve(sp.expand(balance[1]), x_rate)[0].subs(x, along)
    first = d.define("apex_x_rate", first, title="velocity of mass 3 along rod 3, seen from mass 1", latex="x_3'")
    second = sp.solve(balance[0], y_rate)[0].subs({x: along, y: across, x_rate: first})
    second = d.define("apex_y_rate", second, title="velocity of mass 3 across rod 3", latex="y_3'")
    return (along, across), (first, second)
