# SPDX-License-Identifier: Apache-2.0
"""Equations of the pendulums' angles in the slosh paper, (15) and (16), as printed."""

from __future__ import annotations

from collections.abc import Iterator

import sympy as sp
from sympy import Expr

from mehvar.ledger import Case, Printed, Relation, printed

from .symbols import Spacecraft
from .terms import Shorthand

_SHORT = "Printed in short, as (12)-(14)."


def phi_bracket(s: Spacecraft, turn: Expr, second: Expr) -> Expr:
    """Return the factor of l_i in (15) and (25); they print theta' with and without its dot, and l_i phi'."""
    i, t, (W1, W2, W3) = s.i, Shorthand(s.i), s.w
    (_, W2d, W3d), (vxd, vyd, vzd), (vx, vy, vz) = s.w_dot, s.v_dot, s.v
    reach = i.h - i.l * t.c
    return (
        t.s * (vxd + second + i.l * i.phi_dot**2 * t.c)
        + t.cS * (W3d * reach + vyd)
        + i.phi_dot * t.sS * (W3 * reach + vy)
        + turn * t.cC * (W3 * reach + vy)
        + t.cC * (-W2d * reach + vzd)
        + i.phi_dot * t.sC * (W2 * reach)
        + i.theta_dot * t.sC * (W2 * reach)
        - (W3**2 + W2**2) * t.s * reach
        + vx * (-W3 * t.s + W1 * t.cC + i.phi_dot * t.sS - i.theta_dot * t.cC)
        + vz * (W2 * t.s - W1 * t.cC)
    )


def theta_bracket(s: Spacecraft) -> Expr:
    """Return the factor of l_i in (16) and (26)."""
    i, t, (W1, W2, W3) = s.i, Shorthand(s.i), s.w
    (_, W2d, W3d), (_, vyd, vzd), (vx, vy, vz) = s.w_dot, s.v_dot, s.v
    reach = i.h - i.l * t.c
    return (
        t.sC * (W3d * reach + vyd)
        + i.phi_dot * t.cC * (W3 * reach)
        + i.theta_dot * t.sS * (-W3 * reach)
        + t.sS * (W2d * reach - vzd)
        + i.phi_dot * t.cS * (W2 * reach)
        + i.theta_dot * t.sC * (W2 * reach)
        + vx * (W3 * t.sC + W2 * t.sS)
        - vy * W1 * t.sS
        - vz * W1 * t.sC
    )


def corrected_phi(s: Spacecraft, second: Expr) -> Expr:
    """Return the right factor of l_i in (15) and (25), in the printed order: printed terms, then lost ones."""
    i, t, (W1, W2, W3) = s.i, Shorthand(s.i), s.w
    (_, W2d, W3d), (vxd, vyd, vzd), (vx, vy, vz) = s.w_dot, s.v_dot, s.v
    along, across, reach = W2 * t.S + W3 * t.C, W2 * t.C - W3 * t.S, i.h - i.l * t.c
    return (
        t.s * (vxd + second - i.l * i.theta_dot**2 * t.c)
        + t.cS * (W3d * reach + vyd)
        + t.cC * (-W2d * reach + vzd)
        - (W3**2 + W2**2) * t.s * reach
        + vy * (-W3 * t.s + W1 * t.cC)
        + vz * (W2 * t.s - W1 * t.cS)
        + vx * (W3 * t.cS - W2 * t.cC)
        + i.l * t.s**2 * (W2d * t.C - W3d * t.S)
        + 2 * i.l * i.theta_dot * t.s * (W1 * t.c - t.s * along)
        - i.l * t.s * t.c * across**2
        + W1 * t.c * reach * along
        + i.l * t.s**2 * W1 * along
        - i.l * t.s * t.c * W1**2
    )


def corrected_theta(s: Spacecraft) -> Expr:
    """Return the right factor of l_i in (16) and (26), in the printed order: printed terms, then lost ones."""
    i, t, (W1, W2, W3) = s.i, Shorthand(s.i), s.w
    (W1d, W2d, W3d), (_, vyd, vzd), (vx, vy, vz) = s.w_dot, s.v_dot, s.v
    along, across, reach = W2 * t.S + W3 * t.C, W2 * t.C - W3 * t.S, i.h - i.l * t.c
    return (
        t.sC * (W3d * reach + vyd)
        + t.sS * (W2d * reach - vzd)
        + vx * (W3 * t.sC + W2 * t.sS)
        - vy * W1 * t.sS
        - vz * W1 * t.sC
        - i.l * t.s**2 * W1d
        + 2 * i.l * t.s * t.c * i.phi_dot * i.theta_dot
        + 2 * i.l * t.s * i.phi_dot * (t.s * along - t.c * W1)
        + t.s * reach * W1 * across
        + i.l * t.s**2 * along * across
    )


def pendulums(s: Spacecraft) -> Iterator[Printed]:
    """(15), (16): the equations of phi_i and theta_i."""
    i, t = s.i, Shorthand(s.i)
    phi = i.m * (i.l * phi_bracket(s, i.theta_dot, i.l * i.phi_dot * t.s))
    yield _row(
        "15",
        "phi_i",
        s,
        phi + i.I * (i.phi_ddot + s.w_dot[0]) - i.eps * i.phi_dot,
        i.m * (i.l * (corrected_phi(s, i.l * i.phi_ddot * t.s) + i.l * i.phi_ddot * t.c**2))
        + i.I * (i.phi_ddot + s.w_dot[0])
        + i.eps * i.phi_dot,
        0,
    )
    theta = i.m * (i.l * theta_bracket(s))
    yield _row(
        "16",
        "theta_i",
        s,
        theta + i.I * (i.theta_ddot + s.w_dot[2]) + i.eps * i.theta_dot,
        i.m * (i.l * (corrected_theta(s) + i.l * t.s**2 * i.theta_ddot))
        + i.I * (i.theta_ddot + s.w_dot[2])
        + i.eps * i.theta_dot,
        1,
    )


def _row(number: str, angle: str, s: Spacecraft, left: Expr, corrected: Expr, place: int) -> Printed:
    cases: tuple[Case, ...] = tuple(
        {**each, s.row[place]: rows[place]} for each, rows in zip(s.each(), s.rows, strict=True)
    )
    why = "Printed both with a sum over i and `for all i`; "
    return (
        printed(number, f"equation of {angle}", "equation", note=_SHORT)
        .reading(
            "for each pendulum, without the sum",
            Relation(left, sp.S.Zero, corrected_left=corrected, cases=cases, against=s.row[place]),
            why=why + "the equation of one angle cannot hold the damping of the other pendulum's.",
        )
        .reading(
            "with the sum over the pendulums",
            Relation(s.total(left), sp.S.Zero, corrected_left=corrected, cases=cases, against=s.row[place]),
            used=False,
            why=why + "two equations would be the same.",
        )
    )
