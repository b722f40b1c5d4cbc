# SPDX-License-Identifier: Apache-2.0
"""A rigid body by the satellite's equations, with or without gravity gradient, for references without wheels."""

from __future__ import annotations

import functools

import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import mehvar
from tests.models.satellite.loop import satellite

NO_WHEEL = 1e-12
"""Spin inertia of negligible wheels, kg m^2."""


@functools.cache
def model() -> mehvar.Model:
    """Return the satellite in quaternions, compiled."""
    return mehvar.load(satellite("quaternion").folder)


def parameters(inertia: np.ndarray, omega0: float) -> np.ndarray:
    """Return the plant's parameters with external torques and no wheels."""
    values = {f"I_{axis}": value for axis, value in zip("xyz", inertia, strict=True)}
    values |= {f"Iw_{axis}": NO_WHEEL for axis in "xyz"}
    return model().parameters(omega0=omega0, wheels=0.0, **values)


def state(turn: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """Return x for a matrix from orbit to body axes and a rate in body axes; q is scalar first."""
    quaternion = Rotation.from_matrix(turn.T).as_quat(scalar_first=True)
    return np.concatenate([quaternion, rate, np.zeros(4)])


def acceleration(turn: np.ndarray, rate: np.ndarray, torque: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Return the angular acceleration."""
    return model().rhs(state(turn, rate), torque, p)[4:7]


def motion(x: np.ndarray, p: np.ndarray, times: np.ndarray) -> np.ndarray:
    """Return the states at times, without torque: SciPy's dop853 at its tightest over the compiled equations."""
    none = np.zeros(3)
    run = solve_ivp(
        lambda _t, y: model().rhs(y, none, p), (times[0], times[-1]), x, "DOP853", times, rtol=1e-13, atol=1e-16
    )
    return run.y.T


def facing(nadir: np.ndarray) -> np.ndarray:
    """Return a matrix from orbit to body axes whose third column is the nadir; its other columns are arbitrary."""
    side = np.cross(nadir, np.eye(3)[np.argmin(np.abs(nadir))])
    side /= np.linalg.norm(side)
    return np.column_stack([side, np.cross(nadir, side), nadir])
