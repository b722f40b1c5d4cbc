# SPDX-License-Identifier: Apache-2.0
"""Rotors: unbalanced wheels and control moment gyros."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Annotated

import sympy as sp

from ...derivation import Expr
from ...geometry import Shape
from ...quantities import ModelError, Quantity
from ...system import Condition
from ..frame import AXES, ZERO, point_inertia
from ..motion import Motion
from ..part import Mounted, Part, points
from ..terms import Aggregates, Coordinate
from ..values import (
    NO_BODY,
    Number,
    Vector,
    constant,
    direction,
    of_a_body,
    place,
    scalar,
)
from .joints import polynomial, shifted
from .wheels import Wheel


@dataclass(frozen=True, kw_only=True)
class UnbalancedWheel(Wheel):
    """A wheel with mass and with static and dynamic imbalance; wheel and hub disturb each other.

    The static imbalance is a first moment normal to the axis. The dynamic imbalance is a product of inertia about the
    centre of mass, between the axis and the direction 90 degrees ahead of the static imbalance. The convention is
    that of Alcorn, Allard, Schaub: Fully coupled reaction wheel static and dynamic imbalance for spacecraft jitter
    modeling. J. Guid. Contr. Dyn. 41(6), 2018.

    Parameters
    ----------
    name, axis, friction, torque_limit, speed_limit
        As of a `Wheel`; the states are NAME_angle and NAME_speed, the input NAME_torque.
    inertia : number
        About the axis, through the centre of mass, kg m^2.
    mass : number
        kg.
    across : number
        Moment of inertia across the axis, about the centre of mass, kg m^2.
    at : three numbers
        Point where the axis meets the plane in which the centre of mass turns, m.
    static : number
        Static imbalance, kg m.
    dynamic : number, optional
        Dynamic imbalance, kg m^2.
    towards : {"x", "y", "z"}, optional
        Hub axis towards which the static imbalance points at angle zero; default: the one farthest from the wheel's
        axis.
    """

    mass: Annotated[Number, scalar("m", "kg", "mass")]
    across: Annotated[Number, scalar("Jt", "kg m^2", "moment of inertia across the axis")]
    static: Annotated[Number, scalar("Us", "kg m", "static imbalance", "[0, inf)")]
    dynamic: Annotated[Number | None, scalar("Ud", "kg m^2", "dynamic imbalance", "(-inf, inf)", absent=0)] = None
    at: Annotated[Vector, place("r", "centre")] = (0, 0, 0)
    towards: str = ""

    def __post_init__(self) -> None:
        if self.towards and self.towards not in AXES:
            raise ModelError(f"{self.name}.towards = {self.towards!r}: must be one of x, y, z")

    def constraints(self, at: Mounted) -> tuple[Condition, ...]:
        v = at.values
        body = sp.Matrix([[v.inertia, v.dynamic, 0], [v.dynamic, v.across, 0], [0, 0, v.across]])
        return (*super().constraints(at), *of_no_body(self, v, ("inertia", "across", "dynamic"), of_a_body(body)))

    def coordinates(self) -> tuple[Coordinate, ...]:
        (speed,) = super().coordinates()
        return (Coordinate(speed.speed, Quantity(f"{self.name}_angle", "rad", f"angle of {self.name}")),)

    def aggregates(self, at: Mounted) -> Aggregates:
        v, axis, (coordinate,) = at.values, at.values.axis, self.coordinates()
        assert coordinate.place is not None
        c, s = at.frame.circle(coordinate.place.symbol)
        across, side = _across(axis, self._towards(axis))
        out = at.vector("out", across, "direction of the static imbalance at zero", "1")
        ahead = at.vector("ahead", side, "direction of the static imbalance at 90 degrees", "1")
        moved, turned = v.static * (c * out + s * ahead), v.static * (c * ahead - s * out)
        spin = (v.inertia + v.static**2 / v.mass) * axis + v.dynamic * (c * ahead - s * out)
        base = super().aggregates(at)
        return Aggregates(
            v.mass, v.mass * v.at + moved, self._inertia(at, out, ahead, c, s), self.speed * turned,
            self.speed * (v.at.cross(turned) + spin), (v.inertia + v.static**2 / v.mass) * self.speed**2 / 2,
            forces=base.forces,
        )  # fmt: skip

    def _inertia(self, at: Mounted, out: sp.Matrix, ahead: sp.Matrix, c: Expr, s: Expr) -> sp.Matrix:
        """Return the inertia about O as a polynomial in cosine and sine of the angle, without sin^2 = 1 - cos^2."""
        v, axis, square = at.values, at.values.axis, at.values.static**2 / at.values.mass
        fixed = v.across * sp.eye(3) + (v.inertia - v.across) * axis * axis.T + point_inertia(v.mass, v.at)
        even = shifted(v.at, v.static * out) + v.dynamic * (axis * ahead.T + ahead * axis.T)
        odd = shifted(v.at, v.static * ahead) - v.dynamic * (axis * out.T + out * axis.T)
        return polynomial(at, c, s, (
            fixed + square * (sp.eye(3) - ahead * ahead.T), even, odd,
            square * (ahead * ahead.T - out * out.T), -square * (out * ahead.T + ahead * out.T),
        ))  # fmt: skip

    def _towards(self, axis: sp.Matrix) -> int:
        """Return the hub axis along which the static imbalance points at angle zero."""
        if self.towards:
            return AXES.index(self.towards)
        sizes = [1.0 if number is None else abs(number) for number in map(constant, self.axis)]
        return min(range(3), key=sizes.__getitem__)


def _across(axis: sp.Matrix, towards: int) -> tuple[sp.Matrix, sp.Matrix]:
    """Return the unit vector normal to an axis and nearest to an axis of the hub, and the one 90 degrees ahead."""
    unit = sp.eye(3)[:, towards]
    across, size = unit - axis[towards] * axis, sp.sqrt(1 - axis[towards] ** 2)
    if across.is_zero_matrix:
        raise ModelError(f"an unbalanced wheel along {AXES[towards]} has no static imbalance towards {AXES[towards]}")
    return across / size, axis.cross(unit) / size


@dataclass(frozen=True)
class ControlMomentGyro(Part):
    """A rotor in a gimbal. The hub includes its mass; the centre of mass of rotor and gimbal is on the gimbal's axis.

    Parameters
    ----------
    name : str
        As of a `Part`. Its states are NAME_gimbal and NAME_gimbal_rate and, at variable speed, NAME_speed; its inputs
        NAME_gimbal_torque, or NAME_gimbal_rate_cmd where a lag is given, and at variable speed NAME_torque.
    gimbal : three numbers
        Axis of the gimbal; any length.
    spin : three numbers
        Axis of the rotor at gimbal angle zero; its component normal to the gimbal axis is used, scaled to length one.
    inertia : number
        Of the rotor about its axis, kg m^2.
    gimbal_inertia : number
        Of rotor and gimbal about the axis of the gimbal, kg m^2.
    across : number, optional
        Of rotor and gimbal about the axis across both, kg m^2.
    frame : number, optional
        Moment of inertia of the gimbal without rotor about the rotor's axis, kg m^2.
    speed : number, optional
        Speed at which a motor holds the rotor, rad/s; the speed is variable without it.
    lag : number, optional
        Time constant with which the rate of the gimbal follows its command, s; a torque moves the gimbal without it.
    friction, gimbal_friction : number, optional
        Viscous, of the rotor at variable speed and of a gimbal that a torque moves, N m s.
    """

    gimbal: Annotated[Vector, direction("g", "axis of the gimbal")]
    spin: Annotated[Vector, direction("s", "axis of the rotor at zero", across="gimbal")]
    inertia: Annotated[Number, scalar("Js", "kg m^2", "moment of inertia of the rotor about its axis")]
    gimbal_inertia: Annotated[Number, scalar("Jg", "kg m^2", "moment of inertia about the axis of the gimbal")]
    across: Annotated[Number | None, scalar("Jt", "kg m^2", "moment of inertia across both axes", absent=0)] = None
    frame: Annotated[
        Number | None, scalar("Jf", "kg m^2", "moment of inertia of the gimbal about the rotor", absent=0)
    ] = None
    speed: Annotated[Number | None, scalar("W", "rad/s", "speed of the rotor", "(-inf, inf)")] = None
    lag: Annotated[Number | None, scalar("T", "s", "lag of the gimbal's rate")] = None
    friction: Annotated[Number | None, scalar("c", "N m s", "viscous friction of the rotor", "[0, inf)", absent=0)] = (
        None
    )
    gimbal_friction: Annotated[Number | None, scalar("cg", "N m s", "friction of the gimbal", "[0, inf)", absent=0)] = (
        None
    )

    def __post_init__(self) -> None:
        if self.speed is not None and self.friction is not None:
            raise ModelError(f"{self.name}.friction: a motor holds the constant speed; leave out friction or speed")
        if self.lag is not None and self.gimbal_friction is not None:
            raise ModelError(
                f"{self.name}.gimbal_friction: a gimbal rate that follows its command has no "
                "friction; leave out gimbal_friction or lag"
            )

    def constraints(self, at: Mounted) -> tuple[Condition, ...]:
        """Return those on the rotor, of which half its moment at least is in the others, and on rotor and gimbal."""
        v, names = at.values, ("inertia", "gimbal_inertia", "across", "frame")
        beside = [moment for moment in (v.gimbal_inertia, v.across) if moment != 0]
        margins = [margin for moment in beside for margin in of_a_body(sp.diag(v.inertia, moment, moment))]
        if v.frame != 0 and v.across != 0:
            margins += of_a_body(sp.diag(v.inertia + v.frame, v.gimbal_inertia, v.across))
        of_bodies = of_no_body(self, v, names, margins)
        return (*super().constraints(at), *of_bodies)

    @property
    def gimbal_angle(self) -> sp.Symbol:
        """Symbol of the gimbal's angle, rad."""
        return self._angle.symbol

    @property
    def rotor_speed(self) -> sp.Symbol:
        """Symbol of the rotor's variable speed relative to the gimbal, rad/s."""
        return self._rotor.symbol

    @property
    def _angle(self) -> Quantity:
        return Quantity(f"{self.name}_gimbal", "rad", f"angle of the gimbal of {self.name}")

    @property
    def _rotor(self) -> Quantity:
        return Quantity(f"{self.name}_speed", "rad/s", f"speed of {self.name} relative to its gimbal")

    def inputs(self) -> tuple[Quantity, ...]:
        torque = Quantity(f"{self.name}_gimbal_torque", "N m", f"torque on the gimbal of {self.name}")
        rate = Quantity(f"{self.name}_gimbal_rate_cmd", "rad/s", f"commanded rate of the gimbal of {self.name}")
        rotor = Quantity(f"{self.name}_torque", "N m", f"torque on the rotor of {self.name}")
        return (torque if self.lag is None else rate, *((rotor,) if self.speed is None else ()))

    def coordinates(self) -> tuple[Coordinate, ...]:
        rate = Quantity(f"{self.name}_gimbal_rate", "rad/s", f"rate of the gimbal of {self.name}")
        return (Coordinate(rate, self._angle), *((Coordinate(self._rotor),) if self.speed is None else ()))

    def aggregates(self, at: Mounted) -> Aggregates:
        v, rate, speed = at.values, self.coordinates()[0].speed.symbol, self._speed(at)
        spin, across = self._axes(at)
        inertia = v.gimbal_inertia * v.gimbal * v.gimbal.T + v.across * across * across.T
        inertia += (v.inertia + v.frame) * spin * spin.T
        command, *torques = (q.symbol for q in self.inputs())
        drive = command - v.gimbal_friction * rate
        prescribed: tuple[Expr | None, ...] = ()
        if v.lag is not None:
            prescribed, drive = ((command - rate) / v.lag, *(None for _ in torques)), sp.S.Zero
        energy = v.gimbal_inertia * rate**2 / 2 + v.inertia * speed**2 / 2
        return Aggregates(
            inertia=inertia, angular=v.gimbal_inertia * rate * v.gimbal + v.inertia * speed * spin,
            energy=energy, forces=(drive, *(t - v.friction * speed for t in torques)), prescribed=prescribed,
        )  # fmt: skip

    def shapes(self, at: Mounted) -> tuple[Shape, ...]:
        """Return the axes of gimbal and rotor."""
        gimbal, rotor = (points(ZERO, at.craft.reach * axis) for axis in (at.values.gimbal, self._axes(at)[0]))
        return Shape(f"{self.name} gimbal", "arrow", gimbal, "orange"), Shape(self.name, "arrow", rotor, "sky")

    def power(self, at: Mounted, motion: Motion) -> Expr:
        result, v = super().power(at, motion), at.values
        if self.speed is not None:  # of the motor that holds the speed
            (spin, across), rate = self._axes(at), self.coordinates()[0].speed.symbol
            result += v.speed * v.inertia * (spin.dot(motion.angular) + rate * across.dot(at.frame.rate))
        return result

    def _speed(self, at: Mounted) -> Expr:
        speed: Expr = self.rotor_speed if self.speed is None else at.values.speed
        return speed

    def _axes(self, at: Mounted) -> tuple[sp.Matrix, sp.Matrix]:
        """Return the rotor's axis, and the axis normal to it and to the gimbal's."""
        cosine, sine = at.frame.circle(self.gimbal_angle)
        front, side = at.across(at.values.gimbal, at.values.spin, "axis of the rotor")
        return cosine * front + sine * side, cosine * side - sine * front


def of_no_body(part: Part, values: object, names: Sequence[str], margins: Iterable[Expr]) -> Iterator[Condition]:
    """Yield the conditions that moments of inertia are those of a body, without those that always hold."""
    given = {f"{part.name}.{name}": value for name in names if (value := getattr(values, name)) != 0}
    shown = ", ".join(f"{name} = {{{v}:g}}" if v.is_Symbol else f"{name} = {v}" for name, v in given.items())
    for margin in dict.fromkeys(map(sp.expand, margins)):
        if margin.free_symbols and not margin.is_positive:
            yield Condition(margin, f"{shown} kg m^2 {NO_BODY}")
