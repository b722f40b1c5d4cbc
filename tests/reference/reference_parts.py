# SPDX-License-Identifier: Apache-2.0
"""Spacecraft as particles: accelerations, energy and momentum by Newton's law, without an equation of a part.

A part is a list of masses at places. CasADi differentiates the places twice along the motion. The accelerations are
those for which sum (m a - F).dv/ds = 0 over the particles, for each speed s (Jourdain's principle).

Seven particles have the mass, the centre and the second moments of a rigid body. A part whose mass or inertia is that
of the hub has particles of both signs.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence

import casadi as ca
import numpy as np

from mehvar.models import parts as of

from . import reference_sky as seen_from

AXES, UNIT = "xyz", np.eye(3)
NORTH = UNIT[2]
ROTOR = 0.7
"""Angle of a rotor that no state names, rad; no result depends on it."""


def unit(vector):
    return np.array(vector, dtype=float) / np.linalg.norm(vector)


def tensor(inertia):
    rows = np.array(inertia, dtype=float)
    return np.diag(rows) if rows.ndim == 1 else rows


def turn(axis, angle):
    """Return the rotation by an angle about a unit axis (Rodrigues)."""
    hat = ca.skew(ca.SX(axis))
    return ca.SX.eye(3) + ca.sin(angle) * hat + (1 - ca.cos(angle)) * hat @ hat


def product(a, b):
    """Return the product of two quaternions, scalar first."""
    return ca.vertcat(a[0] * b[0] - ca.dot(a[1:], b[1:]), a[0] * b[1:] + b[0] * a[1:] + ca.cross(a[1:], b[1:]))


def turned(q, vector):
    """Return q v q* for a unit quaternion."""
    return vector + 2 * ca.cross(q[1:], ca.cross(q[1:], vector) + q[0] * vector)


def half_turn(axis, angle):
    """Return the quaternion of a turn by an angle about a unit axis."""
    return ca.vertcat(ca.cos(angle / 2), ca.sin(angle / 2) * ca.SX(axis))


CHARTS = {"quaternion": ("q0", "q1", "q2", "q3"), "euler": ("roll", "pitch", "yaw"), "mrp": ("mrp1", "mrp2", "mrp3")}


def quaternion(chart, attitude):
    """Return the quaternion at coordinates: itself, turns about x, y and z, or an axis times tan(angle/4)."""
    if attitude == "quaternion":
        return chart
    if attitude == "mrp":
        size = ca.norm_2(chart)
        return half_turn(chart / size, 4 * ca.atan(size))
    roll, pitch, yaw = (half_turn(axis, chart[k]) for k, axis in enumerate(UNIT))
    return product(product(yaw, pitch), roll)


def following(q, coordinates, rate):
    """Return the rates of coordinates of a unit quaternion that turns at a rate in its own axes."""
    slope = ca.jacobian(q, coordinates)
    return ca.solve(slope.T @ slope, slope.T @ product(q, ca.vertcat(0, rate)) / 2)


def matrix_of(q):
    return ca.horzcat(*(turned(q, ca.SX(axis)) for axis in UNIT))


class Particles:
    """A spacecraft as particles.

    Parameters
    ----------
    parts : sequence of Part
        With numbers as fields.
    motion, attitude : str
        As of a `Spacecraft`.
    orbit : Orbit, optional
        Of the craft.
    period : float
        Of laws and sensors, s.
    """

    def __init__(
        self, parts: Sequence[of.Part], motion: str = "free", orbit: of.Orbit | None = None, period: float = 0.1,
        attitude: str = "quaternion",
    ) -> None:  # fmt: skip
        self.places, self.speeds, self.inputs, self.prescribed = {}, {}, {}, {}
        self.masses, self.points, self.pushes, self.forces, self.across = [], [], [], [], []
        self.potential, self.parts, self.orbit, self.fuel = ca.SX(0), parts, orbit, {}
        self.guards, self.margins, self.resets, self.felt, self.period = [], [], {}, {}, period
        self.relative, self.plane = motion == "attitude" or orbit is not None, motion == "plane"
        self.v, self.w = self.speed("vx", "vy", "vz"), self.speed("wx", "wy", "wz")
        chart = ca.SX.sym("q", 4 if attitude == "quaternion" else 3)
        self.q, names = quaternion(chart, attitude), CHARTS[attitude]
        self.place(names, chart, following(self.q, chart, self.w))
        self.origin = self.place(["", "", ""], ca.SX.sym("O", 3), turned(self.q, self.v))
        if self.plane:
            self.coordinate("theta", self.w[2])
            self.prescribed |= dict.fromkeys(("vz", "wx", "wy"), 0.0)
        if orbit:
            self.sky = Sky(self, orbit)
        for part in sorted(parts, key=lambda part: isinstance(part, of.GravityGradient | of.Cable)):
            write(part, self)
        if attitude == "euler":
            self.margins.append(ca.cos(chart[1]) - 1e-4)
        elif attitude == "mrp":
            self.margins.append(1 - ca.sumsqr(1e-4 * chart))
        if orbit:
            self.sky.fall(sum(self.forces, ca.SX.zeros(3)) / sum(self.masses))
        self._finish()

    def speed(self, *names):
        symbols = [self.speeds.setdefault(name, ca.SX.sym(name)) for name in names]
        return ca.vertcat(*symbols)

    def place(self, names, symbols, rates):
        """Declare coordinates with their rates; those without a name start at zero."""
        for k, name in enumerate(names):
            self.places[name or f"{symbols[k]}"] = symbols[k], rates[k]
        return symbols

    def coordinate(self, name, rate):
        return self.place([name], ca.SX.sym(name), rate * ca.SX(1))

    def vector(self, name, rates):
        return self.place([f"{name}{a}" for a in AXES], ca.SX.sym(name, 3), rates)

    def input(self, name):
        return self.inputs.setdefault(name, ca.SX.sym(name))

    def rate(self, expression):
        """Differentiate along the motion."""
        symbols, rates = (ca.vertcat(*column) for column in zip(*self.places.values(), strict=True))
        return ca.jtimes(expression, symbols, rates)

    def particle(self, mass, place):
        self.masses.append(mass)
        self.points.append(self.origin + turned(self.q, ca.SX(place)))

    def body(self, mass, inertia, place, rotation=UNIT):
        """Add a rigid body: its mass, and its inertia about its centre of mass in its own axes."""
        second = np.trace(inertia) / 2 * UNIT - inertia
        values, vectors = np.linalg.eigh(second)
        for value, vector in zip(values, vectors.T, strict=True):
            for side in (1, -1):
                arm = side * np.sqrt(abs(value)) * vector
                self.particle(np.sign(value) / 2, place + ca.SX(rotation) @ arm)
        self.particle(mass - np.sign(values).sum(), place)

    def rotor(self, axis, inertia, angle, rotation=UNIT):
        """Add the inertia of a rotor about its axis; the hub includes the rest of it."""
        self.body(0.0, inertia * np.outer(axis, axis), ca.SX.zeros(3), ca.SX(rotation) @ turn(axis, angle))

    def stick(self, mass, inertia, pivot, along, length):
        """Add a mass at the end of a rod, with a moment of inertia across the rod."""
        half = np.sqrt((inertia or 0.0) / mass) if not isinstance(mass, ca.SX) else 0.0
        for arm in (length + half, length - half):
            self.particle(mass / 2, pivot + arm * along)

    def push(self, value, rate):
        """Add forces whose power is their product with rates."""
        self.pushes.append((value, rate))

    def damped(self, coefficient, rate):
        self.push(-(0.0 if coefficient is None else coefficient) * rate, rate)

    def spring(self, potential):
        self.potential += potential
        self.push(-1, self.rate(potential))

    def load(self, force, at, outer=True):
        """Add a force on the hub, in its axes, at the point of the hub that is `at` now."""
        self.push(ca.SX(force), self.v + ca.cross(self.w, ca.SX(at)))
        if outer:
            self.forces.append(ca.SX(force))

    def couple(self, moment):
        self.push(moment, self.w)

    def drive(self, part, speed, coordinate, k, d, motor=""):
        """Add spring, damper and motor of a joint."""
        self.spring((k or 0.0) * coordinate**2 / 2)
        self.damped(d, speed)
        if motor:
            self.push(self.input(motor), speed)

    def _finish(self):
        speeds, masses = ca.vertcat(*self.speeds.values()), ca.vertcat(*self.masses)
        velocity = [self.rate(point) for point in self.points]
        every, whole = ca.vertcat(*velocity), ca.sum1(masses)
        slope, bias = ca.jacobian(every, speeds), self.rate(every)
        weight = ca.repmat(masses.T, 3, 1).reshape((-1, 1))
        right = -slope.T @ (weight * bias)
        for value, rate in self.pushes:
            right += ca.jacobian(rate, speeds).T @ value
        rows = [ca.jacobian(each, speeds) for each in self.across]
        ends = [-self.rate(each) for each in self.across]
        for name, value in self.prescribed.items():
            rows.append(ca.jacobian(self.speeds[name], speeds))
            ends.append(value)
        matrix, held = slope.T @ (weight * slope), ca.vertcat(ca.SX(0, speeds.numel()), *rows)
        drift = sum((m * v for m, v in zip(self.masses, velocity, strict=True)), ca.SX.zeros(3)) / whole
        centre = sum((m * p for m, p in zip(self.masses, self.points, strict=True)), ca.SX.zeros(3)) / whole
        drift, about = (drift, centre) if self.relative else (ca.SX.zeros(3), self.origin)
        energy, linear, angular = self.potential, ca.SX.zeros(3), ca.SX.zeros(3)
        for m, point, v in zip(self.masses, self.points, velocity, strict=True):
            own = v - drift
            energy += m * ca.dot(own, own) / 2
            linear, angular = linear + m * own, angular + m * ca.cross(point - about, own)
        back = ca.vertcat(self.q[0], -self.q[1:])
        places, rates = (ca.vertcat(*column) for column in zip(*self.places.values(), strict=True))
        inputs = ca.vertcat(*self.inputs.values(), ca.SX(0, 1))
        self._terms = ca.Function("terms", [places, speeds, inputs], [
            matrix, right, held, ca.vertcat(*ends, ca.SX(0, 1)), rates,
            ca.vertcat(energy, turned(back, linear), turned(back, angular)), ca.vertcat(ca.SX(0, 1), *self.guards),
            ca.vertcat(ca.SX(0, 1), *self.resets.values()), ca.vertcat(ca.SX(0, 1), *self.margins),
            ca.vertcat(self.sky.field, self.sky.sun, self.sky.visible) if self.orbit else ca.SX(0, 1),
        ])  # fmt: skip
        accelerations, found = ca.SX.sym("dv", speeds.numel()), []
        for velocity in self.felt.values():
            change = self.rate(velocity) + ca.jtimes(velocity, speeds, accelerations)
            found.append(turned(back, change))
        self._felt = ca.Function("felt", [places, speeds, accelerations], [ca.vertcat(ca.SX(0, 1), *found)])

    def _given(self, x: Mapping[str, float], u: Mapping[str, float]) -> list[list[float]]:
        known = {n: 0.0 if n.startswith("O_") else ROTOR for n in self.places} | {"q0": 1.0, "q1": 0, "q2": 0, "q3": 0}
        known |= dict(x)
        if self.plane:
            known |= {"q0": np.cos(x["theta"] / 2), "q3": np.sin(x["theta"] / 2)}
        return [[known[n] for n in self.places], [x.get(n, 0.0) for n in self.speeds], [u[n] for n in self.inputs]]

    def _at(self, x: Mapping[str, float], u: Mapping[str, float]) -> list[np.ndarray]:
        return [np.array(value) for value in self._terms(*self._given(x, u))]

    def rates(self, x: Mapping[str, float], u: Mapping[str, float]) -> dict[str, float]:
        """Return the rates of coordinates and speeds by the names of the craft's states."""
        matrix, right, held, ends, rates, *_ = self._at(x, u)
        size, zero = len(right), np.zeros((len(held), len(held)))
        whole = np.block([[matrix, held.T], [held, zero]])
        solution = np.linalg.solve(whole, np.concatenate([right, ends]))[:size, 0]
        felt = self._felt(*self._given(x, u)[:2], solution).full().ravel()
        own = [f"{name}{a}" for name in self.felt for a in AXES]
        result = dict(zip(self.places, rates[:, 0], strict=True)) | dict(zip(self.speeds, solution, strict=True))
        return result | dict(zip(own, felt, strict=True))

    def readings(self, x: Mapping[str, float], u: Mapping[str, float]) -> np.ndarray:
        """Return energy, momentum, and angular momentum about O or the centre of mass, in the axes of the hub."""
        return self._at(x, u)[5][:, 0]

    def found(self, what: str, x: Mapping[str, float], u: Mapping[str, float]) -> np.ndarray:
        """Return guards, states that events reset, margins of limits, or field, direction to the Sun and its share."""
        return self._at(x, u)[6 + ("guards", "resets", "margins", "sky").index(what)][:, 0]

    def pulse(self, part, share):
        """Declare the clock of a part that acts for a share of a period from 2 on; return 1 where it acts.

        It ends a period at -1, so that it goes to what the rest of the period is above that.
        """
        clock = self.coordinate(f"{part.name}_clock", -1 / self.period)
        self.guards.append(share - (2 - clock))
        self.margins.append(clock - (-1.5))  # half a period late
        self.resets[f"{part.name}_clock"] = (1 - share) - 1
        return ca.if_else(ca.logic_and(clock > 0.5, share > 0), 1, 0)


class Sky:
    """Environment of an orbit, in hub axes."""

    def __init__(self, world: Particles, orbit: of.Orbit) -> None:
        self.world, self.orbit = world, orbit
        self.velocity = ca.SX.sym("orbit_v", 3)
        self.place = world.vector("orbit_", self.velocity)
        self.time = world.coordinate("clock", 1.0)
        self.radius = ca.norm_2(self.place)
        world.margins.append(self.radius - orbit.radius)
        self.values = {f: getattr(v := getattr(orbit, f), "default", v) for f in vars(orbit)}
        self.far, self.towards_sun = self._sun()
        self.sun = self.seen(self.towards_sun)

    def __getitem__(self, name):
        return self.values[name]

    def _sun(self):
        """Return the Sun's distance, au, and its direction in inertial axes."""
        if self["epoch"] is None:
            return 1.0, ca.SX(direction(self["ascension"], self["declination"]))
        far, longitude, tilt = seen_from.almanac((self["epoch"] + self.time) / 86400)
        return far, turn(UNIT[0], tilt) @ ca.vertcat(ca.cos(longitude), ca.sin(longitude), 0)

    def seen(self, vector):
        q = self.world.q
        return turned(ca.vertcat(q[0], -q[1:]), ca.SX(vector))

    def fall(self, felt):
        """Declare the acceleration: the slope of the Earth's potential, of other bodies, and of forces."""
        s, ratio, series = self.place[2] / self.radius, self["radius"] / self.radius, 1
        legendre = {2: (3 * s**2 - 1) / 2, 3: (5 * s**3 - 3 * s) / 2, 4: (35 * s**4 - 30 * s**2 + 3) / 8}
        depth = {"two-body": 1, "J2": 2, "J4": 4}[self["gravity"]]
        for n, name in ((2, "oblateness"), (3, "third"), (4, "fourth")):
            series -= self[name] * ratio**n * legendre[n] if n <= depth else 0
        potential = -self["mu"] / self.radius * series
        for body in (part for part in self.world.parts if isinstance(part, of.ThirdBody | of.SunGravity)):
            to = self.body(body)
            potential += body.mu * (ca.dot(self.place, to) / ca.norm_2(to) ** 3 - 1 / ca.norm_2(to - self.place))
        result = -ca.gradient(potential, self.place) + turned(self.world.q, felt)
        self.world.place([f"orbit_v{a}" for a in AXES], self.velocity, result)

    def body(self, part):
        if isinstance(part, of.SunGravity):
            return part.distance * self.far * self.towards_sun
        plane = turn(NORTH, part.node) @ turn(UNIT[0], part.inclination)
        angle = part.phase + part.rate * self.time
        return part.distance * plane @ ca.vertcat(ca.cos(angle), ca.sin(angle), 0)

    @property
    def field(self):
        """Field of the dipole or of Gauss coefficients: minus the slope of its potential."""
        angle = self["longitude"] + self["spin"] * self.time
        if self["harmonics"]:
            fixed = turn(NORTH, -angle) @ self.place
            potential = seen_from.potential(fixed, self["harmonics"], self["reference"])
            return self.seen(-ca.gradient(potential, self.place))
        pole = direction(angle, np.pi / 2 - self["tilt"])
        return self.seen(ca.gradient(self["dipole"] * ca.dot(ca.SX(pole), self.place) / self.radius**3, self.place))

    @property
    def wind(self):
        return self.seen(self.velocity - ca.cross(self["spin"] * ca.SX(NORTH), self.place))

    @property
    def density(self):
        over = self.radius - self["radius"]
        if self["air"]:
            return seen_from.density(over, [(layer.height, layer.density) for layer in self["air"]])
        return self["density"] * ca.exp(-(over - self["height"]) / self["thinning"])

    @property
    def discs(self):
        """Angle between Sun and Earth, and the angular radii of both."""
        down = -self.place
        apart = ca.atan2(ca.norm_2(ca.cross(down, self.towards_sun)), ca.dot(down, self.towards_sun))
        return apart, ca.asin(ca.fmin(1, self["radius"] / self.radius)), self["disc"] / self.far

    @property
    def visible(self):
        """Share of the Sun that is not behind the Earth: a ball, in parallel light or in that of a disc."""
        if self["shadow"] == "cone":
            apart, earth, sun = self.discs
            partly = seen_from.visible(apart, earth, sun)
            return ca.if_else(apart > earth + sun, 1, ca.if_else(apart < earth - sun, 0, partly))
        along = ca.dot(self.towards_sun, self.place)
        dark = ca.logic_and(along < 0, ca.norm_2(self.place - along * self.towards_sun) < self["radius"])
        return ca.if_else(dark, 0, 1)

    @property
    def light(self):
        """Pressure of sunlight."""
        return self["sunlight"] / self.far**2 * self.visible


def direction(ascension, declination):
    flat = np.cos(declination)
    return ca.vertcat(flat * ca.cos(ascension), flat * ca.sin(ascension), np.sin(declination))


@functools.singledispatch
def write(part: of.Part, world: Particles) -> None:
    """Add the particles and forces of a part."""
    raise NotImplementedError(type(part).__name__)


@write.register(of.ThirdBody | of.SunGravity)
def _(part, world):
    pass  # `Sky.fall` has its gravity


@write.register
def _(part: of.Eclipse, world):
    apart, earth, sun = world.sky.discs
    reaches = (earth,) if world.sky["shadow"] == "cylinder" else (earth + sun, earth - sun)
    world.guards += [apart - reach for reach in reaches for _ in ("begins", "ends")]


@write.register
def _(part: of.GroundStation, world):
    """The guard is the line of sight times the difference of the sines of the least elevation and of the craft's."""
    sky, flattening = world.sky, float(getattr(part.flattening, "default", part.flattening))
    out, north = seen_from.station(part.latitude, part.height, flattening, sky["radius"])
    meridian = turn(NORTH, part.ascension + sky["spin"] * sky.time)
    line = sky.place - meridian @ ca.vertcat(out, 0, north)
    up = meridian @ ca.vertcat(np.cos(part.latitude), 0, np.sin(part.latitude))
    world.guards += [ca.norm_2(line) * np.sin(part.elevation) - ca.dot(line, up)] * 2


@write.register(of.StarTracker | of.SunSensor | of.Magnetometer | of.Tachometer)
def _(part, world):
    pass  # `reference_signals` has what they show


@write.register
def _(part: of.Gyro, world):
    """Its integral is the vector of the turn since the last sample, whose quaternion has the rate of the hub."""
    if part.integrating:
        vector = ca.SX.sym(f"{part.name}_angle", 3)
        angle = ca.norm_2(vector)
        rate = following(half_turn(vector / angle, angle), vector, world.w)
        world.place([f"{part.name}_angle_{a}" for a in AXES], vector, rate)


@write.register
def _(part: of.Accelerometer, world):
    world.felt[f"{part.name}_speed_"] = turned(world.q, world.v + ca.cross(world.w, ca.SX(part.at)))


@write.register
def _(part: of.Hub, world):
    world.body(part.mass, tensor(part.inertia), ca.SX(part.centre))


@write.register
def _(part: of.PointMass, world):
    world.particle(part.mass, part.at)


@write.register
def _(part: of.Wheel, world):
    speed = world.speed(f"{part.name}_speed")
    world.rotor(unit(part.axis), part.inertia, world.coordinate(f"{part.name}_angle", speed))
    world.push(world.input(f"{part.name}_torque"), speed)
    world.damped(part.friction, speed)


@write.register
def _(part: of.UnbalancedWheel, world):
    speed, axis = world.speed(f"{part.name}_speed"), unit(part.axis)
    angle = world.coordinate(f"{part.name}_angle", speed)
    towards = AXES.index(part.towards) if part.towards else int(np.argmin(np.abs(part.axis)))
    out = unit(UNIT[towards] - axis[towards] * axis)
    ahead = np.cross(axis, out)
    inertia = part.inertia * np.outer(axis, axis) + part.across * (np.outer(out, out) + np.outer(ahead, ahead))
    inertia += (part.dynamic or 0.0) * (np.outer(axis, ahead) + np.outer(ahead, axis))
    rotation = turn(axis, angle)
    world.body(part.mass, inertia, ca.SX(part.at) + rotation @ (part.static / part.mass * out), rotation)
    world.push(world.input(f"{part.name}_torque"), speed)
    world.damped(part.friction, speed)


@write.register
def _(part: of.ControlMomentGyro, world):
    name, gimbal = part.name, unit(part.gimbal)
    rate = world.speed(f"{name}_gimbal_rate")
    across = unit(np.cross(gimbal, part.spin))
    spin, rotation = np.cross(across, gimbal), turn(gimbal, world.coordinate(f"{name}_gimbal", rate))
    inertia = part.gimbal_inertia * np.outer(gimbal, gimbal) + (part.frame or 0.0) * np.outer(spin, spin)
    world.body(0.0, inertia + (part.across or 0.0) * np.outer(across, across), ca.SX.zeros(3), rotation)
    speed = world.speed(f"{name}_speed") if part.speed is None else part.speed
    world.rotor(spin, part.inertia, world.coordinate(f"{name}_turned", speed), rotation)
    if part.speed is None:
        world.push(world.input(f"{name}_torque"), speed)
        world.damped(part.friction, speed)
    if part.lag is None:
        world.push(world.input(f"{name}_gimbal_torque"), rate)
        world.damped(part.gimbal_friction, rate)
    else:
        world.prescribed[f"{name}_gimbal_rate"] = (world.input(f"{name}_gimbal_rate_cmd") - rate) / part.lag


@write.register
def _(part: of.Modes, world):
    """A mode is a rotor, whose inertia the hub includes, with a place that gives two masses of no sum a momentum."""
    for k, mode in enumerate(part.modes, 1):
        speed = world.speed(f"{part.name}_{k}_dot")
        place, size = world.coordinate(f"{part.name}_{k}", speed), np.linalg.norm(mode.angular)
        world.rotor(unit(mode.angular), size**2, place / size)
        world.rotor(unit(mode.angular), -(size**2), ca.SX(0))
        for side in (1, -1):
            world.particle(side, side * place / 2 * ca.SX(mode.linear))
        world.drive(part, speed, place, mode.frequency**2, 2 * mode.damping * mode.frequency)


@write.register
def _(part: of.Bob, world):
    swing(world, part.name, part.mass, part.inertia, part.at, part.length, part.damping)


def swing(world, name, mass, inertia, at, length, damping):
    """Add a bob, whose states are its direction and the absolute rate of the direction."""
    turning, along = world.speed(*(f"{name}_u{a}" for a in AXES)), ca.SX.sym(f"{name}_e", 3)
    slip = turning - ca.cross(world.w, along)
    along = world.place([f"{name}_e{a}" for a in AXES], along, slip)
    world.stick(mass, inertia, ca.SX(at), along, length)
    world.damped(damping, slip)
    world.across.append(ca.dot(along, turning))
    return along, slip


@write.register
def _(part: of.Pendulum, world):
    axis = unit(part.axis)
    side = unit(np.cross(axis, part.rest))
    along, names = ca.SX(np.cross(side, axis)), ("1", "2") if part.angles == 2 else ("",)
    for k, about in reversed(list(zip(names, (axis, side), strict=False))):
        angle = world.coordinate(f"{part.name}_angle{k}", world.speed(f"{part.name}_rate{k}"))
        along = turn(about, angle) @ along
    world.stick(part.mass, part.inertia, ca.SX(part.at), along, part.length)
    world.damped(part.damping, world.rate(along))


@write.register
def _(part: of.SprungMass, world):
    speed = world.speed(f"{part.name}_speed")
    place = world.coordinate(f"{part.name}_place", speed)
    world.particle(part.mass, ca.SX(part.at) + place * unit(part.axis))
    world.drive(part, speed, place, part.stiffness, part.damping)


@write.register(of.Hinge | of.Slider)
def _(part, world):
    name, axis, hinge = part.name, unit(part.axis), isinstance(part, of.Hinge)
    place, speed, motor = ("angle", "rate", "torque") if hinge else ("place", "speed", "force")
    if part.motion == "locked":
        coordinate = ca.SX(part.locked)
    else:
        rate = world.speed(f"{name}_{speed}")
        coordinate = world.coordinate(f"{name}_{place}", rate)
        world.drive(part, rate, coordinate, part.stiffness, part.damping, part.motor and f"{name}_{motor}")
    if part.motion == "prescribed":
        world.prescribed[f"{name}_{speed}"] = world.input(f"{name}_acceleration")
    rotation = turn(axis, coordinate) if hinge else ca.SX.eye(3)
    shift = ca.SX.zeros(3) if hinge else coordinate * axis
    world.body(part.mass, tensor(part.inertia), ca.SX(part.at) + shift + rotation @ ca.SX(part.centre), rotation)


@write.register
def _(part: of.Chain, world):
    joint, rotation = ca.SX.zeros(3), ca.SX.eye(3)
    for k, link in enumerate(part.links, 1):
        name = f"{part.name}_{k}"
        joint = joint + rotation @ ca.SX(link.at)
        if link.joint == "ball":
            rate, q = world.speed(*(f"{name}{a}" for a in AXES)), ca.SX.sym(f"{name}_q", 4)
            world.place([f"{name}_q{i}" for i in range(4)], q, product(ca.vertcat(0, rate), q) / 2)
            world.damped(link.damping, rate)
            rotation = rotation @ matrix_of(q)
        else:
            place, speed = ("angle", "rate") if link.joint == "hinge" else ("place", "speed")
            rate, axis = world.speed(f"{name}_{speed}"), unit(link.axis)
            coordinate = world.coordinate(f"{name}_{place}", rate)
            world.drive(part, rate, coordinate, link.stiffness, link.damping, link.motor and f"{name}_motor")
            joint = joint + (rotation @ axis * coordinate if link.joint == "slider" else 0)
            rotation = rotation @ turn(axis, coordinate) if link.joint == "hinge" else rotation
        world.body(link.mass, tensor(link.inertia), joint + rotation @ ca.SX(link.centre), rotation)


@write.register
def _(part: of.Tank, world):
    """The fuel of the moment; the hub feels -2 w d' at the middle of a line d with the flow w."""
    flow, at, nozzle = world.input(f"{part.name}_flow"), ca.SX(part.at), ca.SX(part.nozzle)
    fuel, share = world.coordinate(f"{part.name}_fuel", -flow), part.share or 0.0
    world.margins.append(fuel)
    world.particle((1 - share) * fuel, at)
    lumps = [(1 - share, at)]
    if part.share is not None:
        moving, damping = share * fuel, (part.damping or 0.0) * share * fuel
        along, _ = swing(world, f"{part.name}_bob", moving, None, part.at, part.length, damping)
        lumps.append((share, at + part.length * along))
    for portion, lump in lumps:
        reach = nozzle - lump
        changing = world.rate(reach) + ca.cross(world.w, reach)
        world.load(-2 * flow * portion * changing, (lump + nozzle) / 2, outer=False)
    if part.thrust is not None:
        world.load(flow * part.exhaust * unit(part.thrust), nozzle)


@write.register
def _(part: of.Engine, world):
    name, axis = part.name, unit(part.axis)
    angles = []
    for k in "12":
        angle = ca.SX.sym(f"{name}_angle{k}")
        rate = (world.input(f"{name}_target{k}") - angle) / part.lag
        if part.rate_limit is not None:
            rate = ca.fmax(-part.rate_limit, ca.fmin(part.rate_limit, rate))
        angles.append(world.place([f"{name}_angle{k}"], angle, rate))
    side = unit(np.cross(axis, part.direction))
    along = turn(axis, angles[0]) @ np.cross(side, axis)
    along = ca.cos(angles[1]) * along + ca.sin(angles[1]) * axis
    world.load(world.input(f"{name}_force") * along, part.at)


@write.register
def _(part: of.Rod, world):
    name, velocity = part.name, world.speed(*(f"{part.name}_v{a}" for a in AXES))
    rate, q = world.speed(*(f"{name}_w{a}" for a in AXES)), ca.SX.sym(f"{name}_q", 4)
    own, carried = product(q, ca.vertcat(0, rate)), product(ca.vertcat(0, world.w), q)
    world.place([f"{name}_q{k}" for k in range(4)], q, (own - carried) / 2)
    place, rotation = world.vector(f"{name}_", velocity), matrix_of(q)
    world.body(part.mass, tensor(part.inertia), place, rotation)
    line(world, part, place + rotation @ ca.SX(part.mount) - ca.SX(part.at))


@write.register
def _(part: of.Cable, world):
    ends = [ca.vertcat(*(world.places[f"{body.name}_{a}"][0] for a in AXES)) for body in part.between]
    line(world, part, ends[1] - ends[0])


def line(world, part, reach):
    """Add the tension of an elastic line; a rod also pushes."""
    length = ca.norm_2(reach)
    rate, stretch = world.rate(length), length - part.length
    pull, potential = part.stiffness * stretch + (part.damping or 0.0) * rate, part.stiffness * stretch**2 / 2
    if isinstance(part, of.Tether | of.Cable):
        world.guards += [stretch] if part.damping is None else [stretch, pull]
        pull, potential = (ca.if_else(stretch > 0, e, 0) for e in (ca.fmax(pull, 0), potential))
    world.potential += potential
    world.push(-pull, rate)


@write.register
def _(part: of.ExternalForce, world):
    world.load(ca.vertcat(*(world.input(f"{part.name}{a}") for a in AXES)), part.at)


@write.register
def _(part: of.Torquer, world):
    world.couple(ca.vertcat(*(world.input(f"{part.name}{a}") for a in AXES)))


@write.register
def _(part: of.Thruster, world):
    force = world.input(f"{part.name}_force")
    if part.pulsed:
        force = part.limit * world.pulse(part, force / part.limit)
    world.load(force * unit(part.direction), part.at)


@write.register
def _(part: of.GravityGradient, world):
    """The slope of the Earth's field, and its second slope, over all particles as a rigid body."""
    sky = world.sky
    k = sky["mu"] / sky.radius**3
    arms = [turned(ca.vertcat(world.q[0], -world.q[1:]), point - world.origin) for point in world.points]
    centre = sum((m * a for m, a in zip(world.masses, arms, strict=True)), ca.SX.zeros(3)) / sum(world.masses)
    up, moment, potential = sky.seen(sky.place) / sky.radius, ca.SX.zeros(3), ca.SX(0)
    for mass, arm in zip(world.masses, arms, strict=True):
        a = arm - centre
        moment += mass * ca.cross(a, 3 * k * ca.dot(up, a) * up)
        potential -= mass * k / 2 * (3 * ca.dot(up, a) ** 2 - ca.dot(a, a))
    world.load(sky.seen(-ca.gradient(potential, sky.place)), centre)
    world.couple(moment)


@write.register
def _(part: of.Dipole, world):
    world.couple(ca.cross(ca.SX(part.moment), world.sky.field))


@write.register
def _(part: of.Magnetorquer, world):
    dipole = world.input(f"{part.name}_dipole") * (1 if part.duty is None else world.pulse(part, part.duty))
    world.couple(ca.cross(dipole * ca.SX(unit(part.axis)), world.sky.field))


@write.register
def _(part: of.Drag, world):
    wind, share = world.sky.wind, world.sky.density * part.coefficient * part.area / 2
    faced = ca.norm_2(wind) if part.normal is None else ca.fmax(0, ca.dot(ca.SX(unit(part.normal)), wind))
    world.load(-share * faced * wind, part.at)


@write.register
def _(part: of.SunPressure, world):
    sun, pressure = world.sky.sun, world.sky.light * part.area
    if part.normal is None:
        force = -pressure * (1 + 4 / 9 * part.scattered) * sun
    else:
        normal = ca.SX(unit(part.normal))
        cosine = ca.fmax(0, ca.dot(normal, sun))
        out = (1 - part.mirrored) * sun + 2 * (part.mirrored * cosine + part.scattered / 3) * normal
        force = -pressure * cosine * out
    world.load(force, part.at)
