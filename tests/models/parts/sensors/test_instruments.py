# SPDX-License-Identifier: Apache-2.0
"""Sensors show the truth without noise, and errors of the stated sizes with it."""

import numpy as np
import pytest
import sympy as sp
from scipy.spatial.transform import Rotation

import mehvar
from mehvar.base.errors import MehvarError
from mehvar.models.check import check
from mehvar.models.parts import (
    Bob,
    Gyro,
    Hub,
    Magnetometer,
    Orbit,
    Spacecraft,
    StarTracker,
    SunSensor,
    Tachometer,
    Wheel,
)

HUB = Hub("hub", mass=10.0, inertia=(1.0, 1.5, 2.0))
WHEEL = Wheel("wheel", axis=(1, 0, 0), inertia=0.01)


def craft_of(*parts, **options):
    craft = Spacecraft("craft", **options)
    for part in (HUB, *parts):
        craft.add(part)
    return craft


def shown(system, **values):
    """Return the measurement at values of states and errors, by name; all else is as at the start."""
    known = {q.symbol: q.default for q in (*system.parameters, *system.scenario_parameters)}
    known |= {q.symbol: sp.sympify(v).subs(known) for q, v in zip(system.states, system.initial, strict=True)}
    known |= {q.symbol: 0.0 for q in system.sensor.noise} | {sp.Symbol("t", real=True): 0.0}
    known |= {s: values[s.name] for s in known if s.name in values}

    def value(expr):
        while expr.free_symbols - known.keys():
            expr = expr.xreplace(system.definitions)
        return float(expr.subs(known))

    return {q.name: value(e) for q, e in zip(system.sensor.seen, system.sensor.measured, strict=True)}


@pytest.mark.parametrize("attitude", ["quaternion", "euler", "mrp"])
def test_without_noise_a_sensor_shows_the_truth(attitude):
    tacho = Tachometer("tacho", of=WHEEL)
    system = craft_of(WHEEL, Gyro("gyro"), StarTracker("tracker"), tacho, attitude=attitude).system()
    check(system)
    assert not len(system.sensor.noise)
    assert system.random_step is None
    turn = Rotation.from_euler("ZYX", [0.5, -0.4, 0.3])
    q = turn.as_quat(scalar_first=True)
    at = dict(zip(("q0", "q1", "q2", "q3"), q, strict=True))
    at |= dict(zip(("roll", "pitch", "yaw"), (0.3, -0.4, 0.5), strict=True))
    at |= {f"mrp{k}": q[k] / (1 + q[0]) for k in (1, 2, 3)}
    see = shown(system, wx=0.1, wy=-0.2, wz=0.3, wheel_speed=50.0, **at)
    assert [see[f"gyro_{a}"] for a in "xyz"] == [0.1, -0.2, 0.3]
    assert see["tacho"] == 50.0
    np.testing.assert_allclose([see[f"tracker_q{k}"] for k in range(4)], q, rtol=1e-14)


def test_field_and_sun_are_those_of_the_orbit():
    """Over the equator at noon: the field to the north, weak, and the Sun above."""
    parts = (Magnetometer("mag"), SunSensor("sun"))
    system = craft_of(*parts, orbit=Orbit(tilt=0.0, size=7e6)).system()
    check(system)
    see = shown(system)
    np.testing.assert_allclose([see[f"mag_{a}"] for a in "xyz"], [0, 0, 7.9e15 / 7e6**3], atol=1e-20)
    assert [see[f"sun_{a}"] for a in "xyz"] == [1.0, 0.0, 0.0]
    dark = shown(system, orbit_x=-7e6)
    assert [dark[f"sun_{a}"] for a in "xyz"] == [0.0, 0.0, 0.0]


def test_errors_have_the_stated_sizes():
    parts = (
        WHEEL, Gyro("gyro", noise=2e-3), StarTracker("tracker", sigma=(1e-4, 2e-4, 3e-4)),
        Tachometer("tacho", of=WHEEL, sigma=0.5),
    )  # fmt: skip
    system = craft_of(*parts, period=0.25).system()
    check(system)
    one = {q.name: 1.0 for q in system.sensor.noise}
    see = shown(system, **one)
    assert [see[f"gyro_{a}"] for a in "xyz"] == pytest.approx([2e-3 / 0.5] * 3)
    assert see["tacho"] == 0.5
    assert [2 * see[f"tracker_q{k}"] for k in (1, 2, 3)] == pytest.approx([1e-4, 2e-4, 3e-4], rel=1e-6)
    assert sum(see[f"tracker_q{k}"] ** 2 for k in range(4)) == pytest.approx(1.0, abs=1e-15)


def test_a_gyro_at_rest_walks_as_its_densities_say():
    """The angle of the white noise alone grows by N sqrt(t), the bias by K sqrt(t), whatever the period."""
    model = mehvar.build(craft_of(WHEEL, Gyro("gyro", noise=1e-3, walk=1e-4)))
    seen = []

    def law(t, x):
        seen.append(np.array([x.gyro_x, x.gyro_y, x.gyro_z]))
        return 0 * x.gyro_x[None]

    for period in (0.1, 0.5):
        seen.clear()
        runs = mehvar.batch(model, law, 400, period=period, Ts=period, t_end=20.0, seed=3)
        bias = np.array([runs["final"].sel(state=f"gyro_bias_{a}").values for a in "xyz"])
        assert bias.std() == pytest.approx(1e-4 * np.sqrt(20.0), rel=0.1)  # of 1200 numbers: 2 % is one sigma
        angle = sum(block for block in seen[:-1]) * period
        expected = np.hypot(1e-3 * np.sqrt(20.0), 1e-4 * np.sqrt(20.0**3 / 3))
        assert angle.std() == pytest.approx(expected, rel=0.1)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Tachometer("tacho", of=HUB), "tacho.of = .*: must be a part of one degree of freedom"),
        (lambda: craft_of(Tachometer("tacho", of=WHEEL)).system(), "tacho.of: wheel is not on the craft; add it too"),
        (lambda: Tachometer("tacho", of=Bob("tank", mass=1.0, length=1.0)), "must be a part of one degree of freedom"),
        (lambda: craft_of(Magnetometer("mag")).system(), "mag needs an orbit"),
        (lambda: craft_of(Gyro("gyro", noise=-1.0)).system(), r"gyro_noise = -1.0: must be a number in \[0, inf\)"),
        (lambda: craft_of(Gyro("gyro"), period=0.0).system(), r"Ts = 0.0: must be a number in \(0, inf\)"),
    ],
)
def test_wrong_sensors_are_refused(make, words):
    with pytest.raises(MehvarError, match=words):
        make()
