# SPDX-License-Identifier: Apache-2.0
"""Reaction wheels: the paper's three along the body axes, or any number along columns in parameters.toml."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp

from ..derivation import symmetric, vector
from ..parts import Contribution, Load, Mounted, Part
from ..parts.motion import Motion
from ..parts.values import LENGTHS, of_a_direction
from ..system import Actuator, Condition, Derivation, Expr, Group, Quantity

FEWEST = 3
"""Smallest number of wheels: with fewer, an axis has no torque, which no law supports."""
MOMENTA = tuple(Quantity(f"h{i}", "N m s", f"absolute momentum of wheel {i} about its axis", f"h_{i}") for i in "xyz")
TORQUES = tuple(Quantity(f"T{i}", "N m", f"control torque on the body about {i}", f"T_{i}") for i in "xyz")


@dataclass(frozen=True)
class Wheel(Part):
    """A balanced wheel whose state is its absolute momentum about its axis.

    The hub includes the wheel's inertia except the axial one.

    Parameters
    ----------
    name : str
        Begins the names of its steps.
    axis : sympy.Matrix
        a, in body axes.
    momentum : Expr
        h = I_w (s + w . a), with the speed s relative to the body.
    share : Expr
        1 if the wheel exerts the torque, 0 if the torque is external.
    torque : Expr
        Of motor and bearing on the body, N m.
    """

    axis: sp.Matrix
    momentum: Expr
    share: Expr
    torque: Expr

    def contribution(self, at: Mounted) -> Contribution:
        return Contribution(angular=self.momentum * self.axis, loads=(Load(couple=self.torque * self.axis),))

    def rates(self, at: Mounted, motion: Motion) -> tuple[Expr, ...]:
        return (-self.share * self.torque,)


@dataclass(frozen=True)
class Wheels:
    """A set of wheels.

    Attributes
    ----------
    labels : tuple of str
        Label of each wheel, used in names.
    states, torques : Group
        Absolute momentum of each wheel about its axis, and its motor torque on the body, the plant's input.
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
    locked : sympy.Matrix
        Inertia that locked wheels add.
    """

    labels: tuple[str, ...]
    states: Group
    torques: Group
    axes: sp.Matrix
    inertia: tuple[Expr, ...]
    share: Expr
    start: tuple[Expr, ...]
    pseudoinverse: sp.Matrix
    locked: sp.Matrix

    @property
    def momenta(self) -> sp.Matrix:
        """Momenta as a column."""
        return sp.Matrix(self.states.symbols)

    @property
    def momentum(self) -> sp.Matrix:
        """Return the wheels' total momentum in body axes."""
        return self.axes * self.momenta

    def parts(self, torques: sp.Matrix) -> list[Wheel]:
        """Return the wheels as parts, with the torque of each on the body."""
        rows = zip(self.labels, self.momenta, torques, strict=True)
        return [Wheel(f"wheel{k}", self.axes[:, i], h, self.share, u) for i, (k, h, u) in enumerate(rows)]

    @property
    def commanded(self) -> Group:
        """Commanded torques."""
        return self._renamed("u_cmd", "cmd", "commanded", "c")

    @property
    def applied(self) -> Group:
        """Torques that acted over the last sample."""
        return self._renamed("v", "applied", "applied", "a")

    @property
    def acting(self) -> sp.Matrix:
        """Torque of the motors on the body over the last sample."""
        return self.axes * sp.Matrix(self.applied.symbols)

    @property
    def measured(self) -> tuple[Expr, ...]:
        """Arguments of the commands besides the torque on the body."""
        return self.states.symbols if self._spare else ()

    def commands(self, torque: Sequence[Expr], law: Group) -> tuple[Expr, ...]:
        """Return the motors' torques for a torque on the body.

        With more than three wheels, `spread_gain` evens out their momenta without a torque on the body.
        """
        motors = self.pseudoinverse * sp.Matrix(torque)
        if self._spare:
            idle = sp.eye(len(self.labels)) - self.pseudoinverse * self.axes
            motors += law.spread_gain * idle * self.momenta
        return tuple(motors)

    @property
    def _spare(self) -> bool:
        return len(self.labels) > FEWEST

    def _renamed(self, group: str, suffix: str, title: str, mark: str) -> Group:
        def new(q: Quantity) -> Quantity:
            return Quantity(f"{q.name}_{suffix}", q.unit, f"{title} {q.description}", f"{q.latex}^{mark}")

        return Group(group, tuple(map(new, self.torques)))

    def actuator(self, plant: Group, d: Derivation) -> Actuator:
        """Limit the momentum of each wheel at the end of a sample, and its torque.

        The torque limit comes last, so that no torque exceeds umax. For wheels within hmax, as in every allowed run,
        zero torque fulfils both limits; then both hold in either order.
        """
        d.section("Wheels and sensor")
        applied = []
        for i, momentum, wanted in zip(self.labels, self.momenta, self.commanded.symbols, strict=True):
            lower, upper = (momentum - plant.hmax) / plant.Ts, (momentum + plant.hmax) / plant.Ts
            inside = sp.Max(lower, sp.Min(upper, wanted))
            if self.share.free_symbols:
                inside = sp.Piecewise((inside, self.share > sp.Rational(1, 2)), (wanted, True))
            inside = d.define(f"T{i}_inside", inside, "", f"torque about {i} within hmax", "N m", f"T_{{{i},1}}")
            applied.append(sp.Max(-plant.umax, sp.Min(plant.umax, inside)))
        return Actuator(self.commanded, tuple(applied))


def along_axes(plant: Group, s: Group) -> Wheels:
    """Return the paper's wheels along x, y and z."""
    inertia = (plant.Iw_x, plant.Iw_y, plant.Iw_z)
    start, one = (s.hx_0, s.hy_0, s.hz_0), sp.eye(3)
    return Wheels(
        tuple("xyz"), Group("h", MOMENTA), Group("u", TORQUES), one, inertia, plant.wheels, start, one,
        sp.diag(*inertia),
    )  # fmt: skip


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
    inertia = tuple(plant.wheel_inertia)
    locked = axes * sp.diag(*inertia) * axes.T
    momenta = (Quantity(f"h{k}", "N m s", f"absolute momentum of wheel {k} about its axis", f"h_{k}") for k in labels)
    torques = (Quantity(f"T{k}", "N m", f"torque of the motor of wheel {k} on the body", f"T_{k}") for k in labels)
    return Wheels(
        tuple(labels),
        Group("h", tuple(momenta)),
        Group("u", tuple(torques)),
        axes,
        inertia,
        sp.S.One,
        tuple(s.wheel_momentum_0),
        axes.T * spread,
        symmetric("Iw", locked, "what the wheels add to the inertia, locked", "kg m^2", "I_w", d),
    )


def any_axes(plant: Group, wheels: Wheels) -> tuple[Condition, Condition]:
    """Return the conditions that each wheel has an axis, and that three of these span all directions."""
    columns = (plant.wheel_axes[:, k] for k in range(plant.wheel_axes.cols))
    margins = (margin for column in columns for margin in of_a_direction(column))
    gram = wheels.axes * wheels.axes.T
    return (
        Condition(sp.Min(*margins), f"a column of wheel_axes is no axis: it {LENGTHS}"),
        Condition(gram.det(method="berkowitz"), "the wheels' axes wheel_axes lie in a plane"),
    )
