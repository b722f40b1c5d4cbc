# SPDX-License-Identifier: Apache-2.0
"""Attitude of the body by the paper's small angles, 3-2-1 angles or a quaternion.

The paper uses a_j' = Omega_j, which holds only for small angles. The 3-2-1 angles (roll a_1, pitch a_2, yaw a_3) are
singular at a_2 = +-90 degrees; the quaternion has no singularity.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ...derivation import vector
from ...parts.charts import Chart, EulerChart, QuaternionChart, turn_angles
from ...parts.frame import Frame
from ...system import Derivation, Expr
from ..states import ATTITUDE, QUATERNION, rate


@dataclass(frozen=True)
class Attitude:
    """States of the attitude, and quantities that follow from them.

    Attributes
    ----------
    chart : Chart
        Chart by angles or a quaternion.
    rates : mapping of str to tuple of Expr
        Rates of its states, by name of the kinematics; the first is the default.
    angles : tuple of Expr
        The three attitude angles that the laws use.
    """

    chart: Chart
    rates: dict[str, Sequence[Expr]]
    angles: Sequence[Expr]


def by_angles(d: Derivation) -> Attitude:
    """Return the attitude by three angles: small (a_j' = Omega_j) or 3-2-1."""
    chart = EulerChart(ATTITUDE)
    return Attitude(chart, {"small": tuple(rate), "euler": chart.rates(Frame(d, rate))}, chart.symbols)


def by_quaternion(d: Derivation) -> Attitude:
    """Return the attitude by a unit quaternion; its 3-2-1 angles are outputs."""
    d.section("Attitude angles of the quaternion")
    chart = QuaternionChart(QUATERNION)
    angles = turn_angles(chart.rotation())
    named = vector("angle*", angles, "3-2-1 attitude angle *", "rad", "a_*", d, labels="123")
    return Attitude(chart, {"quaternion": chart.rates(Frame(d, rate))}, tuple(named))
