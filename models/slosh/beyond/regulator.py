# SPDX-License-Identifier: Apache-2.0
"""A linear-quadratic regulator with the fuel's motion estimated: what the field would fly today.

Linearised about straight flight the craft falls apart into roll and two equal planes. In the plane of y the state is

    (w_y, a_3, Omega_3, s_1y, s_2y, sigma_1y, sigma_2y, g_2)

with w the velocity in fixed axes, which unlike v_y does not hold v_x a_3. Turned by a right angle about x it is that of
the plane of z. A Kalman filter estimates it from w, attitude and body rate; bobs and gimbals are not measured. The
matrices are of the model's own Jacobian and stand in parameters.toml: papers/slosh/regulator.py renews them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp

from ...mechanics import quaternion_rotation
from ...system import Condition, Controller, Derivation, Expr, Group, Quantity
from ..states import INPUTS, QUATERNION, rate, velocity
from .engine import clip

STATES = (
    ("drift", "m/s", "lateral velocity in fixed axes"),
    ("tilt", "rad", "attitude"),
    ("spin", "rad/s", "body rate"),
    ("lean1", "1", "direction of bob 1"),
    ("lean2", "1", "direction of bob 2"),
    ("swing1", "1/s", "rate of bob 1"),
    ("swing2", "1/s", "rate of bob 2"),
    ("gimbal", "rad", "gimbal"),
)
"""Of a plane; the first three are measured."""
MEASURED = 3
_SAME = sp.Rational(1, 10**9)
"""Part by which periods may differ that are the same: what is lost in writing one down."""
APPLIED = Group("u_applied", tuple(Quantity(f"{q.name}_applied", q.unit, q.description) for q in INPUTS))


@dataclass(frozen=True)
class Plane:
    """One of the two planes.

    Attributes
    ----------
    name : str
        "y" or "z".
    measured : tuple of Expr
        w, a and Omega of it.
    applied : tuple of Expr
        Moment and gimbal command over the last sample.
    """

    name: str
    measured: tuple[Expr, ...]
    applied: tuple[Expr, ...]

    @property
    def memory(self) -> tuple[Quantity, ...]:
        """Estimates."""
        return tuple(
            Quantity(
                f"{name}_{self.name}",
                unit,
                f"estimate: {text}, plane of {self.name}",
                rf"\mathrm{{{name}}}_{self.name}",
            )
            for name, unit, text in STATES
        )


def regulator(c: Group, sample: Expr, angles: Sequence[Expr], d: Derivation) -> Controller:
    """Define the law.

    Parameters
    ----------
    c : Group
        Matrices and limits of the law.
    sample : Expr
        Its sampling period, s.
    angles : sequence of Expr
        Attitude angles.
    d : Derivation
        Receives the steps.
    """
    d.section("Regulator with an estimate of the fuel's motion")
    turn = quaternion_rotation(tuple(q.symbol for q in QUATERNION)).T
    _, wy, wz = turn * velocity
    _, w2, w3 = rate
    _, my, mz, d1, d2 = APPLIED.symbols
    planes = (
        Plane("y", (wy, angles[2], w3), (mz, d2)),
        Plane("z", (wz, -angles[1], -w2), (-my, -d1)),
    )
    updates, commands = [], []
    for plane in planes:
        update, command = _plane(plane, c, d)
        updates += update
        commands.append(command)
    (moment_y, gimbal_y), (moment_z, gimbal_z) = commands
    roll = -(c.K_roll * angles[0] + c.K_spin * rate[0])
    memory = Group("z", tuple(q for plane in planes for q in plane.memory))
    begun = tuple(
        entry for plane in planes for entry in (*plane.measured, *(sp.S.Zero for _ in range(len(STATES) - MEASURED)))
    )
    return Controller(
        "regulator",
        "linear-quadratic regulator with the fuel's motion estimated",
        c,
        (roll, -moment_z, moment_y, -gimbal_z, gimbal_y),
        period="sample",
        applied=APPLIED,
        memory=memory,
        start=begun,
        update=tuple(updates),
        warnings=(
            Condition(
                _SAME * c.sample_of_gains - sp.Abs(sample - c.sample_of_gains),
                "sample = {sample:g} s: the regulator's gains are made for sample_of_gains = {sample_of_gains:g} s",
            ),
        ),
        in_numbers=True,
    )


def _plane(plane: Plane, c: Group, d: Derivation) -> tuple[list[Expr], tuple[Expr, Expr]]:
    """Return the estimate after a measurement and the command for it, moment and gimbal angle."""
    before = sp.Matrix([q.symbol for q in plane.memory])
    applied = sp.Matrix(plane.applied)
    ahead = c.Phi * before + c.Gamma * applied
    predicted = sp.Matrix(
        [
            d.define(f"{q.name}_ahead", entry, title=f"predicted: {q.description}", unit=q.unit)
            for q, entry in zip(plane.memory, ahead, strict=True)
        ]
    )
    error = sp.Matrix(plane.measured) - predicted[:MEASURED, :]
    estimate = predicted + c.L_gain * sp.Matrix(
        [
            d.define(f"{q.name}_error", e, unit=q.unit, title="prediction error")
            for q, e in zip(plane.memory, error, strict=False)
        ]
    )
    named = [
        d.define(f"{q.name}_now", entry, title=q.description, unit=q.unit)
        for q, entry in zip(plane.memory, estimate, strict=True)
    ]
    wanted = sp.Matrix([clip(named[0], c.w_max), *named[1:]])
    moment, gimbal = -c.K_gain * wanted
    return list(named), (moment, clip(gimbal, c.gimbal_max))
