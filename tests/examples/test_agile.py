# SPDX-License-Identifier: Apache-2.0
"""The craft with control moment gyros against its momentum, which stays zero, and Wie's steering law in NumPy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import mehvar
from tests.examples.pages import ROOT, lines, model_here

INERTIA, H, LAG, PERIOD = np.diag([21400.0, 20100.0, 5000.0]), 1.6 * 625.0, 0.02, 0.05
SPIN, GIMBAL, ACROSS = 1.6, 2.0, 1.5
"""Moments of inertia of a gyro about the rotor's axis, the gimbal's and across both, kg m^2."""
AXES = np.array([[0.8, 0, 0.6], [0, 0.8, 0.6], [-0.8, 0, 0.6], [0, -0.8, 0.6]])
ZERO = np.array([[0, 1, 0], [-1, 0, 0], [0, -1, 0], [1, 0, 0]])
NAMES = ["q0", "q1", "q2", "q3", *(f"gyro{i}_gimbal{of}" for of in ("", "_rate") for i in (1, 2, 3, 4))]
TIGHT = {"rtol": 1e-11, "atol": 1e-12}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return model_here("agile", tmp_path_factory.mktemp("agile"))


def turned(angles):
    """Return the rotors' axes and those across rotor and gimbal."""
    across = np.cross(AXES, ZERO)
    c, s = np.cos(angles)[:, None], np.sin(angles)[:, None]
    return c * ZERO + s * across, c * across - s * ZERO


def rate_of(angles, speeds):
    """Return the rate at which the momentum of hub and gyros is zero: nothing acts from outside."""
    spins, across = turned(angles)
    whole = INERTIA + SPIN * spins.T @ spins + GIMBAL * AXES.T @ AXES + ACROSS * across.T @ across
    return -np.linalg.solve(whole, H * spins.sum(0) + GIMBAL * speeds @ AXES)


def moving(_, x, commands):
    q, angles, speeds = x[:4], x[4:8], x[8:]
    w = rate_of(angles, speeds)
    turn = np.concatenate([[-q[1:] @ w], q[0] * w + np.cross(q[1:], w)]) / 2
    return np.concatenate([turn, speeds, (commands - speeds) / LAG])


def steering(t, x):
    """Return the rates of the gimbals by the generalised singularity-robust inverse; equations 13, 14, 24 to 27."""
    q, angles = x[1:4], x[4:8]
    w, (spins, across) = rate_of(angles, x[8:]), turned(angles)
    wanted = -INERTIA @ (np.clip(2 * 9.0 * q, -5.4 * 0.1745, 5.4 * 0.1745) + 5.4 * w)
    e = 0.01 * np.sin(1.571 * t + np.array([0, np.pi / 2, np.pi]))
    off = np.array([[1, e[2], e[1]], [e[2], 1, e[0]], [e[1], e[0], 1]])
    square = across.T @ across
    robust = square + 0.01 * np.exp(-10 * np.linalg.det(square)) * off
    rates = across @ np.linalg.solve(robust, -wanted / 1000.0 - np.cross(w, spins.sum(0)))
    return rates / max(1, np.abs(rates).max() / 2.0)


def by_hand(until):
    x = np.concatenate([[np.cos(0.4115), -np.sin(0.4115), 0, 0], np.zeros(8)])
    states = [x]
    for k in range(round(until / PERIOD)):
        commands = steering(k * PERIOD, x)
        x = solve_ivp(moving, (0, PERIOD), x, "DOP853", args=(commands,), rtol=1e-12, atol=1e-13).y[:, -1]
        states.append(x)
    return np.array(states)


def check(run, until, tolerance):
    states = by_hand(until)
    np.testing.assert_allclose(np.stack([run[n].values for n in NAMES], axis=1), states, atol=tolerance)
    rates = [rate_of(x[4:8], x[8:]) for x in states]
    np.testing.assert_allclose(np.stack([run[f"w{a}"].values for a in "xyz"], axis=1), rates, atol=tolerance)
    return states


def test_it_is_short():
    assert lines(ROOT / "docs" / "examples" / "models" / "agile") <= 40


def test_it_escapes_from_the_singularity_like_the_equations_by_hand(folder):
    """Rates of both integrations err by about 1e-12 rad/s; ten times that."""
    run = mehvar.simulate(folder, "steer", t_end=2.75, **TIGHT)
    states = check(run, 2.75, 1e-11)
    stuck, escaped = run.sel(t=1.5, method="nearest"), run.isel(t=-1)
    assert float(run.measure.min()) < 0.02 < 0.5 < float(escaped.measure)
    turns = [float(stuck[f"gyro{i}_gimbal"]) for i in (1, 2, 3, 4)]
    np.testing.assert_allclose(turns, [np.pi / 2, 0, -np.pi / 2, 0], atol=0.1)
    assert float(stuck.wx) == pytest.approx(1.2 * 1000 / 21400, rel=0.01)  # 2 cos(53.13 degrees) momenta of a gyro
    torque(mehvar.load(folder), states[30])


def torque(model, x):
    """Compare the torque of the gyros on the hub with the change of their momentum, at a command of zero."""
    step, flow = 1e-5, moving(0, x, np.zeros(4))[4:]
    low, here, high = (rate_of(*np.split(x[4:] + k * step * flow, 2)) for k in (-1, 0, 1))
    state = dict(zip(["wx", "wy", "wz", *NAMES], [*here, *x], strict=True))
    given = model.rhs([state[name] for name in model.state_names], np.zeros(4), model.parameters())[:3]
    exerted, expected = (INERTIA @ a + np.cross(here, INERTIA @ here) for a in (given, (high - low) / (2 * step)))
    assert np.linalg.norm(expected) > 10
    np.testing.assert_allclose(exerted, expected, atol=1e-5)  # N m, of a difference of rates over 2e-5 s


def test_the_momentum_stays(folder):
    model = mehvar.load(folder)
    run = mehvar.simulate(folder, "steer", t_end=2.75, **TIGHT)
    x = np.stack([run[name].values for name in model.state_names], axis=1)
    momentum = model.functions["momentum"](x, model.parameters())
    assert np.abs(momentum[:, 3:]).max() < 1e-8  # N m s, beside 1000 in each gyro


@pytest.mark.soak
def test_it_turns_to_the_end_like_the_equations_by_hand(folder):
    """A hundred samples near saturation, at (90, 0, -90, -180) degrees, multiply the errors."""
    run = mehvar.simulate(folder, "steer", **TIGHT)
    check(run, 15.0, 1e-8)
    assert float(run.wx.max()) == pytest.approx(3.2 * 1000 / 21400, rel=0.01)
    assert abs(float(run.q1[-1])) < 1e-6
