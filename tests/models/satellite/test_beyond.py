# SPDX-License-Identifier: Apache-2.0
"""The satellite beyond the paper against independent calculations: Newton, Kepler, Jacobi, and the paper's model."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation
from scipy.special import ellipj

import mehvar
from mehvar.models.satellite.system import system
from mehvar.models.system import ModelError
from mehvar.runtime.board.run import BoardRequest, run_on_board
from tests.models.satellite.beyond import MU, Newton, body_axes, column, craft, motion, names, place, state
from tests.models.satellite.loop import satellite
from tests.tools import needs

Q, W, H = ("q0", "q1", "q2", "q3"), ("wx", "wy", "wz"), ("h1", "h2", "h3", "h4")
TENSOR = np.array([[2.13, 0.05, -0.08], [0.05, 3.04, 0.06], [-0.08, 0.06, 3.09]])
AXES = np.array([[1.0, -1, -1, 1], [1, 1, -1, -1], [1, 1, 1, 1]])
JEOD = tomllib.loads((Path(__file__).parents[2] / "validation" / "jeod.toml").read_text(encoding="utf-8"))
"""Logs of NASA's JEOD, github.com/nasa/jeod, verif/SIM_dyncomp."""


@pytest.mark.soak
def test_a_revolution_of_an_ellipse_against_newtons_laws_in_inertial_axes():
    """Wheels that spin up, torquers and a residual dipole, from a tumble: attitude, rates and wheels after an orbit."""
    values = {"eccentricity": 0.4, "semi_major_axis": 1.2e7, "inclination": 1.1, "dipole_x": 0.1, "dipole_z": -0.2}
    model = craft()
    p = model.parameters(**values)
    x = state(q0=0.8, q1=0.2, q2=-0.4, q3=0.4, wx=0.002, wy=-0.001, wz=0.003, h1=0.02, h2=-0.01, h3=0.03, h4=0.01,
              anomaly=0.3, perigee=0.7, node=-1.1)  # fmt: skip
    x[:4] /= np.linalg.norm(x[:4])
    motors, dipole = np.array([2e-6, -1e-6, 3e-6, -2e-6]), np.array([0.3, -0.2, 0.1])
    times = np.linspace(0, 13000, 14)
    run = motion(x, np.concatenate([motors, dipole]), p, times)
    settings = {**values, "field_moment": 7.9e15}
    newton = Newton(TENSOR, AXES, np.full(4, 1.3e-5), MU)
    turn = body_axes(x, settings)
    whole = turn @ (TENSOR @ column(x, *W) + newton.axes @ column(x, *H))
    start = np.concatenate([*place(x, settings), turn.ravel(), whole, column(x, *H)])
    residual = np.array([0.1, 0, -0.2]) + dipole
    other = solve_ivp(
        lambda _t, y: newton.rate(y, motors, residual, 7.9e15),
        (0, times[-1]),
        start,
        "DOP853",
        times,
        rtol=1e-12,
        atol=1e-13,
    ).y.T
    for mine, theirs in zip(run, other, strict=True):
        np.testing.assert_allclose(body_axes(mine, settings), theirs[6:15].reshape(3, 3), atol=2e-7)
        np.testing.assert_allclose(place(mine, settings)[0], theirs[:3], rtol=0, atol=0.05)
        np.testing.assert_allclose(column(mine, *H), theirs[18:], atol=1e-12)


def test_place_against_keplers_equation():
    e, a = 0.89, 7e7
    p = craft().parameters(eccentricity=e, semi_major_axis=a)
    n = np.sqrt(MU / a**3)
    times = np.linspace(0, 2 * np.pi / n, 14)
    anomaly = column(motion(state(), np.zeros(7), p, times), "anomaly")[:, 0]
    for t, nu in zip(times, anomaly, strict=True):
        eccentric = brentq(lambda E, t=t: E - e * np.sin(E) - n * t, n * t - 1, n * t + 1, xtol=1e-14)
        expected = 2 * np.arctan2(np.sqrt(1 + e) * np.sin(eccentric / 2), np.sqrt(1 - e) * np.cos(eccentric / 2))
        assert abs(np.exp(1j * nu) - np.exp(1j * expected)) < 1e-8


def test_mean_drift_against_the_oblate_earth():
    """The mean of the node's rate over revolutions of the oblate Earth's own field, which has no averages."""
    J2, R, a, e, i = 1.08262668e-3, 6378137.0, 9e6, 0.15, 0.9
    p = craft().parameters(J2=J2, semi_major_axis=a, eccentricity=e, inclination=i)
    period = 2 * np.pi * np.sqrt(a**3 / MU)
    r, v = place(state(), {"semi_major_axis": a, "eccentricity": e, "inclination": i})

    def rate(_t: float, y: np.ndarray) -> np.ndarray:
        r, z = y[:3], y[2]
        size = np.linalg.norm(r)
        bulge = 1.5 * J2 * MU * R**2 / size**5 * (5 * z**2 / size**2 - np.array([1, 1, 3])) * r
        return np.concatenate([y[3:], -MU * r / size**3 + bulge])

    times = np.arange(0, 41) * period
    done = solve_ivp(rate, (0, times[-1]), np.concatenate([r, v]), "DOP853", times, rtol=1e-11, atol=1e-3).y.T
    normal = np.cross(done[:, :3], done[:, 3:])
    node = np.unwrap(np.arctan2(normal[:, 0], -normal[:, 1]))
    measured = np.polyfit(times, node, 1)[0]
    derived = craft().rhs(state(), np.zeros(7), p)[names("states").index("node")]
    assert abs(measured / derived - 1) < 0.01  # second order in J2, and where in its own oscillation the orbit began


def test_free_motion_of_a_full_tensor_against_jacobis_functions():
    """No orbit, no wheels: the asymmetric top in its principal axes is sn, cn and dn."""
    p = craft().parameters(mu=1e-30)
    moments, turn = np.linalg.eigh(TENSOR)
    (A, B, C), w0 = moments, np.array([0.05, 0.0, 0.3])
    twice, square = moments @ w0**2, moments**2 @ w0**2
    assert square > twice * B
    slow, fast = twice * C - square, square - twice * A
    size = np.sqrt(np.array([slow / (A * (C - A)), slow / (B * (C - B)), fast / (C * (C - A))]))
    speed = np.sqrt((C - B) * fast / (A * B * C))
    modulus = (B - A) * slow / ((C - B) * fast)
    times = np.linspace(0, 400, 50)
    sn, cn, dn, _ = ellipj(speed * times, modulus)
    sides = np.linalg.det(turn)
    expected = np.column_stack([size[0] * cn, -sides * size[1] * sn, size[2] * dn])
    start = turn @ w0
    run = motion(state(**dict(zip(W, start, strict=True))), np.zeros(7), p, times)
    in_axes = column(run, *W) @ turn
    signs = np.sign(expected[1] * in_axes[1])  # the middle axis of a tensor has no direction of its own
    np.testing.assert_allclose(in_axes, expected * signs, atol=1e-9)


def test_the_space_stations_tensor_as_jeod_logged_it():
    """Run 9B: a torque of 10 N m in axes that are not principal, which tests/validation turns into principal ones.

    The bound is that of tests/validation/against_jeod.py: 16 digits, and the last stage of a step of 1/32 s.
    """
    data = JEOD["torque"]
    inertia = np.array(data["inertia"])
    tensor = {f"I_{i + 1}_{j + 1}": inertia[i, j] for i in range(3) for j in range(i, 3)}
    p = craft().parameters(mu=1e-30, field_moment=0.0, **tensor, **{f"wheel_inertia_{k}": 1e-12 for k in range(1, 5)})
    motors = np.linalg.pinv(AXES / np.linalg.norm(AXES, axis=0))
    largest = np.abs([row["a"] for row in data["rows"]]).max()
    for row in data["rows"]:
        u = np.concatenate([motors @ [row["torque"], 0, 0], np.zeros(3)])
        x = state(**dict(zip(W, row["w"], strict=True)))
        np.testing.assert_allclose(column(craft().rhs(x, u, p), *W), row["a"], atol=1e-13 * largest, rtol=0)


def posed(inertia: np.ndarray, **values: float) -> np.ndarray:
    """Return the plant's parameters for a body with this tensor, wheels that weigh nothing and no field."""
    tensor = {f"I_{i + 1}_{j + 1}": inertia[i, j] for i in range(3) for j in range(i, 3)}
    wheels = {f"wheel_inertia_{k}": 1e-12 for k in range(1, 5)}
    return np.asarray(craft().parameters(field_moment=0.0, **tensor, **wheels, **values))


def pulled(inertia: np.ndarray, nadir: np.ndarray, radius: float, w: np.ndarray) -> np.ndarray:
    """Return the angular acceleration at a place on an ellipse of e = 0.3 that is so far from the Earth."""
    e, anomaly = 0.3, 1.0
    p = posed(inertia, mu=JEOD["mu"], eccentricity=e, semi_major_axis=radius * (1 + e * np.cos(anomaly)) / (1 - e**2))
    turn, _ = Rotation.align_vectors([[0, 0, 1]], [nadir])
    x = state(anomaly=anomaly, **dict(zip((*Q, *W), (*turn.as_quat(scalar_first=True), *w), strict=True)))
    return column(craft().rhs(x, np.zeros(7), p), *W)


def test_a_cylinder_on_an_ellipse_as_jeod_logged_it():
    """Runs 10A and 10D; the bound is that of tests/validation/against_jeod.py, for the same rows on a circle."""
    data = JEOD["gradient"]
    largest = np.abs([row["a"] for row in data["rows"]]).max()
    for row in data["rows"]:
        place, turn = np.array(row["r"]), np.array(row["T"])
        radius = np.linalg.norm(place)
        a = pulled(np.diag(data["inertia"]), turn @ -place / radius, radius, row["w"])
        np.testing.assert_allclose(a, row["a"], atol=3.7e-13 * largest, rtol=0)


def test_gravity_on_three_masses_as_jeod_has_it():
    """A full tensor in the gradient; the bound is how far JEOD's harmonics are from its own point masses."""
    data = JEOD["table"]
    masses, places = np.array(data["masses"]), np.array(data["places"])
    inertia = np.einsum("i,ijk", masses, np.einsum("ij,ij,kl->ikl", places, places, np.eye(3)))
    inertia -= np.einsum("i,ij,ik", masses, places, places)
    body = Rotation.from_euler("YZX", np.radians(data["pitch_yaw_roll_deg"])).as_matrix().T
    for row in data["rows"]:
        lat, lon = np.radians([row["lat"], row["lon"]])
        up = np.array([np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)])
        torque = inertia @ pulled(inertia, body @ -up, data["radius"], np.zeros(3))
        np.testing.assert_allclose(torque, row["harmonic"], atol=2.1e-6 * np.abs(row["harmonic"]).max(), rtol=0)


def test_five_free_minutes_of_the_space_station_as_jeod_logged_them():
    """Run 9B after its torque: rates and attitude by the tensor in body axes, without an orbit."""
    rows = [row for row in JEOD["torque"]["rows"] if not row["torque"]]
    p = posed(np.array(JEOD["torque"]["inertia"]), mu=1e-30)
    turns = [Rotation.from_quat([q[0], *(-np.array(q[1:]))], scalar_first=True) for q in (r["q"] for r in rows)]
    x = state(**dict(zip((*Q, *W), (*turns[0].as_quat(scalar_first=True), *rows[0]["w"]), strict=True)))
    run = motion(x, np.zeros(7), p, np.array([float(row["t"]) for row in rows]))
    size = np.linalg.norm(rows[0]["w"])
    for y, row, turn in zip(run, rows, turns, strict=True):
        np.testing.assert_allclose(column(y, *W), row["w"], atol=1.1e-12 * size, rtol=0)
        here = Rotation.from_quat(column(y, *Q), scalar_first=True)
        np.testing.assert_allclose(here.as_matrix(), turn.as_matrix(), atol=1.1e-12)


def test_wheels_turn_the_body_and_the_whole_keeps_its_momentum():
    p = craft().parameters(mu=1e-30, field_moment=0.0)
    x = state(q0=0.5, q1=0.5, q2=-0.5, q3=0.5, wx=0.02, wy=-0.01, wz=0.03, h1=0.2, h2=-0.1, h4=0.3)
    run = motion(x, np.array([0.01, -0.02, 0.015, 0.005, 0, 0, 0]), p, np.linspace(0, 60, 7))
    whole = np.array([np.ravel(craft().functions["momentum"](row, p)) for row in run])
    assert np.abs(column(run, *W)[-1] - column(x, *W)).max() > 0.1
    np.testing.assert_allclose(whole, np.tile(whole[0], (len(whole), 1)), atol=1e-11)
    np.testing.assert_allclose(np.linalg.norm(column(run, *Q), axis=1), 1, atol=1e-10)


def test_with_the_papers_numbers_it_moves_as_the_papers_model():
    """Wheels along the axes, a diagonal tensor, a circle: the quaternion form of the paper's plant."""
    paper = mehvar.load(satellite("quaternion").folder)
    here = {"umax": 1.0, "hmax": 3.0, "dipole_x": 0.1, "dipole_y": -0.3, "air_density": 1e-12, "wheel_friction": 1e-5}
    spin = np.array([1.47e-5, 1.26e-5, 1.26e-5])
    axes = np.column_stack([np.eye(3), [1, 0, 0]])  # the fourth holds nothing and hardly weighs
    tensor = {f"I_{i + 1}_{j + 1}": float(i == j) * (2.13, 3.04, 3.09)[i] for i in range(3) for j in range(i, 3)}
    wheels = {f"wheel_axes_{i + 1}_{k + 1}": axes[i, k] for i in range(3) for k in range(4)}
    wheels |= {f"wheel_inertia_{k + 1}": value for k, value in enumerate((*spin, 1e-15))}
    radius = (MU / 1.083077791e-3**2) ** (1 / 3)
    mine = craft().parameters(**here, **tensor, **wheels, semi_major_axis=radius, scale_height=1e30)
    theirs = paper.parameters(**here, orbit_radius=radius)
    random = np.random.default_rng(3)
    states, theirs_states = names("states"), [q.name for q in paper.manifest.states]
    for _ in range(20):
        q, w, h, u = (
            random.normal(size=4),
            random.normal(0, 0.01, 3),
            random.normal(0, 0.1, 3),
            random.normal(0, 0.1, 3),
        )
        q /= np.linalg.norm(q)
        latitude = random.uniform(-3, 3)
        left = state(**dict(zip(Q, q, strict=True)), **dict(zip(W, w, strict=True)), anomaly=latitude,
                     **dict(zip(H, (*h, 1e-15 * w[0]), strict=True)))  # fmt: skip
        right = np.concatenate([q, w, h, [latitude]])
        a, b = craft().rhs(left, np.concatenate([u, np.zeros(4)]), mine), paper.rhs(right, u, theirs)
        for name, other in zip(
            (*Q, *W, "h1", "h2", "h3", "anomaly"), (*Q, *W, "hx", "hy", "hz", "latitude"), strict=True
        ):
            assert a[states.index(name)] == pytest.approx(b[theirs_states.index(other)], rel=1e-9, abs=1e-13)


@pytest.mark.soak
def test_wheels_without_imbalance_move_as_balanced_ones():
    none = {f"{name}_imbalance_{k}": 0.0 for name in ("static", "dynamic") for k in range(1, 5)}
    spin = {f"wheel_inertia_{k}": 8e-4 for k in range(1, 5)}
    here = {"eccentricity": 0.3, "dipole_x": 0.1, "wheel_friction": 1e-5, "air_density": 1e-12, **spin}
    shaken, balanced = craft("unbalanced"), craft()
    p, q = shaken.parameters(**here, **none), balanced.parameters(**here)
    random, known = np.random.default_rng(3), names("states")
    places = [names("states", "unbalanced").index(name) for name in known]
    for _ in range(20):
        x, u = random.normal(0, 0.1, len(known)), random.normal(0, 0.1, len(names("inputs")))
        x[:4] /= np.linalg.norm(x[:4])
        y = random.normal(0, 3, len(names("states", "unbalanced")))
        y[places] = x
        expected = balanced.rhs(x, u, q)
        np.testing.assert_allclose(shaken.rhs(y, u, p)[places], expected, rtol=1e-12, atol=1e-15)
        for name in ("energy", "momentum"):
            left, right = shaken.functions[name](y, p), balanced.functions[name](x, q)
            np.testing.assert_allclose(left, right, rtol=1e-12, atol=1e-15)


@pytest.mark.soak
def test_wheels_off_balance_shake_the_body_by_what_is_off():
    """At steady speed a force U_s W^2 and a moment U_d W^2 turn with the wheel, and the whole swings."""
    static, dynamic, speed, span = 5e-6, 1e-6, 300.0, 0.2
    none = {f"{name}_imbalance_{k}": 0.0 for name in ("static", "dynamic") for k in range(1, 5)}
    values = {"mu": 1e-30, "field_moment": 0.0, "static_imbalance_1": static, "dynamic_imbalance_1": dynamic}
    p = craft("unbalanced").parameters(**{**none, **values})
    x, times = state("unbalanced", h1=8e-4 * speed), np.linspace(0, span, 2001)
    run = motion(x, np.zeros(7), p, times, "unbalanced")
    angle, w = column(run, "angle1", wheels="unbalanced")[:, 0], column(run, *W, wheels="unbalanced")
    axis, r = AXES[:, 0] / np.sqrt(3), np.array([0.1, 0.1, 0.0])
    turn = np.cross([0, 0, 1], axis)
    first = np.eye(3)[0] + np.cross(turn, np.eye(3)[0]) + np.cross(turn, np.cross(turn, np.eye(3)[0])) / (1 + axis[2])
    heavy = np.cos(angle)[:, None] * first + np.sin(angle)[:, None] * np.cross(axis, first)
    ahead = np.cos(angle)[:, None] * np.cross(axis, first) - np.sin(angle)[:, None] * first
    whole = TENSOR + 8e-4 * (AXES @ AXES.T) / 3
    moment = speed**2 * (static * np.cross(r, heavy) + dynamic * ahead)
    expected = np.linalg.solve(whole, moment.T).T
    found = np.gradient(w, times, axis=0, edge_order=2)
    size = np.abs(expected).max()
    assert size > 0.01
    np.testing.assert_allclose(found[1:-1], expected[1:-1], atol=2e-3 * size)  # differences: (W dt)^2/6 is 1.5e-4


@pytest.mark.soak
def test_the_whole_keeps_momentum_and_energy_with_wheels_off_balance():
    values = {f"static_imbalance_{k}": 2e-3 for k in range(1, 5)} | {
        f"dynamic_imbalance_{k}": 2e-4 for k in range(1, 5)
    }
    model = craft("unbalanced")
    p = model.parameters(mu=1e-30, field_moment=0.0, **values)
    x = state("unbalanced", q0=0.5, q1=0.5, q2=-0.5, q3=0.5, wx=0.02, wy=-0.01, wz=0.03, h1=0.05, h2=-0.03, h3=0.04)
    run = motion(x, np.zeros(7), p, np.linspace(0, 5, 6), "unbalanced")
    whole = np.array([np.ravel(model.functions["momentum"](row, p)) for row in run])
    energy = np.array([float(np.ravel(model.functions["energy"](row, p))[0]) for row in run])
    np.testing.assert_allclose(whole, np.tile(whole[0], (len(whole), 1)), atol=1e-11)
    np.testing.assert_allclose(energy, energy[0], rtol=1e-10)
    swing = np.ptp(column(run, *W, wheels="unbalanced"), axis=0)
    assert swing.min() > 1e-3


@pytest.mark.soak
@pytest.mark.parametrize(
    ("value", "message"),
    [({"mass": 1e-9}, "is not more than that of the wheels"), ({"dynamic_imbalance_2": 1e-3}, "dynamic_imbalance")],
)
def test_imbalances_of_no_wheel_are_refused(value, message):
    with pytest.raises(mehvar.MehvarError, match=message):
        mehvar.simulate(craft("unbalanced"), "quaternion", t_end=1.0, **value)


def test_eclipse_is_a_cylinder():
    """Fraction of a circular orbit in shadow: 2 asin(R/a)/(2 pi) with the Sun in its plane."""
    model = craft()
    p = model.parameters(solar_pressure=4.56e-6, sun_ascension=0.0, inclination=0.0)
    dark = []
    for anomaly in np.linspace(-np.pi, np.pi, 4001)[:-1]:
        y = model.functions["outputs"](state(anomaly=anomaly), np.zeros(7), np.zeros(len(names("references"))), p)
        torque = np.array([y[names("outputs").index(f"Tenv_{i}")] for i in "xyz"])
        dark.append(np.abs(torque).max() == 0)
    assert abs(np.mean(dark) - np.arcsin(6378137.0 / 6978137.0) / np.pi) < 1 / 2000


def test_laws_settle_and_torquers_unload_and_detumble():
    off = {
        law: mehvar.simulate(craft(), law, scenario="ellipse", t_end=199.5)
        for law in ("quaternion", "sliding", "mrac", "pd")
    }
    late = {law: float(run.pointing.values[-50:].max()) for law, run in off.items()}
    assert late["quaternion"] < 5e-4
    assert late["mrac"] < 2e-3
    assert late["sliding"] < 0.03
    assert late["pd"] > 0.1  # the paper's gains are as slow here
    unloaded = mehvar.simulate(craft(), "quaternion", scenario="unload")
    assert unloaded.stored.values[-1] < 0.05 * unloaded.stored.values[0]
    assert unloaded.pointing.values[-500:].max() < 1e-3
    tumble = mehvar.simulate(craft(), "b-dot", scenario="tumble")
    assert tumble.tumbling.values[-1] < 4 * 1.08e-3 < 0.06 < tumble.tumbling.values[0]


def test_the_bias_of_the_gyro_is_learnt_from_the_star_tracker():
    bias = {"bias_x_0": 2e-4, "bias_y_0": -1e-4, "bias_z_0": 3e-4}
    held = {"t_end": 3600.0, "roll_step_deg": 0.0, "pitch_step_deg": 0.0, **bias}
    learnt, trusted = (mehvar.simulate(craft(), "quaternion", bias_gain=gain, **held) for gain in (0.01, 0.0))
    for axis, value in zip("xyz", bias.values(), strict=True):
        assert float(learnt[f"bias_est_{axis}"].values[-1]) == pytest.approx(value, rel=0.02, abs=2e-6)
    assert learnt.pointing.values[-1] < 1e-4 < 1e-3 < trusted.pointing.values[-1]


def test_the_safe_mode_turns_the_panels_to_the_sun_out_of_the_shadow():
    run = mehvar.simulate(craft(), "sun", t_end=5800.0, sun_declination=0.3, roll_0_deg=120.0)
    x = np.stack([run[name].values for name in names("states")], axis=-1)
    sun = np.array([np.cos(0.3), 0, np.sin(0.3)])
    settings = {"inclination": 1.710422666954443}
    panels = np.array([body_axes(row, settings) @ [0, 0, -1] for row in x[::200]])
    angle = np.arccos(np.clip(panels @ sun, -1, 1))
    assert angle[0] > 0.5
    assert np.median(angle) < 0.03


@pytest.mark.parametrize(
    ("law", "wheels"),
    [("quaternion", "any"), ("sliding", "any"), ("b-dot", "any"), ("sun", "any"), ("quaternion", "unbalanced")],
)
@pytest.mark.soak
def test_a_board_computes_the_same_bits(law, wheels):
    outcome = run_on_board(craft(wheels), BoardRequest(law, "sil", samples=200))
    assert (outcome.max_ulp, outcome.x.ulp, outcome.u.compared) == (0, 0, 200 * 7)


@needs("arm-none-eabi-gcc")
@pytest.mark.soak
def test_an_emulated_processor_computes_the_same_bits():
    request = BoardRequest("quaternion", "unicorn", "stm32f4", "gcc", samples=60, selftest=4, profiled=False)
    outcome = run_on_board(craft(), request)
    assert (outcome.max_ulp, outcome.x.ulp) == (0, 0)
    assert outcome.stats["stack_used"] <= outcome.bound.bytes


@pytest.mark.parametrize(
    ("values", "text"),
    [
        ({"field_moment": 0.0}, "torquers need a field"),
        ({f"wheel_axes_{i}_1": 0.0 for i in (1, 2, 3)}, "a wheel needs an axis"),
        ({f"wheel_axes_3_{k}": 0.0 for k in (1, 2, 3, 4)}, "lie in a plane"),
    ],
)
def test_what_a_choice_divides_by_is_named_where_it_is_zero(values: dict[str, float], text: str) -> None:
    with pytest.raises(mehvar.InputError, match=text):
        mehvar.simulate(craft(), "quaternion", t_end=1.0, **values)


def test_instruments_are_refused_without_the_laws_that_read_them() -> None:
    with pytest.raises(ModelError, match=r"sensors = 'instruments' .* needs torquers = 'three'"):
        system(sensors="instruments", torquers="three")
