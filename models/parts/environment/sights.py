# SPDX-License-Identifier: Apache-2.0
"""Events of an orbit: eclipses, and contacts with stations on the ground."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import sympy as sp

from ...derivation import Expr
from ...events import Event
from ...mechanics import direction
from ...quantities import TIME
from ..part import Mounted, Part
from ..values import Number, scalar
from .orbit import EARTH, sky

_ANY = "(-inf, inf)"
_RIGHT_ANGLE = "[-1.5707963267948968, 1.5707963267948968]"


@dataclass(frozen=True)
class Eclipse(Part):
    """Entries into the Earth's shadow and exits from it, as located events.

    The events are NAME_begins and NAME_ends. With `Orbit(shadow="cone")` they are of the penumbra; NAME_full_begins
    and NAME_full_ends are of the umbra. Steps end there, where the light has a kink or a jump.

    Parameters
    ----------
    name : str
        As of a `Part`.
    """

    def events(self, at: Mounted) -> tuple[Event, ...]:
        here = sky(at)
        apart, earth = here.discs
        if here.part.shadow == "cylinder":
            return _pair(self.name, apart - earth, "the craft enters the shadow", "the craft leaves the shadow")
        sun = here.disc
        return (
            *_pair(self.name, apart - earth - sun, "the penumbra begins", "the penumbra ends"),
            *_pair(f"{self.name}_full", apart - earth + sun, "the umbra begins", "the umbra ends"),
        )


@dataclass(frozen=True)
class GroundStation(Part):
    """A station on the rotating Earth; NAME_begins and NAME_ends are the events of a contact.

    Parameters
    ----------
    name : str
        As of a `Part`.
    latitude : number
        Geodetic latitude, rad.
    ascension : number
        Right ascension at the start, rad: its longitude and the sidereal time of Greenwich.
    height : number
        Above the ellipsoid, m.
    elevation : number
        Least elevation of a contact, rad.
    flattening : number
        Of the Earth; 0 for a sphere.
    """

    latitude: Annotated[Number, scalar("lat", "rad", "geodetic latitude", _RIGHT_ANGLE)]
    ascension: Annotated[Number, scalar("ra", "rad", "right ascension at the start", _ANY)]
    height: Annotated[Number, scalar("h", "m", "height above the ellipsoid", _ANY)] = 0.0
    elevation: Annotated[Number, scalar("mask", "rad", "least elevation of a contact", _RIGHT_ANGLE)] = 0.0
    flattening: Annotated[Number, scalar("flat", "1", "flattening of the Earth", "[0, 1)")] = EARTH["flattening"]

    def events(self, at: Mounted) -> tuple[Event, ...]:
        v, here = at.values, sky(at)
        earth = here.orbit.values
        angle = at.define("angle", v.ascension + earth.spin * TIME.symbol, "right ascension", "rad")
        up = at.vector("up", direction(angle, v.latitude), "its vertical, inertial", "1")
        polar = at.define("polar", (1 - v.flattening) ** 2, "squared ratio of the Earth's axes", "1")
        sine = sp.sin(v.latitude)
        bend = at.define("bend", earth.radius / sp.sqrt(1 - (1 - polar) * sine**2), "radius of curvature", "m")
        place = [*((bend + v.height) * up[:2, 0]), (polar * bend + v.height) * up[2]]
        line = at.vector("line", here.part.place - sp.Matrix(place), "from the station to the craft, inertial", "m")
        above: Expr = line.dot(up) - sp.sin(v.elevation) * sp.sqrt(line.dot(line))
        return _pair(self.name, -above, f"the craft rises over {self.name}", f"the craft sets at {self.name}")


def _pair(name: str, guard: Expr, begins: str, ends: str) -> tuple[Event, Event]:
    """Return the events at which a guard becomes negative, and positive again."""
    return Event(f"{name}_begins", guard, "falling", title=begins), Event(f"{name}_ends", guard, "rising", title=ends)
