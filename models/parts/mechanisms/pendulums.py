# SPDX-License-Identifier: Apache-2.0
"""Pendulums described by angles, and sprung masses."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import sympy as sp

from ...derivation import Expr
from ...quantities import ModelError, Quantity
from ...system import Condition
from ..charts import NEAR
from ..part import Mounted, Part
from ..terms import Aggregates, Coordinate, Particle
from ..values import Number, Vector, direction, place, scalar
from .joints import freedom


@dataclass(frozen=True)
class Pendulum(Part):
    """A point mass on a massless rod, with one angle of a hinge or two of a universal joint.

    The first angle turns the rod about the axis, the second about a normal axis that turns with the first. Two angles
    are singular if the second is 90 degrees; a `Bob` has no singularity.

    Parameters
    ----------
    name : str
        As of a `Part`; its states are NAME_angle and NAME_rate or, with two angles, NAME_angle1, NAME_angle2 and
        NAME_rate1, NAME_rate2.
    mass, length : number
        kg, m.
    axis : three numbers
        Axis of the first angle, of any length.
    rest : three numbers
        Direction of the rod at angles zero; its component normal to the axis is used, scaled to length one.
    at : three numbers
        Pivot, m.
    angles : int
        1 or 2.
    damping : number, optional
        c of the dissipation c e'.e'/2 of the direction e of the rod, N m s.
    inertia : number, optional
        Moment of inertia of the bob across the rod, kg m^2.
    """

    mass: Annotated[Number, scalar("m", "kg", "mass")]
    length: Annotated[Number, scalar("l", "m", "length of the rod")]
    axis: Annotated[Vector, direction("a", "axis of the hinge")]
    rest: Annotated[Vector, direction("e", "direction of the rod at zero", across="axis")]
    at: Annotated[Vector, place("r", "pivot")] = (0, 0, 0)
    angles: int = 1
    damping: Annotated[Number | None, scalar("c", "N m s", "damping", "[0, inf)", absent=0)] = None
    inertia: Annotated[
        Number | None, scalar("I", "kg m^2", "moment of inertia across the rod", "[0, inf)", absent=0)
    ] = None

    def __post_init__(self) -> None:
        if isinstance(self.angles, bool) or self.angles not in (1, 2):
            raise ModelError(f"{self.name}.angles = {self.angles!r}: must be 1 or 2; a Bob has a ball joint")

    def coordinates(self) -> tuple[Coordinate, ...]:
        return tuple(
            Coordinate(
                Quantity(f"{self.name}_rate{k}", "rad/s", f"rate{k and f' {k}'} of {self.name}"),
                Quantity(f"{self.name}_angle{k}", "rad", f"angle{k and f' {k}'} of {self.name}"),
            )
            for k in (("1", "2") if self.angles == 2 else ("",))
        )

    def particle(self, at: Mounted) -> Particle:
        v = at.values
        return Particle(v.mass, v.at + v.length * self._rod(at)[0], v.length**2 * self._squared(at))

    def aggregates(self, at: Mounted) -> Aggregates:
        v = at.values
        rates = [c.speed.symbol for c in self.coordinates()]
        drags = [-v.damping * size * rate for size, rate in zip(self._sizes(at), rates, strict=True)]
        rod, slopes = self._rod(at)
        slip = sum((s * rate for s, rate in zip(slopes, rates, strict=True)), sp.zeros(3, 1))
        return Aggregates(
            inertia=v.inertia * (sp.eye(3) - rod * rod.T), angular=v.inertia * rod.cross(slip),
            energy=v.inertia * self._squared(at) / 2, forces=tuple(drags),
        )  # fmt: skip

    def limits(self, at: Mounted) -> tuple[Condition, ...]:
        if self.angles == 1:
            return ()
        second = self.coordinates()[1].place
        assert second is not None
        why = f"{second.name} is 90 or -90 degrees, where the two angles of {self.name} are singular; a Bob has none"
        return (Condition(sp.Abs(sp.cos(second.symbol)) - NEAR, why),)

    def _squared(self, at: Mounted) -> Expr:
        """Return the square of the rate of the rod's direction."""
        rates = [c.speed.symbol for c in self.coordinates()]
        return sp.Add(*(size * rate**2 for size, rate in zip(self._sizes(at), rates, strict=True)))

    def _circles(self, at: Mounted) -> list[tuple[Expr, Expr]]:
        return [at.frame.circle(c.place.symbol) for c in self.coordinates() if c.place is not None]

    def _rod(self, at: Mounted) -> tuple[sp.Matrix, list[sp.Matrix]]:
        """Return the rod's direction and its derivatives with respect to the angles."""
        axis = at.values.axis
        front, side = at.across(axis, at.values.rest, "direction of the rod")
        (c, s), *second = self._circles(at)
        rod, slope = c * front + s * side, c * side - s * front
        if not second:
            return rod, [slope]
        ((c2, s2),) = second
        return c2 * rod - s2 * axis, [c2 * slope, -s2 * rod - c2 * axis]

    def _sizes(self, at: Mounted) -> list[Expr]:
        """Return the squared lengths of the derivatives."""
        _, *second = self._circles(at)
        return [second[0][0] ** 2, sp.S.One] if second else [sp.S.One]


@dataclass(frozen=True)
class SprungMass(Part):
    """A point mass on a spring along an axis of the hub.

    Parameters
    ----------
    name : str
        As of a `Part`; its states are NAME_place and NAME_speed.
    mass : number
        kg.
    axis : three numbers
        Along which it moves; any length.
    stiffness : number
        N/m.
    at : three numbers
        Its place at rest, m.
    damping : number, optional
        N s/m.
    """

    mass: Annotated[Number, scalar("m", "kg", "mass")]
    axis: Annotated[Vector, direction("a", "axis")]
    stiffness: Annotated[Number, scalar("k", "N/m", "stiffness", "[0, inf)")]
    at: Annotated[Vector, place("r", "place at rest")] = (0, 0, 0)
    damping: Annotated[Number | None, scalar("d", "N s/m", "damping", "[0, inf)", absent=0)] = None

    def coordinates(self) -> tuple[Coordinate, ...]:
        place, speed, _ = freedom("slider", self.name)
        return (Coordinate(speed, place),)

    def _coordinate(self) -> tuple[Expr, Expr]:
        place, speed, _ = freedom("slider", self.name)
        return place.symbol, speed.symbol

    def particle(self, at: Mounted) -> Particle:
        v, (shift, speed) = at.values, self._coordinate()
        return Particle(v.mass, v.at + shift * v.axis, speed**2)

    def aggregates(self, at: Mounted) -> Aggregates:
        v, (shift, speed) = at.values, self._coordinate()
        return Aggregates(potential=v.stiffness * shift**2 / 2, forces=(-v.damping * speed,))
