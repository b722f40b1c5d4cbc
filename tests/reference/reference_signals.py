# SPDX-License-Identifier: Apache-2.0
"""Commands that act, measurements of sensors, and starts, at many points at once from their definitions.

Values are arrays by the names of quantities. `Parts` keep numbers as fields.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from mehvar.models import parts as of

AXES = "xyz"
Values = Mapping[str, NDArray[np.float64]]


@dataclass(frozen=True)
class Moment:
    """A craft at an instant.

    Attributes
    ----------
    x, given : mapping of str to array
        States, and commands or random numbers.
    sky : array
        Field, direction to the Sun in hub axes, and visible share of the Sun, of shape (n, 7); empty without an orbit.
    period : float
        Of laws and sensors, s.
    """

    x: Values
    given: Values
    sky: NDArray[np.float64]
    period: float

    def vector(self, start, ends=AXES):
        return np.stack([self.x[f"{start}{end}"] for end in ends], axis=-1)

    def attitude(self):
        """Return quaternions, scalar first, whose scalar is the cosine of half the turn."""
        if "q0" in self.x:
            return self.vector("q", "0123")
        if "yaw" in self.x:
            turn, half = Rotation.from_euler("ZYX", self.vector("", ("yaw", "pitch", "roll"))), 1.0
        else:
            mrp = self.vector("mrp", "123")
            turn, half = Rotation.from_mrp(mrp), np.cos(2 * np.arctan(np.linalg.norm(mrp, axis=1, keepdims=True)))
        q = turn.as_quat(scalar_first=True)
        return q * np.sign(q[:, :1] * half)

    def normal(self, name, size, count=3):
        """Return errors: a standard deviation times random numbers."""
        if size is None:
            return 0.0
        return size * np.stack([self.given[f"{name}_e{k + 1}"] for k in range(count)], axis=-1)


def limited(value, limit, least=None):
    top = np.inf if limit is None else limit
    return np.clip(value, -top if least is None else least, top)


@functools.singledispatch
def acting(part: of.Part, at: Moment) -> dict:
    """Return what acts of the commands to a part."""
    return {q.name: at.given[q.name] for q in part.inputs()}


@acting.register
def _(part: of.Thruster, at):
    name = f"{part.name}_force"
    force = limited(at.given[name], part.limit, 0.0)
    return {name: np.where(force * at.period < (part.least or 0.0), 0.0, force)}


@acting.register
def _(part: of.Wheel, at):
    name, speed = f"{part.name}_torque", at.x[f"{part.name}_speed"]
    torque = limited(at.given[name], part.torque_limit)
    most = np.inf if part.speed_limit is None else part.speed_limit
    return {name: np.where((np.abs(speed) > most) & (np.sign(torque) == np.sign(speed)), 0.0, torque)}


@acting.register
def _(part: of.Magnetorquer, at):
    name = f"{part.name}_dipole"
    return {name: limited(at.given[name], part.limit)}


@acting.register
def _(part: of.Engine, at):
    force, *targets = (q.name for q in part.inputs())
    angles = {name: limited(at.given[name], part.angle_limit) for name in targets}
    return {force: limited(at.given[force], part.limit, 0.0)} | angles


@acting.register
def _(part: of.Tank, at):
    name = f"{part.name}_flow"
    kept = at.x[f"{part.name}_fuel"] <= (0.0 if part.reserve is None else part.reserve)
    return {name: np.where(kept, 0.0, limited(at.given[name], part.flow, 0.0))}


def shown(part: of.Instrument, at: Moment) -> dict:
    """Return what a sensor shows at a sample."""
    names = [q.name for q in part.shown()]
    if part.delay:
        return {name: at.x[f"{name}_ago{part.delay}"] for name in names}
    return dict(zip(names, measurement(part, at).T, strict=True))


def measurement(part, at):
    """Return what a sensor sees at a sample, after its flag if it skips samples."""
    values = seen(part, at)
    if part.steady:
        return values
    new = np.ones(len(values), dtype=bool)
    if part.every is not None:
        new &= np.round(at.x["clock"] / at.period).astype(int) % int(part.every) == 0
    if part.dropout is not None:
        lots = (at.given[f"{part.name}_lot{k}"] ** 2 for k in (1, 2))
        new &= chi2.sf(sum(lots), 2) >= part.dropout
    new &= sees(part, at)
    return np.column_stack([new, np.where(new[:, None], values, 0.0)])


def sees(part, at):
    """Return True where nothing dazzles or blurs a sensor."""
    result = np.ones(len(at.x["wx"]), dtype=bool)
    if getattr(part, "blind", None) is not None:
        result &= np.linalg.norm(at.vector("w"), axis=1) <= part.blind
    if getattr(part, "exclusion", None) is not None:
        line = np.array(part.boresight) / np.linalg.norm(part.boresight)
        dazzled = np.arccos(np.clip(at.sky[:, 3:6] @ line, -1, 1)) < part.exclusion
        result &= ~dazzled | (at.sky[:, 6] < 0.5)
    return result


@functools.singledispatch
def seen(part: of.Instrument, at: Moment) -> NDArray[np.float64]:
    """Return the numbers that a sensor measures, with errors."""
    raise NotImplementedError(type(part).__name__)


def biased(part, at):
    """Return bias and noise of a sensor whose noise is white: a mean over n samples has it over the root of n."""
    bias = 0.0 if part.walk is None else at.vector(f"{part.name}_bias_")
    return bias + white(part, at)


def white(part, at):
    spacing = at.period * (part.every or 1)
    return at.normal(part.name, None if part.noise is None else part.noise / np.sqrt(spacing))


@seen.register
def _(part: of.Gyro, at):
    rate = at.vector(f"{part.name}_mean_") if part.integrating else at.vector("w")
    if part.misalignment is not None:
        rate = rate - np.cross(part.misalignment, rate)
    result = rate * (1 + np.array(part.scale or (0.0,) * 3)) + biased(part, at)
    return result if part.step is None else part.step * np.round(result / part.step)


@seen.register
def _(part: of.Accelerometer, at):
    return at.vector(f"{part.name}_mean_") + biased(part, at)


@seen.register
def _(part: of.StarTracker, at):
    """The error is a rotation whose Rodrigues vector, axis times tangent of the half angle, is half the errors."""
    q = at.attitude()
    error = np.atleast_2d(at.normal(part.name, None if part.sigma is None else np.array(part.sigma)) * np.ones(3))
    size = np.linalg.norm(error, axis=1, keepdims=True)
    turn = error * np.where(size > 0, 2 * np.arctan(size / 2) / np.where(size > 0, size, 1), 0)
    wrong = (Rotation.from_quat(q, scalar_first=True) * Rotation.from_rotvec(turn)).as_quat(scalar_first=True)
    return wrong * np.sign(np.sum(wrong * q, axis=1, keepdims=True))


@seen.register
def _(part: of.SunSensor, at):
    return at.sky[:, 6:] * (at.sky[:, 3:6] + at.normal(part.name, part.sigma))


@seen.register
def _(part: of.Magnetometer, at):
    return at.sky[:, :3] + white(part, at)


@seen.register
def _(part: of.Tachometer, at):
    return at.x[f"{part.of.name}_speed"][:, None] + at.normal(part.name, part.sigma, 1)


def sampled(part: of.Part, at: Moment) -> dict:
    """Return the states of a part that change at a sample, with their values after it."""
    after = {}
    if isinstance(part, of.Thruster | of.Magnetorquer) and part.pulses:
        clock = at.x[f"{part.name}_clock"]
        return {f"{part.name}_clock": np.where(np.isclose(np.abs(clock), 1, rtol=0, atol=1e-6), 2.0, -2.0)}
    if isinstance(part, of.Gyro | of.Accelerometer):
        letter, spread = "angle" if isinstance(part, of.Gyro) else "speed", np.sqrt(at.period)
        for axis in AXES:
            bias = f"{part.name}_bias_{axis}"
            if part.walk is not None:
                after[bias] = at.x[bias] + (part.walk * spread * at.given[f"{bias}_e"] if part.walk else 0.0)
            if part.integrating:
                after[f"{part.name}_mean_{axis}"] = at.x[f"{part.name}_{letter}_{axis}"] / at.period
                after[f"{part.name}_{letter}_{axis}"] = 0 * at.x[bias]
    if isinstance(part, of.Instrument) and part.delay:
        new = measurement(part, Moment({**at.x, **after}, at.given, at.sky, at.period)).T
        for k, q in enumerate(part.shown()):
            after[f"{q.name}_ago0"] = new[k]
            after |= {f"{q.name}_ago{age}": at.x[f"{q.name}_ago{age - 1}"] for age in range(1, part.delay + 1)}
    return after


def starts(given: Values, parts: Sequence[of.Part], orbit: of.Orbit | None) -> dict:
    """Return states at the start of a scenario with parameters NAME_0, for those that do not start at zero."""
    angles = np.stack([given.get(f"{angle}_0", np.zeros(1)) for angle in ("yaw", "pitch", "roll")], axis=-1)
    turn = Rotation.from_euler("ZYX", angles)
    q = turn.as_quat(scalar_first=True)
    result = dict(zip(("q0", "q1", "q2", "q3"), (q * np.sign(q[:, :1])).T, strict=True))
    result |= dict(zip(("mrp1", "mrp2", "mrp3"), turn.as_mrp().T, strict=True))
    for part in parts:
        if isinstance(part, of.Bob | of.Tank) and part.length is not None:
            name = part.name if isinstance(part, of.Bob) else f"{part.name}_bob"
            result |= _leaning(name, np.argmax(np.abs(part.rest)), part.rest, given)
    return result | ({} if orbit is None else _kepler(given, orbit.mu))


def _leaning(name, axis, rest, given):
    """Return a direction at the angle phi from rest, at the angle theta about it, from the second axis after it on."""
    out, about = given[f"{name}_phi_0"], given[f"{name}_theta_0"]
    ends = [0, np.sin(about), np.cos(about)]
    return {
        f"{name}_e{letter}": np.cos(out) * rest[k] + np.sin(out) * ends[(k - axis) % 3] for k, letter in enumerate(AXES)
    }


def _kepler(given, mu):
    """Return place and velocity on an ellipse, whose area grows at half the rate sqrt(mu p)."""
    a, e, inclination, node, perigee, anomaly = (
        given[f"orbit_{name}_0"] for name in ("a", "e", "i", "node", "perigee", "anomaly")
    )
    parameter = a * (1 - e**2)
    radius = parameter / (1 + e * np.cos(anomaly))
    turning = np.sqrt(mu * parameter) / radius**2
    rising = radius**2 / parameter * e * np.sin(anomaly) * turning
    turn = Rotation.from_euler("ZXZ", np.stack([node, inclination, perigee + anomaly], axis=-1))
    zero = np.zeros(len(a))
    place = turn.apply(np.stack([radius, zero, zero], axis=-1))
    velocity = turn.apply(np.stack([rising, radius * turning, zero], axis=-1))
    names = [f"orbit_{letter}{axis}" for letter in ("", "v") for axis in AXES]
    return dict(zip(names, np.hstack([place, velocity]).T, strict=True))
