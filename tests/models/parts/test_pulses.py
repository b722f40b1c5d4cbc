# SPDX-License-Identifier: Apache-2.0
"""Actuators that act during a part of each sample period, against closed forms."""

import json

import numpy as np
import pytest

import mehvar
from mehvar.base.errors import MehvarError
from mehvar.parts import Gyro, Hub, Magnetorquer, Orbit, StarTracker, Thruster
from mehvar.runtime.board.run import BoardRequest, run_on_board

from .table import craft_of

TS, FORCE, MASS = 0.5, 2.0, 10.0
HUB = Hub("hub", mass=MASS, inertia=(1.0, 2.0, 3.0))


@pytest.fixture(scope="module")
def model():
    craft = craft_of(HUB, Thruster("jet", direction=(1, 0, 0), limit=FORCE, pulsed=True), motion="plane", period=TS)
    craft.law("push", lambda law: {"jet": law.parameter("mean", 0.7, "N")})
    return mehvar.build(craft)


@pytest.mark.parametrize("mean", [-1.0, 0.0, 1e-9, 0.123, 0.7, 1.9999999, 2.0, 5.0])
def test_the_momentum_is_that_of_the_mean_force(model, mean):
    """Also at instants that are no samples, and with the place in between: the force acts at the begin of a period."""
    run = mehvar.simulate(model, "push", mean=mean, t_end=4.0, dt_out=0.25)
    force = min(max(mean, 0.0), FORCE)
    width = force / FORCE * TS
    begun, rest = np.divmod(run["t"].values, TS)
    speed = (begun * width + np.minimum(rest, width)) * FORCE / MASS
    np.testing.assert_allclose(run["vx"], speed, rtol=0, atol=1e-13)
    ends = json.loads(run.attrs["events"])["t"]
    np.testing.assert_allclose(ends, TS * np.arange(8) + width if force else [], rtol=0, atol=1e-12)


def test_runs_of_a_batch_are_exact_too(model):
    runs = mehvar.batch(model, "push", 64, vary={"mean": "uniform(0, 2)"}, t_end=4.0, dt_out=0.5)
    last = runs["final"].values[:, model.state_names.index("vx")]
    np.testing.assert_allclose(last, runs["mean"].values * 4.0 / MASS, rtol=0, atol=1e-13)


def test_a_law_with_another_period_ends_the_run(model):
    own = {"controller": lambda _t, _x: [0.7], "t_end": 4.0, "dt_out": 0.25, "period": 0.25}
    run = mehvar.simulate(model, **own)
    assert run.attrs["reason"].startswith("the pulses of jet need a command once per period: set hold or period to Ts")
    run = mehvar.simulate(model, **own, Ts=0.25)
    assert float(run["vx"][-1]) == pytest.approx(0.28, abs=1e-13)


def test_a_coil_is_off_while_the_field_is_measured():
    """The rate changes by the duty times the torque, which a field along z gives a dipole along x."""
    orbit, coil = Orbit(size=7e6, tilt=0.0, spin=0.0), Magnetorquer("coil", axis=(1, 0, 0), limit=1.0, duty=0.75)
    craft = craft_of(HUB, coil, period=TS, orbit=orbit)
    craft.law("on", lambda law: {"coil": -law.parameter("dipole", 0.5, "A m^2")})
    run = mehvar.simulate(mehvar.build(craft), "on", t_end=1.0, dt_out=0.125, rtol=1e-12, atol=1e-14)
    field = 7.9e15 / 7e6**3  # over the equator, to the north
    on = 0.375 * np.array([1 / 3, 2 / 3, 1, 1, 4 / 3, 5 / 3, 2, 2])
    np.testing.assert_allclose(run["wy"].values[1:], 0.5 * field / 2.0 * on, rtol=1e-5)


def test_thrusters_that_pulse_share_a_torque_and_fly_on_a_board():
    """Twelve thrusters, whose states and inputs outnumber the parameters; sensors with delays and without noise."""
    craft, jets = craft_of(HUB, Gyro("gyro", delay=1), StarTracker("tracker", delay=1), period=0.2), []
    for axis in np.eye(3):
        for side in (1, -1):
            for way in (1, -1):
                name, at = f"jet{len(jets)}", tuple(side * axis)
                direction = tuple(way * np.roll(axis, 1))
                jets.append(craft.add(Thruster(name, direction=direction, at=at, limit=0.5, pulsed=True)))

    def feedback(law):
        kp, kd, (_, *q), w = law.parameter("kp", 0.5, "N m"), law.parameter("kd", 1.5, "N m s"), law.attitude, law.rates
        return law.torque([-kp * a - kd * b for a, b in zip(q, w, strict=True)], jets)

    craft.law("feedback", feedback)
    model = mehvar.build(craft)
    run = mehvar.simulate(model, "feedback", t_end=60.0, roll_0=0.5, yaw_0=-0.8)
    assert max(abs(float(run[f"q{k}"][-1])) for k in (1, 2, 3)) < 1e-3
    outcome = run_on_board(model, BoardRequest("feedback", "sil", samples=50))
    assert (outcome.max_ulp, outcome.x.ulp) == (0, 0)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Thruster("jet", direction=(1, 0, 0), pulsed=True), "jet.limit is missing: a pulsed thruster needs"),
        (lambda: lonely(Thruster("jet", direction=(1, 0, 0), limit=1.0, pulsed=True)), "need a sampled law"),
        (
            lambda: lonely(Magnetorquer("coil", axis=(1, 0, 0), duty=0.0)),
            r"coil_duty = 0.0: must be a number in \(0, 1",
        ),
    ],
)
def test_what_cannot_pulse_is_refused(make, words):
    with pytest.raises(MehvarError, match=words):
        make()


def lonely(part):
    return craft_of(HUB, part, orbit=Orbit()).system()
