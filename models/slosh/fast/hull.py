# SPDX-License-Identifier: Apache-2.0
"""Symmetric 6 x 6 equations of the hull for pendulums described by angles.

The force of a pendulum on its pivot is that of a constant mass m I/D, with D = m l^2 + I, plus terms that depend on
its direction. Constant masses, hull and fixed fuel form the lump, whose centre of mass C is at x_C. The unknowns are
the acceleration a_C of C, the roll acceleration and two components of G = Omega' x e_x + Omega x (Omega x e_x), so
that every point of the x axis has the acceleration a_C + (x - x_C) G. In these unknowns the matrix of the lump is
diagonal and constant.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp

from ...derivation import vector
from ...system import Derivation, Expr, Group
from ..plant.equations import gimbal_position, thrust
from ..states import INPUTS, Pendulum, rate, velocity
from .linear import Factors

ROWS = "123456"
"""Unknowns: a_C along x, y, z; roll acceleration; G_y; G_z."""
SIZE = len(ROWS)


@dataclass(frozen=True)
class Lump:
    """Hull, fixed fuel, the pendulums' constant masses, and the terms common to all evaluations.

    Attributes
    ----------
    mass, centre : Expr
        kg; x_C, m.
    inertia : tuple of Expr
        Moments of inertia that go with the roll acceleration, G_y (about z) and G_z (about y), kg m^2.
    g1 : Expr
        G_x = -(W2^2 + W3^2), 1/s^2.
    xy, xz : Expr
        W1 W2 and W1 W3, 1/s^2.
    gyration : tuple of (Expr, Expr)
        Velocity terms in the equations of roll, G_y and G_z: a constant and a product of rates.
    applied : tuple of Expr
        Force, roll moment, and moments about C in the order of G_y and G_z.
    """

    mass: Expr
    centre: Expr
    inertia: tuple[Expr, Expr, Expr]
    g1: Expr
    xy: Expr
    xz: Expr
    gyration: tuple[tuple[Expr, Expr], ...]
    applied: tuple[Expr, ...]


@dataclass(frozen=True)
class Arm:
    """Constants of one pendulum.

    Attributes
    ----------
    total : Expr
        D = m l^2 + I, kg m^2.
    ratio : Expr
        m l/D, 1/m.
    lumped, moving : Expr
        m I/D and m^2 l^2/D: the share of m that acts as a mass at the pivot, and the remainder, kg.
    lever : Expr
        Pivot from C, m.
    """

    total: Expr
    ratio: Expr
    lumped: Expr
    moving: Expr
    lever: Expr


def lump(p: Group, pendulums: Sequence[Pendulum], geared: bool, d: Derivation) -> tuple[Lump, tuple[Arm, ...]]:
    """Combine the constant masses and define terms of parameters, rates and inputs only.

    Parameters
    ----------
    p : Group
        Parameters of the plant.
    pendulums : sequence of Pendulum
        Parameters of each.
    geared : bool
        The paper's inertia terms: the bobs' y inertia turns with the hull.
    d : Derivation
        Receives the steps.
    """
    constants = [_constants(pendulum, d) for pendulum in pendulums]
    mass = d.define(
        "M_C", p.m + p.m0 + sp.Add(*(c[2] for c in constants)), title="mass of the lump", unit="kg", latex="M_C"
    )
    first = sp.Add(*(c[2] * pendulum.pivot for c, pendulum in zip(constants, pendulums, strict=True)))
    centre = d.define(
        "x_C", (first - p.m * p.b - p.m0 * p.h0) / mass, title="centre of mass of the lump", unit="m", latex="x_C"
    )
    second = sp.Add(*(c[2] * pendulum.pivot**2 for c, pendulum in zip(constants, pendulums, strict=True)))
    transfer = d.define(
        "S_C",
        p.m * p.b**2 + p.m0 * p.h0**2 + second - mass * centre**2,
        title="second moment of the lump's masses about C",
        unit="kg m^2",
        latex="S_C",
    )
    turning = sp.Add(*(pendulum.inertia for pendulum in pendulums)) if geared else sp.S.Zero
    about_y, about_z = p.J_y + p.I0 + turning, p.J_z + p.I0
    inertia = (
        d.define("J_C1", p.J_x + p.I0, title="roll inertia", unit="kg m^2", latex="J_{C,1}"),
        d.define("J_C3", about_z + transfer, title="inertia that goes with G_y", unit="kg m^2", latex="J_{C,3}"),
        d.define("J_C2", about_y + transfer, title="inertia that goes with G_z", unit="kg m^2", latex="J_{C,2}"),
    )
    w1, w2, w3 = rate
    g1 = d.define("G1", -(w2**2 + w3**2), title="G along x", unit="1/s^2", latex="G_x")
    xy = d.define("W12", w1 * w2, title="product of rates", unit="rad^2/s^2", latex=r"\Omega_1\Omega_2")
    xz = d.define("W13", w1 * w3, title="product of rates", unit="rad^2/s^2", latex=r"\Omega_1\Omega_3")
    gyration = (
        (p.J_z - p.J_y, w2 * w3),
        (p.J_y - p.J_x - about_z, xy),
        (p.J_z - p.J_x - about_y, xz),
    )
    arms = tuple(
        Arm(*c, d.define(f"e{a.name}", a.pivot - centre, title=f"pivot {a.name} from C", unit="m", latex=f"e_{a.name}"))
        for c, a in zip(constants, pendulums, strict=True)
    )
    return Lump(mass, centre, inertia, g1, xy, xz, gyration, _applied(p, centre, d)), arms


def _constants(a: Pendulum, d: Derivation) -> tuple[Expr, Expr, Expr, Expr]:
    k = a.name
    total = d.define(
        f"D{k}",
        a.mass * a.length**2 + a.inertia,
        title=f"inertia of pendulum {k} about its pivot",
        unit="kg m^2",
        latex=f"D_{k}",
        positive=True,
    )
    ratio = d.define(
        f"k{k}", a.mass * a.length / total, title=f"m l/D of pendulum {k}", unit="1/m", latex=f"k_{k}", positive=True
    )
    lumped = d.define(
        f"me{k}",
        a.mass * a.inertia / total,
        title=f"part of mass {k} that stays with its pivot",
        unit="kg",
        latex=f"m'_{k}",
    )
    moving = d.define(
        f"mv{k}", a.mass * a.length * ratio, title=f"part of mass {k} that swings", unit="kg", latex=f"m''_{k}"
    )
    return total, ratio, lumped, moving


def _applied(p: Group, centre: Expr, d: Derivation) -> tuple[Expr, ...]:
    f1, f2, f3 = vector("f_*", thrust(p), "thrust", "N", r"\tau_{t,*}", d)
    lever = gimbal_position(p)[0] - centre
    lever = d.define("r_FC", lever, title="gimbal from C", unit="m", latex="r_{FC}")
    return f1, f2, f3, INPUTS.Mx, INPUTS.Mz + lever * f2, -INPUTS.My + lever * f3


@dataclass(frozen=True)
class Pull:
    """Contribution of one pendulum to the hull's equations, without its constant mass.

    Attributes
    ----------
    matrix : sympy.Matrix
        Its symmetric matrix, lower triangle, over the six unknowns.
    bias : tuple of Expr
        Its six terms without accelerations.
    """

    matrix: sp.Matrix
    bias: tuple[Expr, ...]


@dataclass(frozen=True)
class Balance:
    """The hull's equations, K X + n = applied forces and torques.

    Attributes
    ----------
    matrix : sympy.Matrix
        K, symmetric; entries are symbols or structural zeros.
    bias : tuple of Expr
        n.
    """

    matrix: sp.Matrix
    bias: tuple[Expr, ...]


@dataclass(frozen=True)
class Dynamics:
    """Accelerations, and the hull's equations, with which laws invert them.

    Attributes
    ----------
    centre : Expr
        C on the x axis, whose acceleration a_C is an unknown, m.
    products : tuple of Expr
        Differences of G_y from Omega_z' and of G_z from -Omega_y', 1/s^2.
    direct : bool
        True if Omega_z' and -Omega_y' are the unknowns in place of G_y and G_z.
    balance : Balance
        K X + n = applied.
    factors : Factors
        Factors of K's leading block, which belongs to a_C.
    linear, angular, acceleration : tuple of Expr
        V', Omega' and the acceleration a of O.
    bobs : tuple of Expr
        Accelerations of all pendulums in order.
    """

    centre: Expr
    products: tuple[Expr, Expr]
    direct: bool
    balance: Balance
    factors: Factors
    linear: tuple[Expr, ...]
    angular: tuple[Expr, ...]
    acceleration: tuple[Expr, ...]
    bobs: tuple[Expr, ...]


def balance(hull: Lump, pulls: Sequence[Pull], d: Derivation) -> Balance:
    """Add the terms of the lump and of the pendulums."""
    diagonal = (hull.mass,) * 3 + hull.inertia
    matrix = sp.zeros(SIZE, SIZE)
    for i in range(SIZE):
        for j in range(i + 1):
            own = diagonal[i] if i == j else sp.S.Zero
            entry = sp.Add(own, *(pull.matrix[i, j] for pull in pulls))
            if entry is not sp.S.Zero:
                place = ROWS[i] + ROWS[j]
                entry = d.define(f"K{place}", entry, title="entry of the hull's matrix", latex=f"K_{{{place}}}")
            matrix[i, j] = matrix[j, i] = entry
    own_bias = (sp.S.Zero,) * 3 + tuple(factor * product for factor, product in hull.gyration)
    bias = [sp.Add(own, *terms) for own, *terms in zip(own_bias, *(pull.bias for pull in pulls), strict=True)]
    return Balance(matrix, tuple(vector("n*", bias, "terms without accelerations", "", "n_*", d, labels=ROWS)))


def velocity_rates(unknown: Sequence[Expr], hull: Lump) -> tuple[tuple[Expr, ...], tuple[Expr, ...], tuple[Expr, ...]]:
    """Return V', Omega' and the acceleration a of O from the six unknowns."""
    w1, w2, w3 = rate
    vx, vy, vz = velocity
    g = (hull.g1, unknown[4], unknown[5])
    acceleration = tuple(a - hull.centre * turn for a, turn in zip(unknown[:3], g, strict=True))
    turning = (w2 * vz - w3 * vy, w3 * vx - w1 * vz, w1 * vy - w2 * vx)
    linear = tuple(a - term for a, term in zip(acceleration, turning, strict=True))
    return linear, (unknown[3], hull.xz - unknown[5], unknown[4] - hull.xy), acceleration
