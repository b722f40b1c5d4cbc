# SPDX-License-Identifier: Apache-2.0
"""The triangle whose rods push: against masses in Cartesian coordinates, theory of libration, holonomy and MuJoCo."""

import mujoco
import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

from mehvar import batch, simulate
from mehvar.runtime import load
from mehvar.runtime.board.run import BoardRequest, run_on_board
from mehvar.runtime.model.model import Model
from tests.derived import variant
from tests.reference.cartesian_triangle import place, rods
from tests.tools import needs

EXACT = {"rtol": 1e-12, "atol": 1e-13, "method": "DOP853"}
"""Tolerances of SciPy: ten times tighter ones move no number here by more than 1e-11."""
ENDS = ((1, 2), (2, 0), (0, 1))
MASSES = (1.0, 2.0, 3.5)


def structure(folder, **choices: str) -> Model:
    for name, text in variant("triangle", **choices).items():
        (folder / name).write_text(text)
    return load(folder)


@pytest.fixture(scope="module")
def model(tmp_path_factory) -> Model:
    return structure(tmp_path_factory.mktemp("dynamic"), model="dynamic")


@pytest.fixture(scope="module")
def general(tmp_path_factory) -> Model:
    return structure(tmp_path_factory.mktemp("general"), model="dynamic", masses="general")


def state(model: Model, **values: float) -> np.ndarray:
    return np.array([values.get(name, 0.0) for name in model.state_names])


def inputs(model: Model, **values: float) -> np.ndarray:
    return np.array([values.get(name, 0.0) for name in model.input_names])


def column(model: Model, x: np.ndarray, name: str) -> np.ndarray:
    return x[..., model.state_names.index(name)]


def cartesian(X: np.ndarray, push: np.ndarray, thrust: np.ndarray, gravity: np.ndarray, m: np.ndarray) -> np.ndarray:
    """Accelerations of three masses: rods that push, thrust along and across rod 3, gravity per mass."""
    force = gravity * m[:, None]
    for k, (i, j) in enumerate(ENDS):
        along = (X[j] - X[i]) / np.linalg.norm(X[j] - X[i])
        force[j] += push[k] * along
        force[i] -= push[k] * along
    ahead = (X[1] - X[0]) / np.linalg.norm(X[1] - X[0])
    axes = np.array([ahead, [-ahead[1], ahead[0]]])
    return (force + thrust @ axes) / m[:, None]


def test_a_motion_is_that_of_three_masses_under_newtons_law(general):
    """Rods that push in time, thrust, an orbit of eccentricity 0.4; the masses begin at rest in fixed axes."""
    n, e, m = 0.7, 0.4, np.array(MASSES)
    p = general.parameters(mean_motion=n, eccentricity=e, m1=m[0], m2=m[1], m3=m[2])
    thrust = np.array([[0.1, -0.2], [0.05, 0.3], [-0.2, 0.1]])

    def push(t):
        return np.array([0.3 * np.sin(t), -0.2 * np.cos(2 * t), 0.1 + 0.2 * np.sin(3 * t)])

    X = place(0.5, 0.6, 0.7, 0.3, MASSES)

    def masses(t, y):
        X, V, nu = y[:6].reshape(3, 2), y[6:12].reshape(3, 2), y[12]
        distance = (1 - e**2) / (1 + e * np.cos(nu))
        r, about = np.array([np.cos(nu), np.sin(nu)]), X - m @ X / m.sum()
        tide = n**2 / distance**3 * (3 * np.outer(about @ r, r) - about)
        A = cartesian(X, push(t), thrust, tide, m)
        return np.concatenate([V.ravel(), A.ravel(), [n * np.sqrt(1 - e**2) / distance**2]])

    start = np.concatenate([X.ravel(), np.zeros(6), [0.2]])
    reference = solve_ivp(masses, (0, 0.4), start, **EXACT).y[:, -1]
    l1, l2, l3 = rods(X)
    psi = np.arctan2(*(X[1] - X[0])[::-1])

    def rate(t, x):
        return general.rhs(x, np.concatenate([push(t), thrust.ravel()]), p)

    x = solve_ivp(rate, (0, 0.4), state(general, l1=l1, l2=l2, l3=l3, psi=psi, nu=0.2), **EXACT).y[:, -1]
    X, V = reference[:6].reshape(3, 2), reference[6:12].reshape(3, 2)
    centre, drift = m @ X / m.sum(), m @ V / m.sum()
    H = m @ ((X - centre)[:, 0] * V[:, 1] - (X - centre)[:, 1] * V[:, 0])
    np.testing.assert_allclose(x[:3], rods(X), atol=1e-10)
    assert np.angle(np.exp(1j * (x[3] - np.arctan2(*(X[1] - X[0])[::-1])))) == pytest.approx(0, abs=1e-9)
    named = [column(general, x, name) for name in ("H", "nu", "vx", "vy")]
    np.testing.assert_allclose(named, [H, reference[12], *drift], atol=1e-10)


def test_the_gradient_is_that_of_an_inverse_square_field(model):
    """Masses a millionth of the distance apart; what the gradient leaves out is of that order."""
    near = 1e-6
    X, r = place(0.4, 0.5, 0.6, 0.3, (1, 1, 1)), np.array([np.cos(0.7), np.sin(0.7)])
    places = r + near * X
    field = -places / np.linalg.norm(places, axis=1)[:, None] ** 3
    tide = (field - field.mean(axis=0)) / near
    expected = [((X[j] - X[i]) @ (tide[j] - tide[i])) / np.linalg.norm(X[j] - X[i]) for i, j in ENDS]
    torque = np.sum(X[:, 0] * tide[:, 1] - X[:, 1] * tide[:, 0])
    psi = np.arctan2(*(X[1] - X[0])[::-1])
    x = state(model, l1=0.4, l2=0.5, l3=0.6, psi=psi, nu=0.7)
    rate = model.rhs(x, inputs(model), model.parameters(mean_motion=1.0))
    np.testing.assert_allclose(rate[4:8], [*expected, torque], atol=5e-6)


def rigid(model: Model, x: np.ndarray, p, duration: float, times=None) -> np.ndarray:
    """Move with rods that hold their lengths."""

    def rate(_, x):
        force = np.asarray(model.functions["forces"](x, np.zeros(3), p))
        return model.rhs(x, np.concatenate([force, np.zeros(6)]), p)

    return solve_ivp(rate, (0, duration), x, t_eval=times, **EXACT).y.T


@pytest.mark.parametrize("e", [0.0, 0.6])
def test_a_rigid_triangle_librates_as_theory_says(general, e):
    """theta'' = -(3/2) kappa (B - A)/C sin 2(theta - nu); on a circle, when small, at n sqrt(3 (B - A)/C)."""
    n, m = 0.9, np.array(MASSES)
    X = place(0.5, 0.4, 0.7, 0.0, MASSES)
    moments, axes = np.linalg.eigh((m[:, None] * X).T @ X)
    ratio, inertia = (moments[1] - moments[0]) / moments.sum(), moments.sum()
    long = axes[:, 1] * np.sign(axes[:, 1] @ (X[1] - X[0]))
    offset = np.arctan2(*(X[1] - X[0])[::-1]) - np.arctan2(*long[::-1])
    tilt, nu_rate = 1e-4 if e == 0 else 0.4, n * (1 + e) ** 2 / (1 - e**2) ** 1.5
    p = general.parameters(mean_motion=n, eccentricity=e, m1=m[0], m2=m[1], m3=m[2])
    l1, l2, l3 = rods(X)
    x = state(general, l1=l1, l2=l2, l3=l3, psi=offset + tilt, H=inertia * nu_rate)
    times = np.linspace(0, 12, 60)
    run = rigid(general, x, p, 12, times)
    away = column(general, run, "psi") - offset - column(general, run, "nu")
    if e == 0:
        np.testing.assert_allclose(away, tilt * np.cos(n * np.sqrt(3 * ratio) * times), atol=1e-6 * tilt + 1e-11)
        return

    def body(_, y):
        angle, rate, nu = y
        near = (1 + e * np.cos(nu)) / (1 - e**2)
        return [rate, -1.5 * n**2 * near**3 * ratio * np.sin(2 * (angle - nu)), n * np.sqrt(1 - e**2) * near**2]

    expected = solve_ivp(body, (0, 12), [tilt, nu_rate, 0.0], t_eval=times, **EXACT).y
    np.testing.assert_allclose(away, expected[0] - expected[2], atol=1e-9)


def loop_of_rods(radius: float, centre: float):
    """Rods on a circle in the shape disc, from rest to rest in one second: lengths and accelerations in time."""
    t = sp.Symbol("t")
    angle = 2 * sp.pi * t - sp.sin(2 * sp.pi * t)
    z1, z2 = centre + radius * sp.cos(angle), radius * sp.sin(angle)
    n, mu = sp.sqrt(1 - z1**2 - z2**2), sp.Rational(3, 10)
    angles = (-2 * sp.pi / 3, 2 * sp.pi / 3, 0)
    lengths = [sp.sqrt(mu / 3 * (1 + 2 * n * (z1 * sp.cos(a) - z2 * sp.sin(a)))) for a in angles]
    return sp.lambdify(t, lengths), sp.lambdify(t, [sp.diff(length, t, 2) for length in lengths])


def turns_by_twice_the_area(model, p, radius, centre):
    """Compare the turn after a loop of shapes with twice the area in the shape disc."""
    lengths, accelerations = loop_of_rods(radius, centre)
    l1, l2, l3 = lengths(0.0)

    def rate(t, x):
        force = np.asarray(model.functions["forces"](x, np.array(accelerations(t)), p))
        return model.rhs(x, np.concatenate([force, np.zeros(6)]), p)

    end = solve_ivp(rate, (0, 1), state(model, l1=l1, l2=l2, l3=l3), **EXACT).y[:, -1]
    np.testing.assert_allclose(end[:3], lengths(0.0), atol=1e-10)
    assert column(model, end, "psi") == pytest.approx(2 * np.pi * radius**2, abs=1e-10)


@pytest.mark.parametrize(("radius", "centre"), [(0.3, 0.0), (0.2, 0.3)])
@pytest.mark.share(2)
def test_a_loop_of_shapes_turns_by_the_kinematic_angle_without_gradient(model, radius, centre):
    turns_by_twice_the_area(model, model.parameters(), radius, centre)


def test_stiffer_tracking_comes_to_the_papers_motion_in_proportion(model):
    """The rods' rates lag by 1/k_v; half of it halves what theta is off the kinematic law."""
    kinematic = simulate("triangle", "path", dt_out=0.1).theta.values
    off = [np.abs(simulate(model, "path", k_v=k, dt_out=0.1).theta.values - kinematic).max() for k in (400, 800)]
    assert off[0] < 0.02
    assert off[1] == pytest.approx(off[0] / 2, rel=0.1)


def test_limits_bind_and_the_path_in_shape_stays(model):
    free = simulate(model, "path", dt_out=0.05)
    slow = simulate(model, "path", rate_max=0.05, dt_out=0.05)
    rate = np.abs(np.stack([slow[f"u_l{k}"].values for k in (1, 2, 3)]))
    assert np.abs(free.u_l1.values).max() > 0.1
    assert rate.max() < 0.05 * 1.01
    weak = simulate(model, "path", F_max=0.05, dt_out=0.05)
    push, asked = (np.abs(np.stack([weak[f"{name}_F{k}"].values for k in (1, 2, 3)])) for name in ("u", "u_cmd"))
    assert push.max() == 0.05
    assert asked.max() > 0.05


def test_thrust_holds_the_attitude_that_rods_alone_cannot_hold_in_orbit(model):
    alone, beside = (simulate(model, law, "orbit") for law in ("path", "path-thrust"))
    assert abs(float(alone.theta_error[-1])) > 0.01
    assert abs(float(beside.theta_error[-1])) < 1e-6
    assert np.abs(beside.H.values).max() < 1e-10
    assert max(np.abs(beside[name].values).max() for name in ("vx", "vy")) < 1e-12
    assert float(alone.impulse[-1]) == 0 < float(beside.impulse[-1])


@pytest.mark.soak
def test_a_batch_repeats_a_single_run(model):
    vary = {"H_0": "uniform(-0.0003, 0.0003)", "l1_0": "normal(0.2, 0.01)"}
    many = batch(model, "path", 4, vary=vary, seed=3, dt_out=0.5)
    values = {name: float(many[name][2]) for name in vary}
    single = simulate(model, "path", dt_out=0.5, **values)
    assert float(many.theta_final[2]) == float(single.theta_error[-1])


XML = """
<mujoco><option gravity="0 0 0"/><worldbody>
  <body><inertial pos="0 0 0" mass="{m[0]}" diaginertia="1e-12 1e-12 1e-12"/>
    <joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/><joint type="hinge" axis="0 0 1"/>
    <site name="one"/>
    <body><joint name="rod3" type="slide" axis="1 0 0"/><site name="two"/>
      <inertial pos="0 0 0" mass="{m[1]}" diaginertia="1e-12 1e-12 1e-12"/></body>
    <body><joint type="hinge" axis="0 0 1"/><inertial pos="0 0 0" mass="1e-9" diaginertia="1e-12 1e-12 1e-12"/>
      <body><joint name="rod2" type="slide" axis="1 0 0"/><site name="three"/>
        <inertial pos="0 0 0" mass="{m[2]}" diaginertia="1e-12 1e-12 1e-12"/></body></body>
  </body></worldbody>
  <tendon><spatial name="rod1"><site site="two"/><site site="three"/></spatial></tendon>
  <actuator><motor tendon="rod1"/><motor joint="rod2"/><motor joint="rod3"/></actuator>
</mujoco>"""


@pytest.mark.parametrize("seed", range(5))
def test_accelerations_are_mujocos(general, seed):
    """A hinge with two slides and a tendon: minimal coordinates of a free triangle, whose rods are actuators."""
    rng = np.random.default_rng(seed)
    l2, l3, angle = rng.uniform(0.5, 1.5), rng.uniform(0.5, 1.5), rng.uniform(0.6, 2.2)
    rate, push = rng.uniform(-1, 1, 6), rng.uniform(-2, 2, 3)
    world = mujoco.MjModel.from_xml_string(XML.format(m=MASSES))
    data = mujoco.MjData(world)
    data.qpos[:] = [0, 0, 0.4, l3, angle, l2]
    data.qvel[:] = rate
    data.ctrl[:] = push
    mujoco.mj_forward(world, data)
    turn, v3, opening, v2 = rate[2:]
    ahead = np.array([np.cos(angle), np.sin(angle)])
    across = np.array([-ahead[1], ahead[0]])
    place1, rate1 = l2 * ahead - [l3, 0], v2 * ahead + l2 * opening * across - [v3, 0]
    l1 = np.linalg.norm(place1)
    X = np.array([[0, 0], [l3, 0], l2 * ahead])
    V = np.array([[0, 0], [v3, l3 * turn], v2 * ahead + l2 * (turn + opening) * across])
    m = np.array(MASSES)
    X, V = X - m @ X / m.sum(), V - m @ V / m.sum()
    H = m @ (X[:, 0] * V[:, 1] - X[:, 1] * V[:, 0])
    x = state(general, l1=l1, l2=l2, l3=l3, psi=0.4, u_l1=place1 @ rate1 / l1, u_l2=v2, u_l3=v3, H=H)
    p = general.parameters(m1=m[0], m2=m[1], m3=m[2])
    result = general.rhs(x, inputs(general, F1=push[0], F2=push[1], F3=push[2]), p)
    assert column(general, result, "psi") == pytest.approx(turn, abs=1e-12)
    np.testing.assert_allclose(result[5:7], [data.qacc[5], data.qacc[3]], rtol=1e-7, atol=1e-7)


@pytest.mark.parametrize("law", ["sliding", "path", "path-thrust"])
@pytest.mark.parametrize("target", ["sil", pytest.param("unicorn", marks=needs("arm-none-eabi-gcc"))])
@pytest.mark.soak
def test_the_laws_have_the_same_bits_on_a_board(model, law, target):
    outcome = run_on_board(model, BoardRequest(law, target, samples=100))
    assert (outcome.max_ulp, outcome.x.ulp) == (0, 0)
    assert outcome.u.compared == outcome.single.u_cmd.size
