# SPDX-License-Identifier: Apache-2.0
"""Attitude of the body by the paper's small angles, 3-2-1 angles or a quaternion.

The paper uses a_j' = Omega_j, which holds only for small angles. The 3-2-1 angles (roll a_1, pitch a_2, yaw a_3) are
singular at a_2 = +-90 degrees; the quaternion has no singularity.
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from ...derivation import vector
from ...mechanics import angle_rates, frame_turn, quaternion_of_turns, quaternion_rates, quaternion_rotation
from ...system import Derivation, Expr, Group, Quantity
from ..states import ATTITUDE, QUATERNION, rate

angles = tuple(q.symbol for q in ATTITUDE)


@dataclass(frozen=True)
class Attitude:
    """States of the attitude, and quantities that follow from them.

    Attributes
    ----------
    states : tuple of Quantity
        Angles or quaternion.
    rates : mapping of str to tuple of Expr
        Their rates, by name of the kinematics; the first is the default.
    angles : tuple of Expr
        The three attitude angles that the laws use.
    start : tuple of Expr
        States at the initial angles of a scenario.
    projected : tuple of Expr
        States after projection to their manifold.
    """

    states: tuple[Quantity, ...]
    rates: dict[str, tuple[Expr, ...]]
    angles: tuple[Expr, ...]
    start: tuple[Expr, ...]
    projected: tuple[Expr, ...]


def by_angles(scenario: Group) -> Attitude:
    """Return the attitude by three angles: small (a_j' = Omega_j) or 3-2-1."""
    turned = frame_turn(0, angles[0]) * frame_turn(1, angles[1]) * frame_turn(2, angles[2])
    euler = tuple(angle_rates(turned, angles, rate))
    start = (scenario.att1_0, scenario.att2_0, scenario.att3_0)
    return Attitude(ATTITUDE, {"small": tuple(rate), "euler": euler}, angles, start, angles)


def by_quaternion(scenario: Group, d: Derivation) -> Attitude:
    """Return the attitude by a unit quaternion; its 3-2-1 angles are outputs."""
    d.section("Attitude angles of the quaternion")
    q = tuple(q.symbol for q in QUATERNION)
    turn = quaternion_rotation(q)
    pitch = sp.asin(sp.Max(-1, sp.Min(1, -turn[0, 2])))
    values = (sp.atan2(turn[1, 2], turn[2, 2]), pitch, sp.atan2(turn[0, 1], turn[0, 0]))
    named = tuple(vector("angle*", values, "3-2-1 attitude angle *", "rad", "a_*", d, labels="123"))
    start = quaternion_of_turns(((2, scenario.att3_0), (1, scenario.att2_0), (0, scenario.att1_0)))
    half = vector("half_w*", rate / 2, "half the body rate", "rad/s", r"\Omega_*/2", d, labels="123")
    length = sp.sqrt(sp.Add(*(e**2 for e in q)))
    return Attitude(
        QUATERNION,
        {"quaternion": tuple(quaternion_rates(q, [2 * w for w in half]))},
        named,
        tuple(start),
        tuple(e / length for e in q),
    )
