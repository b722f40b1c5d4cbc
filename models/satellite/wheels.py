# SPDX-License-Identifier: Apache-2.0
"""Reaction wheels: the paper's three along the body axes, or as many along any axes as parameters.toml has columns."""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from ..system import Condition, Derivation, Expr, Group, Quantity

FEWEST = 3
"""Wheels about fewer axes leave the body free about one: no law here is meant for that."""


@dataclass(frozen=True)
class Wheels:
    """A set of wheels.

    Attributes
    ----------
    labels : tuple of str
        What each wheel is called in names.
    states, inputs : tuple of Quantity
        The absolute momentum of each about its axis, and the torque of its motor on the body.
    axes : sympy.Matrix
        The directions, a column each.
    inertia : tuple of Expr
        Their spin inertias.
    share : Expr
        1 where the torques come of wheels, 0 where they come from outside.
    start : tuple of Expr
        Momenta at the start.
    pseudoinverse : sympy.Matrix
        Takes a torque on the body to the smallest torques of the motors.
    idle : sympy.Matrix
        Projection on torques of the motors that do not turn the body: what moves momentum between wheels.
    """

    labels: tuple[str, ...]
    states: tuple[Quantity, ...]
    inputs: tuple[Quantity, ...]
    axes: sp.Matrix
    inertia: tuple[Expr, ...]
    share: Expr
    start: tuple[Expr, ...]
    pseudoinverse: sp.Matrix
    idle: sp.Matrix

    @property
    def momenta(self) -> sp.Matrix:
        """The momenta as a column."""
        return sp.Matrix([q.symbol for q in self.states])

    @property
    def torques(self) -> sp.Matrix:
        """The motors' torques as a column."""
        return sp.Matrix([q.symbol for q in self.inputs])

    @property
    def momentum(self) -> sp.Matrix:
        """What the wheels hold together, in body axes."""
        return self.axes * self.momenta

    @property
    def locked(self) -> sp.Matrix:
        """What the wheels add to the inertia when they do not turn against the body."""
        return self.axes * sp.diag(*self.inertia) * self.axes.T


_MOMENTA = tuple(Quantity(f"h{i}", "N m s", f"absolute momentum of wheel {i} about its axis", f"h_{i}") for i in "xyz")
_TORQUES = tuple(Quantity(f"T{i}", "N m", f"control torque on the body about {i}", f"T_{i}") for i in "xyz")


def along_axes(plant: Group, s: Group) -> Wheels:
    """Return the paper's wheels, along x, y and z."""
    inertia = (plant.Iw_x, plant.Iw_y, plant.Iw_z)
    start = (s.hx_0, s.hy_0, s.hz_0)
    return Wheels(tuple("xyz"), _MOMENTA, _TORQUES, sp.eye(3), inertia, plant.wheels, start, sp.eye(3), sp.zeros(3))


def along_any(plant: Group, s: Group, d: Derivation) -> Wheels:
    """Return wheels along the columns of `wheel_axes`, which need not have the length one."""
    d.section("Wheels")
    directions, labels = plant.wheel_axes, [str(k + 1) for k in range(plant.wheel_axes.cols)]
    axes = sp.zeros(3, len(labels))
    for k, label in enumerate(labels):
        length = sp.sqrt(sp.Add(*(entry**2 for entry in directions[:, k])))
        for j, i in enumerate("xyz"):
            title = f"axis of wheel {label} along {i}"
            axes[j, k] = d.define(f"a{label}_{i}", directions[j, k] / length, "", title, "1", f"a_{{{label},{i}}}")
    pseudoinverse = _pseudoinverse(axes, d)
    return Wheels(
        tuple(labels),
        tuple(Quantity(f"h{k}", "N m s", f"absolute momentum of wheel {k} about its axis", f"h_{k}") for k in labels),
        tuple(Quantity(f"T{k}", "N m", f"torque of the motor of wheel {k} on the body", f"T_{k}") for k in labels),
        axes,
        tuple(plant.wheel_inertia),
        sp.S.One,
        tuple(s.wheel_momentum_0),
        pseudoinverse,
        sp.eye(len(labels)) - pseudoinverse * axes,
    )


def _pseudoinverse(axes: sp.Matrix, d: Derivation) -> sp.Matrix:
    """Define A' (A A')^-1; it depends on parameters alone."""
    square, gram, inverse = axes * axes.T, sp.zeros(3), sp.zeros(3)
    for name, values, named in (("gram", square, gram), ("spread", None, inverse)):
        values = gram.inv(method="ADJ") if values is None else values
        title = "A A' of the wheels' axes" if named is gram else "inverse of A A'"
        for i in range(3):
            for j in range(i, 3):
                latex = rf"{'g' if named is gram else 'G'}_{{{i + 1}{j + 1}}}"
                named[i, j] = named[j, i] = d.define(f"{name}{i + 1}{j + 1}", values[i, j], "", title, "1", latex)
    return axes.T * inverse


def spanning(plant: Group) -> Condition:
    """Return that the wheels' axes span all directions: the volumes of three columns at a time, squared and added."""
    directions = plant.wheel_axes
    return Condition((directions * directions.T).det(method="berkowitz"), "the wheels' axes wheel_axes lie in a plane")
