# SPDX-License-Identifier: Apache-2.0
"""Section 2 of the triangle's paper: equations (1)-(23) and Table 1, as printed."""

from __future__ import annotations

import sympy as sp

from models.paper import Printed, Relation, printed
from models.triangle.paper.symbols import ROOT3, Kinematics

HALF, THIRD = sp.Rational(1, 2), sp.Rational(1, 3)


def rods(k: Kinematics) -> tuple[Printed, ...]:
    """(19)-(23): shape by rod lengths, rod lengths by shape, rates."""
    l1, l2, l3 = k.l
    rho, phi, mu = k.rho, k.phi, k.mu
    root = sp.sqrt(1 - rho**2)
    each = tuple({k.l_i: k.l[i], k.u_i: k.u[i], k.delta_i: k.delta[i]} for i in range(3))
    area = 2 * (l1**2 * l2**2 + l2**2 * l3**2 + l3**2 * l1**2) - (l1**4 + l2**4 + l3**4)
    slope = ROOT3 * (l1**2 - l2**2) / (2 * l3**2 - l1**2 - l2**2)
    along = mu / (3 * k.l_i) * (1 - 2 * rho**2) / root * sp.cos(phi + k.delta_i) * k.w1
    across = mu / (3 * k.l_i) * rho * root * sp.sin(phi + k.delta_i) * k.w2
    growth = k.l_i / (2 * mu) * k.w3
    return (
        printed(
            "19",
            "shape from the rod lengths",
            "equation",
            Relation(mu, l1**2 + l2**2 + l3**2),
            Relation(k.eta, area),
            Relation(rho**2, 1 - ROOT3 * k.eta / mu, corrected=HALF * (1 - sp.sqrt(3 * k.eta) / mu)),
            Relation(sp.tan(phi), slope),
            note="rho^2 vanishes for the equilateral triangle and is 1/2 for masses in a line. The quadrant of phi is "
            "that of atan2(sqrt(3)(l_1^2 - l_2^2), 2 l_3^2 - l_1^2 - l_2^2).",
        ),
        printed(
            "20",
            "rod lengths from the shape",
            "equation",
            Relation(k.l_i**2, mu / 3 * (1 + 2 * rho * root * sp.cos(phi + k.delta_i)), cases=each),
            Relation(k.delta[0], -2 * sp.pi / 3),
            Relation(k.delta[1], 2 * sp.pi / 3),
            Relation(k.delta[2], sp.S.Zero),
        ),
        printed(
            "21",
            "turn of the triangle at zero momentum",
            "equation",
            Relation(k.theta_dot, rho**2 * k.phi_dot, cases=(k.still,)),
        ),
        printed(
            "22",
            "rod rates",
            "equation",
            Relation(k.u_i, growth + along + across, corrected=growth + along - across, cases=each),
            note="Differentiating (20) gives a minus before the last term.",
        ),
        printed(
            "23",
            "equations of motion in the new coordinates",
            "equation",
            Relation(k.rho_dot, k.w1),
            Relation(k.phi_dot, k.w2),
            Relation(k.mu_dot, k.w3),
            Relation(k.theta_dot, rho**2 * k.w2, cases=(k.still,)),
        ),
    )
