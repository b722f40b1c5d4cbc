# SPDX-License-Identifier: Apache-2.0
"""Reaction wheels: the paper's three along the body axes, or any number along columns in parameters.toml."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import sympy as sp

from ...system import Condition, Derivation, Expr, Group, Quantity
from ..naming import symmetric, vector
from .rotors import Balanced, Unbalanced, unbalanced

FEWEST = 3
"""Smallest number of wheels: with fewer, an axis has no torque, which no law supports."""


@dataclass(frozen=True)
class Wheels:
    """A set of wheels.

    Attributes
    ----------
    labels : tuple of str
        Label of each wheel, used in names.
    states, inputs : tuple of Quantity
        Absolute momentum of each wheel about its axis, and its motor torque on the body.
    axes : sympy.Matrix
        The directions, a column each.
    inertia : tuple of Expr
        Their spin inertias.
    share : Expr
        1 if wheels exert the torques, 0 if the torques are external.
    start : tuple of Expr
        Momenta at the start.
    pseudoinverse : sympy.Matrix
        Maps a torque on the body to the smallest motor torques.
    idle : sympy.Matrix
        Projection on motor torques without effect on the body, which move momentum between wheels.
    locked : sympy.Matrix
        Inertia that locked wheels add.
    imbalances : tuple of Unbalanced
        Unbalanced wheels; empty for balanced ones.
    angles_at_start : tuple of Expr
        Angles that unbalanced wheels have turned at the start, rad.
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
    locked: sp.Matrix
    imbalances: tuple[Unbalanced, ...] = ()
    angles_at_start: tuple[Expr, ...] = ()

    @property
    def momenta(self) -> sp.Matrix:
        """Momenta as a column."""
        return sp.Matrix([q.symbol for q in self.states])

    @property
    def torques(self) -> sp.Matrix:
        """Motor torques as a column."""
        return sp.Matrix([q.symbol for q in self.inputs])

    @property
    def angles(self) -> tuple[Quantity, ...]:
        """Angles that unbalanced wheels have turned."""
        return tuple(wheel.angle for wheel in self.imbalances)

    def parts(self) -> tuple[Balanced, ...]:
        """Return the wheels as parts."""
        return self.imbalances or tuple(
            Balanced(f"wheel{label}", self.axes[:, k], self.inertia[k], self.momenta[k], self.share)
            for k, label in enumerate(self.labels)
        )

    @property
    def momentum(self) -> sp.Matrix:
        """Return the wheels' total momentum in body axes."""
        return self.axes * self.momenta


MOMENTA = tuple(Quantity(f"h{i}", "N m s", f"absolute momentum of wheel {i} about its axis", f"h_{i}") for i in "xyz")
TORQUES = tuple(Quantity(f"T{i}", "N m", f"control torque on the body about {i}", f"T_{i}") for i in "xyz")


def along_axes(plant: Group, s: Group) -> Wheels:
    """Return the paper's wheels along x, y and z."""
    inertia = (plant.Iw_x, plant.Iw_y, plant.Iw_z)
    start, one = (s.hx_0, s.hy_0, s.hz_0), sp.eye(3)
    return Wheels(
        tuple("xyz"), MOMENTA, TORQUES, one, inertia, plant.wheels, start, one, sp.zeros(3), sp.diag(*inertia)
    )


def along_any(plant: Group, s: Group, d: Derivation) -> Wheels:
    """Return wheels along the columns of `wheel_axes`, of any length."""
    d.section("Wheels")
    directions, labels = plant.wheel_axes, [str(k + 1) for k in range(plant.wheel_axes.cols)]
    axes = sp.zeros(3, len(labels))
    for k, label in enumerate(labels):
        axis = directions[:, k]
        length = sp.sqrt(sp.Add(*(entry**2 for entry in axis)))
        title, latex = f"axis of wheel {label} along *", f"a_{{{label},*}}"
        axes[:, k] = vector(f"a{label}_*", axis / length, title, "1", latex, d)
    gram = symmetric("gram", axes * axes.T, "A A' of the wheels' axes", "1", "g", d)
    spread = symmetric("spread", gram.inv(method="ADJ"), "inverse of A A'", "1", "G", d)
    inertia, pseudoinverse = tuple(plant.wheel_inertia), axes.T * spread
    locked = axes * sp.diag(*inertia) * axes.T
    return Wheels(
        tuple(labels),
        tuple(Quantity(f"h{k}", "N m s", f"absolute momentum of wheel {k} about its axis", f"h_{k}") for k in labels),
        tuple(Quantity(f"T{k}", "N m", f"torque of the motor of wheel {k} on the body", f"T_{k}") for k in labels),
        axes,
        inertia,
        sp.S.One,
        tuple(s.wheel_momentum_0),
        pseudoinverse,
        sp.eye(len(labels)) - pseudoinverse * axes,
        symmetric("Iw", locked, "what the wheels add to the inertia, locked", "kg m^2", "I_w", d),
    )


def off_balance(plant: Group, s: Group, d: Derivation) -> Wheels:
    """Return unbalanced wheels along the columns of `wheel_axes`."""
    wheels = along_any(plant, s, d)
    angles = (Quantity(f"angle{k}", "rad", f"angle that wheel {k} has turned", rf"\theta_{k}") for k in wheels.labels)
    off = tuple(
        unbalanced(part, k, plant, q, d) for k, (part, q) in enumerate(zip(wheels.parts(), angles, strict=True))
    )
    return dataclasses.replace(wheels, imbalances=off, angles_at_start=tuple(s.wheel_angle_0))


def has_lengths(plant: Group) -> Condition:
    """Return the conditions that no wheel axis is zero."""
    columns = (plant.wheel_axes[:, k] for k in range(plant.wheel_axes.cols))
    squares = (sp.Add(*(entry**2 for entry in column)) for column in columns)
    return Condition(sp.Min(*squares), "a column of wheel_axes is zero: a wheel needs an axis")


def spanning(wheels: Wheels) -> Condition:
    """Return the condition that three of the wheel axes span all directions."""
    gram = wheels.axes * wheels.axes.T
    return Condition(gram.det(method="berkowitz"), "the wheels' axes wheel_axes lie in a plane")
