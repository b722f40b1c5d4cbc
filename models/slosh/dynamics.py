# SPDX-License-Identifier: Apache-2.0
"""Dynamics of hull, fixed fuel and bobs, assembled from parts.

Generation checks the assembled accelerations against the equations (9)-(16) as derived in `plant`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp

from ..parts import Hub, Load
from ..parts.assembly import Balance, Factors, balance, factorise, mount, moved
from ..parts.frame import Frame
from ..parts.part import Craft
from ..system import Derivation, Expr, Group
from .bobs import bob
from .plant.equations import gimbal_position, thrust
from .states import MOMENTS, Pendulum, rate, velocity


@dataclass(frozen=True)
class Dynamics:
    """Accelerations, and the hull's equations, with which laws invert them.

    Attributes
    ----------
    frame : Frame
        Body axes.
    balance : Balance
        The hull's equations without thrust and control moments, about a point of the x axis.
    factors : Factors
        Factors of the block of their matrix that belongs to the acceleration.
    linear, angular, acceleration : tuple of Expr
        V', Omega' and the acceleration a of O.
    bobs : tuple of tuple of Expr
        Rates of the states of each bob.
    """

    frame: Frame
    balance: Balance
    factors: Factors
    linear: tuple[Expr, ...]
    angular: tuple[Expr, ...]
    acceleration: tuple[Expr, ...]
    bobs: tuple[tuple[Expr, ...], ...]


def dynamics(p: Group, pendulums: Sequence[Pendulum], inertia: str, d: Derivation) -> Dynamics:
    """Define the accelerations of hull and bobs.

    Parameters
    ----------
    p : Group
        Parameters of the plant.
    pendulums : sequence of Pendulum
        Parameters of each.
    inertia : {"paper", "hinge", "ball"}
        Convention of their inertia.
    d : Derivation
        Receives the steps.
    """
    craft = Craft(Frame.of(p.symbols, rate, d))
    hull = Hub("hull", p.m, (p.J_x, p.J_y, p.J_z), (-p.b, 0, 0))
    fixed = Hub("fuel", p.m0, (p.I0,) * 3, (-p.h0, 0, 0))
    force = craft.frame.vector("f_", thrust(p), "thrust", "N")
    mount(craft, (hull, fixed, *(bob(pendulum, inertia) for pendulum in pendulums)))
    motions = moved(craft, [Load(force, gimbal_position(p), sp.Matrix([q.symbol for q in MOMENTS]))])
    acceleration, turning = motions[0].origin, motions[0].angular
    bobs = [part.rates(at, motion) for (part, at), motion in zip(craft.parts[2:], motions[2:], strict=True)]
    whole = balance(craft)
    return Dynamics(
        craft.frame, whole, factorise(craft.frame, whole.matrix[:3, :3], ("hub_ax", "hub_ay", "hub_az")),
        tuple(acceleration - rate.cross(velocity)), tuple(turning), tuple(acceleration), tuple(bobs),
    )  # fmt: skip
