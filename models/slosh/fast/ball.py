# SPDX-License-Identifier: Apache-2.0
"""Bobs on ball joints, assembled from parts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp

from ...parts import Bob, Hub, Load
from ...parts.assembly import balance, mount, moved
from ...parts.frame import AXES, Frame
from ...parts.part import Craft, rate_products
from ...system import Derivation, Group, Quantity
from ..plant.equations import gimbal_position, thrust
from ..states import MOMENTS, Pendulum, arm_rate_quantities, direction_quantities, rate, velocity
from .hull import Balance, Dynamics
from .linear import factorise


@dataclass(frozen=True)
class Fuel(Bob):
    """A bob whose states have the names of a pendulum's direction s and its inertial rate sigma.

    Parameters
    ----------
    number : int
        Number of the pendulum; the other fields are those of a `Bob`.
    """

    number: int = 0

    def _vectors(self) -> tuple[tuple[Quantity, ...], ...]:
        return direction_quantities(self.number), arm_rate_quantities(self.number)


def fuel(pendulum: Pendulum) -> Fuel:
    """Return the part that represents a pendulum."""
    a = pendulum
    return Fuel(f"bob{a.name}", a.mass, a.length, (a.pivot, 0, 0), a.damping, a.inertia, number=int(a.name))


def slip_symbols(pendulum: Pendulum) -> tuple[sp.Symbol, ...]:
    """Return the symbols of s' that the part of a pendulum defines."""
    return tuple(sp.Symbol(f"{fuel(pendulum).name}_de{axis}", real=True) for axis in AXES)


def ball_dynamics(p: Group, pendulums: Sequence[Pendulum], d: Derivation) -> Dynamics:
    """Define the accelerations for bobs on ball joints.

    Parameters
    ----------
    p : Group
        Parameters of the plant.
    pendulums : sequence of Pendulum
        Parameters of each.
    d : Derivation
        Receives the steps.
    """
    craft = Craft(Frame.of(p.symbols, rate, d))
    hull = Hub("hull", p.m, (p.J_x, p.J_y, p.J_z), (-p.b, 0, 0))
    fixed = Hub("fuel", p.m0, (p.I0,) * 3, (-p.h0, 0, 0))
    bobs = [fuel(pendulum) for pendulum in pendulums]
    force = craft.frame.vector("f_", thrust(p), "thrust", "N")
    mount(craft, (hull, fixed, *bobs))
    motions = moved(craft, [Load(force, gimbal_position(p), sp.Matrix([q.symbol for q in MOMENTS]))])
    acceleration, turning = motions[0].origin, motions[0].angular
    placed = list(zip(craft.parts, motions, strict=True))[2:]
    states = [part.rates(at, motion) for (part, at), motion in placed]
    whole, products = balance(craft), rate_products(craft.frame)
    sides = sp.diag(sp.eye(4), sp.Matrix([[0, 1], [-1, 0]]))  # Omega_z' and -Omega_y' for G_y and G_z
    matrix = sides * whole.matrix * sides.T
    return Dynamics(
        whole.centre[0], (products[0, 1], products[0, 2]), True, Balance(matrix, tuple(-sides * whole.right)),
        factorise(matrix[:3, :3], "K", d), tuple(acceleration - rate.cross(velocity)), tuple(turning),
        tuple(acceleration), tuple(entry for of in states for entry in of[3:]),
    )  # fmt: skip
