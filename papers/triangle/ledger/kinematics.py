# SPDX-License-Identifier: Apache-2.0
"""Section 2 of the triangle's paper: equations (1)-(23) and Table 1, as printed."""

from __future__ import annotations

import functools
import operator
from collections.abc import Iterable, Iterator

import sympy as sp

from mehvar.ledger import Case, Cross, Printed, Relation, Side, printed

from .symbols import EVEN, ROOT3, Kinematics

HALF, THIRD = sp.Rational(1, 2), sp.Rational(1, 3)
ORIGIN = sp.ZeroMatrix(2, 1)


def placing(k: Kinematics) -> Iterator[Printed]:
    """(1)-(6): positions, the base triangle and the rods."""
    vertices: tuple[Case, ...] = tuple({k.X_i: k.X[i], k.x_i: k.x[i]} for i in (1, 2, 3))
    pairs: tuple[Case, ...] = tuple(
        {**k.equal, k.X_i: k.X[i], k.X_j: k.X[j], k.x_i: k.x[i], k.x_j: k.x[j], k.l_k: k.l[n - 1]} for i, j, n in EVEN
    )
    yield printed(
        "1",
        "the centre of mass is the origin",
        "equation",
        Relation(_sum(k.m[i - 1] * k.X[i] for i in k.X), ORIGIN),
    )
    yield printed(
        "2",
        "the base triangle is centred too",
        "equation",
        Relation(_sum(k.m[i - 1] * k.x[i] for i in k.x), ORIGIN),
        note="The sentence before it prints capitals for the constant vectors x_i.",
    )
    yield printed(
        "3",
        "positions by a linear map of the base triangle",
        "definition",
        Relation(k.X_i, k.A * k.x_i, cases=vertices),
    )
    yield printed(
        "4",
        "rotation and stretch of that map",
        "definition",
        Relation(k.A, k.Q * k.S),
        Relation(k.Q.T * k.Q, k.I, says="Q is orthogonal"),
        Relation(k.S, k.S.T, says="S is symmetric"),
    )
    base = k.x_i - k.x_j
    rod = k.X_i - k.X_j
    yield printed(
        "5",
        "rod lengths depend on the stretch only",
        "equation",
        Relation(k.X_i, k.Q * k.S * k.x_i, cases=vertices),
        Relation(k.l_k**2, rod.T * rod, cases=pairs),
        Relation(k.l_k**2, base.T * k.S * k.S * base, cases=pairs),
        note="Lengths are those of the derivation, (20). One index is printed l_K. The sentences "
        "around (7)-(9) give numbers that are one too low or too high.",
    )
    yield printed(
        "6",
        "the inputs are the rates of the rods",
        "definition",
        *(Relation(k.l_dot[i], k.u[i]) for i in (2, 1, 0)),
    )


def momentum(k: Kinematics) -> Iterator[Printed]:
    """(7)-(12): angular momentum of three masses."""
    vertices: tuple[Case, ...] = tuple({k.X_i: k.X[i], k.x_i: k.x[i], k.X_dot_i: k.X_dot[i]} for i in (1, 2, 3))
    moments = _sum(k.m[i - 1] * k.x[i] * k.x[i].T for i in k.x)
    yield printed(
        "7",
        "angular momentum",
        "definition",
        Relation(k.H, _sum(k.m[i - 1] * Cross(k.X[i], k.X_dot[i]) for i in k.X)),
    )
    velocity = (k.theta_dot * k.J * k.S + k.S_dot) * k.x_i
    yield printed(
        "8",
        "velocities",
        "equation",
        Relation(k.X_dot_i, k.Q * velocity, cases=vertices),
        Relation(k.J, sp.Matrix([[0, -1], [1, 0]])),
    )
    yield printed(
        "9",
        "the rotation drops out of the moment of velocity",
        "equation",
        Relation(Cross(k.X_i, k.X_dot_i), Cross(k.S * k.x_i, velocity), cases=vertices),
    )
    yield printed(
        "text after (9)",
        "cross product of two vectors of the plane",
        "equation",
        Relation(
            Cross(k.X_i, k.X_dot_i),
            k.X_i.T * k.J * k.X_dot_i,
            corrected=-k.X_i.T * k.J * k.X_dot_i,
            cases=vertices,
            says="(a x b)_3 = a^T J b with a = X_i and b its velocity",
        ),
    )
    spin = k.theta_dot * k.S * k.S - k.S * k.J * k.S_dot
    yield printed(
        "10",
        "angular momentum by stretch and turn",
        "equation",
        Relation(
            k.H,
            _sum(-k.m[i - 1] * (k.x[i].T * k.S) * k.J * ((k.theta_dot * k.J * k.S + k.S_dot) * k.x[i]) for i in k.x),
        ),
        Relation(k.H, _sum(k.m[i - 1] * k.x[i].T * spin * k.x[i] for i in k.x)),
        Relation(k.H, sp.Add(*(sp.Trace(spin * (k.m[i - 1] * k.x[i] * k.x[i].T)) for i in k.x))),
    )
    yield printed(
        "text before (11)",
        "condition on the base triangle",
        "condition",
        Relation(k.m_bar, moments, corrected_left=k.m_bar / 2 * k.I),
        Relation(moments, k.m_bar / 2 * k.I),
    )
    balance = k.I_bar * k.theta_dot + k.t_s
    yield printed(
        "11",
        "momentum over the mean mass",
        "equation",
        Relation(k.H / k.mass, balance, corrected_left=k.H / k.m_bar),
        Relation(k.I_bar, sp.Trace(k.S * k.S) / 2),
        Relation(k.t_s, sp.Trace(k.S_dot * k.J * k.S) / 2),
        note="m alone is not defined.",
    )
    yield printed(
        "12",
        "zero momentum",
        "equation",
        Relation(balance, sp.S.Zero, cases=(k.still,)),
    )


def equal_masses(k: Kinematics) -> Iterator[Printed]:
    """(13)-(18): the stretch from the rod lengths."""
    edges: tuple[Case, ...] = tuple(
        {**k.equal, k.d_k: k.d[n], k.D_k: k.D[n], k.x_i: k.x[i], k.x_j: k.x[j], k.X_i: k.X[i], k.X_j: k.X[j]}
        for i, j, n in EVEN
    )
    sides: tuple[Case, ...] = tuple(
        {k.D_i: k.D[i], k.D_j: k.D[j], k.l_i: k.l[i - 1], k.l_j: k.l[j - 1], k.l_k: k.l[n - 1]} for i, j, n in EVEN
    )
    yield printed(
        "13",
        "base triangle of equal masses",
        "condition",
        Relation(
            _sum(k.m[i - 1] * k.x[i].T for i in k.x),
            k.I / 2,
            corrected_left=_sum(k.x[i] * k.x[i].T for i in k.x),
            cases=(k.equal,),
        ),
    )
    yield printed(
        "14",
        "edges",
        "definition",
        Relation(k.d_k, k.x_j - k.x_i, cases=edges),
        Relation(k.D_k, k.X_j - k.X_i, cases=edges),
    )
    yield printed(
        "15", "products of the edges", "equation", Relation(k.D_row.T * k.D_row, k.d_row.T * k.S * k.S * k.d_row)
    )
    yield printed(
        "16",
        "products of the edges by the rod lengths",
        "equation",
        Relation(k.D_i.T * k.D_j, (k.l_k**2 - k.l_i**2 - k.l_j**2) / 2, cases=sides),
        Relation(k.D_i.T * k.D_i, k.l_i**2, cases=sides),
    )
    squares = [length**2 for length in k.l]
    yield printed(
        "17",
        "the stretch by the rod lengths",
        "equation",
        Relation(k.varphi_i, 2 * k.d_i * k.d_i.T - k.I, given=True),
        Relation(
            k.S * k.S,
            2 * THIRD * _sum(square * matrix for square, matrix in zip(squares, k.varphi, strict=True))
            + THIRD * sp.Add(*squares) * k.I,
        ),
    )
    yield printed(
        "18",
        "inertia by the rod lengths",
        "equation",
        Relation(k.I_bar, sp.Trace(k.S * k.S) / 2),
        Relation(k.I_bar, sp.Add(*squares) / 3),
        note="The sentence before it says that I-bar occurs in (10): it is (11).",
    )
    yield printed(
        "text after (18)",
        "what differentiating S gives",
        "statement",
        Relation(k.theta_dot, k.S_rate, corrected_left=k.S_dot, says="computing theta' by differentiating S"),
    )


def table(k: Kinematics) -> Iterator[Printed]:
    """Table 1: successive changes of variables."""
    rho, phi, mu = k.rho, k.phi, k.mu
    l1, l2, l3 = k.l
    yield printed(
        "Table 1, row 1",
        "S, c_i and d",
        "equation",
        Relation(k.d_0, sp.sqrt(mu / 6 + sp.sqrt(k.eta / 12))),
        Relation(k.c_i, k.l_i**2 / (3 * k.d_0), given=True),
        Relation(mu, l1**2 + l2**2 + l3**2),
        Relation(k.eta, _area(k)),
        Relation(_area(k), sp.S.Zero, ">="),
        Relation(k.S, _sum(c * matrix for c, matrix in zip(k.c, k.varphi, strict=True)) + k.d_0 * k.I),
        Relation(k.I_bar, sp.Trace(k.S * k.S) / 2),
        Relation(k.I_bar, mu / 3),
    )
    (p1, p2, p3), (rate1, rate2, _) = k.p, k.p_dot
    swept = p1 * rate2 - p2 * rate1
    yield printed(
        "Table 1, row 2",
        "momentum of the change of shape",
        "equation",
        *(Relation(p, k.c[i] - k.c[(i + 1) % 3], given=True) for i, p in enumerate(k.p)),
        Relation(k.t_s, -ROOT3 / 2 * swept),
        Relation(mu * k.theta_dot, 3 * ROOT3 / 2 * swept, cases=(k.still,)),
    )
    squares = p1**2 + p2**2 + p3**2
    unit = sp.Rational(2, 3) * rho * sp.sqrt(mu)
    third = sp.UnevaluatedExpr(2 * sp.pi / 3)
    yield printed(
        "Table 1, row 3",
        "rho",
        "equation",
        Relation(rho, sp.sqrt(3 / (2 * mu) + squares), corrected=sp.sqrt(sp.UnevaluatedExpr(3 / (2 * mu)) * squares)),
        Relation(p1, unit * sp.sin(phi)),
        Relation(p2, unit * sp.sin(phi - third)),
        Relation(p3, unit * sp.sin(phi + third)),
        Relation(k.d_0**2, mu / 3 * (1 - rho**2)),
        Relation(rho**2, HALF, "<="),
    )
    angle = sp.asin(sp.Rational(3, 2) * p1 / (rho * sp.sqrt(mu)))
    yield printed(
        "Table 1, row 4",
        "phi",
        "equation",
        Relation(
            phi,
            sp.Piecewise((angle, p3 >= p2), (sp.pi - angle, True)),
            domain=(phi + sp.pi / 2,),
            says="for phi from -pi/2 on: the two formulas give -pi/2 to 3 pi/2",
        ),
        Relation(k.theta_dot, rho**2 * k.phi_dot, cases=(k.still,)),
    )


def rods(k: Kinematics) -> Iterator[Printed]:
    """(19)-(23): shape by rod lengths, rod lengths by shape, rates."""
    each: tuple[Case, ...] = tuple({k.l_i: k.l[i], k.u_i: k.u[i], k.delta_i: k.delta[i]} for i in range(3))
    l1, l2, l3 = k.l
    slope = ROOT3 * (l1**2 - l2**2) / (2 * l3**2 - l1**2 - l2**2)
    rho, phi, mu = k.rho, k.phi, k.mu
    yield printed(
        "19",
        "shape from the rod lengths",
        "equation",
        Relation(mu, l1**2 + l2**2 + l3**2),
        Relation(k.eta, _area(k)),
        Relation(rho**2, 1 - ROOT3 * k.eta / mu, corrected=HALF * (1 - sp.sqrt(3 * k.eta) / mu)),
        Relation(sp.tan(phi), slope),
        note="rho^2 vanishes for the equilateral triangle and is 1/2 for masses in a line. The quadrant of phi is "
        "that of atan2(sqrt(3)(l_1^2 - l_2^2), 2 l_3^2 - l_1^2 - l_2^2).",
    )
    root = sp.sqrt(1 - rho**2)
    yield printed(
        "20",
        "rod lengths from the shape",
        "equation",
        Relation(k.l_i**2, mu / 3 * (1 + 2 * rho * root * sp.cos(phi + k.delta_i)), cases=each),
        Relation(k.delta[0], -2 * sp.pi / 3),
        Relation(k.delta[1], 2 * sp.pi / 3),
        Relation(k.delta[2], sp.S.Zero),
    )
    yield printed(
        "21",
        "turn of the triangle at zero momentum",
        "equation",
        Relation(k.theta_dot, rho**2 * k.phi_dot, cases=(k.still,)),
    )
    growth = k.l_i / (2 * mu) * k.w3
    across = mu / (3 * k.l_i) * rho * root * sp.sin(phi + k.delta_i) * k.w2
    along = mu / (3 * k.l_i) * (1 - 2 * rho**2) / root * sp.cos(phi + k.delta_i) * k.w1
    yield printed(
        "22",
        "rod rates",
        "equation",
        Relation(k.u_i, growth + along + across, corrected=growth + along - across, cases=each),
        note="The definitions of w_1, w_2, w_3 and u_i in the sentence before it are run together.",
    )
    yield printed(
        "23",
        "equations of motion in the new coordinates",
        "equation",
        Relation(k.rho_dot, k.w1),
        Relation(k.phi_dot, k.w2),
        Relation(k.mu_dot, k.w3),
        Relation(k.theta_dot, rho**2 * k.w2, cases=(k.still,)),
    )


def _area(k: Kinematics) -> sp.Expr:
    """Sixteen times the squared area of the triangle, as the paper writes it."""
    l1, l2, l3 = k.l
    return 2 * (l1**2 * l2**2 + l2**2 * l3**2 + l3**2 * l1**2) - (l1**4 + l2**4 + l3**4)


def _sum(terms: Iterable[Side]) -> Side:
    return functools.reduce(operator.add, terms)
