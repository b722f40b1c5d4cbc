# SPDX-License-Identifier: Apache-2.0
"""Section 2 of the slosh paper up to the energy: equations (1)-(8) and the symbols they use, as printed."""

from __future__ import annotations

from collections.abc import Iterator

import sympy as sp

from mehvar.ledger import Cross, Printed, Relation, printed

from .symbols import Spacecraft

HALF = sp.Rational(1, 2)


def laws_of_motion(s: Spacecraft) -> Iterator[Printed]:
    """(1)-(4): Kirchhoff's and Lagrange's equations, forces and moments."""
    turned = sp.Matrix([[0, s.w[2], -s.w[1]], [-s.w[2], 0, s.w[0]], [s.w[1], -s.w[0], 0]])
    by, rate_of = s.by, s.rate_of
    across, force = Cross(s.Omega, by["V"]), sp.Matrix(s.balance[:3])
    yield (
        printed("1", "Kirchhoff's equation of the forces", "equation")
        .reading(
            "the cross product of Omega and the momentum",
            Relation(
                rate_of["V_dot"] + across,
                s.tau_t,
                corrected_left=rate_of["V"] + across,
                against=force,
            ),
            why="The only one of the two that gives the derived equations (9)-(11), once the dot over V is "
            "dropped; L has no derivative of V in it.",
        )
        .reading(
            "the matrix that the text calls p-bar, with the dot over V dropped",
            Relation(
                rate_of["V"] + turned * by["V"],
                s.tau_t,
                corrected_left=rate_of["V"] + across,
                against=force,
            ),
            used=False,
            why="The matrix printed for p-bar is the transposed one: the product has the wrong sign.",
        )
    )
    drifted = sp.Matrix([[0, s.v[2], -s.v[1]], [-s.v[2], 0, s.v[0]], [s.v[1], -s.v[0], 0]])
    rolled, moment = Cross(s.Omega, by["Omega"]) + Cross(s.V, by["V"]), sp.Matrix(s.balance[3:])
    yield (
        printed("2", "Kirchhoff's equation of the moments", "equation")
        .reading(
            "cross products",
            Relation(
                rate_of["Omega_dot"] + rolled,
                s.tau_r,
                corrected_left=rate_of["Omega"] + rolled,
                against=moment,
            ),
            why="As for (1).",
        )
        .reading(
            "the matrices that the text calls p-bar, with the dot over Omega dropped",
            Relation(
                rate_of["Omega"] + turned * by["Omega"] + drifted * by["V"],
                s.tau_r,
                corrected_left=rate_of["Omega"] + rolled,
                against=moment,
            ),
            used=False,
            why="As for (1).",
        )
    )
    column = s.zeta
    yield printed(
        "3",
        "Lagrange's equation of a pendulum",
        "equation",
        Relation(
            column["d/dt dL/dzeta_dot"] - column["dL/dzeta"] + column["dR/dzeta"],
            sp.zeros(2, 1),
            corrected_left=column["d/dt dL/dzeta_dot"] - column["dL/dzeta"] + column["dR/dzeta_dot"],
            cases=tuple(
                {**case, s.row_column: sp.Matrix(rows)} for case, rows in zip(s.zeta_cases, s.rows, strict=True)
            ),
            against=s.row_column,
        ),
        note="zeta holds phi_i and theta_i of a pendulum. R (8) depends on their rates only.",
    )
    (d1, d2), sin, cos = s.delta, sp.sin, sp.cos
    yield printed(
        "text after (3), force and moment",
        "thrust, and moments about the tank centre",
        "equation",
        Relation(s.tau_t, s.F * sp.Matrix([cos(d1) * cos(d2), sin(d2), -sin(d1) * cos(d2)])),
        Relation(
            s.tau_r,
            sp.Matrix(
                [
                    s.M[0],
                    s.M[1] - s.F * (s.b + s.d) * sin(d1) * cos(d2),
                    s.M[2] - s.F * (s.b + s.d) * sin(d2),
                ]
            ),
        ),
        note="The text says that both act at the hull's centre of mass. The printed lever b + d is that of the "
        "tank centre, and the moments are free couples.",
    )
    yield printed(
        "4",
        "no gravity",
        "definition",
        Relation(s.L, s.T - s.U),
        Relation(s.U, sp.S.Zero),
        Relation(s.L, s.T),
    )


def energy(s: Spacecraft) -> Iterator[Printed]:
    """(5)-(8): kinetic energy, velocities, places, dissipation."""
    spun = s.omega_i + s.Omega
    i = s.i
    one = i.m * sp.Trace(s.V_i.T * s.V_i) + sp.Trace(spun.T * (i.I * s.I3) * spun)
    turning = s.J_matrix + s.I0 * s.I3
    yield printed(
        "5",
        "kinetic energy",
        "equation",
        Relation(
            s.T,
            HALF * s.m * sp.Trace(s.V_at["c"].T * s.V_at["c"])
            + HALF * s.m0 * sp.Trace(s.V_at["0"].T * s.V_at["0"])
            + HALF * sp.Trace(s.Omega.T * turning * s.Omega)
            + HALF * s.total(one),
        ),
        note="A square of a vector is its length squared, written as a trace here.",
    )
    rate = sp.Matrix(s.place_dot)
    place = sp.Matrix(s.place)
    cases = tuple(
        {**each, s.V_i: s.V_at[str(k)], s.r_i: s.r[str(k)], s.r_dot_i: s.r_dot[str(k)], s.omega_i: s.omega[k - 1]}
        for k, each in enumerate(s.each(), 1)
    )
    yield printed(
        "6",
        "velocities",
        "equation",
        Relation(s.V_at["c"], s.r_dot["c"] + Cross(s.Omega, s.r["c"])),
        Relation(s.V_at["0"], s.r_dot["0"] + Cross(s.Omega, s.r["0"])),
        Relation(s.V_i, s.r_dot_i + Cross(s.Omega, s.r_i), cases=cases),
        Relation(s.V, rate + Cross(s.Omega, place)),
    )
    x, y, z = s.place
    yield printed(
        "7",
        "positions",
        "equation",
        Relation(s.r["c"], sp.Matrix([x - s.b, y, z])),
        Relation(s.r["0"], sp.Matrix([x - s.h0, y, z])),
        Relation(
            s.r_i,
            sp.Matrix(
                [
                    x + i.h - i.l * sp.cos(i.phi),
                    y + i.l * sp.sin(i.phi) * sp.sin(i.theta),
                    z + i.l * sp.sin(i.phi) * sp.cos(i.theta),
                ]
            ),
            cases=cases,
        ),
        note="x, y, z is the position of the tank centre, which V in (6) comes from. r_i is printed as a row.",
    )
    yield (
        printed("text after (7), omega_i", "angular velocity of a pendulum", "definition")
        .reading(
            "(phi', 0, theta')",
            Relation(s.omega_i, sp.Matrix([i.phi_dot, 0, i.theta_dot]), cases=cases),
            why="The printed terms with I_i of (12)-(16) are those of this choice. It is not the angular "
            "velocity of the arm; the structure `hinge` takes that one.",
        )
        .reading(
            "(phi', theta'), as printed",
            Relation(s.omega_i, sp.Matrix([i.phi_dot, i.theta_dot]), cases=cases),
            used=False,
            why="Two entries cannot be added to Omega.",
        )
        .reading(
            "(phi', theta', 0)",
            Relation(s.omega_i, sp.Matrix([i.phi_dot, i.theta_dot, 0]), cases=cases),
            used=False,
            why="Would put theta'' into (13), where no such term is printed.",
        )
        .reading(
            "the rate of the arm itself",
            Relation(
                s.omega_i,
                sp.Matrix([-i.theta_dot, i.phi_dot * sp.cos(i.theta), -i.phi_dot * sp.sin(i.theta)]),
                cases=cases,
            ),
            used=False,
            why="phi' about the axis across the arm, theta' about -x. The printed (12)-(16) do not have it.",
        )
    )
    yield printed(
        "8",
        "dissipation",
        "definition",
        Relation(s.R, s.total(HALF * i.eps * (i.phi_dot**2 + i.theta_dot**2))),
    )
