# SPDX-License-Identifier: Apache-2.0
"""Evaluation form of (9)-(16) for pendulums described by angles: O(N), without a large matrix.

The equations (15), (16) are solved for the angle accelerations and put into the hull's balances (arrow elimination),
each in the frame of its pendulum; what is left is one symmetric 6 x 6 system.
"""

from __future__ import annotations

from collections.abc import Sequence

from ...system import Derivation, Group
from ..states import Pendulum
from .geared import geared_angles, geared_pull
from .hinged import hinged_angles, hinged_pull
from .hull import Dynamics, balance, lump
from .linear import factorise, solve
from .swing import swing_of


def angle_dynamics(p: Group, pendulums: Sequence[Pendulum], inertia: str, d: Derivation) -> Dynamics:
    """Define the accelerations for pendulums described by angles.

    Parameters
    ----------
    p : Group
        Parameters of the plant.
    pendulums : sequence of Pendulum
        Parameters of each.
    inertia : {"paper", "hinge"}
        Convention of their inertia term.
    d : Derivation
        Receives the steps.
    """
    geared = inertia == "paper"
    hull, arms = lump(p, pendulums, geared, d)
    swings = [swing_of(k, d) for k in range(1, len(pendulums) + 1)]
    pull, recover = (geared_pull, geared_angles) if geared else (hinged_pull, hinged_angles)
    pulls = [pull(a, arm, swing, hull, d) for a, arm, swing in zip(pendulums, arms, swings, strict=True)]
    whole = balance(hull, pulls, d)
    factors = factorise(whole.matrix, "K", d)
    right = [
        d.define(f"b{k}", applied - bias, title="right side", latex=f"b_{k}")
        for k, (applied, bias) in enumerate(zip(hull.applied, whole.bias, strict=True), 1)
    ]
    unknown = solve(factors, right, "X", d)
    angles = [
        angle
        for a, arm, swing in zip(pendulums, arms, swings, strict=True)
        for angle in recover(a, arm, swing, hull, unknown, d)
    ]
    return Dynamics(hull, whole, factors, unknown, tuple(angles))
