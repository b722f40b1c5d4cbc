# SPDX-License-Identifier: Apache-2.0
"""Balanced reaction wheels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import sympy as sp

from ...derivation import Expr
from ...geometry import Shape
from ...quantities import Quantity
from ..frame import ZERO
from ..part import Mounted, Part, clipped, points
from ..terms import Aggregates, Coordinate
from ..values import Number, Vector, direction, scalar


@dataclass(frozen=True)
class Wheel(Part):
    """A balanced wheel; the hub includes its mass and its inertia across the axis.

    Parameters
    ----------
    name : str
        As of a `Part`; its state is NAME_speed, relative to the hub, its input NAME_torque. It acts on the wheel, the
        opposite torque on the hub.
    axis : three numbers
        Of rotation; any length.
    inertia : number
        About the axis, kg m^2.
    friction : number, optional
        Viscous, N m s.
    torque_limit : number, optional
        Largest torque of the motor, N m.
    speed_limit : number, optional
        Speed above which commands for a higher speed are ignored, rad/s.
    """

    axis: Annotated[Vector, direction("a", "axis")]
    inertia: Annotated[Number, scalar("Js", "kg m^2", "moment of inertia about the axis")]
    friction: Annotated[Number | None, scalar("c", "N m s", "viscous friction", "[0, inf)", absent=0)] = None
    torque_limit: Annotated[Number | None, scalar("Tmax", "N m", "largest torque", absent=sp.oo)] = None
    speed_limit: Annotated[Number | None, scalar("wmax", "rad/s", "largest speed", absent=sp.oo)] = None

    @property
    def speed(self) -> sp.Symbol:
        """Symbol of the speed relative to the hub, rad/s."""
        return self.coordinates()[0].speed.symbol

    def inputs(self) -> tuple[Quantity, ...]:
        return (Quantity(f"{self.name}_torque", "N m", f"torque of {self.name}"),)

    def coordinates(self) -> tuple[Coordinate, ...]:
        return (Coordinate(Quantity(f"{self.name}_speed", "rad/s", f"speed of {self.name} relative to the hub")),)

    def aggregates(self, at: Mounted) -> Aggregates:
        v = at.values
        return Aggregates(
            inertia=v.inertia * v.axis * v.axis.T,
            angular=v.inertia * self.speed * v.axis,
            energy=v.inertia * self.speed**2 / 2,
            forces=(self.inputs()[0].symbol - v.friction * self.speed,),
        )

    def shapes(self, at: Mounted) -> tuple[Shape, ...]:
        """Return the axis and, as shares of the largest, the motor's torque at its tip and a ball for the speed."""
        v = at.values
        centre, tip = getattr(v, "at", ZERO), at.craft.reach * v.axis
        result = [Shape(self.name, "arrow", points(centre, centre + tip), "sky")]
        if v.torque_limit != sp.oo:
            end = tip * (1 + self.inputs()[0].symbol / (2 * v.torque_limit))
            result.append(Shape(f"{self.name} torque", "arrow", points(centre + tip, centre + end), "purple"))
        if v.speed_limit != sp.oo:
            result.append(Shape(f"{self.name} speed", "ball", points(centre + tip * self.speed / v.speed_limit), "sky"))
        return tuple(result)

    def applied(self, at: Mounted, commanded: Sequence[sp.Symbol]) -> tuple[Expr, ...]:
        v = at.values
        torque = clipped(commanded[0], v.torque_limit)
        faster = sp.And(sp.Abs(self.speed) >= v.speed_limit, torque * self.speed > 0)
        return (sp.Piecewise((0, faster), (torque, True)),)
