# SPDX-License-Identifier: Apache-2.0
"""The satellite with bending modes and a full inertia tensor, of the page on matrices, against lumped masses on springs."""

from __future__ import annotations

import numpy as np
import pytest

import mehvar
from mehvar.physics.gates import balance, gates
from mehvar.physics.machine import Machine
from tests.examples import checks
from tests.examples.pages import lines, model_of_page

PAGE = "how-to/matrices.md"
INERTIA = np.array([[120, -4, 2.5], [-4, 90, 3], [2.5, 3, 100]])
DELTA, OMEGA = np.array([[1, 0.2], [0.1, 3], [4, -0.5]]), np.array([2, 5.5])


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return model_of_page(PAGE, "flexible", tmp_path_factory.mktemp("flexible"))


def test_the_tensor_is_one_line_and_the_model_is_short(folder):
    text = (folder.parents[1] / "models/flexible/parameters.toml").read_text(encoding="utf-8")
    assert [line.split(" = ")[0] for line in text.splitlines() if "120.0" in line] == ["I"]
    assert lines(folder.parents[1] / "models/flexible") <= 100


def test_frequencies_of_the_free_body(folder):
    """Likins: (I - delta delta^T) is the body's; free modes are eigenvalues of the undamped pencil, which are higher."""
    model = mehvar.load(folder)
    p = model.parameters({"zeta_1": 0.0, "zeta_2": 0.0})
    values = np.linalg.eigvals(model.jac_x(np.zeros(7), np.zeros(3), p))
    reduced = np.eye(2) - DELTA.T @ np.linalg.solve(INERTIA, DELTA)
    expected = np.sqrt(np.linalg.eigvals(np.linalg.solve(reduced, np.diag(OMEGA**2))))
    np.testing.assert_allclose(np.sort(values.imag)[-2:], np.sort(expected.real), rtol=1e-9)
    assert (np.sort(expected.real) > OMEGA).all()


def test_a_rigid_body_where_nothing_couples(folder):
    """Without couplings it is Euler's body, whose momentum in its own axes keeps its size and its energy."""
    free = {f"delta_{i}_{k}": 0.0 for i in (1, 2, 3) for k in (1, 2)} | {"gain": 0.0}
    run = mehvar.simulate(folder, "damp", parameters=free, rtol=1e-11, atol=1e-11)
    w = np.stack([run[name].values for name in ("wx", "wy", "wz")])
    energy, momentum = np.einsum("it,ij,jt->t", w, INERTIA, w) / 2, np.linalg.norm(INERTIA @ w, axis=0)
    assert np.ptp(energy) < 1e-9 and np.ptp(momentum) < 1e-9 < np.ptp(w[0])


def test_gates(folder):
    def supply(at):
        torque = sum(at[f"tau_{axis}"] * at[f"w{axis}"] for axis in "xyz")
        return torque - sum(2 * at[f"zeta_{k}"] * at[f"omega_{k}"] * at[f"eta_dot_{k}"] ** 2 for k in (1, 2))

    energy = balance(
        "energy changes by the torques' power, less what damping takes", lambda at: at.call("energy"), supply
    )
    assert max(gates([energy], Machine(checks.system_of(folder), {})).values()) < 1e-9


def test_the_rest(folder, tmp_path):
    checks.backends_agree(folder, "damp", "eta_2", 1e-8)
    checks.runs_repeat(folder, ("damp",), {"I_1_2": "normal(-4, 1)", "delta_3_1": "uniform(3, 4.5)"}, tmp_path)
    checks.diff_tells(folder, "p.delta, p.delta.T", "p.delta, 2 * p.delta.T", "mass_eta_dot_1_wx")
