# SPDX-License-Identifier: Apache-2.0
"""Attitude laws with error quaternion and full inertia, in place of separate laws per axis."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import sympy as sp

from ...mechanics import quaternion_of_turns, quaternion_product
from ...system import Controller, Derivation, Expr, Group
from ..drive import Drive
from ..naming import vector
from .gyro import Rate


@dataclass(frozen=True)
class Motion:
    """Motion as the laws see it.

    Attributes
    ----------
    quaternion : tuple of Expr
        Attitude in the orbit axes.
    wanted : tuple of Expr
        Desired roll, pitch and yaw, rad.
    omega, rate : sympy.Matrix
        Rate relative to the orbit axes and inertial rate, rad/s; both include the gyro's bias.
    inertia, momentum : sympy.Matrix
        J, and the momentum of the wheels.
    """

    quaternion: tuple[Expr, ...]
    wanted: tuple[Expr, ...]
    omega: sp.Matrix
    rate: sp.Matrix
    inertia: sp.Matrix
    momentum: sp.Matrix


@dataclass(frozen=True)
class Error:
    """Attitude error; vector and scalar have the signs of the shorter rotation."""

    scalar: Expr
    vector: sp.Matrix


Law = Callable[[Error, sp.Matrix, sp.Matrix, Motion, Group], sp.Matrix]
"""Function that returns a torque for error, rate relative to the orbit axes, orbit rate, motion and parameters."""


def error(quaternion: Sequence[Expr], wanted: Sequence[Expr], tag: str, d: Derivation) -> Error:
    """Define the error quaternion from desired to current attitude along the shorter rotation."""
    goal = quaternion_of_turns([(axis, wanted[axis]) for axis in (2, 1, 0)])
    product = quaternion_product((goal[0], *(-part for part in goal[1:, 0])), tuple(quaternion))
    parts = [d.define(f"e{k}_{tag}", product[k], "", f"error quaternion, {k}", latex=f"e_{k}") for k in range(4)]
    side = d.define(
        f"way_{tag}", sp.Piecewise((1, parts[0] >= 0), (-1, True)), "", "sign of the shorter way", latex="s_e"
    )
    return Error(side * parts[0], side * sp.Matrix(parts[1:]))


def pointing(quaternion: Sequence[Expr], wanted: Sequence[Expr], d: Derivation) -> Expr:
    """Return the angle between current and desired attitude, rad."""
    off = error(quaternion, wanted, "pointing", d)
    return 2 * sp.atan2(sp.sqrt(off.vector.dot(off.vector)), off.scalar)


def feedback(off: Error, omega: sp.Matrix, carried: sp.Matrix, motion: Motion, law: Group) -> sp.Matrix:
    """Return the torque that makes the error about each axis a damped oscillator.

    Notes
    -----
    The torque is J (-2 wn^2 e - 2 zeta wn Omega) + w x (J w + h), where the last term removes the coupling. Rotation
    of the orbit axes and environment torques are neglected.
    """
    demand = -2 * law.bandwidth**2 * off.vector - 2 * law.ratio * law.bandwidth * omega
    return motion.inertia * demand + _gyroscopic(omega + carried, motion)


def sliding(off: Error, omega: sp.Matrix, carried: sp.Matrix, motion: Motion, law: Group) -> sp.Matrix:
    """Return the torque that drives Omega + slope e into a boundary layer around zero and keeps it there.

    Notes
    -----
    On the surface 2 e' = e_0 Omega + e x Omega, and C' = -[Omega x] C turns the rate of the orbit axes.
    """
    surface = omega + law.slope * off.vector
    along = (off.scalar * omega + off.vector.cross(omega)) / 2
    reach = (surface / law.layer).applyfunc(lambda part: sp.Max(-1, sp.Min(1, part)))
    demand = -law.slope * along - law.reach * reach - omega.cross(carried)
    return motion.inertia * demand + _gyroscopic(omega + carried, motion)


def _gyroscopic(rate: sp.Matrix, motion: Motion) -> sp.Matrix:
    return rate.cross(motion.inertia * rate + motion.momentum)


def attitude_law(
    name: str, title: str, form: Law, motion: Motion, seen: Rate, drive: Drive, law: Group, d: Derivation
) -> Controller:
    """Combine a law: error, torque, and actuator commands."""
    d.section(f"Law {name}: {title}")
    tag = name.replace("-", "_")
    off = error(motion.quaternion, motion.wanted, tag, d)
    demand = form(off, seen.omega, motion.rate - motion.omega, motion, law)
    torque = list(vector(f"u_*_{tag}", demand, "torque about *", "N m", "u(k)", d))
    return Controller(
        name,
        title,
        law,
        drive.commands(torque, law),
        period="Ts",
        memory=Group("z", seen.memory),
        start=seen.start,
        update=seen.update,
    )
