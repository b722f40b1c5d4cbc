# SPDX-License-Identifier: Apache-2.0
"""Gravity of the Moon and of the Sun on an orbit about the Earth."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass, replace
from typing import Annotated

import sympy as sp

from ...derivation import Expr
from ...mechanics import frame_turn
from ...quantities import TIME
from ..part import Mounted, Part
from ..terms import Load
from ..values import Number, scalar
from .orbit import Attraction, sky

_ANY = "(-inf, inf)"
_HALF_TURN = "[0, 3.141592653589794)"


@dataclass(frozen=True)
class _Body(Attraction):
    """A body whose gravity disturbs the orbit of the craft.

    With positions r of the craft and p of the body the acceleration is mu ((p - r)/|p - r|^3 - p/|p|^3). This
    difference of nearly equal vectors loses digits. It is therefore computed as -mu/|p - r|^3 (r + f p), where q =
    r.(r - 2 p)/p.p and f = q (3 + 3 q + q^2)/(1 + (1 + q)^(3/2)). (Battin, Mathematics and Methods of Astrodynamics,
    1999, 8.4.) All parts of a craft accelerate alike, so that only the orbit changes.
    """

    @abstractmethod
    def body(self, at: Mounted) -> tuple[Expr, sp.Matrix]:
        """Return the body's distance from the Earth, m, and direction in inertial axes."""

    def loads(self, at: Mounted) -> tuple[Load, ...]:
        sky(at)  # refuses a craft without an orbit
        return ()

    def acceleration(self, at: Mounted, place: sp.Matrix) -> sp.Matrix:
        distance, along = self.body(at)
        body = at.vector("p", distance * along, "place", "m")
        q = at.define("q", place.dot(place - 2 * body) / distance**2, "relative change of the squared distance", "1")
        f = at.define("f", q * (3 + 3 * q + q**2) / (1 + (1 + q) ** sp.Rational(3, 2)), "of the cubed distance", "1")
        pull = at.define(
            "pull", at.values.mu / (distance**3 * (1 + q) ** sp.Rational(3, 2)), "gravity over distance", "1/s^2"
        )
        return -pull * (place + f * body)


@dataclass(frozen=True)
class ThirdBody(_Body):
    """A body on a circle about the Earth whose gravity disturbs the orbit of the craft, such as the Moon.

    Parameters
    ----------
    name : str
        As of a `Part`.
    mu : number
        Gravitational parameter, m^3/s^2; default: the Moon's.
    distance : number
        Radius of its circle, m.
    rate : number
        Angular rate on the circle, rad/s.
    inclination, node : number
        Inclination of the circle to the equator, and right ascension of its ascending node, rad.
    phase : number
        Angle from the node at the start, rad.
    """

    mu: Annotated[Number, scalar("mu", "m^3/s^2", "gravitational parameter")] = 4.9028e12
    distance: Annotated[Number, scalar("d", "m", "radius of its circle about the Earth")] = 3.844e8
    rate: Annotated[Number, scalar("n", "rad/s", "angular rate on the circle", _ANY)] = 2.6617e-6
    inclination: Annotated[Number, scalar("i", "rad", "inclination to the equator", _HALF_TURN)] = 0.4091
    node: Annotated[Number, scalar("node", "rad", "right ascension of the ascending node", _ANY)] = 0.0
    phase: Annotated[Number, scalar("phase", "rad", "angle from the node at the start", _ANY)] = 0.0

    def doubles(self, other: Part) -> bool:
        return isinstance(other, ThirdBody) and replace(other, name=self.name) == self

    def body(self, at: Mounted) -> tuple[Expr, sp.Matrix]:
        v = at.values
        angle = at.define("angle", v.phase + v.rate * TIME.symbol, "angle from the node", "rad")
        turned = frame_turn(2, -v.node) * frame_turn(0, -v.inclination)
        return v.distance, turned * sp.Matrix([sp.cos(angle), sp.sin(angle), 0])


@dataclass(frozen=True)
class SunGravity(_Body):
    """Gravity of the Sun, which stands where the orbit has it: fixed, or moving from `Orbit(epoch=...)`.

    Parameters
    ----------
    name : str
        As of a `Part`.
    mu : number
        Gravitational parameter, m^3/s^2.
    distance : number
        Astronomical unit, m.
    """

    name: str = "sun"
    mu: Annotated[Number, scalar("mu", "m^3/s^2", "gravitational parameter")] = 1.32712440018e20
    distance: Annotated[Number, scalar("d", "m", "astronomical unit")] = 1.495978707e11

    def doubles(self, other: Part) -> bool:
        return isinstance(other, SunGravity)

    def body(self, at: Mounted) -> tuple[Expr, sp.Matrix]:
        here = sky(at)
        return at.values.distance * here.far, here.towards_sun
