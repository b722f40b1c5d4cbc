# SPDX-License-Identifier: Apache-2.0
"""Safe mode: point the panels at the Sun with Sun sensor and gyro only."""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from ...system import Controller, Derivation, Expr, Group
from ..drive import Drive
from ..naming import vector

NORMAL = sp.Matrix([0, 0, -1])
"""Normal of the panels in body axes, away from the Earth."""

LEAST = sp.Rational(1, 10**4)
"""Sine below which the sine replaces the angle: the difference, its cube over six, is below single precision. Half or
twice the value changes nothing.
"""


def sun_pointing(
    drive: Drive, sun: Sequence[Expr], rates: sp.Matrix, inertia: sp.Matrix, law: Group, d: Derivation
) -> Controller:
    """Return the law J (b^2 a - 2 b w) with rotation a towards the Sun; in shadow a is zero and the law only damps.

    Parameters
    ----------
    drive : Drive
        The actuators.
    sun : sequence of Expr
        Measured direction of the Sun in body axes, zero in shadow.
    rates : sympy.Matrix
        Measured inertial rate, rad/s.
    inertia : sympy.Matrix
        J.
    law : Group
        Parameters.
    d : Derivation
        Receives the steps.
    """
    d.section("Law sun: the panels to the Sun")
    seen = sp.Matrix(sun)
    across = NORMAL.cross(seen)
    sine = d.define("sun_sine", sp.sqrt(across.dot(across)), "", "sine of the angle between panels and Sun", "1")
    angle = sp.atan2(sine, NORMAL.dot(seen))
    share = d.define(
        "sun_share", sp.Piecewise((angle / sine, sine > LEAST), (1, True)), "", "angle to the Sun over its sine", "1"
    )
    turn = law.sun_bandwidth**2 * share * across - 2 * law.sun_bandwidth * rates
    demand = inertia * turn
    torque = list(vector("u_*_sun", demand, "torque about *", "N m", "u(k)", d))
    return Controller("sun", "safe mode: panels to the Sun", law, drive.commands(torque, law), period="Ts")
