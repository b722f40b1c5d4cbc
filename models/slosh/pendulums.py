# SPDX-License-Identifier: Apache-2.0
"""Pendulums of a spacecraft, described by angles or by directions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import sympy as sp

from ..system import Derivation, Expr, Group, Quantity
from .bobs import ball_bob, slip_symbols
from .dynamics import Dynamics, dynamics
from .laws.controllers import Form
from .laws.weights import angle_form, ball_term
from .plant import ball, pendulum
from .plant.equations import ACCELERATIONS
from .plant.pendulum import Contribution, angle_acceleration
from .plant.reduced import angle_accelerations, angle_rows
from .states import Pendulum, angle_quantities, angle_rate_quantities, arm_rate_quantities, direction_quantities, rate

Accelerations = Sequence[Expr]


@dataclass(frozen=True)
class Pendulums:
    """Pendulums in one of two descriptions, by angles or by directions.

    Attributes
    ----------
    states : tuple of Quantity
        In the order of the system.
    start : tuple of Expr
        Their initial values.
    dynamics : Dynamics
        Evaluation form of the whole spacecraft.
    rates : tuple of Expr
        Rates of the states.
    reduced : callable
        (a, Omega') -> rates of the states for given accelerations of the hull.
    terms : callable
        (law parameters, a_x) -> the pendulums' terms of V1 and of (29).
    outputs : tuple of (Quantity, Expr)
        Angles that are not states.
    projected : tuple of Expr
        The states after projection to their manifold; unchanged without one.
    """

    states: tuple[Quantity, ...]
    start: tuple[Expr, ...]
    dynamics: Dynamics
    rates: tuple[Expr, ...]
    reduced: Callable[[Accelerations, Accelerations], tuple[Expr, ...]]
    terms: Callable[[Group, Expr], list[tuple[Expr, Form]]]
    outputs: tuple[tuple[Quantity, Expr], ...] = ()
    projected: tuple[Expr, ...] = ()


@dataclass(frozen=True)
class Start:
    """Initial angles and angle rates of one pendulum."""

    phi: Expr
    theta: Expr
    phi_rate: Expr
    theta_rate: Expr


def parts(inertia: str, pendulums: Sequence[Pendulum]) -> tuple[Contribution, list[dict[sp.Symbol, Expr]]]:
    """Return the generic contribution of a pendulum, and for each pendulum the values of the generic symbols."""
    if inertia == "ball":
        return ball.contribution(), [ball.instance(a, k) for k, a in enumerate(pendulums, 1)]
    return pendulum.contribution(inertia), [pendulum.instance(a, k) for k, a in enumerate(pendulums, 1)]


def equilibrium(inertia: str) -> dict[sp.Symbol, Expr]:
    """Return the equilibrium (18) of hull and pendulum i: rates zero, arm along -x, only a_x as acceleration."""
    still: tuple[Expr, ...] = (*rate, *ACCELERATIONS[1:])
    if inertia == "ball":
        still = (*still, *ball.direction, *ball.arm_rate, *ball.arm_acceleration)
        return dict.fromkeys(still, sp.S.Zero) | {ball.direction[0]: sp.S.NegativeOne}
    angles = (pendulum.phi, pendulum.theta, pendulum.phi_rate, pendulum.theta_rate, *angle_acceleration)
    return dict.fromkeys((*still, *angles), sp.S.Zero)


def angle_pendulums(
    p: Group, pendulums: Sequence[Pendulum], inertia: str, starts: Sequence[Start], d: Derivation
) -> Pendulums:
    """Describe the pendulums by angles, with the inertia convention `paper` or `hinge`."""
    numbers = range(1, len(pendulums) + 1)
    d.section("Evaluation of the equations of motion")
    moving = dynamics(p, pendulums, inertia, d)
    d.section("Reduced model, pendulum by pendulum")
    rows = angle_rows(pendulums, inertia, d)
    speeds = tuple(row.speed for row in rows)
    states = (
        *(q for k in numbers for q in angle_quantities(k)),
        *(q for k in numbers for q in angle_rate_quantities(k)),
    )

    def terms(c: Group, axial: Expr) -> list[tuple[Expr, Form]]:
        weights = (c.r9, c.r10) * len(pendulums)
        return [angle_form(row, weight, axial, d) for row, weight in zip(rows, weights, strict=True)]

    return Pendulums(
        states,
        (*(e for s in starts for e in (s.phi, s.theta)), *(e for s in starts for e in (s.phi_rate, s.theta_rate))),
        moving,
        (*speeds, *(e for bob in moving.bobs for e in bob[2:])),
        lambda linear, angular: (*speeds, *angle_accelerations(rows, linear, angular)),
        terms,
        (),
        tuple(q.symbol for q in states),
    )


def ball_pendulums(
    p: Group, pendulums: Sequence[Pendulum], starts: Sequence[Start], turning: Sequence[Expr], d: Derivation
) -> Pendulums:
    """Describe the pendulums by directions with inertial rates, on ball joints."""
    numbers = range(1, len(pendulums) + 1)
    d.section("Evaluation of the equations of motion")
    moving = dynamics(p, pendulums, "ball", d)
    names = [ball.instance(a, k) for k, a in enumerate(pendulums, 1)]
    slips = [slip_symbols(pendulum) for pendulum in pendulums]

    def reduced(linear: Accelerations, angular: Accelerations) -> tuple[Expr, ...]:
        hull = dict(zip(ACCELERATIONS, (*linear, *angular), strict=True))
        turned = [ball.arm_equation().xreplace(hull | named) for named in names]
        return tuple(e for slip, turn in zip(slips, turned, strict=True) for e in (*slip, *turn))

    def terms(c: Group, axial: Expr) -> list[tuple[Expr, Form]]:
        return [ball_term(a, k, named, c.r9, axial, d) for k, a, named in zip(numbers, pendulums, names, strict=True)]

    begun = (ball.at_angles(s.phi, s.theta, (s.phi_rate, s.theta_rate), turning) for s in starts)
    return Pendulums(
        tuple(q for k in numbers for q in (*direction_quantities(k), *arm_rate_quantities(k))),
        tuple(e for start in begun for e in start),
        moving,
        tuple(e for bob in moving.bobs for e in bob),
        reduced,
        terms,
        tuple(pair for k in numbers for pair in _angles(k)),
        tuple(e for pendulum in pendulums for e in ball_bob(pendulum).projection().values()),
    )


def _angles(k: int) -> tuple[tuple[Quantity, Expr], ...]:
    """Return phi and theta for a bob in direction s."""
    x, y, z = (q.symbol for q in direction_quantities(k))
    phi, theta = angle_quantities(k)
    return (phi, sp.atan2(sp.sqrt(y**2 + z**2), -x)), (theta, sp.atan2(y, z))
