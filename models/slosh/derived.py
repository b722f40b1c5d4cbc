# SPDX-License-Identifier: Apache-2.0
"""Derived equations of motion, as numbered equations and as residuals that check their efficient form."""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from ..system import Derivation, Expr, Group
from .pendulums import parts
from .plant import ball, pendulum
from .plant.equations import (
    accelerations_of,
    applied_wrench,
    hull_wrench,
    show_equations,
    velocity_accelerations,
    whole,
)
from .plant.pendulum import angle_acceleration
from .plant.reduced import generic_accelerations, show_reduced
from .states import RATE, VELOCITY, Pendulum, angle_rate_quantities, arm_rate_quantities, rate, velocity


def residuals(p: Group, bobs: Sequence[Pendulum], inertia: str) -> tuple[dict[str, sp.Symbol], tuple[Expr, ...]]:
    """Return the derived equations of motion as residuals, which are zero for correct rates.

    Parameters
    ----------
    p : Group
        Parameters of the plant.
    bobs : sequence of Pendulum
        Parameters of each pendulum.
    inertia : str
        Convention of their inertia.

    Returns
    -------
    rates : dict of str to Symbol
        For each velocity state, the symbol of its rate.
    residuals : tuple of Expr
        Left minus right sides of (9)-(16), linear in these symbols.
    """
    part, copies = parts(inertia, bobs)
    own = [sp.Symbol(f"{q.name}_rate", real=True) for q in (*VELOCITY, *RATE)]
    unknown, rows = _pendulum_equations(inertia, bobs)
    hull = velocity_accelerations(dict(zip((*velocity, *rate), own, strict=True)))
    named = [copy | _accelerations(inertia, k) for k, copy in enumerate(copies, 1)]
    left = whole(hull_wrench(p), (*part.force, *part.moment), named)
    balance = [side - applied for side, applied in zip(left, applied_wrench(p), strict=True)]
    states = [q.name for q in (*VELOCITY, *RATE)]
    for k in range(1, len(bobs) + 1):
        moving = arm_rate_quantities(k) if inertia == "ball" else angle_rate_quantities(k)
        states += [q.name for q in moving]
    equations = tuple(entry.xreplace(hull) for entry in (*balance, *rows))
    return dict(zip(states, (*own, *unknown), strict=True)), equations


def _pendulum_equations(inertia: str, pendulums: Sequence[Pendulum]) -> tuple[tuple[sp.Symbol, ...], tuple[Expr, ...]]:
    """Return the symbols of the pendulums' accelerations, and the residuals of (15), (16) or of the equations of s."""
    part, names = parts(inertia, pendulums)
    rows = tuple(ball.tangential_rows()) if inertia == "ball" else tuple(part.rows)
    named = [n | _accelerations(inertia, k) for k, n in enumerate(names, 1)]
    unknown = tuple(s for k in range(1, len(pendulums) + 1) for s in _accelerations(inertia, k).values())
    return unknown, tuple(row.xreplace(n) for n in named for row in rows)


def _accelerations(inertia: str, k: int) -> dict[sp.Symbol, Expr]:
    """Map the generic acceleration symbols to those of pendulum k."""
    if inertia == "ball":
        own = sp.symbols(" ".join(f"sigma{k}{axis}_dot" for axis in "xyz"), real=True)
        return dict(zip(ball.arm_acceleration, own, strict=True))
    return dict(zip(angle_acceleration, accelerations_of(k), strict=True))


def show(p: Group, inertia: str, d: Derivation) -> None:
    """Show the published derivation (5)-(26) in generic symbols."""
    if inertia == "ball":
        part = ball.contribution()
        show_equations(p, part, [("(15), (16)", row) for row in ball.tangential_rows()], d)
        arm = [
            (rf"\dot\sigma_{{i,{axis}}}", "(25), (26)", e) for axis, e in zip("xyz", ball.arm_equation(), strict=True)
        ]
        show_reduced(arm, d)
        return
    part = pendulum.contribution(inertia)
    show_equations(p, part, list(zip(("(15)", "(16)"), part.rows, strict=True)), d)
    first, second = generic_accelerations(inertia)
    show_reduced([(r"\ddot\varphi_i", "(25)", first), (r"\ddot\theta_i", "(26)", second)], d)
