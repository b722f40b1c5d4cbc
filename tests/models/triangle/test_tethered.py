# SPDX-License-Identifier: Apache-2.0
"""The triangle on tethers: against masses in Cartesian coordinates, the kinematic law, theory of a spin and MuJoCo."""

import json

import mujoco
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from mehvar import batch, simulate
from mehvar.models.quantities import ModelError
from mehvar.runtime import load
from mehvar.runtime.board.run import BoardRequest, run_on_board
from mehvar.runtime.model.model import Model
from tests.derived import system, variant
from tests.reference.cartesian_triangle import rods
from tests.reference.scipy_loop import by_scipy
from tests.tools import needs

EXACT = {"rtol": 1e-12, "atol": 1e-13, "method": "DOP853"}
"""Of SciPy: ten times looser moves no number here by more than 1e-10."""
ENDS = ((1, 2), (2, 0), (0, 1))
MASSES = np.array([1.0, 2.0, 3.5])
SIZE = np.sqrt(0.43 / 0.17)
START = {"l1_0": 0.2 * SIZE, "l2_0": 0.2 * SIZE, "l3_0": 0.3 * SIZE}
"""The paper's first shape at the size of its target, so that nothing but the path changes the spin."""


def structure(folder, **choices: str) -> Model:
    for name, text in variant("triangle", model="tethered", **choices).items():
        (folder / name).write_text(text)
    return load(folder)


@pytest.fixture(scope="module")
def model(tmp_path_factory) -> Model:
    return structure(tmp_path_factory.mktemp("tethered"))


@pytest.fixture(scope="module")
def general(tmp_path_factory) -> Model:
    return structure(tmp_path_factory.mktemp("general"), masses="general")


def lengths(run) -> np.ndarray:
    return np.stack([run[f"l{k}"].values for k in (1, 2, 3)])


def tensions(run) -> np.ndarray:
    return np.stack([run[f"T{k}"].values for k in (1, 2, 3)])


class Masses:
    """Three masses on tethers in fixed axes: places, velocities, true anomaly, natural lengths, rates of reels."""

    def __init__(self, model: Model, law: str, p, r, **tether: float) -> None:
        self.model, self.law, self.p, self.r = model, model.functions[law.replace("-", "_")], p, r
        self.c = model.law_parameters(law, R=0.45)
        self.k, self.damping, self.k_r, self.n, self.e = (tether[name] for name in ("k", "c", "k_r", "n", "e"))

    def pull(self, y: np.ndarray) -> np.ndarray:
        X, V, s, w = y[:6].reshape(3, 2), y[6:12].reshape(3, 2), y[13:16], y[16:19]
        edges = np.array([X[j] - X[i] for i, j in ENDS])
        length = np.linalg.norm(edges, axis=1)
        rate = np.array([edges[k] @ (V[j] - V[i]) for k, (i, j) in enumerate(ENDS)]) / length
        return self.k * (length / s - 1) + self.damping * (rate - length / s * w)

    def seen(self, t: float, y: np.ndarray) -> np.ndarray:
        """State of the model, whose heading counts whole turns."""
        X, V = y[:6].reshape(3, 2), y[6:12].reshape(3, 2)
        edges = np.array([X[j] - X[i] for i, j in ENDS])
        length = np.linalg.norm(edges, axis=1)
        rate = np.array([edges[k] @ (V[j] - V[i]) for k, (i, j) in enumerate(ENDS)]) / length
        about, drift = X - MASSES @ X / MASSES.sum(), V - MASSES @ V / MASSES.sum()
        H = MASSES @ (about[:, 0] * drift[:, 1] - about[:, 1] * drift[:, 0])
        about_here = self.r(t)[3]
        psi = about_here + np.angle((edges[2, 0] + 1j * edges[2, 1]) * np.exp(-1j * about_here))
        return np.concatenate([length, [psi], rate, [H, y[12], 0, 0, 0, 0], y[13:]])

    def __call__(self, t: float, y: np.ndarray) -> np.ndarray:
        X, nu = y[:6].reshape(3, 2), y[12]
        u = np.asarray(self.law(self.seen(t, y), self.r(t), self.p, self.c))
        near = (1 + self.e * np.cos(nu)) / (1 - self.e**2)
        r, about = np.array([np.cos(nu), np.sin(nu)]), X - MASSES @ X / MASSES.sum()
        force = MASSES[:, None] * self.n**2 * near**3 * (3 * np.outer(about @ r, r) - about)
        for (i, j), demand in zip(ENDS, self.pull(y), strict=True):
            along = (X[j] - X[i]) / np.linalg.norm(X[j] - X[i])
            force[i] += max(0, demand) * along
            force[j] -= max(0, demand) * along
        ahead = (X[1] - X[0]) / np.linalg.norm(X[1] - X[0])
        force += u[3:].reshape(3, 2) @ np.array([ahead, [-ahead[1], ahead[0]]])
        kepler = self.n * near**2 * np.sqrt(1 - self.e**2)
        return np.concatenate(
            [y[6:12], (force / MASSES[:, None]).ravel(), [kepler], y[16:19], self.k_r * (u[:3] - y[16:19])]
        )

    def run(self, y: np.ndarray, end: float) -> tuple[np.ndarray, list[float]]:
        """Move, in pieces between the instants at which a tether becomes slack or taut; return these too."""
        events = [lambda _, y, k=k: self.pull(y)[k] for k in range(3)]
        for event in events:
            event.terminal = True
        t, instants = 0.0, []
        while True:
            piece = solve_ivp(self, (t, end), y, events=events, **EXACT)
            t, y = piece.t[-1], piece.y[:, -1]
            if piece.status == 0:
                return y, instants
            if not instants or t - instants[-1] > 1e-9:
                instants.append(t)
            t, y = t + 1e-12, y + 1e-12 * self(t, y)


def test_a_motion_with_slack_is_that_of_three_masses_under_newtons_law(general):
    """Reels under the path law beside thrust, an orbit of eccentricity 0.4, tethers two centimetres too long."""
    n, e, end = 0.7, 0.4, 1.0
    m = {f"m{k}": float(value) for k, value in enumerate(MASSES, 1)}
    settings = {"mean_motion": n, "eccentricity": e, "slack_0": 0.02, "nu_0": 0.2, "H_0": 0.1, "u_l1_0": 0.2, **m}
    run = simulate(
        general, "path-thrust", "spin", t_end=end, dt_out=0.01, method="dop853", rtol=1e-12, atol=1e-13, **settings
    )
    found = json.loads(run.attrs["events"])["t"]
    first = np.array([float(run[name][0]) for name in general.state_names])
    l1, l2, l3, psi = first[:4]
    along = (l2**2 + l3**2 - l1**2) / (2 * l3)
    corners = np.array([[0, 0], [l3, 0], [along, np.sqrt(l2**2 - along**2)]])
    c, s = np.cos(psi), np.sin(psi)
    X = (corners - MASSES @ corners / MASSES.sum()) @ np.array([[c, s], [-s, c]])
    left, right = np.zeros((6, 6)), np.array([*first[4:8], 0, 0])
    for k, (i, j) in enumerate(ENDS):
        way = (X[j] - X[i]) / np.linalg.norm(X[j] - X[i])
        left[k, 2 * j : 2 * j + 2], left[k, 2 * i : 2 * i + 2] = way, -way
    for i, mass in enumerate(MASSES):
        left[3, 2 * i : 2 * i + 2] = -mass * X[i, 1], mass * X[i, 0]
        left[4, 2 * i] = left[5, 2 * i + 1] = mass
    p = general.parameters(mean_motion=n, eccentricity=e, **m)
    values = json.loads(run.attrs["parameters"])
    scenario = np.array([values[q.name] for q in general.manifest.scenario_parameters])

    def reference(t):
        return general.functions["reference"](t, p, scenario)

    masses = Masses(general, "path-thrust", p, reference, k=1000.0, c=10.0, k_r=20.0, n=n, e=e)
    y, instants = masses.run(np.concatenate([X.ravel(), np.linalg.solve(left, right), first[8:9], first[13:19]]), end)
    last = {name: float(run[name][-1]) for name in general.state_names}
    expected = dict(zip(general.state_names, masses.seen(end, y), strict=True))
    compared = [name for name in last if name not in ("vx", "vy", "work", "impulse")]
    np.testing.assert_allclose([last[k] for k in compared], [expected[k] for k in compared], atol=1e-7)
    assert len(found) == len(instants) > 5
    np.testing.assert_allclose(found, instants, atol=1e-8)


def test_stiff_tethers_on_fast_reels_come_to_the_papers_motion(model):
    """In a spin of the target's size the attitude beside it is the kinematic triangle's; reels lag by 1/k_r."""
    choices = {"R": 0.45, "dt_out": 0.1, "t_end": 20, **START}
    kinematic = simulate("triangle", "path", **choices)

    def off(spin: float, k_r: float) -> float:
        run = simulate(model, "path", "spin", spin=spin, k_r=k_r, stiffness=25 * k_r**2, damping=k_r, **choices)
        assert tensions(run).min() > 0
        return float(np.abs(run.theta_error.values - kinematic.theta_error.values).max())

    slow = off(4, 80)
    assert slow < 0.03
    assert off(4, 160) == pytest.approx(slow / 2, rel=0.1)
    assert off(8, 160) == pytest.approx(slow, rel=0.1)


def test_near_a_line_of_masses_a_tether_goes_slack_and_the_papers_radius_is_too_large(model):
    """With R = 0.65 the law asks for shapes that the spin does not hold open; with 0.45 no tether is ever slack."""
    narrow, wide = (simulate(model, "path", "spin", **START, **more) for more in ({}, {"R": 0.65}))
    assert tensions(narrow).min() > 0.3
    assert json.loads(narrow.attrs["events"])["t"] == []
    assert abs(float(narrow.theta_error[-1])) < 0.002
    assert float(narrow.rho_error[-1]) < 0.002
    assert tensions(wide).min() == 0
    assert len(json.loads(wide.attrs["events"])["t"]) > 0
    assert wide.attrs["status"] == "limit"


def test_without_a_spin_tethers_do_not_hold_the_triangle(model):
    run = simulate(model, "path", "spin", spin=0.5)
    assert run.attrs["status"] != "done"
    assert tensions(run).min() == 0


def test_tethers_that_begin_slack_are_taut_within_a_second(model):
    run = simulate(model, "path", "slack")
    instants = json.loads(run.attrs["events"])["t"]
    assert 5 < len(instants) < 50
    assert max(instants) < 1
    assert abs(float(run.theta_error[-1])) < 0.002


def test_breathing_beside_a_spin_is_at_its_frequency(model):
    """Equal tethers with reels at rest: delta'' = -(3 Omega^2 + 3 k/(m s)) delta about the steady spin."""
    k, spin, m, length, small = 40.0, 3.0, 1.2, 0.4, 1e-6
    s = length / (1 + m * spin**2 * length / 3 / k)
    p = model.parameters(stiffness=k, damping=0.0, mass=m)
    x = np.zeros(19)
    x[:3], x[7], x[13:16] = length + small, m * length**2 * spin, s
    times = np.linspace(0, 2, 40)
    run = solve_ivp(lambda _, x: model.rhs(x, np.zeros(9), p), (0, 2), x, t_eval=times, **EXACT).y
    expected = small * np.cos(np.sqrt(3 * spin**2 + 3 * k / (m * s)) * times)
    np.testing.assert_allclose(run[0] - length, expected, atol=2e-5 * small + 1e-11)


def test_thrust_holds_the_momentum_of_the_spin_on_an_ellipse(model):
    alone, beside = (simulate(model, law, "ellipse") for law in ("path", "path-thrust"))
    wanted = float(model.functions["reference"](0.0, *_of(model, beside))[4])
    assert abs(float(beside.theta_error[-1])) < 1e-3 < abs(float(alone.theta_error[-1]))
    assert abs(float(beside.H[-1]) / wanted - 1) < 1e-5 < np.abs(alone.H.values / wanted - 1).max()
    assert min(tensions(alone).min(), tensions(beside).min()) > 0.3


def _of(model: Model, run) -> tuple[np.ndarray, np.ndarray]:
    values = json.loads(run.attrs["parameters"])
    groups = (model.manifest.parameters, model.manifest.scenario_parameters)
    return tuple(np.array([values[q.name] for q in group]) for group in groups)


def test_methods_and_backends_agree_across_events(model):
    """Tolerances of 1e-9; SciPy reads the state at an event from dense output."""
    choices = {"t_end": 1.0, "dt_out": 0.05, "rtol": 1e-9, "atol": 1e-9}
    one = simulate(model, "path", "slack", **choices)
    stiff = simulate(model, "path", "slack", method="rodas5p", **choices)
    np.testing.assert_allclose(lengths(stiff), lengths(one), atol=1e-5)
    with by_scipy():
        python = simulate(model, "path", "slack", **choices)
    np.testing.assert_allclose(lengths(python), lengths(one), atol=1e-5)
    counts = [len(json.loads(run.attrs["events"])["t"]) for run in (one, stiff, python)]
    assert counts == [counts[0]] * 3


def test_a_batch_repeats_a_single_run_and_counts_its_events(model):
    vary = {"H_0": "uniform(-0.003, 0.003)", "slack_0": "uniform(0, 0.02)"}
    many = batch(model, "path", 4, scenario="slack", vary=vary, seed=3, dt_out=0.5)
    values = {name: float(many[name][2]) for name in vary}
    single = simulate(model, "path", "slack", dt_out=0.5, **values)
    assert float(many.theta_final[2]) == float(single.theta_error[-1])
    assert int(many.changes[2]) == len(json.loads(single.attrs["events"])["t"]) > 0


XML = """
<mujoco><option gravity="0 0 0"/><worldbody>{bodies}</worldbody><tendon>{tendons}</tendon></mujoco>"""
BODY = """
<body><joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/><site name="{i}"/>
  <inertial pos="0 0 0" mass="{m}" diaginertia="1 1 1"/></body>"""
TENDON = """
<spatial stiffness="{k}" springlength="0 {s}"><site site="{i}"/><site site="{j}"/></spatial>"""


@pytest.mark.parametrize("seed", range(5))
def test_accelerations_are_mujocos(general, seed):
    """Spatial tendons with a dead band up to their natural length; some are slack. They have no damper that lets go."""
    rng = np.random.default_rng(seed)
    X, V = rng.uniform(-1, 1, (3, 2)), rng.uniform(-1, 1, (3, 2))
    if np.linalg.det(np.array([X[1] - X[0], X[2] - X[0]])) < 0:
        X[[1, 2]] = X[[2, 1]]
    length = rods(X)
    s, k = length * rng.uniform(0.9, 1.1, 3), 50.0
    bodies = "".join(BODY.format(i=i, m=m) for i, m in enumerate(MASSES))
    held = "".join(TENDON.format(k=k / out, s=out, i=i, j=j) for out, (i, j) in zip(s, ENDS, strict=True))
    world = mujoco.MjModel.from_xml_string(XML.format(bodies=bodies, tendons=held))
    data = mujoco.MjData(world)
    data.qpos[:], data.qvel[:] = X.ravel(), V.ravel()
    mujoco.mj_forward(world, data)
    A = data.qacc.reshape(3, 2)
    expected, rate = [], []
    for n, (i, j) in enumerate(ENDS):
        edge, change = X[j] - X[i], V[j] - V[i]
        rate.append(edge @ change / length[n])
        expected.append((edge @ (A[j] - A[i]) + change @ change - rate[n] ** 2) / length[n])
    about, drift = X - MASSES @ X / MASSES.sum(), V - MASSES @ V / MASSES.sum()
    H = MASSES @ (about[:, 0] * drift[:, 1] - about[:, 1] * drift[:, 0])
    x = np.concatenate([length, [0.0], rate, [H], np.zeros(5), s, np.zeros(3)])
    p = general.parameters(stiffness=k, damping=0.0, m1=MASSES[0], m2=MASSES[1], m3=MASSES[2])
    result = general.rhs(x, np.zeros(9), p)
    np.testing.assert_allclose(result[4:7], expected, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("law", ["sliding", "path", "path-thrust"])
@pytest.mark.parametrize("target", ["sil", pytest.param("unicorn", marks=needs("arm-none-eabi-gcc"))])
def test_the_laws_have_the_same_bits_on_a_board(model, law, target):
    outcome = run_on_board(model, BoardRequest(law, target, samples=100))
    assert (outcome.max_ulp, outcome.x.ulp) == (0, 0)
    assert outcome.u.compared == outcome.single.u_cmd.size


def test_tethers_have_no_mass():
    with pytest.raises(ModelError, match=r"rods = 'uniform' with model = 'tethered': needs model = 'dynamic'"):
        system("triangle", model="tethered", rods="uniform")
