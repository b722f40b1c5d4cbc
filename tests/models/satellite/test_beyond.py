# SPDX-License-Identifier: Apache-2.0
"""The satellite beyond the paper against independent calculations: Jacobi, JEOD, and the paper's model."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.special import ellipj

import mehvar
from mehvar.runtime.board.run import BoardRequest, run_on_board
from tests.models.satellite.beyond import MU, NOTHING, column, craft, motion, names, state
from tests.models.satellite.loop import satellite

Q, W, H = ("q0", "q1", "q2", "q3"), ("wx", "wy", "wz"), ("h1", "h2", "h3", "h4")
TENSOR = np.array([[2.13, 0.05, -0.08], [0.05, 3.04, 0.06], [-0.08, 0.06, 3.09]])
AXES = np.array([[1.0, -1, -1, 1], [1, 1, -1, -1], [1, 1, 1, 1]])
JEOD = tomllib.loads((Path(__file__).parents[2] / "validation" / "jeod.toml").read_text(encoding="utf-8"))
"""Logs of NASA's JEOD, github.com/nasa/jeod, verif/SIM_dyncomp."""


def test_free_motion_of_a_full_tensor_against_jacobis_functions():
    """No orbit, no wheels: the asymmetric top in its principal axes is sn, cn and dn."""
    p = craft().parameters(omega0=0.0)
    moments, turn = np.linalg.eigh(TENSOR)
    (A, B, C), w0 = moments, np.array([0.05, 0.0, 0.3])
    twice, square = moments @ w0**2, moments**2 @ w0**2
    assert square > twice * B
    slow, fast = twice * C - square, square - twice * A
    size = np.sqrt(np.array([slow / (A * (C - A)), slow / (B * (C - B)), fast / (C * (C - A))]))
    speed = np.sqrt((C - B) * fast / (A * B * C))
    modulus = (B - A) * slow / ((C - B) * fast)
    times = np.linspace(0, 120, 15)
    sn, cn, dn, _ = ellipj(speed * times, modulus)
    sides = np.linalg.det(turn)
    expected = np.column_stack([size[0] * cn, -sides * size[1] * sn, size[2] * dn])
    start = turn @ w0
    run = motion(state(**dict(zip(W, start, strict=True))), NOTHING, p, times)
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
    p = craft().parameters(omega0=0.0, field_moment=0.0, **tensor, **{f"wheel_inertia_{k}": 1e-12 for k in range(1, 5)})
    motors = np.linalg.pinv(AXES / np.linalg.norm(AXES, axis=0))
    largest = np.abs([row["a"] for row in data["rows"]]).max()
    for row in data["rows"]:
        u = motors @ [row["torque"], 0, 0]
        x = state(**dict(zip(W, row["w"], strict=True)))
        np.testing.assert_allclose(column(craft().rhs(x, u, p), *W), row["a"], atol=1e-13 * largest, rtol=0)


def posed(inertia: np.ndarray, **values: float) -> np.ndarray:
    """Return the plant's parameters for a body with this tensor, wheels that weigh nothing and no field."""
    tensor = {f"I_{i + 1}_{j + 1}": inertia[i, j] for i in range(3) for j in range(i, 3)}
    wheels = {f"wheel_inertia_{k}": 1e-12 for k in range(1, 5)}
    return np.asarray(craft().parameters(field_moment=0.0, **tensor, **wheels, **values))


def pulled(inertia: np.ndarray, nadir: np.ndarray, radius: float) -> np.ndarray:
    """Return the angular acceleration on a circle that is so far from the Earth, of a body at inertial rest."""
    p = posed(inertia, omega0=np.sqrt(JEOD["mu"] / radius**3))
    turn, _ = Rotation.align_vectors([[0, 0, 1]], [nadir])
    x = state(**dict(zip(Q, turn.as_quat(scalar_first=True), strict=True)))
    return column(craft().rhs(x, NOTHING, p), *W)


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
        torque = inertia @ pulled(inertia, body @ -up, data["radius"])
        np.testing.assert_allclose(torque, row["harmonic"], atol=2.1e-6 * np.abs(row["harmonic"]).max(), rtol=0)


def test_five_free_minutes_of_the_space_station_as_jeod_logged_them():
    """Run 9B after its torque: rates and attitude by the tensor in body axes, without an orbit."""
    rows = [row for row in JEOD["torque"]["rows"] if not row["torque"]]
    p = posed(np.array(JEOD["torque"]["inertia"]), omega0=0.0)
    turns = [Rotation.from_quat([q[0], *(-np.array(q[1:]))], scalar_first=True) for q in (r["q"] for r in rows)]
    x = state(**dict(zip((*Q, *W), (*turns[0].as_quat(scalar_first=True), *rows[0]["w"]), strict=True)))
    run = motion(x, NOTHING, p, np.array([float(row["t"]) for row in rows]))
    size = np.linalg.norm(rows[0]["w"])
    for y, row, turn in zip(run, rows, turns, strict=True):
        np.testing.assert_allclose(column(y, *W), row["w"], atol=1.1e-12 * size, rtol=0)
        here = Rotation.from_quat(column(y, *Q), scalar_first=True)
        np.testing.assert_allclose(here.as_matrix(), turn.as_matrix(), atol=1.1e-12)


def test_wheels_turn_the_body_and_the_whole_keeps_its_momentum():
    p = craft().parameters(omega0=0.0, field_moment=0.0)
    x = state(q0=0.5, q1=0.5, q2=-0.5, q3=0.5, wx=0.02, wy=-0.01, wz=0.03, h1=0.2, h2=-0.1, h4=0.3)
    run = motion(x, np.array([0.01, -0.02, 0.015, 0.005]), p, np.linspace(0, 60, 7))
    whole = np.array([np.ravel(craft().functions["momentum"](row, p)) for row in run])
    assert np.abs(column(run, *W)[-1] - column(x, *W)).max() > 0.1
    np.testing.assert_allclose(whole, np.tile(whole[0], (len(whole), 1)), atol=1e-11)
    np.testing.assert_allclose(np.linalg.norm(column(run, *Q), axis=1), 1, atol=1e-10)


@pytest.mark.soak
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
    here |= {"orbit_radius": radius}
    mine = craft().parameters(**here, **tensor, **wheels)
    theirs = paper.parameters(**here)
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
        left = state(**dict(zip(Q, q, strict=True)), **dict(zip(W, w, strict=True)), latitude=latitude,
                     **dict(zip(H, (*h, 1e-15 * w[0]), strict=True)))  # fmt: skip
        right = np.concatenate([q, w, h, [latitude]])
        a, b = craft().rhs(left, np.array([*u, 0.0]), mine), paper.rhs(right, u, theirs)
        for name, other in zip(
            (*Q, *W, "h1", "h2", "h3", "latitude"), (*Q, *W, "hx", "hy", "hz", "latitude"), strict=True
        ):
            assert a[states.index(name)] == pytest.approx(b[theirs_states.index(other)], rel=1e-9, abs=1e-13)


@pytest.mark.soak
@pytest.mark.parametrize("law", ["mrac", "pd"])
def test_a_board_computes_the_same_bits(law):
    outcome = run_on_board(craft(), BoardRequest(law, "sil", samples=200))
    assert (outcome.max_ulp, outcome.x.ulp, outcome.u.compared) == (0, 0, 200 * 4)


@pytest.mark.parametrize(
    ("values", "text"),
    [
        ({f"wheel_axes_{i}_1": 0.0 for i in (1, 2, 3)}, "is no axis: it must have a length"),
        ({"wheel_axes_1_1": 1e200}, "wheel_axes is no axis: it must have a length from 1e-150 to 1e"),
        ({f"wheel_axes_{i}_1": 1e-200 for i in (1, 2, 3)}, "wheel_axes is no axis"),
        ({f"wheel_axes_3_{k}": 0.0 for k in (1, 2, 3, 4)}, "lie in a plane"),
    ],
)
def test_what_a_choice_divides_by_is_named_where_it_is_extreme(values: dict[str, float], text: str) -> None:
    with pytest.raises(mehvar.InputError, match=text):
        mehvar.simulate(craft(), "pd", t_end=1.0, **values)
