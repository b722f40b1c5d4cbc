# SPDX-License-Identifier: Apache-2.0
"""Sensors show the truth without noise, and errors of the stated sizes with it."""

import functools

import numpy as np
import pytest
import sympy as sp
from scipy.spatial.transform import Rotation

import mehvar
from mehvar.base.errors import InputError, MehvarError
from mehvar.models.check import check
from mehvar.models.parts import (
    Accelerometer,
    Bob,
    Gyro,
    Hub,
    Magnetometer,
    Orbit,
    StarTracker,
    SunSensor,
    Tachometer,
    Thruster,
    Torquer,
    Wheel,
)
from tests.models.parts import table

HUB = Hub("hub", mass=10.0, inertia=(1.0, 1.5, 2.0))
WHEEL = Wheel("wheel", axis=(1, 0, 0), inertia=0.01)


craft_of = functools.partial(table.craft_of, HUB)


def shown(system, **values):
    """Return the measurement at values of states and errors, by name; all else is as at the start."""
    known = {q.symbol: q.default for q in (*system.parameters, *system.scenario_parameters)}
    known |= {q.symbol: sp.sympify(v).subs(known) for q, v in zip(system.states, system.initial, strict=True)}
    known |= {q.symbol: 0.0 for q in system.sensor.noise} | {sp.Symbol("t", real=True): 0.0}
    known |= {s: values[s.name] for s in known if s.name in values}

    def value(expr):
        for symbol in expr.free_symbols - known.keys():
            known[symbol] = value(system.definitions[symbol])
        return float(expr.xreplace(known))

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


def test_a_gyro_has_errors_of_scale_and_alignment_and_steps():
    """The small turn of the gyros is that of a rotation, to second order; numbers are whole multiples of the step."""
    errors = {"scale": (1e-3, -2e-3, 0.0), "misalignment": (2e-5, -1e-5, 3e-5)}
    rate = np.array([0.1, -0.2, 0.3])
    values = dict(zip(("wx", "wy", "wz"), rate, strict=True))
    for step in (None, 1e-4):
        system = craft_of(Gyro("gyro", **errors, step=step)).system()
        check(system)
        see = shown(system, **values)
        turned = Rotation.from_rotvec(errors["misalignment"]).inv().apply(rate) * (1 + np.array(errors["scale"]))
        expected = turned if step is None else step * np.round(turned / step)
        np.testing.assert_allclose([see[f"gyro_{a}"] for a in "xyz"], expected, rtol=1e-8)
    assert [see[f"gyro_{a}"] / 1e-4 for a in "xyz"] == pytest.approx([1001, -1996, 3000])


@functools.cache
def glared():
    tracker = StarTracker("tracker", boresight=(0, 2, 0), exclusion=0.45)
    system = craft_of(tracker, orbit=Orbit(tilt=0.0, size=7e6), attitude="euler").system()
    check(system)
    return system


@pytest.mark.parametrize(
    ("angle", "lit", "new"), [(0.5, True, 1.0), (0.4, True, 0.0), (0.4, False, 1.0)], ids=["off", "glare", "shadow"]
)
def test_a_tracker_is_blind_near_the_sun(angle, lit, new):
    """The Sun stands along x; the tracker looks along y of a hub that is turned about z."""
    see = shown(glared(), yaw=-np.pi / 2 + angle, orbit_x=7e6 if lit else -7e6)
    assert see["tracker_new"] == new


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


def variance(errors, count):
    """Return the Allan variance of errors, shape (runs, samples), over means of `count` samples; all overlap."""
    total = np.cumsum(np.insert(errors, 0, 0.0, axis=1), axis=1)
    second = total[:, 2 * count :] - 2 * total[:, count:-count] + total[:, : -2 * count]
    return (second**2).mean() / (2 * count**2)


EVERY, STEP = 4, 0.05
SIZES = {
    "gyro_noise": (1e-3, "gyro_y"), "mag_noise": (1e-9, "mag_x"), "sun_sigma": (2e-3, "sun_z"),
    "tacho_sigma": (0.3, "tacho"), "tracker_sigmay": (1e-4, "tracker_q2"), "acc_noise": (1e-3, "acc_z"),
}  # fmt: skip


@pytest.mark.soak
def test_allan_variances_are_those_of_the_densities():
    """White noise has sigma^2 / m over means of m measurements, a walk of the gyro's bias K^2 tau / 3 besides."""
    rate = {"every": EVERY}
    parts = (
        WHEEL, Gyro("gyro", noise=1e-3, walk=1e-3, **rate), Magnetometer("mag", noise=1e-9, **rate),
        SunSensor("sun", sigma=2e-3, **rate), Tachometer("tacho", of=WHEEL, sigma=0.3, **rate),
        StarTracker("tracker", sigma=(1e-4, 1e-4, 1e-4), **rate), Accelerometer("acc", noise=1e-3),
    )  # fmt: skip
    model = mehvar.build(craft_of(*parts, orbit=Orbit(), period=STEP))
    options = {"t_end": 200.0, "save": STEP * EVERY, "wheel_speed_0": 3.0, "dt_out": STEP * EVERY}
    still = dict.fromkeys(SIZES, 0.0) | {"gyro_walk": 0.0}
    truth = mehvar.batch(model, "watch", 1, **options, **(still | {"tracker_sigmax": 0.0, "tracker_sigmaz": 0.0}))

    def errors(runs, name):
        return (runs[f"{name}_shown"].values - truth[f"{name}_shown"].values)[:, 2:]

    noisy = mehvar.batch(model, "watch", 60, **options, gyro_walk=0.0)
    for parameter, (size, name) in SIZES.items():
        white = {"noise": size / np.sqrt(STEP * EVERY), "sigma": size, "sigmay": size / 2}[parameter.split("_")[1]]
        white *= np.sqrt(EVERY) if name == "acc_z" else 1  # it measures at each sample
        for count in (1, 3, 10, 30):
            assert variance(errors(noisy, name), count) == pytest.approx(white**2 / count, rel=0.1)
    walking = mehvar.batch(model, "watch", 60, **options, gyro_noise=0.0)
    for count in (10, 30, 100):
        tau = count * STEP * EVERY
        assert variance(errors(walking, "gyro_y"), count) == pytest.approx(1e-6 * tau / 3, rel=0.15)


def test_a_sensor_measures_at_its_turn_and_loses_a_share():
    tracker = StarTracker("tracker", every=3, dropout=0.25)
    model = mehvar.build(craft_of(WHEEL, tracker, Tachometer("tacho", of=WHEEL, dropout=0.5), period=0.1))
    seen = []

    def law(t, x):
        seen.append(np.stack([x.tracker_new, x.tracker_q0, x.tacho_new]))
        return 0 * x.tacho[None]

    mehvar.batch(model, law, 1000, period=0.1, t_end=6.0)
    new, q0, tacho = np.stack(seen, axis=1)
    assert not new[np.arange(len(new)) % 3 > 0].any()
    assert new[::3].mean() == pytest.approx(0.75, abs=0.01)
    assert tacho.mean() == pytest.approx(0.5, abs=0.01)
    np.testing.assert_array_equal(q0, new)  # it shows the truth, or zero


def test_measurements_arrive_late():
    """A tracker two samples late, with pictures at each third; a gyro one sample late that integrates; no noise."""
    tracker = StarTracker("tracker", sigma=(1e-4, 1e-4, 1e-4), every=3, delay=2)
    gyro = Gyro("gyro", walk=0.0, integrating=True, delay=1)
    model = mehvar.build(craft_of(WHEEL, tracker, gyro, Tachometer("tacho", of=WHEEL, delay=1), period=0.1))
    start = {"wx_0": 0.3, "wy_0": -0.5, "wz_0": 0.7, "gyro_bias_y_0": 0.01}
    run = mehvar.simulate(model, "watch", t_end=3.0, **start, **{f"tracker_sigma{a}": 0.0 for a in "xyz"})
    q = run["q1"].values
    last = [3 * ((k - 2) // 3) for k in range(5, 30)]
    np.testing.assert_array_equal(run["tracker_q1_shown"].values[6:], q[last])
    mean = run["gyro_mean_y"].values
    np.testing.assert_allclose(run["gyro_y_shown"].values[3:], mean[1:-2] + 0.01, rtol=1e-14)
    np.testing.assert_array_equal(run["tacho_shown"].values[3:], run["wheel_speed"].values[1:-2])


def test_a_gyro_that_integrates_has_the_turn_of_a_tumble():
    """At 1.8 rad/s the rotation vector of a period agrees with the attitudes at its ends to 1e-6 of a turn."""
    model = mehvar.build(craft_of(WHEEL, Gyro("gyro", walk=0.0, integrating=True), period=0.1))
    run = mehvar.simulate(model, "watch", t_end=10.0, wx_0=1.0, wy_0=-1.2, wz_0=0.9)
    turns = Rotation.from_quat(np.stack([run[f"q{k}"].values for k in range(4)], axis=1), scalar_first=True)
    means = np.stack([run[f"gyro_mean_{a}"].values for a in "xyz"], axis=1)
    np.testing.assert_allclose(0.1 * means[1:], (turns[:-1].inv() * turns[1:]).as_rotvec(), rtol=0, atol=2e-7)
    assert means[0].tolist() == [1.0, -1.2, 0.9]


@pytest.mark.parametrize("orbit", [None, Orbit("J2", inclination=1.7)], ids=["free", "orbit"])
def test_an_accelerometer_feels_thrust_and_turn_of_its_place_and_no_gravity(orbit):
    """Thrust F along x at the centre, torque M about z from rest: means of F/m - w^2 r and of r M/J over a period."""
    parts = (Thruster("jet", direction=(1, 0, 0)), Torquer("turn"), Accelerometer("acc", noise=1e-3, at=(0.4, 0, 0)))
    model = mehvar.build(craft_of(*parts, orbit=orbit, period=0.5))

    shown = []

    def law(t, x):
        shown.append(x.acc_y)
        return [5.0, 0.0, 0.0, 0.2]

    run = mehvar.simulate(model, law, period=0.5, dt_out=0.5, t_end=5.0, acc_noise=0.0, acc_bias_y_0=0.02)
    t, alpha = run["t"].values[1:], 0.2 / 2.0
    squared = alpha**2 * (t**2 - t * 0.5 + 0.5**2 / 3)
    seen = {axis: run[f"acc_mean_{axis}"].values[1:] for axis in "xyz"}
    np.testing.assert_allclose(seen["x"], 5.0 / 10 - 0.4 * squared, rtol=1e-9)
    np.testing.assert_allclose(seen["y"], 0.4 * alpha, rtol=1e-9)
    np.testing.assert_allclose(seen["z"], 0, atol=1e-12)
    np.testing.assert_allclose(shown[1:10], 0.4 * alpha + 0.02, rtol=1e-9)


def test_a_law_has_the_last_measurement():
    """A tracker that is blind until a turn has slowed down, and a gyro at each fourth sample."""
    craft = craft_of(WHEEL, StarTracker("tracker", blind=0.1, every=1), Gyro("gyro", every=4), period=0.1)

    def held_law(law):
        k, kd, bias = (
            law.parameter("k", 1.0, "N m"),
            law.parameter("kd", 1.0, "N m s"),
            law.parameter("T", -0.01, "N m"),
        )
        return {"wheel": k * law.attitude[1] + kd * law.rates[0] + bias}

    craft.law("held", held_law)
    run = mehvar.simulate(mehvar.build(craft), "held", t_end=3.0, wx_0=0.12, roll_0=0.2)
    x, q = run["wx"].values[:-1], run["q1"].values[:-1]
    k = np.arange(len(x))
    shown = np.where(x <= 0.1, q, 0.0)  # before the first picture a law has no turn
    np.testing.assert_allclose(run["u_cmd_wheel_torque"].values[:-1], shown + x[4 * (k // 4)] - 0.01, rtol=1e-12)
    assert 0 < np.count_nonzero(shown) < len(x)


@pytest.mark.parametrize(
    ("gyro", "words"),
    [
        ({"walk": 1e-5}, ""),
        ({"delay": 2}, r"change states at samples \(gyro_x_ago0"),
        ({"walk": 0.0, "integrating": True}, r"change states at samples \(gyro_angle_x"),
        ({"every": 3}, r"skip samples \(gyro_new"),
        ({"dropout": 0.3}, r"skip samples \(gyro_new"),
    ],
)
@pytest.mark.share(2)
def test_a_linear_loop_has_every_sensor_at_every_sample_or_is_refused(gyro, words):
    """Such a loop was linear without its rate feedback, or with every sample measured."""
    craft = craft_of(WHEEL, Gyro("gyro", **gyro), motion="attitude", period=0.25)
    craft.law("rate", lambda law: {"wheel": law.parameter("k", 0.2, "N m s") * law.rates[0]})
    model = mehvar.build(craft)
    if words:
        with pytest.raises(InputError, match=words):
            model.linearize(model.state(), controller="rate")
    else:
        eigenvalues = model.linearize(model.state(), controller="rate").eigenvalues
        assert np.abs(eigenvalues - (1 - 0.25 * 0.2 / 1.0)).min() < 1e-9  # 0.2 N m s on 1 kg m^2 for 0.25 s
        with pytest.raises(InputError, match=r"^x is impossible: q0 = 0 \("):
            model.linearize(np.zeros(len(model.state_names)))


def continuous(sensor):
    craft = craft_of(WHEEL, sensor)
    craft.law("own", lambda law: {"wheel": law.measured(sensor)[1]}, sampled=False)
    return craft.system()


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (
            lambda: continuous(StarTracker("tracker", every=2)),
            "law own is continuous, but tracker needs a sampled law: leave out sampled=False",
        ),
        (lambda: craft_of(Gyro("gyro", every=0)).system(), r"gyro_every = 0: must be a number in \[1, inf\)"),
        (lambda: craft_of(Gyro("gyro", dropout=1.0)).system(), r"gyro_dropout = 1.0: must be a number in \[0, 1\)"),
        (
            lambda: mehvar.simulate(mehvar.build(craft_of(Gyro("g", every=1.5))), "watch"),
            "g.every must be a whole number",
        ),
        (lambda: StarTracker("tracker", exclusion=0.5), "tracker.exclusion, boresight: give both"),
        (lambda: StarTracker("tracker", boresight=(1, 0, 0)), "tracker.exclusion, boresight: give both, or neither"),
        (
            lambda: craft_of(StarTracker("tracker", boresight=(1, 0, 0), exclusion=0.5)).system(),
            "tracker needs an orbit",
        ),
        (lambda: craft_of(Gyro("gyro", step=0.0)).system(), r"gyro_step = 0.0: must be a number in \(0, inf\)"),
        (
            lambda: Gyro("gyro", integrating=True),
            "gyro.walk = None: must be given for a sensor that integrates; 0 is allowed",
        ),
        (lambda: Accelerometer("acc", every=2), "acc integrates from sample to sample: leave out every and dropout"),
        (lambda: Gyro("gyro", delay=-1), "gyro.delay = -1: must be a whole number from 0 to 100"),
        (lambda: continuous(Gyro("gyro", walk=0.0, integrating=True)), "is continuous, but gyro needs a sampled law"),
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
