# SPDX-License-Identifier: Apache-2.0
"""The satellite with all that is beyond its paper, compiled, and the same motion by other means."""

from __future__ import annotations

import functools
import tempfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import mehvar
from mehvar.codegen.generate import write
from tests.derived import variant

Array = NDArray[np.float64]
EVERYTHING = {
    "chart": "quaternion", "inertia": "full", "wheels": "any", "orbit": "keplerian", "torquers": "three",
    "sensors": "instruments", "laws": "more",
}  # fmt: skip


MU = 3.986004418e14


@functools.cache
def craft(wheels: str = "any") -> mehvar.Model:
    """Return the model of all choices, with wheels that are balanced or not."""
    folder = Path(_scratch().name) / wheels
    write(folder, variant("satellite", **{**EVERYTHING, "wheels": wheels}))
    return mehvar.load(folder)


@functools.cache
def _scratch() -> tempfile.TemporaryDirectory[str]:
    return tempfile.TemporaryDirectory(prefix="craft-")


def names(key: str, wheels: str = "any") -> list[str]:
    """Return the names of the states, inputs, ..."""
    return [q.name for q in getattr(craft(wheels).manifest, key)]


def state(wheels: str = "any", **values: float) -> Array:
    """Return x: zero but for what is given, and at rest in the orbit axes' attitude."""
    values = {"q0": 1.0, **values}
    return np.array([values.get(name, 0.0) for name in names("states", wheels)])


def motion(x: Array, u: Array, p: Array, times: Array, wheels: str = "any") -> Array:
    """Return the states at times by SciPy's dop853 over the compiled equations."""
    done = solve_ivp(
        lambda _t, y: craft(wheels).rhs(y, u, p), (times[0], times[-1]), x, "DOP853", times, rtol=1e-12, atol=1e-14
    )
    assert done.success
    return np.asarray(done.y.T)


def column(x: Array, *which: str, wheels: str = "any") -> Array:
    """Return columns of states by their names."""
    return x[..., [names("states", wheels).index(name) for name in which]]


def body_axes(x: Array, p: Mapping[str, float], wheels: str = "any") -> Array:
    """Return the matrix from body to inertial axes."""
    anomaly, perigee, node = column(x, "anomaly", "perigee", "node", wheels=wheels)
    up = Rotation.from_euler("ZXZ", [node, p["inclination"], anomaly + perigee]).as_matrix()
    orbit = np.column_stack([up[:, 1], -up[:, 2], -up[:, 0]])
    attitude = Rotation.from_quat(column(x, "q0", "q1", "q2", "q3", wheels=wheels), scalar_first=True)
    return np.asarray(orbit @ attitude.as_matrix())


def place(x: Array, p: Mapping[str, float], wheels: str = "any") -> tuple[Array, Array]:
    """Return place and velocity."""
    anomaly, perigee, node = column(x, "anomaly", "perigee", "node", wheels=wheels)
    a, e = p["semi_major_axis"], p["eccentricity"]
    up = Rotation.from_euler("ZXZ", [node, p["inclination"], perigee]).as_matrix()
    latus = a * (1 - e**2)
    r = latus / (1 + e * np.cos(anomaly)) * np.array([np.cos(anomaly), np.sin(anomaly), 0])
    v = np.sqrt(MU / latus) * np.array([-np.sin(anomaly), e + np.cos(anomaly), 0])
    return up @ r, up @ v


class Newton:
    """The same craft in inertial axes: place and velocity, a rotation matrix, its whole momentum, wheels by their own.

    Gravity is that of the Earth's centre on the points of a body that has the inertia: no gradient is expanded.
    """

    def __init__(self, inertia: Array, axes: Array, spin: Array, mu: float) -> None:
        self.axes, self.spin, self.mu = axes / np.linalg.norm(axes, axis=0), spin, mu
        self.inertia = inertia
        moments, turn = np.linalg.eigh(inertia + self.axes @ np.diag(spin) @ self.axes.T)
        second = moments.sum() / 2 - moments  # of the masses along each principal axis
        self.points = np.concatenate([turn.T * np.sqrt(second / 2)[:, None], -turn.T * np.sqrt(second / 2)[:, None]])

    def rate(self, y: Array, motors: Array, dipole: Array, field_moment: float) -> Array:
        """Return the rates of r, v, R (body to inertial), H (inertial) and h."""
        r, v, turn, whole, h = y[:3], y[3:6], y[6:15].reshape(3, 3), y[15:18], y[18:]
        w = np.linalg.solve(self.inertia, turn.T @ whole - self.axes @ h)
        skew = np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])
        radius = np.linalg.norm(r)
        away, north = r / radius, np.array([0, 0, 1.0])
        field = field_moment / radius**3 * (north - 3 * north @ away * away)
        torque = self._gravity(turn, r) + np.cross(turn @ dipole, field)
        return np.concatenate([v, -self.mu * r / radius**3, (turn @ skew).ravel(), torque, -motors])

    def _gravity(self, turn: Array, r: Array) -> Array:
        """Return the sum of arm x force over six points of unit mass; differences of pulls, so that none cancels."""
        total = np.zeros(3)
        for arm in self.points @ turn.T:
            # 1/|r + a|^3 - 1/|r|^3 without the difference of near numbers
            excess = (2 * r @ arm + arm @ arm) / (r @ r)
            total += np.cross(arm, r) * np.expm1(-1.5 * np.log1p(excess))
        return -self.mu / np.linalg.norm(r) ** 3 * total
