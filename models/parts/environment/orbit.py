# SPDX-License-Identifier: Apache-2.0
"""Orbit about the Earth with gravity, magnetic field, air and sunlight along it.

The centre of mass moves under the Earth's gravity, optionally with oblateness, and under all forces on the parts. The
inertial axes are equatorial.
"""

from __future__ import annotations

import itertools
from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from types import SimpleNamespace
from typing import Annotated

import sympy as sp

from mehvar.base.errors import value_text

from ...arrays import INCREASING
from ...arrays.curves import curve
from ...derivation import Expr
from ...mechanics import direction, frame_turn
from ...quantities import ModelError, Quantity
from ...system import TIME, Condition
from ..frame import AXES, ZERO, Frame, symbols
from ..motion import Motion
from ..part import Mounted, Part
from ..terms import State
from ..values import Number, Parameters, Value, kinds, scalar
from .magnetism import Harmonics, check, coefficients
from .magnetism import field as gauss_field
from .sun import DAY, SPAN, Solar, date, seconds

GRAVITY = ("two-body", "J2", "J4")
SHADOW = ("cylinder", "cone")
EARTH = {
    "mu": Value(3.986004418e14, source="addition: the Earth, EGM96"),
    "J2": Value(1.08262668e-3, source="addition: the Earth, EGM96"),
    "J3": Value(-2.53265649e-6, source="addition: the Earth, EGM96"),
    "J4": Value(-1.61962159e-6, source="addition: the Earth, EGM96"),
    "radius": Value(6378137.0, source="addition: the Earth, WGS 84"),
    "flattening": Value(1 / 298.257223563, source="addition: the Earth, WGS 84"),
    "reference": Value(6371200.0, source="addition: reference radius of the IGRF"),
    "spin": Value(7.292115e-5, source="addition: the Earth, WGS 84"),
    "dipole": Value(7.9e15, source="addition: dipole model of the Earth's field"),
    "tilt": Value(0.17, source="addition: the Earth in 2020, IGRF-13"),
    "air": Value(1.5e-13, source="addition: at 600 km, mean activity of the Sun; 1e-14 to 1e-12"),
    "thinning": Value(7e4, source="addition: at 600 km"),
    "sunlight": Value(4.56e-6, source="addition: at the Earth"),
    "disc": Value(4.6525e-3, source="addition: the Sun at 1 au"),
}
_CLOSEST = 1e-9
"""Smallest angle between two discs, rad; the position of their chord divides by this angle."""
_ANY = "(-inf, inf)"
_HALF_TURN = "[0, 3.141592653589794)"
_DECLINATION = "[-1.5707963267948968, 1.5707963267948968]"
_BESIDE, _WITHOUT = "beside {}: leave one of both out", "without {}: give both or neither"
_IDLE: Mapping[str, tuple[Callable[[Orbit], bool], str]] = {
    "density height thinning": (lambda o: o.air != (), _BESIDE.format("air")),
    "ascension declination": (lambda o: o.epoch is not None, _BESIDE.format("epoch")),
    "dipole tilt": (lambda o: o.harmonics != (), _BESIDE.format("harmonics")),
    "reference": (lambda o: o.harmonics == (), _WITHOUT.format("harmonics")),
    "disc": (lambda o: o.shadow != "cone", _WITHOUT.format('shadow = "cone"')),
    "oblateness": (lambda o: o.gravity == "two-body", _WITHOUT.format('gravity = "J2" or "J4"')),
    "third fourth": (lambda o: o.gravity != "J4", _WITHOUT.format('gravity = "J4"')),
}
"""Fields that have no effect beside or without another field, whatever the parts of the craft."""


@dataclass(frozen=True)
class Layer:
    """A row of a table of the air.

    Parameters
    ----------
    height : number
        Above the equatorial radius, m.
    density : number
        kg/m^3.
    """

    height: Annotated[Number, scalar("air_h", "m", "height of the air's density", _ANY)]
    density: Annotated[Number, scalar("air_rho", "kg/m^3", "density of the air")]


@dataclass(frozen=True)
class Orbit(Part):
    """Orbit about the Earth, given to a craft by `Spacecraft(..., orbit=Orbit())`.

    Its states are position and velocity of the craft's centre of mass in inertial axes, orbit_x, ... and orbit_vx, ...
    Elements at the start are parameters of the scenario: orbit_a_0, orbit_e_0, orbit_i_0, orbit_node_0,
    orbit_perigee_0 and orbit_anomaly_0. A run ends where the centre of mass reaches the Earth's equatorial radius.

    Parameters
    ----------
    gravity : {"two-body", "J2", "J4"}
        Gravity of a sphere, with J2, or with zonal harmonics to J4.
    shadow : {"cylinder", "cone"}
        Sharp shadow of a point-like Sun at infinity, or penumbra and umbra of the Sun's disc.
    size, eccentricity, inclination, node, perigee, anomaly : float
        Defaults of the elements: semi-major axis, m, and angles in rad.
    mu, oblateness, third, fourth, radius : number
        Gravitational parameter, m^3/s^2, J2, J3, J4, and equatorial radius, m.
    spin : number
        Rate of the Earth, which its field and its air follow, rad/s.
    dipole, tilt, longitude : number
        Strength of the Earth's magnetic dipole, Wb m, its angle from the Earth's axis, and its right ascension at the
        start, rad.
    harmonics : sequence of (int, int, float, float)
        Degree n, order m and Gauss coefficients g and h, nT, in Schmidt's normalisation, as of the IGRF. They
        replace the dipole; `longitude` is then the right ascension of Greenwich at the start.
    reference : number
        Radius to which the coefficients refer, m.
    density, height, thinning : number
        Density of the air, kg/m^3, at a height, m, and the height in which it falls by e, m.
    air : sequence of (height, density)
        A table that replaces these: at least two heights, m, increasing, with densities, kg/m^3. The logarithm is
        interpolated linearly, also beyond the ends. Parameters are orbit_air_h_1, ..., orbit_air_rho_1, ...
    sunlight, disc : number
        Pressure of sunlight, N/m^2, and angular radius of the Sun's disc, rad, at 1 au.
    ascension, declination : number
        Where a fixed Sun at 1 au stands, rad.
    epoch : text or number, optional
        Time of the start, such as "2026-11-28 12:00", or seconds since 2000-01-01 12:00; from 1950 to 2050. The Sun
        then moves, to 0.015 degrees, in axes of the mean equator and equinox of date. `longitude` and the `ascension`
        of stations do not follow from it.
    """

    name: str = field(default="orbit", init=False)
    gravity: str = "two-body"
    shadow: str = field(default="cylinder", kw_only=True)
    harmonics: Harmonics = field(default=(), kw_only=True)
    air: Sequence[Layer | Sequence[Number]] = field(default=(), kw_only=True)
    epoch: Annotated[Number | str | None, scalar("epoch", "s", "start, since 2000-01-01 12:00", SPAN)] = field(
        default=None, kw_only=True
    )
    size: float = 6978137.0
    eccentricity: float = 0.0
    inclination: float = 0.0
    node: float = 0.0
    perigee: float = 0.0
    anomaly: float = 0.0
    mu: Annotated[Number, scalar("mu", "m^3/s^2", "gravitational parameter")] = EARTH["mu"]
    oblateness: Annotated[Number, scalar("J2", "1", "oblateness", "[0, 1)")] = EARTH["J2"]
    third: Annotated[Number, scalar("J3", "1", "third zonal harmonic", _ANY)] = EARTH["J3"]
    fourth: Annotated[Number, scalar("J4", "1", "fourth zonal harmonic", _ANY)] = EARTH["J4"]
    radius: Annotated[Number, scalar("R", "m", "equatorial radius")] = EARTH["radius"]
    spin: Annotated[Number, scalar("spin", "rad/s", "rate of the Earth", _ANY)] = EARTH["spin"]
    dipole: Annotated[Number, scalar("mf", "Wb m", "strength of the magnetic dipole", "[0, inf)")] = EARTH["dipole"]
    tilt: Annotated[Number, scalar("tilt", "rad", "angle of the dipole from the axis", _HALF_TURN)] = EARTH["tilt"]
    longitude: Annotated[Number, scalar("pole", "rad", "right ascension of the dipole at the start", _ANY)] = 0.0
    reference: Annotated[Number, scalar("Rm", "m", "reference radius of the harmonics")] = EARTH["reference"]
    density: Annotated[Number, scalar("rho", "kg/m^3", "density of the air at the height", "[0, inf)")] = EARTH["air"]
    height: Annotated[Number, scalar("height", "m", "height at which the density is rho", _ANY)] = 6e5
    thinning: Annotated[Number, scalar("thin", "m", "height in which the air thins out by e")] = EARTH["thinning"]
    sunlight: Annotated[Number, scalar("light", "N/m^2", "pressure of sunlight", "[0, inf)")] = EARTH["sunlight"]
    ascension: Annotated[Number, scalar("sun", "rad", "right ascension of the Sun", _ANY)] = 0.0
    declination: Annotated[Number, scalar("sun_up", "rad", "declination of the Sun", _DECLINATION)] = 0.0
    disc: Annotated[Number, scalar("disc", "rad", "angular radius of the Sun", "(0, 0.1]")] = EARTH["disc"]

    def __post_init__(self) -> None:
        for name, words in (("gravity", GRAVITY), ("shadow", SHADOW)):
            if getattr(self, name) not in words:
                raise ModelError(
                    f"orbit: {name} = {value_text(getattr(self, name))}: must be one of {', '.join(words)}"
                )
        if self.harmonics:
            check(self.harmonics)
        if isinstance(self.epoch, str):
            object.__setattr__(self, "epoch", Value(seconds(self.epoch), source=self.epoch))
        object.__setattr__(self, "air", _layers(self.air))
        for group, (idle, effect) in _IDLE.items():
            given = [f.name for f in fields(self) if f.name in group.split() and getattr(self, f.name) != f.default]
            if given and idle(self):
                raise ModelError(f"orbit: {given[0]} has no effect {effect}")

    @classmethod
    def lists(cls) -> Mapping[str, type]:
        return {"air": Layer}

    def texts(self) -> Mapping[str, str]:
        epoch = self.epoch.default if isinstance(self.epoch, Value) else self.epoch
        return {"epoch": date(float(epoch))} if isinstance(epoch, int | float) else {}

    def values(self, parameters: Parameters) -> SimpleNamespace:
        result = super().values(parameters)
        result.gauss = coefficients(self.harmonics, parameters, self.name)
        height, density = kinds(Layer).values()
        rows = [
            parameters.column(kind, f"{self.name}_{kind.symbol}", [getattr(layer, name) for layer in self.air], form)
            for name, kind, form in (("height", height, INCREASING), ("density", density, ""))
            if self.air
        ]
        result.air = tuple(rows)
        if self.epoch is not None:
            day = Value(DAY, source="addition: exact")
            result.day = parameters.add(f"{self.name}_day", day, "s", "duration of a day", "(0, inf)")
        return result

    @property
    def place(self) -> sp.Matrix:
        """Symbols of the position of the centre of mass in inertial axes, m."""
        return symbols(self._quantities()[:3])

    @property
    def velocity(self) -> sp.Matrix:
        """Symbols of the velocity of the centre of mass in inertial axes, m/s."""
        return symbols(self._quantities()[3:])

    def _quantities(self) -> tuple[Quantity, ...]:
        kinds = (("", "m", "position"), ("v", "m/s", "velocity"))
        return tuple(
            Quantity(f"{self.name}_{letter}{axis}", unit, f"{meaning} of the centre of mass along inertial {axis}")
            for letter, unit, meaning in kinds
            for axis in AXES
        )

    def ignored(self, at: Mounted) -> list[str]:
        """Return no field: the terms of other parts contain those of the orbit."""
        return []

    def states(self, scenario: Parameters) -> tuple[State, ...]:
        rows = (
            ("a", self.size, "m", "semi-major axis", "(0, inf)"),
            ("e", self.eccentricity, "1", "eccentricity", "[0, 1)"),
            ("i", self.inclination, "rad", "inclination", _HALF_TURN),
            ("node", self.node, "rad", "right ascension of the ascending node", _ANY),
            ("perigee", self.perigee, "rad", "argument of the perigee", _ANY),
            ("anomaly", self.anomaly, "rad", "true anomaly", _ANY),
        )
        elements = [
            scenario.add(f"{self.name}_{letter}_0", value, unit, f"{meaning} at the start", bounds)
            for letter, value, unit, meaning, bounds in rows
        ]
        mu = self.values(Parameters()).mu
        return tuple(map(State, self._quantities(), at_elements(mu, *elements)))

    def rates(self, at: Mounted, motion: Motion) -> tuple[Expr, ...]:
        v, frame, craft = at.values, at.frame, at.craft
        radius, up = _radius(self, frame)
        pull = at.define("pull", v.mu / radius**2, "gravity of the Earth", "m/s^2")
        result = -pull * up
        if self.gravity != "two-body":
            share = at.define("flat", v.oblateness * (v.radius / radius) ** 2 * 3 / 2 * pull, "of oblateness", "m/s^2")
            result -= share * ((1 - 5 * up[2] ** 2) * up + 2 * up[2] * sp.Matrix([0, 0, 1]))
        if self.gravity == "J4":
            for order, harmonic in ((3, v.third), (4, v.fourth)):
                share = at.define(f"J{order}g", harmonic * (v.radius / radius) ** order * pull, "zonal", "m/s^2")
                result += share * zonal(order, up)
        for part, mounted in craft.parts:
            if isinstance(part, Attraction):
                result += part.acceleration(mounted, self.place)
        force = sum((load.force for load in craft.loads()), ZERO)
        if not force.is_zero_matrix:
            felt = at.vector("push_", force / craft.whole().mass, "acceleration by forces on the craft", "m/s^2")
            result += craft.rotation.T * felt
        return (*self.velocity, *result)

    def limits(self, at: Mounted) -> tuple[Condition, ...]:
        return (
            Condition(
                _radius(self, at.frame)[0] - at.values.radius,
                f"the craft is inside the Earth, whose radius is {self.name}_R = {{{self.name}_R:g}} m",
            ),
        )


def zonal(order: int, up: sp.Matrix) -> sp.Matrix:
    """Return the direction and share of a zonal harmonic's acceleration, per J_n (R/r)^n mu/r^2.

    With s the sine of the latitude it is (n + 1) P_n(s) n - P_n'(s) (k - s n), where n points away from the Earth and k
    to the north. (Vallado, Fundamentals of Astrodynamics, 2013, 8.6.)
    """
    s = sp.Symbol("s")
    legendre = sp.legendre(order, s)
    value, slope = (expr.subs(s, up[2]) for expr in (legendre, legendre.diff(s)))
    return (order + 1) * value * up - slope * (sp.Matrix([0, 0, 1]) - up[2] * up)


def _layers(air: object) -> tuple[Layer, ...]:
    """Return the rows of a table of the air."""
    try:
        rows = [row if isinstance(row, Layer) else Layer(*row) for row in air]  # type: ignore[attr-defined]
    except TypeError:
        raise ModelError(f"orbit: air = {value_text(air)}: must be rows of height, m, and density, kg/m^3") from None
    heights = [layer.height.default if isinstance(layer.height, Value) else layer.height for layer in rows]
    if len(rows) == 1 or any(not a < b for a, b in itertools.pairwise(heights)):
        raise ModelError(f"orbit: air: must be two rows or more with increasing heights, not {heights}")
    return tuple(rows)


class Attraction(Part):
    """A body whose gravity accelerates all parts of a craft alike and thus changes only the orbit."""

    @abstractmethod
    def acceleration(self, at: Mounted, place: sp.Matrix) -> sp.Matrix:
        """Return the acceleration relative to the Earth at a place, in inertial axes, m/s^2."""


def at_elements(
    mu: Expr, size: Expr, eccentricity: Expr, inclination: Expr, node: Expr, perigee: Expr, anomaly: Expr
) -> tuple[Expr, ...]:
    """Return position and velocity in inertial axes for Kepler's elements."""
    parameter = size * (1 - eccentricity**2)
    radius, speed = parameter / (1 + eccentricity * sp.cos(anomaly)), sp.sqrt(mu / parameter)
    turned = frame_turn(2, -node) * frame_turn(0, -inclination) * frame_turn(2, -perigee)
    place = turned * sp.Matrix([radius * sp.cos(anomaly), radius * sp.sin(anomaly), 0])
    velocity = turned * sp.Matrix([-speed * sp.sin(anomaly), speed * (eccentricity + sp.cos(anomaly)), 0])
    return (*place, *velocity)


def _radius(orbit: Orbit, frame: Frame) -> tuple[Expr, sp.Matrix]:
    """Name the distance from the Earth's centre and the direction away from it, in inertial axes."""
    name, place = orbit.name, orbit.place
    radius = frame.define(f"{name}_r", sp.sqrt(place.dot(place)), "distance from the centre of the Earth", "m")
    return radius, frame.vector(f"{name}_n", place / radius, "direction from the centre of the Earth, inertial", "1")


@dataclass(frozen=True)
class Sky:
    """Environment at a point of the orbit, in hub axes; each quantity is defined at first use.

    Parameters
    ----------
    orbit : Mounted
        The orbit in its assembly.
    part : Orbit
        The orbit.
    """

    orbit: Mounted
    part: Orbit

    @property
    def radius(self) -> Expr:
        """Distance from the centre of the Earth, m."""
        return _radius(self.part, self.orbit.frame)[0]

    @property
    def up(self) -> sp.Matrix:
        """Direction away from the centre of the Earth."""
        return self._seen("up_", _radius(self.part, self.orbit.frame)[1], "direction from the Earth", "1")

    @property
    def pull(self) -> Expr:
        """mu/r^3, 1/s^2."""
        return self.orbit.define("k", self.orbit.values.mu / self.radius**3, "gravity over the radius", "1/s^2")

    @property
    def field(self) -> sp.Matrix:
        """Magnetic field of the rotating Earth, Wb/m^2: of its dipole, or of Gauss coefficients."""
        v = self.orbit.values
        if v.gauss:
            turn = frame_turn(2, v.longitude + v.spin * TIME.symbol)
            turn = sp.Matrix(3, 3, lambda i, j: self.orbit.define(f"E{i}{j}", turn[i, j], "turn of the Earth", "1"))
            place = self.orbit.vector("fixed_", turn * self.part.place, "place in axes of the Earth", "m")
            value = turn.T * gauss_field(v.gauss, place, v.reference, self.orbit.define)
        else:
            pole = direction(v.longitude + v.spin * TIME.symbol, sp.pi / 2 - v.tilt)
            radius, up = _radius(self.part, self.orbit.frame)
            pole = self.orbit.vector("pole_", pole, "direction of the magnetic dipole, towards north", "1")
            value = v.dipole / radius**3 * (pole - 3 * pole.dot(up) * up)
        return self._seen("B", self.orbit.vector("B0", value, "magnetic field, inertial", "Wb/m^2"), "field", "Wb/m^2")

    @property
    def wind(self) -> sp.Matrix:
        """Velocity relative to the air, which rotates with the Earth, m/s."""
        place, spin = self.part.place, self.orbit.values.spin
        value = self.part.velocity - spin * sp.Matrix([-place[1], place[0], 0])
        return self._seen("wind_", value, "velocity through the air", "m/s")

    @property
    def density(self) -> Expr:
        """Density of the air, kg/m^3."""
        v, height = self.orbit.values, self.radius - self.orbit.values.radius
        if v.air:
            height = self.orbit.define("height", height, "height over the equatorial radius", "m")
            heights, densities = v.air
            logs = [sp.log(entry / densities[0]) for entry in densities]
            value = densities[0] * sp.exp(curve(height, heights, logs, "linear", "line"))
        else:
            value = v.density * sp.exp(-(height - v.height) / v.thinning)
        return self.orbit.define("air", value, "density of the air", "kg/m^3")

    @property
    def sun(self) -> sp.Matrix:
        """Direction to the Sun."""
        return self._seen("sun_", self.towards_sun, "direction to the Sun", "1")

    @property
    def solar(self) -> Solar | None:
        """The moving Sun; None for a fixed one."""
        epoch = self.orbit.values.epoch
        return None if epoch is None else Solar(self.orbit, epoch)

    @property
    def far(self) -> Expr:
        """Distance of the Sun, in units of 149 597 870 700 m."""
        return sp.S.One if self.solar is None else self.solar.distance

    @property
    def sunlight(self) -> Expr:
        """Pressure of sunlight out of the shadow, N/m^2."""
        return self.orbit.values.sunlight / self.far**2

    @property
    def disc(self) -> Expr:
        """Angular radius of the Sun's disc, rad."""
        return self.orbit.values.disc / self.far

    @property
    def light(self) -> Expr:
        """Visible share of the Sun: 1 in sunlight, 0 in the Earth's shadow."""
        if self.part.shadow == "cone":
            return self._visible()
        radius, along = self.radius, self._noon
        off = sp.sqrt(sp.Max(0, 1 - along**2)) * radius
        dark = sp.And(along < 0, off < self.orbit.values.radius)
        return self.orbit.define("lit", sp.Piecewise((0, dark), (1, True)), "1 in sunlight, 0 in the shadow", "1")

    @property
    def _noon(self) -> Expr:
        up = _radius(self.part, self.orbit.frame)[1]
        return self.orbit.define("noon", self.towards_sun.dot(up), "cosine of the angle between Sun and craft", "1")

    @property
    def discs(self) -> tuple[Expr, Expr]:
        """Angle between the centres of the Sun's and the Earth's disc, and the angular radius of the Earth, rad."""
        define, limb = self.orbit.define, sp.asin(sp.Min(1, self.orbit.values.radius / self.radius))
        earth = define("limb", limb, "angular radius of the Earth", "rad")
        along = sp.Max(-1, sp.Min(1, -self._noon))
        return define("apart", sp.acos(along), "angle between the discs", "rad"), earth

    def _visible(self) -> Expr:
        """Return the visible share of the Sun's disc beside the Earth's disc; both are flat circles.

        Circular segments on both sides of the common chord form the overlap. (Montenbruck and Gill, Satellite Orbits,
        2000, 3.4.2.)
        """
        define = self.orbit.define
        sun, (apart, earth) = self.disc, self.discs
        gap = define("gap", sp.Max(apart, _CLOSEST), "angle between the discs, above zero", "rad")
        chord = define("chord", (gap**2 + sun**2 - earth**2) / (2 * gap), "distance of the chord from the Sun", "rad")

        def segment(size: Expr, distance: Expr) -> Expr:
            cosine = sp.Max(-1, sp.Min(1, distance / size))
            return size**2 * (sp.acos(cosine) - cosine * sp.sqrt(1 - cosine**2))

        covered = (segment(sun, chord) + segment(earth, gap - chord)) / (sp.pi * sun**2)
        partly = define("shade", sp.Min(1, covered), "covered share of the Sun's disc", "1")
        inside = sp.Piecewise((1, apart <= earth - sun), (0, apart >= earth + sun), (partly, True))
        return define("lit", 1 - inside, "visible share of the Sun's disc", "1")

    @property
    def towards_sun(self) -> sp.Matrix:
        """Direction to the Sun in inertial axes."""
        v = self.orbit.values
        value = direction(v.ascension, v.declination) if self.solar is None else self.solar.direction
        return self.orbit.vector("sun0", value, "direction to the Sun, inertial", "1")

    def _seen(self, name: str, inertial: sp.Matrix, title: str, unit: str) -> sp.Matrix:
        return self.orbit.vector(name, self.orbit.craft.rotation * inertial, f"{title}, in the axes of the hub", unit)


def sky(at: Mounted) -> Sky:
    """Return the environment of a craft on its orbit.

    Raises
    ------
    ModelError
        If the craft has none.
    """
    for part, mounted in at.craft.parts:
        if isinstance(part, Orbit):
            return Sky(mounted, part)
    raise ModelError(f"{at.name} needs an orbit: write Spacecraft(..., orbit=Orbit())")
