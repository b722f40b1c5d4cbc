# SPDX-License-Identifier: Apache-2.0
"""The flexible satellite against bodies in inertial axes, with the tension of the bob's rod as an unknown."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import mehvar
from tests.examples.pages import ROOT, lines, model_here

MASS, INERTIA = 600.0, np.array([[350.0, 3, 4], [3, 270, 10], [4, 10, 190]])
DELTA = np.array([[6.45637, 1.27814, 2.15629], [-1.25619, 0.91756, -1.67264],
                  [1.11687, 2.48901, -0.83674], [1.23637, -2.6581, -1.12503]])  # fmt: skip
FREQUENCY, DAMPING = np.array([0.7681, 1.1038, 1.8733, 2.5496]), np.array([0.0056, 0.0086, 0.013, 0.025])
AXES, SPIN, LARGEST = np.array([[1, 0, 1], [0, 1, 1], [-1, 0, 1], [0, -1, 1]]) / np.sqrt(2), 0.1, 1.0
BOB, ROD, LOSS, PIVOT = 40.0, 0.4 / 1.56, 0.2, np.array([0.3, 0.0, 0.1])
ENGINE, THRUST, PERIOD = np.array([-1.0, 0.002, 0.0]), np.array([22.0, 0, 0]), 0.1
TIGHT = {"rtol": 1e-10, "atol": 1e-12}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return model_here("flexsat", tmp_path_factory.mktemp("flexsat"))


def crossing(a):
    return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


def moving(_, x, commands):
    """Return the rates of place and velocity of O, attitude, rate, wheels, modes, and place and velocity of the bob.

    Newton's law for hub and bob, Euler's for the hub with wheels and modes, and |bob - pivot| = l twice differentiated.
    """
    _, velocity, q, w, wheels, modes, paces, bob, falling = np.split(x, [3, 6, 10, 13, 17, 21, 25, 28])
    turn = Rotation.from_quat(q, scalar_first=True).as_matrix()
    arm = turn @ PIVOT
    rod = (bob - x[:3] - arm) / ROD
    slip = falling - velocity - turn @ np.cross(w, PIVOT)
    swing = slip / ROD - turn @ np.cross(w, turn.T @ rod)  # of the rod in the hub
    drag = LOSS * swing / ROD  # of the damper, at the ends of the rod
    couple = turn.T @ np.cross(rod, LOSS * swing)
    matrix, right = np.zeros((14, 14)), np.zeros(14)  # accelerations of O, hub, bob and modes; tension
    matrix[:3, :3], matrix[:3, 13] = MASS * np.eye(3), -rod
    right[:3] = turn @ THRUST + drag
    matrix[3:6, 3:6], matrix[3:6, 9:13] = INERTIA, DELTA.T
    matrix[3:6, 13] = -np.cross(PIVOT, turn.T @ rod)
    whole = INERTIA @ w + DELTA.T @ paces + AXES.T @ (SPIN * (wheels + AXES @ w))
    outside = np.cross(ENGINE, THRUST) + np.cross(PIVOT, turn.T @ drag) + couple
    right[3:6] = outside - np.cross(w, whole) - AXES.T @ commands
    matrix[6:9, 6:9], matrix[6:9, 13], right[6:9] = BOB * np.eye(3), rod, -drag
    matrix[9:13, 9:13], matrix[9:13, 3:6] = np.eye(4), DELTA
    right[9:13] = -2 * DAMPING * FREQUENCY * paces - FREQUENCY**2 * modes
    matrix[13, 6:9], matrix[13, :3], matrix[13, 3:6] = rod, -rod, rod @ turn @ crossing(PIVOT)
    right[13] = rod @ turn @ np.cross(w, np.cross(w, PIVOT)) - slip @ slip / ROD
    a = np.linalg.solve(matrix, right)
    turning = np.concatenate([[-q[1:] @ w], q[0] * w + np.cross(q[1:], w)]) / 2
    return np.concatenate([velocity, a[:3], turning, a[3:6], commands / SPIN - AXES @ a[3:6], paces, a[9:13],
                           falling, a[6:9]])  # fmt: skip


def by_hand(start, until):
    """Hold the commands of the law over each period, and return attitude, rates, wheels, modes and rod in the hub."""
    x, rows = start, []
    for _ in range(round(until / PERIOD) + 1):
        turn = Rotation.from_quat(x[6:10], scalar_first=True).as_matrix()
        rows.append([*x[6:21], *(turn.T @ (x[25:28] - x[:3]) - PIVOT) / ROD])
        commands = np.linalg.pinv(-AXES.T) @ (-20.0 * x[7:10] - 150.0 * x[10:13])
        commands /= max(1.0, np.abs(commands).max() / LARGEST)
        x = solve_ivp(moving, (0, PERIOD), x, "DOP853", args=(commands,), rtol=1e-10, atol=1e-12).y[:, -1]
    return np.array(rows)


def check(run, until, tolerance):
    names = [*(f"q{k}" for k in range(4)), "wx", "wy", "wz", *(f"wheel{k}_speed" for k in (1, 2, 3, 4)),
             *(f"panels_{k}" for k in (1, 2, 3, 4)), "tank_ex", "tank_ey", "tank_ez"]  # fmt: skip
    seen = np.stack([run[name].values for name in names], axis=1)
    q, x = seen[0, :4], np.zeros(31)
    x[6:10], x[25:28] = q, Rotation.from_quat(q, scalar_first=True).apply(PIVOT + ROD * seen[0, 15:])
    hand = by_hand(x, until)
    np.testing.assert_allclose(seen, hand, atol=tolerance)


def test_it_is_short():
    assert lines(ROOT / "docs" / "examples" / "models" / "flexsat") <= 40


def test_it_moves_like_bodies_in_inertial_axes(folder):
    """Steps of 0.1 s err by about 1e-13 rad/s; a hundred times that."""
    run = mehvar.simulate(folder, "turn", t_end=4.0, **TIGHT)
    check(run, 4.0, 1e-11)
    assert float(run.panels_1[-1]) > 0.08
    assert float(abs(run.u_wheel1_torque).max()) == LARGEST


@pytest.mark.soak
def test_it_moves_like_bodies_in_inertial_axes_to_the_end(folder):
    """By then the largest error is 1e-12 rad/s, of a wheel; a hundred times that."""
    check(mehvar.simulate(folder, "turn", **TIGHT), 120.0, 1e-10)
