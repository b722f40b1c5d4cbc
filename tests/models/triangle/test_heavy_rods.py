# SPDX-License-Identifier: Apache-2.0
"""Rods with mass: against many points along each rod, theory of libration, and the kinematics of the paper."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from mehvar import InputError, simulate
from mehvar.runtime import load
from mehvar.runtime.board.run import BoardRequest, run_on_board
from mehvar.runtime.model.model import Model
from tests.derived import variant
from tests.models.triangle.test_dynamic import ENDS, EXACT, column, inputs, rigid, state, turns_by_twice_the_area
from tests.reference.cartesian_triangle import place, rods
from tests.tools import needs

pytestmark = pytest.mark.soak  # a structure of its own: test_dynamic.py has the one without mass

MASSES, BEAMS = np.array([1.0, 2.0, 3.5]), np.array([0.9, 0.3, 1.6])
GENERAL = {f"m{k}": MASSES[k - 1] for k in (1, 2, 3)} | {f"rod_mass{k}": BEAMS[k - 1] for k in (1, 2, 3)}


def structure(folder, **choices: str) -> Model:
    for name, text in variant("triangle", model="dynamic", **choices).items():
        (folder / name).write_text(text)
    return load(folder)


@pytest.fixture(scope="module")
def model(tmp_path_factory) -> Model:
    return structure(tmp_path_factory.mktemp("uniform"), rods="uniform")


@pytest.fixture(scope="module")
def general(tmp_path_factory) -> Model:
    return structure(tmp_path_factory.mktemp("general"), rods="uniform", masses="general")


def spread() -> tuple[np.ndarray, np.ndarray]:
    """Corners and 201 points along each rod: their shares of the three corners, and masses, by Simpson's rule."""
    s = np.linspace(0, 1, 201)
    weight = np.where(np.arange(201) % 2, 4.0, 2.0)
    weight[[0, -1]] = 1.0
    shares, masses = [np.eye(3)], [MASSES]
    for (i, j), beam in zip(ENDS, BEAMS, strict=True):
        along = np.zeros((201, 3))
        along[:, i], along[:, j] = 1 - s, s
        shares.append(along)
        masses.append(beam * weight / weight.sum())
    return np.vstack(shares), np.concatenate(masses)


@pytest.mark.soak
def test_a_motion_is_that_of_many_points_along_the_rods(general):
    """Rods that push in time, thrust, an orbit of eccentricity 0.4; all points move as the corners make them."""
    n, e = 0.7, 0.4
    shares, points = spread()
    matrix = shares.T @ (points[:, None] * shares)
    thrust = np.array([[0.1, -0.2], [0.05, 0.3], [-0.2, 0.1]])
    p = general.parameters(mean_motion=n, eccentricity=e, **GENERAL)

    def push(t):
        return np.array([0.3 * np.sin(t), -0.2 * np.cos(2 * t), 0.1 + 0.2 * np.sin(3 * t)])

    def centred(X):
        return X - points @ (shares @ X) / points.sum()

    def corners(t, y):
        X, V, nu = y[:6].reshape(3, 2), y[6:12].reshape(3, 2), y[12]
        near = (1 + e * np.cos(nu)) / (1 - e**2)
        r, about = np.array([np.cos(nu), np.sin(nu)]), shares @ centred(X)
        field = n**2 * near**3 * (3 * np.outer(about @ r, r) - about)
        force = shares.T @ (points[:, None] * field)
        for k, (i, j) in enumerate(ENDS):
            along = (X[j] - X[i]) / np.linalg.norm(X[j] - X[i])
            force[j] += push(t)[k] * along
            force[i] -= push(t)[k] * along
        ahead = (X[1] - X[0]) / np.linalg.norm(X[1] - X[0])
        force += thrust @ np.array([ahead, [-ahead[1], ahead[0]]])
        return np.concatenate([V.ravel(), np.linalg.solve(matrix, force).ravel(), [n * np.sqrt(1 - e**2) * near**2]])

    X = place(0.5, 0.6, 0.7, 0.3, MASSES)
    reference = solve_ivp(corners, (0, 1), np.concatenate([X.ravel(), np.zeros(6), [0.2]]), **EXACT).y[:, -1]
    l1, l2, l3 = rods(X)
    psi = np.arctan2(*(X[1] - X[0])[::-1])

    def rate(t, x):
        return general.rhs(x, np.concatenate([push(t), thrust.ravel()]), p)

    x = solve_ivp(rate, (0, 1), state(general, l1=l1, l2=l2, l3=l3, psi=psi, nu=0.2), **EXACT).y[:, -1]
    X, V = reference[:6].reshape(3, 2), reference[6:12].reshape(3, 2)
    drift = points @ (shares @ V) / points.sum()
    about, moving = shares @ centred(X), shares @ V
    H = points @ (about[:, 0] * moving[:, 1] - about[:, 1] * moving[:, 0])
    kinetic = points @ np.sum(moving**2, axis=1) / 2
    np.testing.assert_allclose(x[:3], rods(X), atol=1e-10)
    assert np.angle(np.exp(1j * (x[3] - np.arctan2(*(X[1] - X[0])[::-1])))) == pytest.approx(0, abs=1e-9)
    named = [column(general, x, name) for name in ("H", "nu", "vx", "vy")]
    np.testing.assert_allclose(named, [H, reference[12], *drift], atol=1e-10)
    assert float(general.functions["energy"](x, p)[0]) == pytest.approx(kinetic, abs=1e-10)


def test_a_rigid_triangle_librates_as_theory_says(general):
    """Moments of rods m l^2/12 about their middles; small on a circle, at n sqrt(3 (B - A)/C)."""
    n, tilt = 0.9, 1e-4
    X = place(0.5, 0.4, 0.7, 0.0, MASSES)
    middles = np.array([(X[i] + X[j]) / 2 for i, j in ENDS])
    bodies, places = np.concatenate([MASSES, BEAMS]), np.vstack([X, middles])
    places = places - bodies @ places / bodies.sum()
    second = (bodies[:, None] * places).T @ places
    for (i, j), beam in zip(ENDS, BEAMS, strict=True):
        second = second + beam * np.outer(X[j] - X[i], X[j] - X[i]) / 12
    moments, axes = np.linalg.eigh(second)
    long = axes[:, 1] * np.sign(axes[:, 1] @ (X[1] - X[0]))
    offset = np.arctan2(*(X[1] - X[0])[::-1]) - np.arctan2(*long[::-1])
    l1, l2, l3 = rods(X)
    x = state(general, l1=l1, l2=l2, l3=l3, psi=offset + tilt, H=moments.sum() * n)
    times = np.linspace(0, 12, 60)
    run = rigid(general, x, general.parameters(mean_motion=n, **GENERAL), 12, times)
    away = column(general, run, "psi") - offset - column(general, run, "nu")
    frequency = n * np.sqrt(3 * (moments[1] - moments[0]) / moments.sum())
    np.testing.assert_allclose(away, tilt * np.cos(frequency * times), atol=1e-6 * tilt + 1e-11)


def test_a_loop_of_shapes_turns_by_the_papers_angle(model):
    """Equal rods with mass move as equal points of half a rod more do."""
    turns_by_twice_the_area(model, model.parameters(rod_mass=3.0), 0.3, 0.0)


def test_heavier_rods_take_more_force_on_the_same_way(model):
    light, heavy = (simulate(model, "path", rod_mass=mass, dt_out=0.1) for mass in (0.0, 2.0))
    np.testing.assert_allclose(heavy.theta, light.theta, atol=1e-6)
    np.testing.assert_allclose(heavy.u_F1[1:], 2 * light.u_F1[1:], rtol=1e-4, atol=1e-5)


def test_thrust_holds_the_attitude_on_an_ellipse(model):
    alone, beside = (simulate(model, law, "ellipse", rod_mass=20.0) for law in ("path", "path-thrust"))
    assert abs(float(alone.theta_error[-1])) > 0.003
    assert abs(float(beside.theta_error[-1])) < 1e-5
    assert np.abs(beside.H.values).max() < 1e-9


def test_rods_without_mass_are_light(general, tmp_path_factory):
    light = structure(tmp_path_factory.mktemp("light"), masses="general")
    rng = np.random.default_rng(0)
    x = state(light, **{name: rng.uniform(0.3, 0.5) for name in light.state_names})
    u = inputs(light, **{name: rng.uniform(-1, 1) for name in light.input_names})
    masses = {name: value for name, value in GENERAL.items() if name.startswith("m")}
    weightless = {f"rod_mass{k}": 0.0 for k in (1, 2, 3)}
    here = general.rhs(x, u, general.parameters(mean_motion=0.4, **masses, **weightless))
    np.testing.assert_allclose(here, light.rhs(x, u, light.parameters(mean_motion=0.4, **masses)), rtol=1e-12)


def test_rods_that_no_points_stand_for_are_refused(general):
    with pytest.raises(InputError, match=r"rods of 0.2, 0.2, 9 kg with masses of 1, 1, 100 kg: one is heavier"):
        simulate(general, "path", m3=100.0, rod_mass3=9.0)


@pytest.mark.parametrize("target", ["sil", pytest.param("unicorn", marks=needs("arm-none-eabi-gcc"))])
@pytest.mark.share(2)
def test_the_laws_have_the_same_bits_on_a_board(model, target):
    outcome = run_on_board(model, BoardRequest("path-thrust", target, samples=100))
    assert (outcome.max_ulp, outcome.x.ulp) == (0, 0)
    assert outcome.u.compared == outcome.single.u_cmd.size
