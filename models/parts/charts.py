# SPDX-License-Identifier: Apache-2.0
"""Charts of the attitude: coordinates, their rates, and the rotation."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

import sympy as sp

from ..derivation import Expr
from ..mechanics import (
    angle_rates,
    cross_matrix,
    frame_turn,
    quaternion_of_turns,
    quaternion_rates,
    quaternion_rotation,
)
from ..quantities import Quantity
from ..system import Condition
from .frame import Frame

ANGLES = ("roll", "pitch", "yaw")
NEAR = sp.Rational(1, 10**4)
"""Smallest distance from a singularity, rad or a fraction of a quarter turn. Coordinate rates then stay below
1/NEAR^2 times the hub's rate.
"""


class Chart(ABC):
    """Chart of the attitude.

    Parameters
    ----------
    states : sequence of Quantity, optional
        Coordinates with names of a system's own.

    Attributes
    ----------
    name : str
        Its name.
    states : tuple of Quantity
        Its coordinates.
    """

    name: str
    states: tuple[Quantity, ...]

    def __init__(self, states: Sequence[Quantity] = ()) -> None:
        if states:
            self.states = tuple(states)

    @property
    def symbols(self) -> tuple[sp.Symbol, ...]:
        """Symbols of the coordinates."""
        return tuple(q.symbol for q in self.states)

    @abstractmethod
    def rates(self, frame: Frame) -> Sequence[Expr]:
        """Return the rates of the coordinates for a given rate of the hub."""

    @abstractmethod
    def rotation(self) -> sp.Matrix:
        """Return the matrix from inertial axes to hub axes."""

    @abstractmethod
    def quaternion(self) -> Sequence[Expr]:
        """Return the unit quaternion, scalar first, from hub axes to inertial axes."""

    @abstractmethod
    def of_angles(self, angles: Sequence[Expr]) -> Sequence[Expr]:
        """Return the coordinates for 3-2-1 angles roll, pitch and yaw."""

    def projection(self) -> Sequence[Expr]:
        """Return the coordinates projected to their manifold; empty for a chart without one."""
        return ()

    def limits(self) -> tuple[Condition, ...]:
        """Return limits that end a run before a singularity."""
        return ()


class QuaternionChart(Chart):
    """Chart by a unit quaternion, scalar first, from hub axes to inertial axes."""

    name = "quaternion"
    states = tuple(Quantity(f"q{k}", "1", f"quaternion, component {k}", latex=f"q_{k}") for k in range(4))

    def rates(self, frame: Frame) -> Sequence[Expr]:
        half = frame.vector("half_w", frame.rate / 2, "half the rate of the hub", "rad/s")
        return list(2 * quaternion_rates(self.symbols, half))

    def rotation(self) -> sp.Matrix:
        return quaternion_rotation(self.symbols)

    def quaternion(self) -> Sequence[Expr]:
        return self.symbols

    def of_angles(self, angles: Sequence[Expr]) -> Sequence[Expr]:
        roll, pitch, yaw = angles
        return list(quaternion_of_turns(((2, yaw), (1, pitch), (0, roll))))

    def projection(self) -> Sequence[Expr]:
        size = sp.sqrt(sp.Add(*(q**2 for q in self.symbols)))
        return [q / size for q in self.symbols]


def turn_angles(rotation: sp.Matrix) -> tuple[Expr, Expr, Expr]:
    """Return the 3-2-1 angles roll, pitch and yaw of a matrix from inertial axes to hub axes."""
    pitch = -sp.asin(sp.Max(-1, sp.Min(1, rotation[0, 2])))
    return sp.atan2(rotation[1, 2], rotation[2, 2]), pitch, sp.atan2(rotation[0, 1], rotation[0, 0])


class EulerChart(Chart):
    """Chart by 3-2-1 Euler angles, singular at a pitch of 90 degrees."""

    name = "euler"
    states = tuple(Quantity(name, "rad", f"{name} angle") for name in ANGLES)

    def rates(self, frame: Frame) -> Sequence[Expr]:
        return list(angle_rates(self.rotation(), self.symbols, list(frame.rate)))

    def rotation(self) -> sp.Matrix:
        roll, pitch, yaw = self.symbols
        return frame_turn(0, roll) * frame_turn(1, pitch) * frame_turn(2, yaw)

    def quaternion(self) -> Sequence[Expr]:
        roll, pitch, yaw = self.symbols
        return list(quaternion_of_turns(((2, yaw), (1, pitch), (0, roll))))

    def of_angles(self, angles: Sequence[Expr]) -> Sequence[Expr]:
        return angles

    def limits(self) -> tuple[Condition, ...]:
        pitch = self.symbols[1]
        return (Condition(sp.cos(pitch) - NEAR, "pitch is 90 or -90 degrees, where the Euler angles are singular"),)


class RodriguesChart(Chart):
    """Chart by modified Rodrigues parameters, axis times tan(angle/4); singular at 360 degrees."""

    name = "mrp"
    states = tuple(Quantity(f"mrp{k}", "1", f"modified Rodrigues parameter {k}") for k in (1, 2, 3))

    def rates(self, frame: Frame) -> Sequence[Expr]:
        s, rate = sp.Matrix(self.symbols), frame.rate
        return list(((1 - s.dot(s)) * rate + 2 * s.cross(rate) + 2 * s.dot(rate) * s) / 4)

    def rotation(self) -> sp.Matrix:
        s = sp.Matrix(self.symbols)
        hat, size = cross_matrix(s), s.dot(s)
        return sp.eye(3) + (8 * hat * hat - 4 * (1 - size) * hat) / (1 + size) ** 2

    def quaternion(self) -> Sequence[Expr]:
        s = sp.Matrix(self.symbols)
        size = s.dot(s)
        return [(1 - size) / (1 + size), *(2 * s / (1 + size))]

    def of_angles(self, angles: Sequence[Expr]) -> Sequence[Expr]:
        roll, pitch, yaw = angles
        scalar, *vector = quaternion_of_turns(((2, yaw), (1, pitch), (0, roll)))
        return [component / (1 + scalar) for component in vector]

    def limits(self) -> tuple[Condition, ...]:
        s = sp.Matrix(self.symbols)
        why = "the attitude is a whole turn from the start of the chart, where its parameters are infinite"
        return (Condition(1 - NEAR**2 * s.dot(s), why),)


class PlaneChart(Chart):
    """Chart of plane motion: the hub's angle about z."""

    name = "plane"
    states = (Quantity("theta", "rad", "angle of the hub", latex=r"\theta"),)

    def rates(self, frame: Frame) -> Sequence[Expr]:
        return [frame.rate[2]]

    def rotation(self) -> sp.Matrix:
        return frame_turn(2, self.symbols[0])

    def quaternion(self) -> Sequence[Expr]:
        (angle,) = self.symbols
        return [sp.cos(angle / 2), sp.S.Zero, sp.S.Zero, sp.sin(angle / 2)]

    def of_angles(self, angles: Sequence[Expr]) -> Sequence[Expr]:
        return [angles[2]]


CHARTS: dict[str, type[Chart]] = {chart.name: chart for chart in (QuaternionChart, EulerChart, RodriguesChart)}
