# SPDX-License-Identifier: Apache-2.0
"""Hand-written dynamics of the spacecraft with draining tanks: positions of all masses in fixed axes, and multipliers.

Every body has its own Newton equations in fixed axes, every bob is a free point that a multiplier holds at its length,
and all constraints are differentiated twice. Nothing is shared with the model: tables are SciPy's, their derivatives
too, the momentum of the flow is integrated along each line numerically.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

Array = NDArray[np.float64]
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(4)


@dataclass(frozen=True)
class Lump:
    """Fuel at a place: kg, kg m^2 and their first and second derivatives in time."""

    mass: float
    out: float
    out_rate: float
    inertia: float
    inertia_rate: float


@dataclass(frozen=True)
class Tank:
    """A lump on an arm."""

    lump: Lump
    pivot: Array
    length: float
    length_rate: float
    length_change: float
    eps: float


def tanks(v: Mapping[str, float], count: int, burnt: float) -> tuple[Lump, list[Tank]]:
    """Return the fixed fuel and the tanks once so much fuel is burnt."""
    at = [v[f"share_at_{k}"] for k in range(1, 6)]
    mass, arm = (PchipInterpolator(at, [v[f"{name}_{k}"] for k in range(1, 6)]) for name in ("mass_part", "arm_part"))
    fuel = v["m0"] + sum(v[f"m{k}"] for k in range(1, count + 1))
    share, pace = burnt / fuel, v["flow"] / fuel
    part, part_1, part_2 = (float(mass.derivative(n)(share)) if n else float(mass(share)) for n in range(3))
    reach, reach_1, reach_2 = (float(arm.derivative(n)(share)) if n else float(arm(share)) for n in range(3))
    bobs = []
    for k in range(1, count + 1):
        m, length, inertia = v[f"m{k}"], v[f"l{k}"], v[f"I{k}"]
        lump = Lump(m * part, -m * part_1 * pace, -m * part_2 * pace**2, inertia * part, inertia * part_1 * pace)
        pivot = np.array([v[f"h{k}"], v[f"y{k}"], v[f"z{k}"]])
        bobs.append(
            Tank(lump, pivot, length * reach, length * reach_1 * pace, length * reach_2 * pace**2, v[f"eps{k}"])
        )
    rest = fuel - burnt - sum(bob.lump.mass for bob in bobs)
    out = v["flow"] - sum(bob.lump.out for bob in bobs)
    square = v["I0"] / v["m0"]
    fixed = Lump(rest, out, -sum(bob.lump.out_rate for bob in bobs), square * rest, -square * out)
    return fixed, bobs


def rotation(q: Array) -> Array:
    """Return the matrix from body to fixed axes."""
    w, x, y, z = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def rates(v: Mapping[str, float], count: int, x: Mapping[str, float], u: Array, time: float) -> dict[str, float]:
    """Return the rates of vx..wz and of sigma, by solving for all accelerations, forces and multipliers at once.

    Unknowns, in fixed axes: acceleration of O and angular acceleration; per bob its acceleration and the tension of its
    arm. The bob's turning inertia acts as two equal masses I/(2 e^2) at e before and behind the bob along the arm.
    """
    R = rotation(np.array([x[f"q{k}"] for k in range(4)]))
    V, W = R @ [x["vx"], x["vy"], x["vz"]], R @ [x["wx"], x["wy"], x["wz"]]
    fixed, bobs = tanks(v, count, x["burnt"])
    d1, d2 = x["gimbal1"], x["gimbal2"]
    thrust = v["F"] * R @ [np.cos(d1) * np.cos(d2), np.sin(d2), -np.sin(d1) * np.cos(d2)]
    gimbal = R @ [-(v["b"] + v["d"]), 0.0, 0.0]
    nu = v["zenith_0"] + v["orbit_rate"] * time
    o = np.array([np.cos(nu), 0.0, np.sin(nu)])
    pull = v["orbit_rate"] ** 2 * (3 * np.outer(o, o) - np.eye(3))
    arms = [R @ [x[f"s{k}{axis}"] for axis in "xyz"] for k in range(1, count + 1)]
    turning = [R @ [x[f"sigma{k}{axis}"] for axis in "xyz"] for k in range(1, count + 1)]

    size = 6 + 7 * count  # a, alpha; per bob: acceleration of its direction, of its place, tension
    rows: list[Array] = []
    right: list[Array] = []

    def equation(terms: list[tuple[int, Array]], value: Array) -> None:
        block = np.zeros((len(value), size))
        for at, matrix in terms:
            block[:, at : at + matrix.shape[1]] += matrix
        rows.append(block)
        right.append(value)

    def cross(r: Array) -> Array:
        return np.cross(np.eye(3), r)  # the matrix of r x

    eye = np.eye(3)
    force_terms: list[tuple[int, Array]] = []
    moment_terms: list[tuple[int, Array]] = []
    force, moment = thrust.copy(), np.cross(gimbal, thrust) + R @ np.asarray(u[:3])
    for mass, place in ((v["m"], R @ [-v["b"], 0, 0]), (fixed.mass, R @ [-v["h0"], 0, 0])):
        # m (a + alpha x r + W x (W x r))
        acceleration = np.hstack([eye, -cross(place)])
        own = mass * (pull @ place - np.cross(W, np.cross(W, place)))
        force_terms.append((0, mass * acceleration))
        moment_terms.append((0, mass * cross(place) @ acceleration))
        force, moment = force + own, moment + np.cross(place, own)
    J = R @ np.diag([v[f"J_{axis}"] + fixed.inertia for axis in "xyz"]) @ R.T
    moment_terms.append((3, J))
    moment = moment - np.cross(W, J @ W) - fixed.inertia_rate * W + 3 * v["orbit_rate"] ** 2 * np.cross(o, J @ o)
    pipes = [(fixed, R @ [-v["h0"], 0, 0], np.cross(W, R @ [-v["h0"], 0, 0]))]
    for k, (bob, s, sigma) in enumerate(zip(bobs, arms, turning, strict=True)):
        at = 6 + 7 * k
        P = R @ bob.pivot
        m, length, inertia = bob.lump.mass, bob.length, bob.lump.inertia
        place = P + length * s
        speed = np.cross(W, P) + bob.length_rate * s + length * sigma
        pipes.append((bob.lump, place, speed))
        slip = sigma - np.cross(W, s)
        # the place of the bob: r'' = a + alpha x P + W x (W x P) + l'' s + 2 l' sigma + l s''
        equation(
            [(at + 3, eye), (0, -np.hstack([eye, -cross(P)])), (at, -length * eye)],
            np.cross(W, np.cross(W, P)) + bob.length_change * s + 2 * bob.length_rate * sigma,
        )
        # the bob itself, moved by the tension T along the arm and, across it, by its turning inertia and damping:
        # m r'' = m g + T s - (I s'' + eps s' - I g(s))/l across s
        across = eye - np.outer(s, s)
        equation(
            [(at + 3, m * eye), (at, inertia / length * across), (at + 6, s[:, None])],
            m * pull @ place - across @ (bob.eps * slip - inertia * pull @ s) / length,
        )
        equation([(at, s[None, :])], np.array([-sigma @ sigma]))
        force_terms.append((at + 3, m * eye))
        force = force + m * pull @ place
        moment_terms += [(at + 3, m * cross(place)), (at, inertia * cross(s))]
        moment = moment + m * np.cross(place, pull @ place) + inertia * np.cross(s, pull @ s)
        moment = moment - bob.lump.inertia_rate * np.cross(s, sigma)
    for lump, start, speed in pipes:
        # fluid at start + t reach, of momentum w reach dt in the body: integrated along the pipe
        reach, change = gimbal - start, np.cross(W, gimbal) - speed
        for node, weight in zip((1 + _NODES) / 2, _WEIGHTS / 2, strict=True):
            push = weight * (lump.out_rate * reach + 2 * lump.out * change)
            force, moment = force - push, moment - np.cross(start + node * reach, push)
    equation(force_terms, force)
    equation(moment_terms, moment)
    z = np.linalg.solve(np.vstack(rows), np.concatenate(right))
    a, alpha = R.T @ z[:3], R.T @ z[3:6]
    body, spin = R.T @ V, R.T @ W
    result = dict(zip(("vx", "vy", "vz"), a - np.cross(spin, body), strict=True))
    result |= dict(zip(("wx", "wy", "wz"), alpha, strict=True))
    for k in range(count):
        change = R.T @ z[6 + 7 * k : 9 + 7 * k] - np.cross(spin, R.T @ turning[k])
        result |= {f"sigma{k + 1}{axis}": value for axis, value in zip("xyz", change, strict=True)}
    return result
