# SPDX-License-Identifier: Apache-2.0
"""The equations of motion of the satellite's paper, (1)-(11), as printed."""

from __future__ import annotations

from collections.abc import Iterator

import sympy as sp

from mehvar.ledger import Cross, Printed, Relation, printed

from .symbols import Motion

_BAR = "a dot over a vector is the bar that the text has there"
_RATE = "a dot is a derivative, as in (5)-(11)"
_WHY_BAR = "The text after (33) writes bars over T, H, omega and omega_0; with them (2) and (4) hold."
_WHY_RATE = "Then vectors and their derivatives are mixed: the units do not agree."
_ALONE = "one axis moves, the others rest"
_WHY_ALONE = "The law takes each axis by itself and the coupling as an unknown offset."
_COMPLETE = "the complete linear model"
_WHY_COMPLETE = "The model has the coupling of roll and yaw, {}; the paper's linear model leaves it out."


def balance(m: Motion) -> Iterator[Printed]:
    """(1)-(4): momentum, and the rate relative to the orbit axes."""
    yield (
        printed(
            "1", "Euler's equation", "equation", note="T is the torque on the body, from outside or from the wheels."
        )
        .reading(
            _RATE,
            Relation(
                m.T_ddot,
                m.I * m.omega_ddot + Cross(m.omega_dot, m.H),
                corrected_left=m.T,
                corrected=m.I * m.omega_dot + Cross(m.omega, m.H),
            ),
            used=False,
            why=_WHY_RATE,
        )
        .reading(
            _BAR + ", one of two dots likewise",
            Relation(m.T_dot, m.I * m.omega_dot + Cross(m.omega, m.H), corrected_left=m.T),
            why=_WHY_BAR + " T still has a dot too many.",
        )
    )
    yield (
        printed("2", "angular momentum", "definition", note="The model adds the momentum stored in the wheels.")
        .reading(_RATE, Relation(m.H, m.I * m.omega_dot, corrected=m.I * m.omega), used=False, why=_WHY_RATE)
        .reading(_BAR, Relation(m.H, m.I * m.omega), why=_WHY_BAR)
    )
    about_y = m.C * sp.Matrix([0, m.omega_0, 0])
    yield (
        printed(
            "3",
            "rate of the orbit axes",
            "equation",
            note="The sign changes the roll-yaw coupling of the linear model, which (8)-(10) leave out.",
        )
        .reading(
            _BAR + "; x along the velocity, z to nadir",
            Relation(m.omega_RI, about_y, corrected=m.C * sp.Matrix([0, -m.omega_0, 0])),
            why="The axes of the paper's reference for (1)-(4). (8)-(10) cannot decide: omega_0 enters squared.",
        )
        .reading(
            _BAR + "; x against the velocity, y along the orbit normal",
            Relation(m.omega_RI, about_y, cases=(m.backwards,)),
            used=False,
            why="The paper does not say which axes it takes; in these the sign is right.",
        )
        .reading(
            _RATE,
            Relation(m.omega_RI_dot, m.C * sp.Matrix([0, m.omega_0_dot, 0])),
            used=False,
            why="On a circular orbit the right side is zero; the left side is not, because C turns.",
        )
    )
    pqr = sp.Matrix([m.p, m.q, m.r])
    yield (
        printed("4", "rate relative to the orbit axes", "definition")
        .reading(
            _BAR,
            Relation(m.Omega, m.omega - m.omega_RI, cases=(m.relative,)),
            Relation(m.Omega, pqr, cases=(m.relative,)),
            why=_WHY_BAR,
        )
        .reading(
            _RATE,
            Relation(m.Omega_dot, m.omega_dot - m.omega_RI_dot, cases=(m.relative,)),
            Relation(m.Omega_dot, pqr, corrected_left=m.Omega, cases=(m.relative,)),
            used=False,
            why="The first equation is the derivative of the other reading's; but p, q, r are no accelerations.",
        )
    )
    yield from _words(m)


def _words(m: Motion) -> Iterator[Printed]:
    """Sentences after (33) that explain (1)-(4): the rates p, q, r and the order of the turns."""
    relations = _kinematics(m)
    yield (
        printed(
            "text on (3)",
            "C is for phi -> theta -> psi",
            "statement",
            note="Judged by (5)-(7). With the first reading the turns are made in the order psi, theta, phi.",
        )
        .reading("the order of the factors, C = R1(phi) R2(theta) R3(psi)", *relations, why="(5)-(7) hold.")
        .reading(
            "the order of the turns, phi first: C = R3(psi) R2(theta) R1(phi)",
            *(Relation(r.left, r.right, cases=(m.other_order,)) for r in relations),
            used=False,
            why="(5)-(7) do not hold.",
        )
    )
    yield (
        printed("text on (4)", "p, q, r are the satellite's body rates", "statement", note="Judged by (5)-(7).")
        .reading("relative to the orbit axes, as (4) has it", *relations, why="(5)-(7) hold.")
        .reading(
            "relative to inertial axes, in body axes",
            *(Relation(r.left, r.right, cases=(m.inertial,)) for r in relations),
            used=False,
            why="(5)-(7) do not hold: the orbit axes turn too.",
        )
    )


def _kinematics(m: Motion) -> tuple[Relation, Relation, Relation]:
    phi_dot, theta_dot, psi_dot = m.rate
    across = m.q * sp.sin(m.phi) + m.r * sp.cos(m.phi)
    return (
        Relation(phi_dot, m.p + across * sp.tan(m.theta)),
        Relation(theta_dot, m.q * sp.cos(m.phi) - m.r * sp.sin(m.phi)),
        Relation(psi_dot, across * sp.sec(m.theta)),
    )


def kinematics(m: Motion) -> Iterator[Printed]:
    """(5)-(7): rates of the angles."""
    roll, pitch, yaw = _kinematics(m)
    yield printed("5", "rate of roll", "equation", roll)
    yield printed("6", "rate of pitch", "equation", pitch)
    yield printed("7", "rate of yaw", "equation", yaw)


def linear(m: Motion) -> Iterator[Printed]:
    """(8)-(11): small motions about the orbit axes."""
    says = "T of (1) for small motions of one axis; right: (8)-(10) with second derivatives"
    (I_x, I_y, I_z), square = m.moments, m.omega_0**2
    stiffness = (4 * square * (I_y - I_z) * m.phi, 3 * square * (I_x - I_z) * m.theta, square * (I_y - I_x) * m.psi)
    moving = [inertia * motion + pull for inertia, motion, pull in zip(m.moments, m.small_rate, stiffness, strict=True)]
    balance = [
        inertia * motion + pull for inertia, motion, pull in zip(m.moments, m.acceleration, stiffness, strict=True)
    ]
    pulled = (balance[0] + m.pull[0], balance[1] + m.pull[1], balance[2])
    yield printed(
        "text before (8)",
        "(5)-(7) are rewritten as (8)-(10)",
        "statement",
        *(
            Relation(total, right, corrected=corrected, cases=(alone,), says=says)
            for total, right, corrected, alone in zip(m.total, balance, pulled, m.alone, strict=True)
        ),
        note="(8)-(10) are the control torque: they follow from (1)-(7) and the gravity gradient T_gg = "
        "3 omega_0^2 n x I n, n to nadir, which the paper never writes. About yaw it has no term of first order. The "
        "paper has one I. Gravity pulls at the wheels too: the model has I + I_omega there and I in (1); with I_omega "
        "of Table 1 that is 2e-6 of the stiffness in (9), nothing in (8) and (10).",
    )
    coupling, (phi_dot, _, psi_dot) = m.omega_0 * (I_x - I_y + I_z), m.small_rate
    yield (
        printed("8", "small motions in roll", "equation")
        .reading(_ALONE, Relation(m.torque[0], moving[0], corrected=balance[0], cases=(m.alone[0],)), why=_WHY_ALONE)
        .reading(
            _COMPLETE,
            Relation(m.torque[0], moving[0], corrected=balance[0] - coupling * psi_dot),
            used=False,
            why=_WHY_COMPLETE.format("-omega_0 (I_x - I_y + I_z) psi'"),
        )
    )
    yield printed("9", "small motions in pitch", "equation", Relation(m.torque[1], moving[1], corrected=balance[1]))
    yield (
        printed("10", "small motions in yaw", "equation")
        .reading(_ALONE, Relation(m.torque[2], moving[2], corrected=balance[2], cases=(m.alone[2],)), why=_WHY_ALONE)
        .reading(
            _COMPLETE,
            Relation(m.torque[2], moving[2], corrected=balance[2] + coupling * phi_dot),
            used=False,
            why=_WHY_COMPLETE.format("omega_0 (I_x - I_y + I_z) phi'"),
        )
    )
    angles = (m.phi, m.theta, m.psi)
    yield printed(
        "11",
        "state space",
        "definition",
        Relation(m.x_dot, m.A_c * m.x + m.B_c * m.u_c),
        Relation(m.y_c, m.C_c * m.x),
        Relation(m.x, sp.Matrix([*angles, *angles]), corrected=sp.Matrix([*angles, *m.small_rate]), says="x of (11)"),
        note="A and B are not printed; these have (8)-(10) with second derivatives.",
    )
