# SPDX-License-Identifier: Apache-2.0
"""Gemini and its Agena on a tether against two rigid bodies in inertial axes by Newton and Euler."""

from __future__ import annotations

import json

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import mehvar
from tests.examples.pages import ROOT, lines, model_here

MASS = np.array([3798.0, 3175.0])
INERTIA = np.array([[1600.0, 6700.0, 6700.0], [1500.0, 10000.0, 10000.0]])
MOUNTS = np.array([[2.7, 0, 0], [-3.5, 0, 0]])
LENGTH, STIFFNESS, DAMPING = 30.48, 200.0, 50.0
JET, BEGIN, END = np.array([0, -25.0, 0]), 600.0, 630.0
TIGHT = {"rtol": 1e-11, "atol": 1e-12}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return model_here("gemini", tmp_path_factory.mktemp("gemini"))


def line(x):
    """Return attitudes, mounts, direction, stretch and tension of a line that could also push."""
    place, velocity, turn, w = x[:, :3], x[:, 3:6], x[:, 6:10], x[:, 10:]
    turns = [Rotation.from_quat(q, scalar_first=True).as_matrix() for q in turn]
    arms = np.array([r @ m for r, m in zip(turns, MOUNTS, strict=True)])
    speeds = [v + r @ np.cross(rate, m) for v, r, rate, m in zip(velocity, turns, w, MOUNTS, strict=True)]
    reach = place[1] + arms[1] - place[0] - arms[0]
    size = np.linalg.norm(reach)
    stretch = size - LENGTH
    pace = reach @ (speeds[1] - speeds[0]) / size
    return turns, arms, reach / size, stretch, STIFFNESS * stretch + DAMPING * pace


def moving(_, x, pulls, jet):
    x = x.reshape(2, 13)
    turns, arms, along, _, tension = line(x)
    forces = np.outer([1, -1], along) * tension * pulls
    result = np.empty((2, 13))
    for k, (r, arm, force) in enumerate(zip(turns, arms, forces, strict=True)):
        q, w = x[k, 6:10], x[k, 10:]
        push = r @ JET * jet if k == 0 else 0
        turning = np.concatenate([[-q[1:] @ w], q[0] * w + np.cross(q[1:], w)]) / 2
        spin = (r.T @ np.cross(arm, force) - np.cross(w, INERTIA[k] * w)) / INERTIA[k]
        result[k] = [*x[k, 3:6], *(force + push) / MASS[k], *turning, *spin]
    return result.ravel()


def switch(_, x, *_options):
    """Return a number that is positive where the line is longer than without load and its tension is positive."""
    *_, stretch, tension = line(x.reshape(2, 13))
    return min(stretch * STIFFNESS, tension)


def by_hand(x, times):
    """Integrate from event to event, so that no step contains a jump of the tension."""
    t, rows, pulls = 0.0, [], False
    cuts = [c for c in (BEGIN, END) if c < times[-1]] + [times[-1]]
    for cut in cuts:
        while t < cut:
            event = lambda t, x, *o: switch(t, x, *o)  # noqa: E731
            event.terminal, event.direction = True, -1 if pulls else 1
            inside = times[(times > t + 1e-9) & (times < cut)]
            done = solve_ivp(moving, (t, cut), x, "DOP853", events=event, t_eval=[*inside, cut],
                             args=(pulls, BEGIN <= t < END), rtol=1e-11, atol=1e-12)  # fmt: skip
            rows += [*done.y.T]
            if done.status == 1:
                t, x, pulls = done.t_events[0][0], done.y_events[0][0], not pulls
            else:
                t, x = cut, done.y[:, -1]
    return np.array(rows).reshape(-1, 2, 13)


def states(run):
    """Return the place of the Agena from Gemini and the x axis of each body in inertial axes, and the rates."""
    turn = Rotation.from_quat(np.stack([run[f"q{k}"] for k in range(4)], axis=1), scalar_first=True)
    own = Rotation.from_quat(np.stack([run[f"agena_q{k}"] for k in range(4)], axis=1), scalar_first=True)
    rates = [np.stack([run[f"{name}w{a}"] for a in "xyz"], axis=1) for name in ("", "agena_")]
    place = turn.apply(np.stack([run[f"agena_{a}"] for a in "xyz"], axis=1))
    return np.hstack([place, turn.as_matrix()[:, :, 0], (turn * own).as_matrix()[:, :, 0], *rates])


def check(run, tolerance):
    x = np.zeros((2, 13))
    x[:, 6], x[1, :3], x[1, 3:6] = 1, [36.18, 0, 0], [0, 0.4, 0.02]
    rows = by_hand(x.ravel(), run.t.values)
    turns = [Rotation.from_quat(rows[:, k, 6:10], scalar_first=True).as_matrix()[:, :, 0] for k in (0, 1)]
    hand = np.hstack([rows[:, 1, :3] - rows[:, 0, :3], *turns, rows[:, 0, 10:], rows[:, 1, 10:]])
    np.testing.assert_allclose(states(run)[1:], hand, atol=tolerance)


def test_it_is_short():
    assert lines(ROOT / "docs" / "examples" / "models" / "gemini") <= 40


def test_the_bodies_move_as_by_newton_and_euler(folder):
    """Twice taut and slack again. The place errs by 1e-10 m, of instants of events; ten times that."""
    run = mehvar.simulate(folder, "spin", t_end=60.0, **TIGHT)
    assert json.loads(run.attrs["events"])["name"].count("agena_taut") == 4
    check(run, 1e-9)


@pytest.mark.soak
def test_the_bodies_move_as_by_newton_and_euler_to_the_end(folder):
    """The errors of 34 events grow to 4e-9 m; ten times that."""
    run = mehvar.simulate(folder, "spin", **TIGHT)
    check(run, 4e-8)


def test_momentum_stays_and_the_damper_takes_energy(folder):
    model, run = mehvar.load(folder), mehvar.simulate(folder, "spin", t_end=200.0, **TIGHT)
    x = np.stack([run[name].values for name in model.state_names], axis=1)
    energy = model.functions["energy"](x, model.parameters())
    assert np.diff(energy).max() < 1e-8 < 1.0 < energy[0] - energy[-1]
    momentum = model.functions["momentum"](x, model.parameters())[:, :3]
    assert np.ptp(np.linalg.norm(momentum, axis=1)) < 1e-7  # kg m/s, of 1270
