# SPDX-License-Identifier: Apache-2.0
"""A satellite with bending modes and a full inertia tensor, as matrices, against masses on springs."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import mehvar
from mehvar.physics.gates import balance, gates
from mehvar.physics.machine import Machine
from tests.examples import checks
from tests.examples.pages import lines, model_here

INERTIA = np.array([[120, -4, 2.5], [-4, 90, 3], [2.5, 3, 100]])
DELTA, OMEGA = np.array([[1, 0.2], [0.1, 3], [4, -0.5]]), np.array([2, 5.5])


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return model_here("flexible", tmp_path_factory.mktemp("flexible"), "tests")


def test_the_tensor_is_one_line_and_the_model_is_short(folder):
    text = (folder.parents[1] / "models/flexible/parameters.toml").read_text(encoding="utf-8")
    assert [line.split(" = ")[0] for line in text.splitlines() if "120.0" in line] == ["I"]
    assert lines(folder.parents[1] / "models/flexible") <= 80


def test_frequencies_of_the_free_body(folder):
    """Those of the modes with the body held, over what is left of a unit of modal mass: they are higher."""
    model = mehvar.load(folder)
    p = model.parameters(zeta_1=0.0, zeta_2=0.0)
    values = np.linalg.eigvals(model.jac_x(np.zeros(7), np.zeros(3), p))
    reduced = np.eye(2) - DELTA.T @ np.linalg.solve(INERTIA, DELTA)
    expected = np.sqrt(np.linalg.eigvals(np.linalg.solve(reduced, np.diag(OMEGA**2))))
    np.testing.assert_allclose(np.sort(values.imag)[-2:], np.sort(expected.real), rtol=1e-9)
    assert (np.sort(expected.real) > OMEGA).all()


def test_point_masses_on_springs(folder):
    """Newton's law for a hub and two masses that slide on springs, at rates whose squares are nothing.

    What a rail does not let go moves with the hub; what the spring exerts acts on both ends of it.
    """
    hub, m, k, c = np.diag([50.0, 40.0, 45.0]), (2.0, 1.5), (8.0, 40.0), (0.02, 0.03)
    place = np.array([[0.2, 3.0, 0.4], [-0.3, -2.5, 1.0]])
    rail = np.array([[0.6, 0.0, 0.8], [0.0, 0.6, 0.8]])
    inertia, coupling, carried = hub.copy(), np.zeros((3, 2)), hub.copy()
    for j, (r, d) in enumerate(zip(place, rail, strict=True)):
        inertia += m[j] * (r @ r * np.eye(3) - np.outer(r, r))
        coupling[:, j] = np.sqrt(m[j]) * np.cross(r, d)
        turned = np.cross(np.eye(3), r)  # a row for each axis
        across = turned - np.outer(turned @ d, d)
        carried += m[j] * np.cross(r, across).T

    def rate(_, x):
        s, s_dot = x[3:5], x[5:]
        pull = k * s + c * s_dot
        w_dot = np.linalg.solve(carried, sum(f * np.cross(r, d) for f, r, d in zip(pull, place, rail, strict=True)))
        along = [d @ np.cross(w_dot, r) for r, d in zip(place, rail, strict=True)]
        return np.concatenate([w_dot, s_dot, -pull / m - along])

    values = {f"I_{i + 1}_{j + 1}": inertia[i, j] for i in range(3) for j in range(i, 3)} | {"gain": 0.0}
    values |= {f"delta_{i + 1}_{j + 1}": coupling[i, j] for i in range(3) for j in range(2)}
    values |= {f"omega_{j + 1}": np.sqrt(k[j] / m[j]) for j in range(2)}
    values |= {f"zeta_{j + 1}": c[j] / (2 * np.sqrt(k[j] * m[j])) for j in range(2)}
    start = [1e-7, -2e-7, 1.5e-7]
    values |= {f"w_0_{i + 1}": start[i] for i in range(3)}
    bent = {"eta_1": np.sqrt(m[0]) * 1e-6}
    run = mehvar.simulate(folder, "damp", parameters=values, initial=bent, rtol=1e-9, atol=1e-16, t_end=20.0)
    end = solve_ivp(rate, (0, 20), [*start, 1e-6, 0, 0, 0], "DOP853", rtol=1e-11, atol=1e-18).y[:, -1]
    deflections = [float(run[f"eta_{j + 1}"][-1]) / np.sqrt(m[j]) for j in range(2)]
    np.testing.assert_allclose(deflections, end[3:5], atol=1e-11)
    np.testing.assert_allclose([float(run[f"w{a}"][-1]) for a in "xyz"], end[:3], atol=1e-11)


def test_a_rigid_body_where_nothing_couples(folder):
    """Without couplings it is Euler's body, whose momentum in its own axes keeps its size and its energy."""
    free = {f"delta_{i}_{k}": 0.0 for i in (1, 2, 3) for k in (1, 2)} | {"gain": 0.0}
    run = mehvar.simulate(folder, "damp", parameters=free, rtol=1e-11, atol=1e-11)
    w = np.stack([run[name].values for name in ("wx", "wy", "wz")])
    energy, momentum = np.einsum("it,ij,jt->t", w, INERTIA, w) / 2, np.linalg.norm(INERTIA @ w, axis=0)
    assert np.ptp(energy) < 1e-9
    assert np.ptp(momentum) < 1e-9 < np.ptp(w[0])


def test_gates(folder):
    def supply(at):
        torque = sum(at[f"tau_{axis}"] * at[f"w{axis}"] for axis in "xyz")
        return torque - sum(2 * at[f"zeta_{k}"] * at[f"omega_{k}"] * at[f"eta_dot_{k}"] ** 2 for k in (1, 2))

    energy = balance(
        "energy changes by the torques' power, less what damping takes", lambda at: at.call("energy"), supply
    )
    assert max(gates([energy], Machine(checks.system_of(folder), {})).values()) < 1e-9


@pytest.mark.soak
def test_the_rest(folder, tmp_path):
    checks.backends_agree(folder, "damp", "eta_2", 1e-8)
    checks.runs_repeat(folder, ("damp",), {"I_1_2": "normal(-4, 1)", "delta_3_1": "uniform(3, 4.5)"}, tmp_path)
    checks.diff_tells(folder, "p.delta, p.delta.T", "2 * p.delta, 2 * p.delta.T", "mass_wx_eta_dot_1")
