# SPDX-License-Identifier: Apache-2.0
"""Rigid bodies on joints of one degree of freedom."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import sympy as sp

from ..derivation import Expr
from ..quantities import Quantity
from .frame import cross_matrix, point_inertia
from .part import Aggregates, Coordinate, Mounted, Part
from .values import Number, Tensor, Vector, direction, place, scalar, tensor


@dataclass(frozen=True)
class _Jointed(Part):
    """A rigid body on a joint with a spring, a damper and a motor."""

    mass: Annotated[Number, scalar("m", "kg", "mass")]
    inertia: Annotated[Tensor, tensor("J", "moment of inertia about its centre of mass")]
    axis: Annotated[Vector, direction("a", "axis")]
    at: Annotated[Vector, place("r", "joint")] = (0, 0, 0)
    centre: Annotated[Vector, place("c", "centre of mass from the joint, at zero")] = (0, 0, 0)
    motor: bool = False

    def _forces(self, at: Mounted, place: sp.Symbol, speed: sp.Symbol) -> tuple[Expr, Expr]:
        """Return the potential of the spring, and the force of damper and motor."""
        v = at.values
        potential = v.stiffness * place**2 / 2 if v.stiffness is not None else sp.S.Zero
        force: Expr = -v.damping * speed if v.damping is not None else sp.S.Zero
        return potential, force + (self.inputs()[0].symbol if self.motor else sp.S.Zero)


@dataclass(frozen=True)
class Hinge(_Jointed):
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
        Whether a law commands a torque.
    stiffness, damping : number, optional
        N m/rad, N m s/rad.
    """

    stiffness: Annotated[Number | None, scalar("k", "N m/rad", "stiffness", "[0, inf)")] = None
    damping: Annotated[Number | None, scalar("d", "N m s/rad", "damping", "[0, inf)")] = None

    def inputs(self) -> tuple[Quantity, ...]:
        return (Quantity(f"{self.name}_torque", "N m", f"torque of {self.name}"),) if self.motor else ()

    def coordinates(self) -> tuple[Coordinate, ...]:
        angle = Quantity(f"{self.name}_angle", "rad", f"angle of {self.name}")
        return (Coordinate(Quantity(f"{self.name}_rate", "rad/s", f"rate of {self.name}"), angle),)

    def aggregates(self, at: Mounted) -> Aggregates:
        v, (coordinate,) = at.values, self.coordinates()
        assert coordinate.place is not None
        angle, rate = coordinate.place.symbol, coordinate.speed.symbol
        cosine, sine = at.frame.circle(angle)
        rest = _Turning(at, v.axis, cosine, sine)
        first = v.mass * v.at + rest.vector("s", v.mass * v.centre, "first moment about the joint")
        about = v.inertia + point_inertia(v.mass, v.centre)
        spin = rest.vector("Jg", about * v.axis, "angular momentum about the joint per rate")
        momentum = v.axis.cross(first - v.mass * v.at)
        potential, force = self._forces(at, angle, rate)
        return Aggregates(
            v.mass, first, rest.inertia(about, v.mass * v.centre, v.mass, v.at), rate * momentum,
            rate * (v.at.cross(momentum) + spin), _along(about, v.axis) * rate**2 / 2, potential, (force,),
        )  # fmt: skip


@dataclass(frozen=True)
class Slider(_Jointed):
    """A rigid body that slides along an axis of the hub.

    Parameters
    ----------
    name : str
        As of a `Part`; its states are NAME_place and NAME_speed, its input, with a motor, NAME_force.
    mass, inertia, axis, at, centre, motor
        As of a `Hinge`.
    stiffness, damping : number, optional
        N/m, N s/m.
    """

    stiffness: Annotated[Number | None, scalar("k", "N/m", "stiffness", "[0, inf)")] = None
    damping: Annotated[Number | None, scalar("d", "N s/m", "damping", "[0, inf)")] = None

    def inputs(self) -> tuple[Quantity, ...]:
        return (Quantity(f"{self.name}_force", "N", f"force on {self.name}"),) if self.motor else ()

    def coordinates(self) -> tuple[Coordinate, ...]:
        place = Quantity(f"{self.name}_place", "m", f"place of {self.name} along its axis")
        return (Coordinate(Quantity(f"{self.name}_speed", "m/s", f"speed of {self.name}"), place),)

    def aggregates(self, at: Mounted) -> Aggregates:
        v, (coordinate,) = at.values, self.coordinates()
        assert coordinate.place is not None
        shift, rate = coordinate.place.symbol, coordinate.speed.symbol
        place = v.at + v.centre + shift * v.axis
        potential, force = self._forces(at, shift, rate)
        return Aggregates(
            v.mass, v.mass * place, v.inertia + point_inertia(v.mass, place), v.mass * rate * v.axis,
            v.mass * rate * place.cross(v.axis), v.mass * _along(sp.eye(3), v.axis) * rate**2 / 2, potential, (force,),
        )  # fmt: skip


def _along(matrix: sp.Matrix, axis: sp.Matrix) -> Expr:
    return (axis.T * matrix * axis)[0]


class _Turning:
    """Vectors and inertias of a body that turns about an axis: polynomials in cosine and sine of the angle.

    Their coefficients depend on parameters alone.
    """

    def __init__(self, at: Mounted, axis: sp.Matrix, cosine: Expr, sine: Expr) -> None:
        self.at, self.axis, self.cosine, self.sine = at, axis, cosine, sine
        projection = axis * axis.T
        self.fixed, self.even, self.odd = projection, sp.eye(3) - projection, cross_matrix(axis)

    def vector(self, name: str, rest: sp.Matrix, title: str) -> sp.Matrix:
        """Return a vector of the body in the axes of the hub, from its components at the angle zero."""
        fixed, even, odd = (
            self.at.vector(f"{name}{k}", part * rest, f"{title}: {which} part")
            for k, part, which in ((0, self.fixed, "fixed"), (1, self.even, "cosine"), (2, self.odd, "sine"))
        )
        return fixed + self.cosine * even + self.sine * odd

    def inertia(self, about: sp.Matrix, first: sp.Matrix, mass: Expr, joint: sp.Matrix) -> sp.Matrix:
        """Return the inertia about O, from that about the joint and the first moment at the angle zero.

        With sin^2 = 1 - cos^2 it has five coefficients.
        """
        f, e, o = self.fixed, self.even, self.odd
        shift = [_shifted(joint, part * first) for part in (f, e, o)]
        coefficients = (
            f * about * f + o * about * o.T + shift[0] + point_inertia(mass, joint),
            f * about * e + e * about * f + shift[1],
            f * about * o.T + o * about * f + shift[2],
            e * about * e - o * about * o.T,
            e * about * o.T + o * about * e,
        )
        c, s = self.cosine, self.sine
        named = (
            self.at.frame.tensor(f"{self.at.name}_K{k}", matrix, f"{self.at.name}: inertia, coefficient {k}", "kg m^2")
            for k, matrix in enumerate(coefficients)
        )
        return sum(
            (factor * matrix for factor, matrix in zip((1, c, s, c * c, c * s), named, strict=True)), sp.zeros(3, 3)
        )


def _shifted(joint: sp.Matrix, first: sp.Matrix) -> sp.Matrix:
    """Return what a first moment about the joint adds to the inertia about O."""
    return 2 * joint.dot(first) * sp.eye(3) - joint * first.T - first * joint.T
