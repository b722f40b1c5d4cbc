# SPDX-License-Identifier: Apache-2.0
"""Rigid bodies on joints of one degree of freedom: free, prescribed or locked."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Annotated

import sympy as sp

from ...derivation import Expr
from ...mechanics import cross_matrix
from ...quantities import ModelError, Quantity
from ..frame import point_inertia
from ..part import Mounted, Part
from ..terms import Aggregates, Coordinate
from ..values import Number, Parameters, Tensor, Vector, direction, place, scalar, tensor

MOTIONS = ("free", "prescribed", "locked")


def freedom(joint: str, name: str) -> tuple[Quantity, Quantity, Quantity]:
    """Return place, speed and motor force of a "hinge" or a "slider"."""
    if joint == "hinge":
        return (
            Quantity(f"{name}_angle", "rad", f"angle of {name}"),
            Quantity(f"{name}_rate", "rad/s", f"rate of {name}"),
            Quantity(f"{name}_torque", "N m", f"torque of {name}"),
        )
    return (
        Quantity(f"{name}_place", "m", f"place of {name} along its axis"),
        Quantity(f"{name}_speed", "m/s", f"speed of {name}"),
        Quantity(f"{name}_force", "N", f"force on {name}"),
    )


@dataclass(frozen=True)
class Joint(Part):
    """A rigid body on a joint with a spring, a damper and a motor: a `Hinge` or a `Slider`.

    Its motion is free, prescribed (a law or an input over time gives its acceleration relative to the hub), or locked
    at the parameter NAME_locked.
    """

    mass: Annotated[Number, scalar("m", "kg", "mass")]
    inertia: Annotated[Tensor, tensor("J", "moment of inertia about its centre of mass")]
    axis: Annotated[Vector, direction("a", "axis")]
    at: Annotated[Vector, place("r", "joint")] = (0, 0, 0)
    centre: Annotated[Vector, place("c", "centre of mass from the joint, at zero")] = (0, 0, 0)
    motor: bool = False
    motion: str = field(default="free", kw_only=True)
    locked: Number = field(default=0.0, kw_only=True)

    def __post_init__(self) -> None:
        if self.motion not in MOTIONS:
            raise ModelError(f"{self.name}.motion = {self.motion!r}: must be one of {', '.join(MOTIONS)}")
        if self.locked != 0 and self.motion != "locked":
            raise ModelError(
                f"{self.name}.locked = {self.locked!r}: motion is {self.motion}; leave locked out, or lock it"
            )
        idle = [f for f in ("motor", "stiffness", "damping") if getattr(self, f)]
        if idle and self.motion != "free":
            raise ModelError(f"{self.name}.{idle[0]}: motion is {self.motion}; leave out {idle[0]} or motion")

    def values(self, parameters: Parameters) -> SimpleNamespace:
        result = super().values(parameters)
        if self.motion == "locked":
            place, *_ = self._freedom()
            kind = scalar("locked", place.unit, f"{place.description}, locked", "(-inf, inf)")
            result.locked = parameters.number(kind, self.name, self.locked)
        return result

    @abstractmethod
    def _freedom(self) -> tuple[Quantity, Quantity, Quantity]:
        """Return place, speed and motor force of the joint."""

    def inputs(self) -> tuple[Quantity, ...]:
        _, speed, force = self._freedom()
        if self.motion == "prescribed":
            return (Quantity(f"{self.name}_acceleration", f"{speed.unit}^2", f"acceleration of {self.name}"),)
        return (force,) if self.motor else ()

    def coordinates(self) -> tuple[Coordinate, ...]:
        place, speed, _ = self._freedom()
        return () if self.motion == "locked" else (Coordinate(speed, place),)

    def _motion(self, at: Mounted) -> tuple[Expr, Expr]:
        """Return position and speed of the joint."""
        place, speed, _ = self._freedom()
        return (at.values.locked, sp.S.Zero) if self.motion == "locked" else (place.symbol, speed.symbol)

    def _driven(self, at: Mounted, rigid: Aggregates, inertia: Expr) -> Aggregates:
        """Add the joint's energy, spring, damper and motor, or its prescribed acceleration, to a rigid body's terms."""
        place, speed = self._motion(at)
        if self.motion == "locked":
            return rigid
        v, commands = at.values, tuple(q.symbol for q in self.inputs())
        return rigid + Aggregates(
            energy=inertia * speed**2 / 2, potential=v.stiffness * place**2 / 2,
            forces=(sp.Add(-v.damping * speed, *(commands if self.motor else ())),),
            prescribed=() if self.motor else commands,
        )  # fmt: skip


@dataclass(frozen=True)
class Hinge(Joint):
    """A rigid body that turns about an axis of the hub.

    Parameters
    ----------
    name : str
        As of a `Part`; its states are NAME_angle and NAME_rate, its input, with a motor, NAME_torque.
    mass : number
        kg.
    inertia : three numbers, or three rows
        About its own centre of mass at the angle zero, in the axes of the hub, kg m^2.
    axis : three numbers
        Of rotation, any length.
    at : three numbers
        A point of the axis, m.
    centre : three numbers
        Its centre of mass from that point at the angle zero, m.
    motor : bool
        True if a law commands a torque.
    motion : {"free", "prescribed", "locked"}
        Prescribed by the input NAME_acceleration, or locked.
    locked : number
        Angle at which it is locked, rad.
    stiffness, damping : number, optional
        N m/rad, N m s/rad.
    """

    stiffness: Annotated[Number | None, scalar("k", "N m/rad", "stiffness", "[0, inf)", absent=0)] = None
    damping: Annotated[Number | None, scalar("d", "N m s/rad", "damping", "[0, inf)", absent=0)] = None

    def _freedom(self) -> tuple[Quantity, Quantity, Quantity]:
        return freedom("hinge", self.name)

    def aggregates(self, at: Mounted) -> Aggregates:
        v, (angle, rate) = at.values, self._motion(at)
        cosine, sine = at.frame.circle(angle)
        rest = Turning(at, v.axis, cosine, sine)
        first = v.mass * v.at + rest.vector("s", v.mass * v.centre, "first moment about the joint")
        about = v.inertia + point_inertia(v.mass, v.centre)
        spin = rest.vector("Jg", about * v.axis, "angular momentum about the joint per rate")
        momentum = v.axis.cross(first - v.mass * v.at)
        rigid = Aggregates(
            v.mass, first, rest.inertia(about, v.mass * v.centre, v.mass, v.at), rate * momentum,
            rate * (v.at.cross(momentum) + spin),
        )  # fmt: skip
        return self._driven(at, rigid, _along(about, v.axis))


@dataclass(frozen=True)
class Slider(Joint):
    """A rigid body that slides along an axis of the hub.

    Parameters
    ----------
    name : str
        As of a `Part`; its states are NAME_place and NAME_speed, its input, with a motor, NAME_force.
    mass, inertia, axis, at, centre, motor, motion, locked
        As of a `Hinge`; the place at which it is locked is in m.
    stiffness, damping : number, optional
        N/m, N s/m.
    """

    stiffness: Annotated[Number | None, scalar("k", "N/m", "stiffness", "[0, inf)", absent=0)] = None
    damping: Annotated[Number | None, scalar("d", "N s/m", "damping", "[0, inf)", absent=0)] = None

    def _freedom(self) -> tuple[Quantity, Quantity, Quantity]:
        return freedom("slider", self.name)

    def aggregates(self, at: Mounted) -> Aggregates:
        v, (shift, rate) = at.values, self._motion(at)
        place = v.at + v.centre + shift * v.axis
        rigid = Aggregates(
            v.mass, v.mass * place, v.inertia + point_inertia(v.mass, place), v.mass * rate * v.axis,
            v.mass * rate * place.cross(v.axis),
        )  # fmt: skip
        return self._driven(at, rigid, v.mass * _along(sp.eye(3), v.axis))


def _along(matrix: sp.Matrix, axis: sp.Matrix) -> Expr:
    return (axis.T * matrix * axis)[0]


class Turning:
    """Vectors and inertias of a rotating body, as polynomials in cosine and sine of the angle.

    The coefficients depend only on parameters.
    """

    def __init__(self, at: Mounted, axis: sp.Matrix, cosine: Expr, sine: Expr) -> None:
        self.at, self.axis, self.cosine, self.sine = at, axis, cosine, sine
        projection = axis * axis.T
        self.fixed, self.even, self.odd = projection, sp.eye(3) - projection, cross_matrix(axis)

    def vector(self, name: str, rest: sp.Matrix, title: str) -> sp.Matrix:
        """Return a vector of the body in hub axes, from its components at angle zero."""
        fixed, even, odd = (
            self.at.vector(f"{name}{k}", part * rest, f"{title}: {which} part")
            for k, part, which in ((0, self.fixed, "fixed"), (1, self.even, "cosine"), (2, self.odd, "sine"))
        )
        return fixed + self.cosine * even + self.sine * odd

    def inertia(self, about: sp.Matrix, first: sp.Matrix, mass: Expr, joint: sp.Matrix) -> sp.Matrix:
        """Return the inertia about O from the inertia about the joint and the first moment at angle zero.

        After replacing sin^2 by 1 - cos^2 it has five coefficients.
        """
        f, e, o = self.fixed, self.even, self.odd
        shift = [shifted(joint, part * first) for part in (f, e, o)]
        coefficients = (
            f * about * f + o * about * o.T + shift[0] + point_inertia(mass, joint),
            f * about * e + e * about * f + shift[1],
            f * about * o.T + o * about * f + shift[2],
            e * about * e - o * about * o.T,
            e * about * o.T + o * about * e,
        )
        return polynomial(self.at, self.cosine, self.sine, coefficients)


def polynomial(at: Mounted, cosine: Expr, sine: Expr, coefficients: Sequence[sp.Matrix]) -> sp.Matrix:
    """Return an inertia with the factors 1, c, s, c^2 and c s of its coefficients, which depend on parameters only."""
    named = (at.tensor(f"K{k}", matrix, f"inertia, coefficient {k}", "kg m^2") for k, matrix in enumerate(coefficients))
    factors = (1, cosine, sine, cosine * cosine, cosine * sine)
    return sum((factor * matrix for factor, matrix in zip(factors, named, strict=True)), sp.zeros(3, 3))


def shifted(joint: sp.Matrix, first: sp.Matrix) -> sp.Matrix:
    """Return the contribution of a first moment to the inertia about O."""
    return 2 * joint.dot(first) * sp.eye(3) - joint * first.T - first * joint.T
