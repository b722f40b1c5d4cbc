# SPDX-License-Identifier: Apache-2.0
"""Orbit: the paper's circle, or a Kepler ellipse by true anomaly with mean drift by the Earth's oblateness.

Orbit axes: x along the motion across the radius, y opposite to the orbit normal, z to nadir. An orbit gives the
rotation of these axes, the gravity gradient, and at each position magnetic field, air and sunlight.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass

import sympy as sp

from ..mechanics import angular_velocity, direction, frame_turn
from ..system import TIME, Derivation, Expr, Group, Quantity
from .naming import matrix, vector

LATITUDE = Quantity("latitude", "rad", "argument of latitude, the satellite's place on its orbit", r"\nu")
ANOMALY = Quantity("anomaly", "rad", "true anomaly, the angle from the perigee", r"\nu")
PERIGEE = Quantity("perigee", "rad", "argument of the perigee, from the ascending node", r"\omega_p")
NODE = Quantity("node", "rad", "right ascension of the ascending node", r"\Omega_n")

_TO_ORBIT_AXES = sp.Matrix([[0, 1, 0], [0, 0, -1], [-1, 0, 0]])
"""Rotation from the axes radius, along track and normal to the orbit axes."""


@dataclass(frozen=True)
class Orbit:
    """An orbit with the quantities of the model; vectors are in orbit axes.

    Attributes
    ----------
    states, rates : tuple
        States of the orbit and their rates.
    turning : sympy.Matrix
        Inertial rate of the orbit axes, rad/s.
    pull : Expr
        mu/r^3, 1/s^2.
    axes : sympy.Matrix
        Matrix from inertial to orbit axes.
    field : tuple of Expr
        Magnetic field, Wb/m^2.
    ahead, speed : sympy.Matrix and Expr
        Direction and size of the velocity, m/s.
    density : Expr
        Of the air, kg/m^3.
    sun : tuple of Expr
        Direction of the Sun.
    light : Expr
        1 in sunlight, 0 in the shadow of the Earth.
    start : tuple of Expr
        The states at the start.
    turning_at_start : sympy.Matrix
        `turning` at the start.
    """

    states: tuple[Quantity, ...]
    rates: tuple[Expr, ...]
    turning: sp.Matrix
    pull: Expr
    axes: sp.Matrix
    field: tuple[Expr, ...]
    ahead: sp.Matrix
    speed: Expr
    density: Expr
    sun: tuple[Expr, ...]
    light: Expr
    start: tuple[Expr, ...]
    turning_at_start: sp.Matrix


def circular_turning(omega0: Expr) -> sp.Matrix:
    """Return the rate of a circular orbit's axes in their own components: about -y, as z is nadir and x is velocity."""
    return sp.Matrix([0, -omega0, 0])


def circular(plant: Group, s: Group) -> Orbit:
    """Return the paper's orbit: constant rate about -y, dipole along the Earth's axis, Sun fixed in its plane."""
    latitude = LATITUDE.symbol
    turning = circular_turning(plant.omega0)
    strength, tilt = plant.field_moment / plant.orbit_radius**3, plant.inclination
    along, up = plant.sun_latitude - latitude, plant.sun_elevation
    return Orbit(
        states=(LATITUDE,),
        rates=(plant.omega0,),
        turning=turning,
        pull=plant.omega0**2,
        axes=frame_turn(1, -latitude),
        field=tuple(
            strength * part
            for part in (sp.cos(latitude) * sp.sin(tilt), -sp.cos(tilt), 2 * sp.sin(latitude) * sp.sin(tilt))
        ),
        ahead=sp.Matrix([1, 0, 0]),
        speed=plant.omega0 * plant.orbit_radius,
        density=plant.air_density,
        sun=(sp.cos(up) * sp.sin(along), -sp.sin(up), -sp.cos(up) * sp.cos(along)),
        light=sp.S.One,
        start=(s.latitude_0,),
        turning_at_start=turning,
    )


@functools.cache
def oblate_drift() -> tuple[tuple[sp.Symbol, ...], tuple[Expr, Expr, Expr]]:
    """Derive the mean rates of node, perigee and mean anomaly under J2 from Lagrange's planetary equations.

    Returns
    -------
    tuple of Symbol, tuple of Expr
        mu, a, e, i, J2, R, and the rates of node, of perigee, and of the mean anomaly beyond the mean motion.

    Notes
    -----
    The potential -mu J2 R^2 (3 sin^2 i sin^2 u - 1)/(2 r^3) is averaged over a revolution, with the weight r^2/(a^2
    sqrt(1 - e^2)) over the true anomaly. The result agrees with Kozai and Brouwer to first order.
    """
    mu, a, J2, R = symbols = sp.symbols("mu a J2 R", positive=True)
    e, i, anomaly, perigee = sp.symbols("e i nu omega", real=True)
    root = sp.sqrt(1 - e**2)
    inverse = (1 + e * sp.cos(anomaly)) / (a * (1 - e**2))
    potential = -mu * J2 * R**2 / 2 * inverse * (3 * sp.sin(i) ** 2 * sp.sin(anomaly + perigee) ** 2 - 1)
    passing = sp.expand(sp.expand_trig(potential / (a**2 * root)))
    mean = sp.simplify(sp.integrate(passing, (anomaly, 0, 2 * sp.pi)) / (2 * sp.pi))
    n = sp.sqrt(mu / a**3)
    by_inclination = sp.diff(mean, i) / (n * a**2 * root)
    node = by_inclination / sp.sin(i)
    turn = root * sp.diff(mean, e) / (n * a**2 * e) - sp.cos(i) * by_inclination / sp.sin(i)
    forth = -(root**2) * sp.diff(mean, e) / (n * a**2 * e) - 2 * sp.diff(mean, a) / (n * a)
    return (mu, a, e, i, *symbols[2:]), tuple(sp.factor(sp.simplify(rate)) for rate in (node, turn, forth))


@dataclass(frozen=True)
class _Place:
    """Position and motion on the ellipse at an anomaly, as unnamed expressions.

    Attributes
    ----------
    radius, around, outward : Expr
        r, m, and velocity components normal to and along the radius, m/s.
    rates : tuple of Expr
        Rates of anomaly, perigee and node, rad/s.
    axes, turning : sympy.Matrix
        Matrix from inertial to orbit axes, and the rate of the orbit axes.
    """

    radius: Expr
    around: Expr
    outward: Expr
    rates: tuple[Expr, Expr, Expr]
    axes: sp.Matrix
    turning: sp.Matrix


def _place(plant: Group, anomaly: Expr, perigee: Expr, node: Expr, named: Callable[..., Expr]) -> _Place:
    """Return position and motion at an anomaly; `named` may name the steps."""
    a, e, mu = plant.semi_major_axis, plant.eccentricity, plant.mu
    parameter = named("parameter", a * (1 - e**2), "semi-latus rectum", "m", "p")
    nearness = 1 + e * sp.cos(anomaly)
    radius = named("radius", parameter / nearness, "distance from the centre of the Earth", "m", "r")
    scale = named(
        "speed_scale", sp.sqrt(mu / parameter), "velocity across the radius at the semi-latus rectum", "m/s", "v_p"
    )
    symbols, drift = oblate_drift()
    values = dict(zip(symbols, (mu, a, e, plant.inclination, plant.J2, plant.earth_radius), strict=True))
    node_rate, perigee_rate, ahead = (rate.xreplace(values) for rate in drift)
    node_rate = named("node_rate", node_rate, "mean rate of the node by J2", "rad/s", r"\Omega_n'")
    perigee_rate = named("perigee_rate", perigee_rate, "mean rate of the perigee by J2", "rad/s", r"\omega_p'")
    share = named(
        "anomaly_share",
        1 + ahead / sp.sqrt(mu / a**3),
        "rate of the mean anomaly with J2 over that without",
        "1",
        "s_M",
    )
    anomaly_rate = named(
        "anomaly_rate", share * scale * nearness / radius, "rate of the true anomaly", "rad/s", r"\nu'"
    )
    up, turn, tilt = sp.symbols("up turn tilt", real=True)
    frame = _TO_ORBIT_AXES * frame_turn(2, up) * frame_turn(0, tilt) * frame_turn(2, turn)
    rate_up, rate_turn = sp.symbols("rate_up rate_turn", real=True)
    turning = angular_velocity(frame, {up: rate_up, turn: rate_turn})
    here = {up: anomaly + perigee, turn: node, tilt: plant.inclination}
    here |= {rate_up: anomaly_rate + perigee_rate, rate_turn: node_rate}
    rates = (anomaly_rate, perigee_rate, node_rate)
    axes, turning = (matrix.xreplace(here) for matrix in (frame, turning))
    return _Place(radius, scale * nearness, scale * e * sp.sin(anomaly), rates, axes, turning)


def keplerian(plant: Group, s: Group, d: Derivation) -> Orbit:
    """Define a Kepler ellipse by true anomaly, with mean J2 drift, tilted dipole, air, Sun and shadow.

    The dipole rotates with the Earth. Air density decays exponentially above the perigee, and the air does not
    rotate. The shadow is a cylinder.
    """
    d.section("Orbit")

    def named(name: str, expr: Expr, title: str, unit: str, latex: str) -> Expr:
        return d.define(name, expr, "", title, unit, latex)

    states = (ANOMALY, PERIGEE, NODE)
    here = _place(plant, ANOMALY.symbol, PERIGEE.symbol, NODE.symbol, named)
    start = (s.anomaly_0, s.perigee_0, s.node_0)
    first = _place(plant, s.anomaly_0, s.perigee_0, s.node_0, lambda _name, expr, *_: expr)
    axes = matrix("O", here.axes, "inertial to orbit axes", "1", d)
    title = "rate of the orbit axes about orbit *"
    turning = vector("orbit_rate_*", here.turning, title, "rad/s", r"\omega_{o,*}", d)
    speed = named("speed", sp.sqrt(here.around**2 + here.outward**2), "speed on the orbit", "m/s", "v")
    height = here.radius - plant.semi_major_axis * (1 - plant.eccentricity)
    density = named(
        "density", plant.air_density * sp.exp(-height / plant.scale_height), "density of the air", "kg/m^3", r"\rho"
    )
    sun = tuple(axes * direction(plant.sun_ascension, plant.sun_declination))
    beyond = sp.sqrt(sp.Max(0, 1 - sun[2] ** 2)) * here.radius  # distance from the line through Earth and Sun
    dark = sp.And(sun[2] > 0, beyond < plant.earth_radius)
    return Orbit(
        states=states,
        rates=here.rates,
        turning=turning,
        pull=named("pull", plant.mu / here.radius**3, "mu/r^3", "1/s^2", r"\mu/r^3"),
        axes=axes,
        field=_field(plant, here.radius, axes),
        ahead=sp.Matrix([here.around, 0, -here.outward]) / speed,
        speed=speed,
        density=density,
        sun=sun,
        light=named("light", sp.Piecewise((0, dark), (1, True)), "1 in sunlight, 0 in the shadow", "1", "l"),
        start=start,
        turning_at_start=first.turning,
    )


def _field(plant: Group, radius: Expr, axes: sp.Matrix) -> tuple[Expr, ...]:
    """Return a dipole's field (mf/r^3) (m - 3 (m.n) n), with northward axis m and nadir n."""
    longitude = plant.pole_longitude + plant.earth_rate * TIME.symbol
    pole = axes * direction(longitude, sp.pi / 2 - plant.pole_tilt)
    nadir = sp.Matrix([0, 0, 1])
    return tuple(plant.field_moment / radius**3 * (pole - 3 * pole[2] * nadir))
