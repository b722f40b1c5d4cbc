# SPDX-License-Identifier: Apache-2.0
"""Physics of the spacecraft with tanks that drain: bodies, lines and what leaves, in inertial axes.

What the tanks hold comes from SciPy's interpolator on the tables; places, velocities and what is summed over them from
the state. Accelerations are differences of velocities along the motion.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import PchipInterpolator

from mehvar.physics.gates import Gate, Symmetry, balance, dot, identity, smaller, symmetric
from mehvar.physics.machine import Array, Machine, Points, points
from tests.mehvar.physics import rotations, slosh
from tests.mehvar.physics.installed import machine

_NUMBERS = (1, 2)
_POINTS = range(1, 6)
"""Of the tables."""
_WITHOUT = (("pendulums", "2"), ("inertia", "ball"), ("attitude", "quaternion"))
"""The paper's craft on ball joints: what a law takes the craft for, and what neutral numbers leave."""


def gates_of(_: Machine) -> list[Gate]:
    """Return what must hold."""
    still = {"y1": 0.0, "z1": 0.0, "y2": 0.0, "z2": 0.0, "flow": 0.0, "orbit_rate": 0.0, "burnt": 0.0}
    full = {"share_at_1": 0.0, "mass_part_1": 1.0, "arm_part_1": 1.0}
    gimbals: dict[str, Callable[[Points], Array]] = {f"gimbal{k}": functools.partial(_get, f"delta{k}") for k in (1, 2)}
    own = [f"{name}{k}" for k in _NUMBERS for name in ("m", "l", "h", "y", "z", "I", "eps")]
    own += [f"{name}{k}{axis}" for k in _NUMBERS for name in ("s", "sigma") for axis in "xyz"]
    other = {name: name.translate(str.maketrans("12", "21")) for name in own}
    return [
        identity("energy of the bodies", lambda at: _filled(at).call("energy")[:, 0], lambda at: _energy(_filled(at))),
        identity("momentum with the lines", lambda at: _filled(at).call("momentum"), lambda at: _momenta(_filled(at))),
        balance("linear momentum", _linear, lambda at: _back(at, _force(at)), where=_filled),
        balance("angular momentum", _angular, lambda at: _back(at, _moment(at)), where=_filled),
        identity("equations of the bobs", lambda at: _bobs(_filled(at))[0], lambda at: _bobs(_filled(at))[1]),
        balance("arms keep their length", _held, lambda at: np.zeros((len(at["F"]), 4))),
        balance("energy of the bodies, with the work at bobs and lines", _energy, _power, where=_filled),
        balance("energy with the lines and what leaves", _energy_with_lines, _power_with_lines, where=_filled),
        balance("attitude", lambda at: slosh.turned(at).reshape(-1, 9), _turning),
        balance("unit quaternion", lambda at: dot(_q(at), _q(at)), lambda at: np.zeros(len(at["F"]))),
        identity("fuel and clock", lambda at: at.result("rhs", "burnt", "clock"), _ticking),
        identity("gimbals follow", lambda at: at.result("rhs", "gimbal1", "gimbal2"), _followed),
        identity("gimbals follow their limits", lambda at: _hard(at).result("rhs", "gimbal1", "gimbal2"),
                 lambda at: _followed(_hard(at))),
        identity("Galilean invariance", slosh.accelerations, lambda at: slosh.accelerations(_faster(at))),
        smaller("neutral numbers", machine("slosh", *_WITHOUT), _same, {**still, **full, **gimbals}),
        symmetric(Symmetry("order of the tanks", swaps=other)),
        *_outputs(),
    ]  # fmt: skip


def _get(name: str, at: Points) -> Array:
    return at[name]


def _same(name: str) -> str:
    known = machine("slosh", *_WITHOUT).system
    names = {q.name for group in (known.states, known.inputs, known.parameters) for q in group}
    return name if name in names else ""


# What the tanks hold


@functools.lru_cache(maxsize=4096)
def _curves(at: tuple[float, ...], of: tuple[float, ...]) -> tuple[Callable[[float], Array], ...]:
    """Return a table's interpolator and its first two derivatives."""
    curve = PchipInterpolator(at, of)
    return curve, curve.derivative(1), curve.derivative(2)


def _table(at: Points, name: str, share: Array) -> Array:
    """Return value, slope and curvature of a table at each point, shape (3, n)."""
    rows = zip(_columns(at, "share_at"), _columns(at, name), share, strict=True)
    return np.array([[curve(s) for curve in _curves(x, y)] for x, y, s in rows]).T


def _columns(at: Points, name: str) -> list[tuple[float, ...]]:
    return [tuple(map(float, row)) for row in at.vector(*(f"{name}_{k}" for k in _POINTS))]


def _fuel(at: Points) -> Array:
    """Return all fuel at the start."""
    return np.asarray(at["m0"] + at["m1"] + at["m2"])


def _filled(at: Points) -> Points:
    """Return the points once for each interval of the tables, somewhere inside it."""
    inside = 0.3 + 0.4 * (at["burnt"] - at["burnt"].min()) / np.ptp(at["burnt"])
    shares = [at[f"share_at_{k}"] * (1 - inside) + at[f"share_at_{k + 1}"] * inside for k in _POINTS[:-1]]
    many = at.at(**{name: np.tile(values, (len(shares), 1)) for name, values in at.values.items()})
    return many.moved(burnt=np.concatenate(shares) * _fuel(many))


@dataclass(frozen=True)
class Lump:
    """Mass in a place: kg; kg/s that leave and its rate; place and motion from O in body axes."""

    mass: Array
    out: Array
    out_rate: Array
    place: Array
    slip: Array


@dataclass(frozen=True)
class Tank:
    """A lump on an arm, and what its turning inertia and length do."""

    lump: Lump
    pivot: Array
    s: Array
    sigma: Array
    length: Array
    length_rate: Array
    length_change: Array
    inertia: Array
    inertia_rate: Array
    eps: Array


def _tanks(at: Points) -> list[Tank]:
    fuel = _fuel(at)
    share, pace = at["burnt"] / fuel, at["flow"] / fuel
    part, arm = _table(at, "mass_part", share), _table(at, "arm_part", share)
    tanks = []
    for k in _NUMBERS:
        s, sigma = (at.vector(*(f"{name}{k}{axis}" for axis in "xyz")) for name in ("s", "sigma"))
        length, rate, change = at[f"l{k}"] * arm * np.array([pace**0, pace, pace**2])
        mass, growth, growth_rate = at[f"m{k}"] * part * np.array([pace**0, pace, pace**2])
        pivot, slip = at.vector(f"h{k}", f"y{k}", f"z{k}"), sigma - np.cross(slosh.rate(at), s)
        lump = Lump(
            mass, -growth, -growth_rate, pivot + length[:, None] * s, rate[:, None] * s + length[:, None] * slip
        )
        inertia = at[f"I{k}"] * part
        tanks.append(Tank(lump, pivot, s, sigma, length, rate, change, inertia[0], inertia[1] * pace, at[f"eps{k}"]))
    return tanks


def _along_x(x: Array) -> Array:
    return np.asarray(x[:, None] * np.array([1.0, 0.0, 0.0]))


def _fixed(at: Points, tanks: list[Tank]) -> Lump:
    mass = _fuel(at) - at["burnt"] - sum(tank.lump.mass for tank in tanks)
    out = at["flow"] - sum(tank.lump.out for tank in tanks)
    place = _along_x(-at["h0"])
    return Lump(mass, out, -sum(tank.lump.out_rate for tank in tanks), place, np.zeros_like(place))


def _lumps(at: Points, tanks: list[Tank]) -> list[Lump]:
    """Return the fuel, place by place."""
    return [_fixed(at, tanks), *(tank.lump for tank in tanks)]


def _dry(at: Points) -> Lump:
    none, place = np.zeros(len(at["m"])), _along_x(-at["b"])
    return Lump(at["m"], none, none, place, np.zeros_like(place))


def _inertia(at: Points, fixed: Lump) -> tuple[Array, Array]:
    """Return the moments of inertia of hull and fixed fuel about their centres, and the rate of that of the fuel."""
    square = at["I0"] / at["m0"]
    return at.vector("J_x", "J_y", "J_z") + (square * fixed.mass)[:, None], -square * fixed.out


# Sums over bodies and lines


def _velocity(at: Points, lump: Lump) -> Array:
    return _carried(at, lump.place) + lump.slip


def _carried(at: Points, place: Array) -> Array:
    return np.asarray(slosh.velocity(at) + np.cross(slosh.rate(at), place))


def _gimbal(at: Points) -> Array:
    return _along_x(-(at["b"] + at["d"]))


def _energy(at: Points) -> Array:
    tanks = _tanks(at)
    J, _ = _inertia(at, _fixed(at, tanks))
    bodies = [_dry(at), *_lumps(at, tanks)]
    moving = sum(body.mass * dot(_velocity(at, body), _velocity(at, body)) for body in bodies)
    turning = dot(J * slosh.rate(at), slosh.rate(at)) + sum(t.inertia * dot(t.sigma, t.sigma) for t in tanks)
    return np.asarray(moving + turning) / 2


def _momenta(at: Points) -> Array:
    """Return P and H about O in body axes; of w kg/s over the length D the momentum is w D."""
    tanks = _tanks(at)
    J, _ = _inertia(at, _fixed(at, tanks))
    linear, angular = np.zeros((len(J), 3)), J * slosh.rate(at)
    for body in (_dry(at), *_lumps(at, tanks)):
        reach = _gimbal(at) - body.place
        moving, flow = body.mass[:, None] * _velocity(at, body), body.out[:, None] * reach
        linear = linear + moving + flow
        angular = angular + np.cross(body.place, moving) + np.cross(body.place + reach / 2, flow)
    angular = angular + sum(t.inertia[:, None] * np.cross(t.s, t.sigma) for t in tanks)
    return np.hstack([linear, angular])


def _linear(at: Points) -> Array:
    return _back(at, _momenta(at)[:, :3])


def _angular(at: Points) -> Array:
    return _back(at, _momenta(at)[:, 3:])


def _back(at: Points, vector: Array) -> Array:
    """Return a vector in inertial axes."""
    return rotations.back(slosh.turned(at), vector)


def _thrust(at: Points) -> Array:
    (s1, s2), (c1, c2) = (f(at.vector("gimbal1", "gimbal2").T) for f in (np.sin, np.cos))
    return np.asarray(at["F"][:, None] * np.column_stack([c1 * c2, s2, -s1 * c2]))


def _leaving(at: Points) -> Array:
    """Return thrust less the momentum of what passes the gimbal."""
    return _thrust(at) - at["flow"][:, None] * _carried(at, _gimbal(at))


def _vertical(at: Points) -> Array:
    """Return the local vertical in body axes."""
    angle = at["zenith_0"] + at["orbit_rate"] * at["clock"]
    fixed = np.column_stack([np.cos(angle), 0 * angle, np.sin(angle)])
    return rotations.apply(slosh.turned(at), fixed)


def _gradient(at: Points, r: Array) -> Array:
    o = _vertical(at)
    return np.asarray(at["orbit_rate"][:, None] ** 2 * (3 * o * dot(o, r)[:, None] - r))


def _turned_by_gravity(at: Points, J: Array) -> Array:
    """Return the moment of the gradient on a body with these moments of inertia."""
    o = _vertical(at)
    return np.asarray(3 * at["orbit_rate"][:, None] ** 2 * np.cross(o, J * o))


def _force(at: Points) -> Array:
    bodies = [_dry(at), *_lumps(at, _tanks(at))]
    return np.asarray(_leaving(at) + sum(b.mass[:, None] * _gradient(at, b.place) for b in bodies))


def _moment(at: Points) -> Array:
    """Return what changes H about O, which moves."""
    tanks = _tanks(at)
    J, _ = _inertia(at, _fixed(at, tanks))
    total = at.vector("Mx", "My", "Mz") + np.cross(_gimbal(at), _leaving(at)) + _turned_by_gravity(at, J)
    for body in (_dry(at), *_lumps(at, tanks)):
        total = total + np.cross(body.place, body.mass[:, None] * _gradient(at, body.place))
    total = total + sum(t.inertia[:, None] * np.cross(t.s, _gradient(at, t.s)) for t in tanks)
    return np.asarray(total - np.cross(slosh.velocity(at), _momenta(at)[:, :3]))


# Accelerations along the motion


def _inertial_rate(at: Points, of: Callable[[Points], Array]) -> Array:
    """Return the rate in inertial axes, in body components, of vectors that are given in body axes, shape (n, 3 k)."""

    def reading(here: Points) -> Array:
        return np.hstack([_back(here, part) for part in _threes(of(here))])

    return np.hstack([rotations.apply(slosh.turned(at), part) for part in _threes(at.along(reading))])


def _threes(vectors: Array) -> list[Array]:
    return np.split(vectors, vectors.shape[1] // 3, axis=1)


def _bobs(at: Points) -> tuple[Array, Array]:
    """Return both sides of the bobs' equations across their arms, from the accelerations of their pivots."""

    def moving(here: Points) -> Array:
        tanks = _tanks(here)
        return np.hstack([v for t in tanks for v in (t.sigma, _carried(here, t.pivot))])

    rates, left, right = _threes(_inertial_rate(at, moving)), [], []
    for k, t in enumerate(_tanks(at)):
        turning, pivot = rates[2 * k : 2 * k + 2]
        first = (t.lump.mass * t.length)[:, None]
        slip = t.sigma - np.cross(slosh.rate(at), t.s)
        load = -first * (pivot + 2 * t.length_rate[:, None] * t.sigma - _gradient(at, t.lump.place))
        load = load - t.eps[:, None] * slip + t.inertia[:, None] * _gradient(at, t.s)
        left.append(np.cross(t.s, (t.lump.mass * t.length**2 + t.inertia)[:, None] * turning))
        right.append(np.cross(t.s, load))
    return np.hstack(left), np.hstack(right)


def _power(at: Points) -> Array:
    """Return the power on the bodies: lines push the hull, and the fuel that leaves a place takes its energy along."""
    tanks = _tanks(at)
    total = _power_of_both(at, tanks)
    for lump in _lumps(at, tanks):
        reach, change = _gimbal(at) - lump.place, _carried(at, _gimbal(at)) - _velocity(at, lump)
        push = lump.out_rate[:, None] * reach + 2 * lump.out[:, None] * change
        middle = _carried(at, (lump.place + _gimbal(at)) / 2)
        total = total - dot(push, middle) - lump.out * dot(_velocity(at, lump), _velocity(at, lump)) / 2
    return np.asarray(total)


def _power_of_both(at: Points, tanks: list[Tank]) -> Array:
    """Return the power of thrust, moments, gravity and dampers, and of what inertia and arms that change do."""
    w = slosh.rate(at)
    J, J_rate = _inertia(at, _fixed(at, tanks))
    total = dot(_thrust(at), _carried(at, _gimbal(at))) + dot(at.vector("Mx", "My", "Mz"), w)
    total = total + dot(_turned_by_gravity(at, J), w) - J_rate * dot(w, w) / 2
    for body in (_dry(at), *_lumps(at, tanks)):
        total = total + body.mass * dot(_gradient(at, body.place), _velocity(at, body))
    pulls = _threes(_inertial_rate(at, lambda here: np.hstack([_velocity(here, t.lump) for t in _tanks(here)])))
    for t, a in zip(tanks, pulls, strict=True):
        slip = t.sigma - np.cross(w, t.s)
        arm = t.lump.mass * dot(a - _gradient(at, t.lump.place), t.s)
        total = total + arm * t.length_rate - t.eps * dot(slip, slip) + t.inertia * dot(_gradient(at, t.s), t.sigma)
        total = total + t.inertia_rate * (dot(t.sigma, t.sigma) / 2 - dot(w, np.cross(t.s, t.sigma)))
    return np.asarray(total)


def _energy_with_lines(at: Points) -> Array:
    """Return the energy with what the motion of the lines adds to their flow: w D times the mean velocity of a line."""
    end, total = _carried(at, _gimbal(at)), _energy(at)
    for lump in _lumps(at, _tanks(at)):
        mean = (_velocity(at, lump) + end) / 2
        total = total + lump.out * dot(_gimbal(at) - lump.place, mean)
    return np.asarray(total)


def _power_with_lines(at: Points) -> Array:
    """Return the same power; what leaves takes w v^2/2 along, and pumps work against accelerations of their lines."""
    tanks, end = _tanks(at), _carried(at, _gimbal(at))
    total = _power_of_both(at, tanks) - at["flow"] * dot(end, end) / 2

    def means(here: Points) -> Array:
        rear = _carried(here, _gimbal(here))
        return np.hstack([(_velocity(here, lump) + rear) / 2 for lump in _lumps(here, _tanks(here))])

    for lump, mean in zip(_lumps(at, tanks), _threes(_inertial_rate(at, means)), strict=True):
        reach, change = _gimbal(at) - lump.place, end - _velocity(at, lump)
        total = total + lump.out * dot(reach, mean)
        total = total + dot(lump.out_rate[:, None] * reach / 2 + lump.out[:, None] * change, lump.slip)
    return np.asarray(total)


# The rest


def _held(at: Points) -> Array:
    return np.column_stack([dot(t.s, other) for t in _tanks(at) for other in (t.s, t.sigma)])


def _q(at: Points) -> Array:
    return at.vector("q0", "q1", "q2", "q3")


def _turning(at: Points) -> Array:
    return (
        np.asarray(-np.cross(slosh.rate(at)[:, None, :], np.swapaxes(slosh.turned(at), 1, 2)))
        .swapaxes(1, 2)
        .reshape(-1, 9)
    )


def _ticking(at: Points) -> Array:
    return np.column_stack([at["flow"], np.ones(len(at["flow"]))])


def _hard(at: Points) -> Points:
    """Return points with commands beyond the limits of the angles, and gimbals that may be as fast as they want."""
    sign = np.where(np.arange(len(at["F"])) % 2, 1.0, -1.0)
    return at.moved(delta1=5 * sign, delta2=-5 * sign, gimbal_rate=100.0)


def _followed(at: Points) -> Array:
    limits, angles = at.vector("delta1_max", "delta2_max"), at.vector("gimbal1", "gimbal2")
    wanted = (np.clip(at.vector("delta1", "delta2"), -limits, limits) - angles) / at["lag"][:, None]
    fastest = at["gimbal_rate"][:, None]
    return np.clip(wanted, -fastest, fastest)


def _faster(at: Points) -> Points:
    return at.moved(vx=at["vx"] + 2.0, vy=at["vy"] - 1.0, vz=at["vz"] + 0.5)


def _outputs() -> list[Gate]:
    def across(at: Points) -> Array:
        return np.linalg.norm(_thrust(at)[:, 1:], axis=1) / at["F"]

    return [
        identity("accelerations", _accelerated, lambda at: slosh.accelerations(at)[:, :6]),
        identity("lateral thrust", lambda at: at.result("outputs", "lateral")[:, 0], across),
        identity("angles of the bobs", slosh.directions, lambda at: np.hstack([t.s for t in _tanks(at)])),
        identity("attitude angles", slosh.turned_by_outputs, slosh.turned),
        identity("a law's inputs from accelerations", lambda at: _demand(_filled(at)), lambda at: _met(_filled(at))),
        identity(
            "a law's turning beyond the thrust",
            lambda at: _demand(_filled(at), 40.0)[:, 2:],
            lambda at: _met(_filled(at), 40.0)[:, 2:],
        ),
        identity("initial state", lambda at: at.call("initial"), _initial),
    ]


def _accelerated(at: Points) -> Array:
    return at.result("outputs", "ax", "ay", "az", "alpha1", "alpha2", "alpha3")


def _known(at: Points) -> Points:
    """Return the craft that a law takes this one for: masses at present on ball joints, and no more."""
    tanks, part = _tanks(at), machine("slosh", *_WITHOUT)
    fixed = _fixed(at, tanks)
    values = {"m0": fixed.mass, "I0": at["I0"] / at["m0"] * fixed.mass}
    for k, t in zip(_NUMBERS, tanks, strict=True):
        values |= {f"m{k}": t.lump.mass, f"l{k}": t.length, f"I{k}": t.inertia}
    copied = {q.name: at[q.name] for g in (part.system.states, part.system.inputs, part.system.parameters) for q in g}
    return points(part, len(fixed.mass)).moved(**{**copied, **values})


def _demand(at: Points, lateral: float = 1.0) -> Array:
    """Return accelerations that inputs give that craft; those across the thrust scaled by a factor."""
    return np.asarray(_known(at).call("outputs")[:, :5] * np.array([lateral, lateral, 1, 1, 1]))


def _met(at: Points, lateral: float = 1.0) -> Array:
    """Return the accelerations that come of the inputs for the demand."""
    u = at.machine("to_physical", at.values["x"], _demand(at, lateral), at.values["p"])
    return _known(at).at(u=u).call("outputs")[:, :5]


def _initial(at: Points) -> Array:
    return np.hstack([slosh.initial(at), np.zeros((len(at["F"]), 4))])
