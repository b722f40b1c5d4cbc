# SPDX-License-Identifier: Apache-2.0
"""Equilibrium and reduced model of the slosh paper: equations (18)-(26), as printed."""

from __future__ import annotations

import sympy as sp

from models.derivation import Expr
from models.paper import Printed, Relation, printed
from models.slosh.paper.angles import phi_bracket, theta_bracket
from models.slosh.paper.laws import Laws
from models.slosh.paper.symbols import Spacecraft
from models.slosh.paper.terms import Shorthand


def equilibrium(s: Spacecraft, law: Laws) -> tuple[Printed, ...]:
    """(18), (19): the relative equilibrium."""
    i = s.i
    vy, vz = (s.names.free(f"v{axis}_eq", -2, 2, latex=rf"\tilde v_{axis}") for axis in "yz")
    attitude = [s.names.free(f"att{k}_eq", -1, 1, latex=rf"\tilde\vartheta_{k}") for k in (1, 2, 3)]
    zero = sp.S.Zero
    still = dict.fromkeys((*s.w, *s.w_dot, *s.v_dot[1:], *s.M, *s.delta), zero)
    for bob in s.bobs:
        names = ("phi", "phi_dot", "theta_dot", "phi_ddot", "theta_ddot")
        still |= dict.fromkeys((bob.symbols[name] for name in names), zero)
    left = s.names.matrix("E", r"E_{10\ldots16}", sp.Matrix([*s.balance[1:], *s.rows[0], *s.rows[1]]))
    along = s.names.derived("E_9", "E_9", s.balance[0])
    case = still | {s.v_dot[0]: law.axial}
    return (
        printed(
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
        ),
        printed(
            "19",
            "acceleration at the equilibrium",
            "equation",
            Relation(s.a[0], s.F / (s.m + s.m0 + s.total(i.m)), cases=({s.a[0]: law.axial},)),
        ),
    )


def reduced(s: Spacecraft, law: Laws) -> tuple[Printed, ...]:
    """(20)-(26): the reduced model."""
    (vx, vy, vz), (W1, W2, W3), u = s.v, s.w, law.u
    case = law.motion
    return (
        _rate("20", "v_y", s.v_dot[1], u[0] - vx * W3 + vz * W1, case),
        _rate("21", "v_z", s.v_dot[2], u[1] - vy * W1 + vx * W2, case),
        *(
            _rate(str(22 + k), f"Omega_{k + 1}", s.w_dot[k], u[2 + k], case)
            for k in range(3)
        ),
        *_angles(s, law),
    )


def _rate(number: str, name: str, left: Expr, right: Expr, case: dict[Expr, Expr]) -> Printed:
    return printed(number, f"reduced model: {name}", "equation", Relation(left, right, cases=(case,)))


def _angles(s: Spacecraft, law: Laws) -> tuple[Printed, ...]:
    i, t = s.i, Shorthand(s.i)
    W1d, _, W3d = s.w_dot
    inertia = i.m * i.l**2 * t.s**2 + i.I
    phi = i.l * phi_bracket(s, i.theta, sp.S.Zero) + i.I * W1d / i.m - i.eps * i.phi_dot / i.m
    theta = i.l * theta_bracket(s) + i.I * W3d / i.m - i.eps * i.theta_dot / i.m
    cases = tuple(law.motion | each for each in s.each())
    right_phi, right_theta = _corrected(s)
    return (
        printed(
            "25",
            "reduced model: phi_i",
            "equation",
            Relation(i.phi_ddot, -phi / inertia, corrected=right_phi, cases=cases),
            note="In (25) theta_i stands where (15) has its rate.",
        ),
        printed(
            "26",
            "reduced model: theta_i",
            "equation",
            Relation(i.theta_ddot, -theta / i.I, corrected=right_theta, cases=cases),
        ),
    )


def _corrected(s: Spacecraft) -> tuple[Expr, Expr]:
    """Write (25), (26) out, with a instead of V' as V drops out then."""
    i, t, (W1, W2, W3) = s.i, Shorthand(s.i), s.w
    (W1d, W2d, W3d), (ax, ay, az) = s.w_dot, s.a
    along, across = W2 * t.S + W3 * t.C, W2 * t.C - W3 * t.S
    reach = i.h - i.l * t.c
    phi = (
        i.m
        * i.l
        * (
            t.s * ax
            + t.cS * ay
            + t.cC * az
            + (i.l - i.h * t.c) * (t.C * W2d - t.S * W3d)
            - i.l * t.s * t.c * i.theta_dot**2
            + 2 * i.l * t.s * i.theta_dot * (t.c * W1 - t.s * along)
            - i.h * t.s * (W2**2 + W3**2)
            + i.h * t.c * W1 * along
            + i.l * (t.s * t.c * (along**2 - W1**2) + (1 - 2 * t.c**2) * W1 * along)
        )
        + i.I * W1d
        + i.eps * i.phi_dot
    )
    theta = (
        i.m
        * i.l
        * (
            t.sC * ay
            - t.sS * az
            - i.l * t.s**2 * W1d
            + t.s * reach * (t.S * W2d + t.C * W3d)
            + 2 * i.l * t.s * t.c * i.phi_dot * i.theta_dot
            + 2 * i.l * t.s * i.phi_dot * (t.s * along - t.c * W1)
            + t.s * reach * W1 * across
            + i.l * t.s**2 * along * across
        )
        + i.I * W3d
        + i.eps * i.theta_dot
    )
    return -phi / (i.m * i.l**2 + i.I), -theta / (i.m * i.l**2 * t.s**2 + i.I)
