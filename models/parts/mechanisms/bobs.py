# SPDX-License-Identifier: Apache-2.0
"""Bobs: spherical pendulums as models of sloshing fuel."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated

import sympy as sp

from ...derivation import Expr
from ...quantities import ModelError, Quantity
from ..frame import point_inertia, symbols, triple
from ..motion import Motion
from ..part import Mounted, Part
from ..terms import Aggregates, Contribution, Follower, Load, State
from ..values import Number, Parameters, Vector, place, plain, scalar


@dataclass(frozen=True)
class Bob(Part):
    """A spherical pendulum: a point mass on a massless rod with a ball joint. Its states have no singularity.

    Its states are the direction e of the rod (NAME_ex, ...) and the absolute rate u = e' + W x e of the direction
    (NAME_ux, ...), both in the axes of the hub. A moment of inertia I of the bob resists rotation of the rod. With D
    = m l^2 + I the force on the pivot P is

        m I/D a_P + (m l)^2/D e (e . a_P) - m l/D c e' - m l u.u e.

    Parameters
    ----------
    name : str
        As of a `Part`.
    mass, length : number
        kg, m.
    at : three numbers
        Pivot, m.
    damping : number, optional
        c of the dissipation c e'.e'/2, N m s.
    inertia : number, optional
        Moment of inertia of the bob across the rod, kg m^2.
    rest : three numbers
        Direction of the rod from which the scenario's angles NAME_phi_0 (away from it) and NAME_theta_0 (around it)
        count; one of the axes, or its opposite.
    """

    mass: Annotated[Number, scalar("m", "kg", "mass")]
    length: Annotated[Number, scalar("l", "m", "length of the rod")]
    at: Annotated[Vector, place("r", "pivot")] = (0, 0, 0)
    damping: Annotated[Number | None, scalar("c", "N m s", "damping", "[0, inf)", absent=0)] = None
    inertia: Annotated[
        Number | None, scalar("I", "kg m^2", "moment of inertia across the rod", "[0, inf)", absent=0)
    ] = None
    rest: tuple[int, int, int] = (-1, 0, 0)

    def __post_init__(self) -> None:
        rest = plain(self.rest)
        if not isinstance(rest, Sequence) or any(isinstance(e, bool) for e in rest) or list(rest) not in _AXES:
            raise ModelError(
                f"{self.name}.rest = {self.rest!r}: must be an axis of the hub with either sign, such as (0, 0, -1)"
            )

    @property
    def direction(self) -> sp.Matrix:
        """Symbols of the rod's direction e."""
        return symbols(self._vectors()[0])

    @property
    def turning(self) -> sp.Matrix:
        """Symbols of the absolute rate u of the direction, 1/s."""
        return symbols(self._vectors()[1])

    def _vectors(self) -> tuple[tuple[Quantity, ...], ...]:
        name = self.name
        return triple(f"{name}_e", "1", f"direction of {name}"), triple(f"{name}_u", "1/s", f"absolute rate of {name}")

    def states(self, scenario: Parameters) -> tuple[State, ...]:
        angles = [
            scenario.add(f"{self.name}_{angle}_0", 0.0, "rad", f"{meaning} of {self.name} at the start", "(-inf, inf)")
            for angle, meaning in (("phi", "angle from rest"), ("theta", "angle around rest"))
        ]
        starts = [*_turned(self.rest, *angles), *[sp.S.Zero] * 3]
        return tuple(map(State, itertools.chain(*self._vectors()), starts))

    def projection(self) -> Mapping[sp.Symbol, Expr]:
        e, u = self.direction, self.turning
        unit = e / sp.sqrt(e.dot(e))
        across = u - e * (e.dot(u) / e.dot(e))
        return dict(zip((*e, *u), (*unit, *across), strict=True))

    def aggregates(self, at: Mounted) -> Aggregates:
        v, e = at.values, self.direction
        slip = self.turning - at.frame.rate.cross(e)
        place, velocity = v.at + v.length * e, v.length * slip
        return Aggregates.body(v.mass, place, velocity=velocity) + Aggregates(
            inertia=v.inertia * (sp.eye(3) - e * e.T), angular=v.inertia * e.cross(slip),
            energy=v.inertia * slip.dot(slip) / 2, power=-v.damping * slip.dot(slip),
        )  # fmt: skip

    def contribution(self, at: Mounted) -> Contribution:
        v, e = at.values, self.direction
        slip, squared = self._kinematics(at)
        swing = at.define("ml", v.mass * v.length, "mass times length", "kg m")
        moving = at.define("mv", v.mass * self._gain(at) * v.length, "mass that swings", "kg")
        loads: tuple[Load, ...] = ()
        if v.damping != 0:
            loss = at.define("kc", self._gain(at) * v.damping, "damping force over e'", "N s")
            force = at.vector("F", loss * slip, "damping force at the pivot", "N")
            loads = (Load(force, v.at, v.damping * e.cross(slip)),)
        mass = at.define("mf", v.mass * v.inertia / self._total(at), "mass that stays with the pivot", "kg")
        follower = Follower(moving, e, v.at, at.define("T0", swing * squared, "centrifugal pull along the rod", "N"))
        return Contribution(mass, mass * v.at, point_inertia(mass, v.at), loads=loads, followers=(follower,))

    def rates(self, at: Mounted, motion: Motion) -> tuple[Expr, ...]:
        v, e, w, u = at.values, self.direction, at.frame.rate, self.turning
        slip, _ = self._kinematics(at)
        gain, (pull,) = self._gain(at), motion.pulls
        pivot = motion.at(v.at, f"{self.name}_aP", f"pivot of {self.name}")
        value = at.define("kae", pull / (v.mass * v.length), "second rate along the rod", "1/s^2")
        drag = at.define("cD", v.damping / self._total(at), "damping over inertia", "1/s") * slip
        return (*slip, *(value * e - gain * pivot - w.cross(u) - drag))

    def slip(self, at: Mounted) -> sp.Matrix:
        """Return e', the rate of the rod's direction in hub axes."""
        title = "rate of the direction in the axes of the hub"
        return at.vector("de", self.turning - at.frame.rate.cross(self.direction), title, "1/s")

    def _kinematics(self, at: Mounted) -> tuple[sp.Matrix, Expr]:
        """Return e' and the square of u."""
        u, slip = self.turning, self.slip(at)
        return slip, at.define("uu", u.dot(u), "square of the rate", "1/s^2")

    def _total(self, at: Mounted) -> Expr:
        total: Expr = at.values.mass * at.values.length**2 + at.values.inertia
        return total

    def _gain(self, at: Mounted) -> Expr:
        """Return m l/D."""
        v = at.values
        return at.define("k", v.mass * v.length / self._total(at), "mass times length over inertia", "1/m")


_AXES = [[sign * (k == axis) for k in range(3)] for axis in range(3) for sign in (1, -1)]


def _turned(rest: tuple[int, int, int], phi: Expr, theta: Expr) -> tuple[Expr, ...]:
    """Return the direction at one angle from the rest direction and another angle about it."""
    axis = next(k for k in range(3) if rest[k])
    entries: list[Expr] = [sp.S.Zero] * 3
    entries[axis] = rest[axis] * sp.cos(phi)
    entries[(axis + 1) % 3] = sp.sin(phi) * sp.sin(theta)
    entries[(axis + 2) % 3] = sp.sin(phi) * sp.cos(theta)
    return tuple(entries)
