# SPDX-License-Identifier: Apache-2.0
"""Equations of motion of the slosh paper: (9)-(14) of the spacecraft and (17), as printed."""

from __future__ import annotations

from collections.abc import Iterator

import sympy as sp
from sympy import Expr

from mehvar.ledger import Cross, Printed, Relation, printed
from mehvar.mechanics import matrix_rate

from .symbols import Spacecraft
from .terms import Shorthand

_MISSING = "One closing bracket is missing in print; "
_SHORT = "Printed in short; the paper says that its simulations took the equations in complete form."


def forces(s: Spacecraft) -> Iterator[Printed]:
    """(9)-(11): balances of forces."""
    d1, d2 = s.delta
    sin, cos = sp.sin, sp.cos
    yield printed("9", "balance of forces along x", "equation", _along_x(s, s.F * cos(d1) * cos(d2)))
    yield _scoped(
        "10", "balance of forces along y", _along_y(s, s.F * sin(d2), True), _along_y(s, s.F * sin(d2), False)
    )
    yield _scoped(
        "11",
        "balance of forces along z",
        _along_z(s, -s.F * sin(d1) * cos(d2), True),
        _along_z(s, -s.F * sin(d1) * cos(d2), False),
    )


def _scoped(number: str, title: str, inside: Relation, outside: Relation) -> Printed:
    """Return an equation in which one closing bracket is missing."""
    return (
        printed(number, title, "equation")
        .reading(
            "that term outside the bracket",
            outside,
            why=_MISSING + "the term has the right dimension only there.",
        )
        .reading(
            "the term with h_i - l_i cos(phi_i) inside the bracket that l_i multiplies",
            inside,
            used=False,
            why=_MISSING + "so it stands in (9), where none is missing.",
        )
    )


def _along_x(s: Spacecraft, right: Expr) -> Relation:
    i, t, (W1, W2, W3) = s.i, Shorthand(s.i), s.w
    ax, sigma, reach = s.a[0], s.m * s.b + s.m0 * s.h0, i.h - i.l * t.c
    common = (
        i.phi_dot**2 * t.c
        + 2 * i.phi_dot * W2 * t.cC
        - 2 * i.theta_dot * W2 * t.sS
        - 2 * i.phi_dot * W3 * t.cS
        - 2 * i.theta_dot * W3 * t.sC
        + s.w_dot[1] * t.sC
        - s.w_dot[2] * t.sS
        + W1 * W3 * t.sC
        + W1 * W2 * t.sS
    )
    own = (s.m + s.m0) * ax + sigma * (W2**2 + W3**2)
    printed_bracket = common + i.phi_dot * t.s + (W2**2 - W3**2) * reach
    bracket = common + i.phi_ddot * t.s
    return Relation(
        own + s.total(i.m * (ax + i.l * printed_bracket)),
        right,
        corrected_left=own + s.total(i.m * (ax + i.l * bracket - (W2**2 + W3**2) * reach)),
        against=s.balance[0],
    )


def _along_y(s: Spacecraft, right: Expr, inside: bool) -> Relation:
    i, t, (W1, W2, W3) = s.i, Shorthand(s.i), s.w
    ay, sigma, reach = s.a[1], s.m * s.b + s.m0 * s.h0, i.h - i.l * t.c
    common = (
        -(i.phi_dot**2) * t.sS
        - i.theta_dot**2 * t.sS
        + 2 * i.theta_dot * W1 * t.sS
        + 2 * i.phi_dot * W3 * t.s
        + 2 * i.phi_dot * i.theta_dot * t.cC
        - (s.w_dot[0] - W2 * W3) * t.sC
        - (W1**2 + W3**2) * t.sS
    )
    arm = (s.w_dot[2] + W1 * W2) * reach
    own = (s.m + s.m0) * ay - sigma * (s.w_dot[2] + W1 * W2)
    bracket = common + i.phi_dot * t.cS + i.theta_dot * t.sC + 2 * i.phi_dot * W1 * t.cC
    corrected = common + i.phi_ddot * t.cS + i.theta_ddot * t.sC - 2 * i.phi_dot * W1 * t.cC
    term = ay + i.l * (bracket + arm) if inside else ay + i.l * bracket + arm
    return Relation(
        own + s.total(i.m * term),
        right,
        corrected_left=own + s.total(i.m * (ay + i.l * corrected + arm)),
        against=s.balance[1],
    )


def _along_z(s: Spacecraft, right: Expr, inside: bool) -> Relation:
    i, t, (W1, W2, W3) = s.i, Shorthand(s.i), s.w
    az, sigma, reach = s.a[2], s.m * s.b + s.m0 * s.h0, i.h - i.l * t.c
    common = -(i.phi_dot**2) * t.sC - 2 * i.phi_dot * i.theta_dot * t.cS + (s.w_dot[0] + W2 * W3) * t.sS
    arm = (s.w_dot[1] - W1 * W3) * reach
    own = (s.m + s.m0) * az + sigma * (s.w_dot[1] - W1 * W3)
    bracket = (
        common
        + i.phi_dot * t.cC
        - i.theta_dot * t.sS
        - i.theta_dot**2 * 2 * i.phi_dot * W2 * t.s
        - (W1**2 + W2**2) * t.sS
    )
    corrected = (
        common
        + i.phi_ddot * t.cC
        - i.theta_ddot * t.sS
        - i.theta_dot**2 * t.sC
        + 2 * i.phi_dot * W1 * t.cS
        + 2 * i.theta_dot * W1 * t.sC
        - 2 * i.phi_dot * W2 * t.s
        - (W1**2 + W2**2) * t.sC
    )
    term = az + i.l * (bracket - arm) if inside else az + i.l * bracket - arm
    return Relation(
        own + s.total(i.m * term),
        right,
        corrected_left=own + s.total(i.m * (az + i.l * corrected - arm)),
        against=s.balance[2],
    )


def moments(s: Spacecraft) -> Iterator[Printed]:
    """(12)-(14): balances of moments, printed in short."""
    i, t, (W1, W2, W3) = s.i, Shorthand(s.i), s.w
    sigma, reach, I0 = s.m * s.b + s.m0 * s.h0, i.h - i.l * t.c, s.I0
    W1d, W2d, W3d = s.w_dot
    (_, ay, az), (Jx, Jy, Jz), (vx, vy, vz) = s.a, s.J, s.v
    x = (
        W1d * (Jx + I0)
        + W2 * W3 * (Jz - Jy)
        + s.total(
            i.m
            * (
                i.l
                * (
                    t.sC * (-W3d * reach + 2 * i.theta_dot * W2 * reach - ay - W1 * W2 * reach)
                    + t.sS * (-W2d * reach + 2 * i.theta_dot * W3 * reach + az)
                    + i.phi_dot * t.cS * (2 * W2 * reach)
                )
                + i.I / i.m * (i.phi_ddot + W1d)
                + i.I * (i.theta_dot * W2 + W2 * W3)
                - W3 * vz * reach
            )
        )
    )
    right = _derived_moments(s)
    yield _short("12", "x", _moment(s, 3, x, s.M[0], right[0]))
    y = (
        sigma * (W2d + az)
        + W2d * (Jy + I0)
        + W1 * W3 * (Jx - Jz)
        + s.total(
            i.m
            * (
                i.l
                * (
                    t.sC * (-(W3**2) * reach + s.v_dot[0] - W3 * vy)
                    + t.sS * (2 * W3 * vz - 2 * W1 * vx)
                    - reach * (-2 * i.phi_dot * W2 * t.s + W2 * W3 * t.sS)
                )
                - reach * ((-W2d + W1 * W3) * reach + az)
                + i.I * W2d / i.m
                + i.I * W3 * (i.phi_dot + W1)
                - i.I * W1 * (i.theta_dot + W3)
            )
        )
    )
    (d1, d2), lever = s.delta, s.F * (s.b + s.d)
    yield _short("13", "y", _moment(s, 4, y, s.M[1] - lever * sp.sin(d1) * sp.cos(d2), right[1]))
    torque = s.M[2] - lever * sp.sin(d2)
    yield (
        printed("14", "balance of moments about z", "equation", note=_SHORT)
        .reading(
            "the terms with I_i multiplied by m_i",
            _moment(s, 5, _about_z(s, True), torque, right[2]),
            why=_MISSING + "so they stand in (12) and (13).",
        )
        .reading(
            "the terms with I_i outside the factor m_i",
            _moment(s, 5, _about_z(s, False), torque, right[2]),
            used=False,
            why=_MISSING + "they need no factor m_i.",
        )
    )


def _derived_moments(s: Spacecraft) -> tuple[Expr, Expr, Expr]:
    """Return the left sides that (12)-(14) should have."""
    i, (W1, W2, W3), (W1d, W2d, W3d) = s.i, s.w, s.w_dot
    (_, ay, az), (Jx, Jy, Jz) = s.a, s.J
    sigma, I0 = s.m * s.b + s.m0 * s.h0, s.I0
    own = s.m * s.b**2 + s.m0 * s.h0**2
    place, force = _bob(s)
    spin = (
        i.I / i.m * (i.phi_ddot + W1d + W2 * i.theta_dot),
        i.I * W2d / i.m + i.I / i.m * W3 * i.phi_dot - i.I / i.m * W1 * i.theta_dot,
        i.I / i.m * (i.theta_ddot + W3d) - i.I / i.m * W2 * i.phi_dot,
    )
    swung = [s.total(i.m * (turn + e)) for turn, e in zip(place.cross(force), spin, strict=True)]
    return (
        W1d * (Jx + I0) + W2 * W3 * (Jz - Jy) + swung[0],
        own * (W2d - W1 * W3) + sigma * az + W2d * (Jy + I0) + W1 * W3 * (Jx - Jz) + swung[1],
        own * (W3d + W1 * W2) - sigma * ay + W3d * (Jz + I0) + W1 * W2 * (Jy - Jx) + swung[2],
    )


def _about_z(s: Spacecraft, inside: bool) -> Expr:
    i, t, (W1, W2, W3) = s.i, Shorthand(s.i), s.w
    (ax, ay, _), W3d = s.a, s.w_dot[2]
    sigma, reach = s.m * s.b + s.m0 * s.h0, i.h - i.l * t.c
    own = sigma * (W3d - ay) + W3d * (s.J[2] + s.I0) + W1 * W2 * (s.J[1] - s.J[0])
    bob = (
        i.l * (t.sS * (ax + W2**2 * reach) + t.sC * (W2 * W3 * reach - 2 * W2 * s.v[1]) - W1 * W2 * t.c)
        + reach * (ay + (W3d + W1 * W2) * reach)
        + i.I / i.m * (i.theta_ddot + W3d)
    )
    rotor = i.I * W2 * (-i.phi_dot - W1) + i.I * W1 * W2
    return own + s.total(i.m * (bob + rotor) if inside else i.m * bob + rotor)


def _bob(s: Spacecraft) -> tuple[sp.Matrix, sp.Matrix]:
    """Return place and acceleration of bob i: a + Omega' x r + Omega x (Omega x r + 2 r') + r''."""
    i, t, (W1, W2, W3) = s.i, Shorthand(s.i), s.w
    place = sp.Matrix([i.h - i.l * t.c, i.l * t.sS, i.l * t.sC])
    moved = matrix_rate(place, {i.phi: i.phi_dot, i.theta: i.theta_dot})
    rates = {i.phi: i.phi_dot, i.theta: i.theta_dot, i.phi_dot: i.phi_ddot, i.theta_dot: i.theta_ddot}
    turn, turning = sp.Matrix([W1, W2, W3]), sp.Matrix(s.w_dot)
    carried = turning.cross(place) + turn.cross(turn.cross(place) + 2 * moved)
    linear = sp.Matrix([s.a_spelled[0], *s.a[1:]])
    return place, linear + carried + matrix_rate(moved, rates)


def _short(number: str, axis: str, relation: Relation) -> Printed:
    return printed(number, f"balance of moments about {axis}", "equation", relation, note=_SHORT)


def _moment(s: Spacecraft, row: int, left: Expr, right: Expr, corrected: Expr) -> Relation:
    return Relation(left, right, corrected_left=corrected, against=s.balance[row])


def acceleration(s: Spacecraft) -> Printed:
    """(17): the acceleration of the tank centre."""
    return printed(
        "17",
        "acceleration of the tank centre",
        "definition",
        Relation(s.a_column, s.V_dot + Cross(s.Omega, s.V)),
    )
