# SPDX-License-Identifier: Apache-2.0
"""A pendulum described by angles, in a frame of its own.

Its axes are e_x, e_t = (0, S, C) through the bob and e_n = (0, C, -S). In it s = -c e_x + s e_t is the direction of the
arm, e_phi = s e_x + c e_t that of phi and e_n that of theta. Body rates are W_n, W_t, and w = W1 - theta'; p = phi' +
W_n and nu = -(c W_t + s w) turn the arm, chi = c w - s W_t spins it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp

from ...system import Derivation, Expr
from ..states import Pendulum, angle_quantities, angle_rate_quantities, rate
from .hull import SIZE, Arm, Lump


@dataclass(frozen=True)
class Swing:
    """Named quantities of one pendulum at a state.

    Attributes
    ----------
    s, c, S, C : Expr
        Sines and cosines of phi and theta.
    phi_rate, theta_rate : Expr
        rad/s.
    wn, wt, w, p, chi : Expr
        Rates in the pendulum's frame and of the arm, rad/s.
    nu_chi, squared : Expr
        nu chi and p^2 + nu^2, rad^2/s^2.
    """

    s: Expr
    c: Expr
    S: Expr
    C: Expr
    phi_rate: Expr
    theta_rate: Expr
    wn: Expr
    wt: Expr
    w: Expr
    p: Expr
    chi: Expr
    nu_chi: Expr
    squared: Expr


def swing_of(k: int, d: Derivation) -> Swing:
    """Name the sines, cosines and rates of pendulum k."""
    phi, theta = (q.symbol for q in angle_quantities(k))
    phi_rate, theta_rate = (q.symbol for q in angle_rate_quantities(k))

    def name(text: str, value: Expr, title: str, unit: str, latex: str) -> sp.Symbol:
        return d.define(f"{text}{k}", value, title=f"{title} {k}", unit=unit, latex=latex)

    s = name("sin_phi", sp.sin(phi), "sine of phi", "1", rf"s_{k}")
    c = name("cos_phi", sp.cos(phi), "cosine of phi", "1", rf"c_{k}")
    S = name("sin_theta", sp.sin(theta), "sine of theta", "1", rf"S_{k}")
    C = name("cos_theta", sp.cos(theta), "cosine of theta", "1", rf"C_{k}")
    w1, w2, w3 = rate
    wn = name("Wn", w2 * C - w3 * S, "body rate across the plane of arm", "rad/s", rf"W_{{n{k}}}")
    wt = name("Wt", w2 * S + w3 * C, "body rate along the azimuth of arm", "rad/s", rf"W_{{t{k}}}")
    w = name("w_x", w1 - theta_rate, "roll rate of the plane of arm", "rad/s", rf"w_{k}")
    p = name("p", phi_rate + wn, "inertial rate of arm in its plane,", "rad/s", rf"p_{k}")
    nu = name("nu", -(c * wt + s * w), "inertial rate across its plane of arm", "rad/s", rf"\nu_{k}")
    chi = name("chi", c * w - s * wt, "spin of arm", "rad/s", rf"\chi_{k}")
    return Swing(
        s,
        c,
        S,
        C,
        phi_rate,
        theta_rate,
        wn,
        wt,
        w,
        p,
        chi,
        name("nu_chi", nu * chi, "product of rates of arm", "rad^2/s^2", rf"\nu_{k}\chi_{k}"),
        name("sigma_sq", p**2 + nu**2, "squared rate of arm", "rad^2/s^2", rf"|\sigma_{k}|^2"),
    )


class Namer:
    """Names expressions of one pendulum."""

    def __init__(self, k: str, swing: Swing, d: Derivation) -> None:
        self.k, self.swing, self._d = k, swing, d

    def __call__(self, text: str, value: Expr, title: str = "product", unit: str = "1", latex: str = "") -> Expr:
        """Define an expression under this text and the number of the pendulum."""
        return self._d.define(f"{text}{self.k}", value, title=f"{title}, pendulum {self.k}", unit=unit, latex=latex)


def in_body(radial: Sequence[Expr], along: Sequence[Expr], across: Sequence[Expr], name: Namer) -> sp.Matrix:
    """Turn a pendulum's matrix from its frame to body axes.

    Parameters
    ----------
    radial : sequence of Expr
        Entries x-x, x-t and x-G_t.
    along, across : sequence of Expr
        Entries t-t, t-G_t, G_t-G_t and n-n, n-G_n, G_n-G_n.
    name : callable
        Names an expression.
    """
    S, C = name.swing.S, name.swing.C
    S_squared, SC = name("S_sq", S**2), name("SC", S * C)
    matrix = sp.zeros(SIZE, SIZE)
    matrix[0, 0] = radial[0]
    for row, entry in ((1, radial[1]), (4, radial[2])):
        matrix[row, 0], matrix[row + 1, 0] = entry * S, entry * C
    for (row, column), t, n in zip(((1, 1), (4, 1), (4, 4)), along, across, strict=True):
        difference = name(f"tn{row}{column}_", t - n)
        mixed = difference * SC
        matrix[row, column] = n + difference * S_squared
        matrix[row + 1, column + 1] = t - difference * S_squared
        matrix[row + 1, column] = mixed
        if row > column:
            matrix[row, column + 1] = mixed
    return matrix


def bias_in_body(force: Sequence[Expr], turning: Sequence[Expr], roll: Expr, name: Namer) -> list[Expr]:
    """Turn force (x, t, n) and the terms of (G_t, G_n) to body axes and put them in the order of the unknowns."""
    S, C = name.swing.S, name.swing.C
    (ft, fn), (gt, gn) = force[1:], turning
    return [force[0], S * ft + C * fn, C * ft - S * fn, roll, S * gt + C * gn, C * gt - S * gn]


def along_arm(a: Pendulum, arm: Arm, hull: Lump, name: Namer) -> tuple[Expr, Expr, list[Expr], list[Expr]]:
    """Return what the arm's tension adds: reaction at rest of the unknowns, e G_x, and entries x-. and t-.."""
    swing = name.swing
    lead = name("eG1_", arm.lever * hull.g1, "centripetal acceleration of the pivot", "m/s^2")
    pull = name(
        "tension",
        -(arm.moving * swing.c * lead + a.mass * a.length * swing.squared),
        "force along the arm",
        "N",
    )
    As = name("As_", arm.moving * swing.s)
    Ass, Asc = name("Ass_", As * swing.s), name("Asc_", As * swing.c)
    eAss = name("eAss_", arm.lever * Ass)
    return lead, pull, [arm.moving - Ass, -Asc, -arm.lever * Asc], [Ass, eAss, arm.lever * eAss]


def at_centre(swing: Swing, unknown: Sequence[Expr]) -> tuple[Expr, Expr, Expr, Expr]:
    """Return a_t, a_n of C and G_t, G_n."""
    (_, a2, a3, _, g2, g3), S, C = unknown, swing.S, swing.C
    return S * a2 + C * a3, C * a2 - S * a3, S * g2 + C * g3, C * g2 - S * g3


def phi_acceleration(
    a: Pendulum, arm: Arm, unknown: Sequence[Expr], along: Expr, turning: Expr, moment: Expr, name: Namer
) -> Expr:
    """Solve the equation of phi for p' + nu chi, given its moment without the acceleration of the pivot."""
    swing = name.swing
    k = a.name
    lead = sp.Symbol(f"eG1_{k}", real=True)
    pivot = swing.s * (unknown[0] + lead) + swing.c * (along + arm.lever * turning)
    return -(arm.ratio * pivot + moment / arm.total)
