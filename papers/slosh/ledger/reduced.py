# SPDX-License-Identifier: Apache-2.0
"""Equilibrium and reduced model of the slosh paper: equations (18)-(26), as printed."""

from __future__ import annotations

from collections.abc import Iterator

import sympy as sp
from sympy import Expr

from mehvar.ledger import Printed, Relation, printed

from .angles import corrected_phi, corrected_theta, phi_bracket, theta_bracket
from .laws import Laws
from .symbols import Spacecraft
from .terms import Shorthand


def equilibrium(s: Spacecraft, law: Laws) -> Iterator[Printed]:
    """(18), (19): the relative equilibrium."""
    vy, vz = (s.names.free(f"v{axis}_eq", -2, 2, latex=rf"\tilde v_{axis}") for axis in "yz")
    attitude = [s.names.free(f"att{k}_eq", -1, 1, latex=rf"\tilde\vartheta_{k}") for k in (1, 2, 3)]
    i, zero = s.i, sp.S.Zero
    resting = ("phi", "phi_dot", "theta_dot", "phi_ddot", "theta_ddot")
    bobs = (bob.symbols[name] for bob in s.bobs for name in resting)
    still = dict.fromkeys((*s.w, *s.w_dot, *s.v_dot[1:], *s.M, *s.delta, *bobs), zero)
    case = still | {s.v_dot[0]: law.axial}
    left = s.names.matrix("E", r"E_{10\ldots16}", sp.Matrix([*s.balance[1:], *s.rows[0], *s.rows[1]]))
    along = s.names.derived("E_9", "E_9", s.balance[0])
    yield printed(
        "18",
        "relative equilibrium",
        "condition",
        *(Relation(a, b, given=True) for a, b in ((s.v[1], vy), (s.v[2], vz))),
        *(Relation(a, b, given=True) for a, b in zip(s.att, attitude, strict=True)),
        Relation(s.Omega, sp.zeros(3, 1), given=True),
        *(Relation(angle, zero, given=True) for angle in (i.phi, i.theta)),
        Relation(left, sp.zeros(9, 1), cases=(case,), says="(10)-(16) hold there without inputs and accelerations"),
        Relation(along, zero, cases=(case,), says="and (9) with the a_x of (19)"),
        note="zeta is printed twice, zeta = zeta~ = 0; the rates of the angles must be zero too, and theta_i may "
        "have any value.",
    )
    yield printed(
        "19",
        "acceleration at the equilibrium",
        "equation",
        Relation(s.a[0], s.F / (s.m + s.m0 + s.total(i.m)), cases=({s.a[0]: law.axial},)),
    )


def reduced(s: Spacecraft, law: Laws) -> Iterator[Printed]:
    """(20)-(26): the reduced model."""
    (_, vy_dot, vz_dot), (W1_dot, W2_dot, W3_dot), case = s.v_dot, s.w_dot, law.motion
    (vx, vy, vz), (W1, W2, W3), u = s.v, s.w, law.u
    yield _rate("20", "v_y", vy_dot, u[0] - vx * W3 + vz * W1, case)
    yield _rate("21", "v_z", vz_dot, u[1] - vy * W1 + vx * W2, case)
    yield _rate("22", "Omega_1", W1_dot, u[2], case)
    yield _rate("23", "Omega_2", W2_dot, u[3], case)
    yield _rate("24", "Omega_3", W3_dot, u[4], case)
    yield from _angles(s, law)


def _rate(number: str, name: str, left: Expr, right: Expr, case: dict[Expr, Expr]) -> Printed:
    return printed(number, f"reduced model: {name}", "equation", Relation(left, right, cases=(case,)))


def _angles(s: Spacecraft, law: Laws) -> Iterator[Printed]:
    W1d, _, W3d = s.w_dot
    i, t = s.i, Shorthand(s.i)
    phi, phi_dotted = (
        i.l * phi_bracket(s, turn, sp.S.Zero) + i.I * W1d / i.m - i.eps * i.phi_dot / i.m
        for turn in (i.theta, i.theta_dot)
    )
    inertia = i.m * i.l**2 * t.s**2 + i.I
    right_phi, right_theta = _corrected(s)
    cases = tuple(law.motion | each for each in s.each())
    per_mass = {i.I: i.I / i.m}
    as_in_energy, other = "I_i a moment of inertia", "I_i per unit of the pendulum's mass"
    yield (
        printed("25", "reduced model: phi_i", "equation", note="In (25) theta_i stands where (15) has its rate.")
        .reading(
            as_in_energy,
            Relation(i.phi_ddot, -1 / inertia * phi, corrected=right_phi, cases=cases),
            why="As in the energy (5).",
        )
        .reading(
            f"{other}, theta_i with its dot",
            Relation(i.phi_ddot, (-1 / inertia * phi_dotted).xreplace(per_mass), cases=cases),
            used=False,
            why="The factor m_i then has to stand in the denominator's first term alone, and the damping still drives.",
        )
    )
    theta = i.l * theta_bracket(s) + i.I * W3d / i.m - i.eps * i.theta_dot / i.m
    yield (
        printed("26", "reduced model: theta_i", "equation")
        .reading(
            as_in_energy,
            Relation(i.theta_ddot, -1 / i.I * theta, corrected=right_theta, cases=cases),
            why="As in the energy (5).",
        )
        .reading(
            other,
            Relation(i.theta_ddot, (-1 / i.I * theta).xreplace(per_mass), cases=cases),
            used=False,
            why="The factor m_i is then right before l_i, and the damping still drives.",
        )
    )


def _corrected(s: Spacecraft) -> tuple[Expr, Expr]:
    """Write the corrected (25), (26) with the factors that the printed ones have or lack."""
    i, t = s.i, Shorthand(s.i)
    (W1d, _, W3d), inertia = s.w_dot, i.m * i.l**2
    phi = i.l * corrected_phi(s, sp.S.Zero) + i.I * W1d / i.m + i.eps * i.phi_dot / i.m
    theta = i.l * corrected_theta(s) + i.I * W3d / i.m + i.eps * i.theta_dot / i.m
    return -i.m / (inertia + i.I) * phi, -i.m / (inertia * t.s**2 + i.I) * theta
