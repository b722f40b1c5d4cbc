# SPDX-License-Identifier: Apache-2.0
"""Models that pages build, against calculations that share nothing with them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.interpolate import PchipInterpolator

import mehvar
from mehvar.runtime.run.noise import normals
from tests.examples.pages import model_of_page

Array = NDArray[np.float64]


def test_the_filter_of_several_rates_is_that_of_numpy(tmp_path: Path) -> None:
    run = mehvar.simulate(str(model_of_page("gyro", "how-to/noise-and-rates.md", tmp_path)), "ekf")
    dt, J, top, load, bias, n_g, s_s, walk = 0.01, 2.0, 0.05, 0.002, 0.01, 2e-4, 0.005, 1e-4
    e = normals(0, 0, len(run.t), 2)
    x, z, P, side = np.array([0.4, 0.0]), np.zeros(2), np.diag([0.25, 4e-4]), 0.0
    F = np.array([[1, -dt], [0, 1]])
    names = ("angle", "angle_est", "bias_est", "P_bb", "u_torque", "off_by")
    seen = np.stack([run[name].values for name in names])
    for k in range(len(run.t)):
        gyro, sun = x[1] + bias + n_g / np.sqrt(dt) * e[k, 0], np.sin(x[0]) + s_s * e[k, 1]
        if k % 10 == 0:
            line = z[0] + 2.0 * (gyro - z[1])
            stays = side * line > 0 and abs(line) > 0.02
            side = np.sign(line) if abs(line) > 0.05 else side if stays else 0.0
        assert seen[:, k] == pytest.approx([x[0], z[0], z[1], P[1, 1], -top * side, x[0] - z[0]], rel=0, abs=1e-11)
        H = np.array([[np.cos(z[0]), 0.0]])
        K = P @ H.T / (H @ P @ H.T + s_s**2)
        z = z + K[:, 0] * (sun - np.sin(z[0]))
        P = F @ (np.eye(2) - K @ H) @ P @ F.T + np.diag([n_g**2 * dt, walk**2 * dt])
        z = np.array([z[0] + dt * (gyro - z[1]), z[1]])
        a = (load - top * side) / J
        x = np.array([x[0] + dt * x[1] + dt**2 / 2 * a, x[1] + dt * a])


def test_the_rocket_is_that_of_scipy(tmp_path: Path) -> None:
    """Each step of SciPy ends at a sample, so that it contains no kink of the thrust."""
    drag = PchipInterpolator([0, 0.6, 0.9, 1.1, 1.6, 3], [0.45, 0.45, 0.6, 0.8, 0.7, 0.5])

    def rate(t: float, x: Array) -> list[float]:
        thrust = np.interp(t, [0, 0.3, 3, 3.4, 5], [0, 90, 60, 10, 0])
        force = thrust - drag(abs(x[1]) / 340) * 1.2 * 0.005 * x[1] * abs(x[1]) / 2
        return [x[1], force / (2 - 0.2 * min(t, 5)) - 9.81]

    run = mehvar.simulate(str(model_of_page("rocket", "how-to/time-and-tables.md", tmp_path)), None, inputs={})
    x, heights = np.zeros(2), run.height.values
    for k, (a, b) in enumerate(zip(run.t.values[:-1], run.t.values[1:], strict=True)):
        x = solve_ivp(rate, (a, b), x, method="DOP853", rtol=1e-12, atol=1e-12).y[:, -1]
        assert heights[k + 1] == pytest.approx(x[0], rel=0, abs=1e-7)


def test_the_crane_is_that_of_the_equations_by_hand(tmp_path: Path) -> None:
    def rate(_: float, x: Array) -> list[float]:
        place, theta, v, w = x
        force = 4 * (-6 * place - 4 * v) / 2
        v_dot = (force + np.sin(theta) * (0.8 * w**2 + 9.81 * np.cos(theta))) / (4 - np.cos(theta) ** 2)
        return [v, w, v_dot, -(9.81 * np.sin(theta) + np.cos(theta) * v_dot) / 0.8]

    crane = model_of_page("crane", "how-to/implicit-forms.md", tmp_path)
    run = mehvar.simulate(str(crane), "drive", method="rodas5p", rtol=1e-9, atol=1e-9)
    end = solve_ivp(rate, (0, 8), [0, 0, 1, 0], "DOP853", rtol=1e-11, atol=1e-11).y[:, -1]
    assert [float(run[name][-1]) for name in ("place", "theta", "v", "w")] == pytest.approx(end, rel=0, abs=1e-7)
    assert abs(2 * run.i + 4 * run.v + 6 * run.place).max() < 1e-8
