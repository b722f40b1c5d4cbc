# SPDX-License-Identifier: Apache-2.0
"""The sigma-point filter of a pendulum against filterpy's cubature Kalman filter, with a measurement that is linear.

filterpy measures with the points of the prediction and ours draws new ones: for a linear measurement without process
noise both are the same filter. It takes lower triangular factors and ours are upper: its states are in reverse order.
"""

from __future__ import annotations

from dataclasses import replace
from importlib.metadata import version

import numpy as np
from filterpy.kalman import CubatureKalmanFilter

import mehvar
from mehvar import Group, Quantity, Sensor, estimated
from mehvar.runtime.run.noise import normals
from tests.models.estimation.swing import DEVIATION, KD, KP, MEAN, SIGMA_G, START, TS, P, X, moved, swing
from tests.validation.table import record


def test_cubature_filter_of_a_pendulum() -> None:
    noise = Group("e", (Quantity("e_g", "1", "error of the rate"),))
    seen = Group("seen", (Quantity("gyro", "rad/s", "measured rate"),))
    sensor = Sensor(noise, (X.rate + P.sigma_g * noise.e_g,), seen)
    known = replace(P, quantities=tuple(q for q in P if q.name not in ("sigma", "walk")))
    plain = swing(sensor=sensor, random_step=None, parameters=known)
    system = estimated(plain, "pd", START, kind="sigma-point")
    run = mehvar.simulate(mehvar.build(system), "pd", t_end=10.0)
    theirs = CubatureKalmanFilter(3, 1, TS, lambda x: x[[1]], lambda x, dt, u: moved(x[::-1], u)[::-1])
    theirs.x, theirs.P = np.array(MEAN[::-1], dtype=float)[:, None], np.diag(np.square(DEVIATION[::-1]))
    theirs.Q, theirs.R = np.zeros((3, 3)), np.array([[SIGMA_G**2]])
    errors = normals(0, 0, run.sizes["t"], 1)[:, 0] * SIGMA_G
    off = []
    theirs.sigmas_f = _points(theirs.x.ravel(), theirs.P)
    for k, speed in enumerate(run["rate"].values):
        ours = np.array([float(run[f"{name}_est"][k]) for name in START])
        off.append(ours - theirs.x[::-1].ravel())
        theirs.update(np.array([[speed + errors[k]]]))
        theirs.predict(fx_args=(float(-KP * theirs.x[2, 0] - KD * theirs.x[1, 0]),))
    record(
        "estimation: sigma-point filter of a pendulum, 200 samples",
        "filterpy",
        version("filterpy"),
        off,
        1e-9,
        "rad, rad/s, 1/s",
        "rounding of 200 factorisations",
    )


def _points(x: np.ndarray, covariance: np.ndarray) -> np.ndarray:
    columns = np.sqrt(len(x)) * np.linalg.cholesky(covariance)
    return np.concatenate([x + columns.T, x - columns.T])
