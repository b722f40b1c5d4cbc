# SPDX-License-Identifier: Apache-2.0
"""The coefficients of `rock4` against their conditions, and what they are for: a stiff loop in few steps."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import mehvar
from mehvar.runtime import simulate
from tests.reference.scipy_loop.solvers import Rock4
from tests.runtime.run import rock4

A, B, C, E = Rock4.A, Rock4.B, Rock4.C, Rock4.E[:-1]
D = Rock4.P[:-1, -1]  # of s^2 (1 - s)^2
LENGTH = 87.0


def stages(z: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the stages of x' = z x from x = 1 with a step of one."""
    return np.array([np.linalg.solve(np.eye(len(B)) - v * A, np.ones(len(B))) for v in z])


def test_every_coefficient_is_in_its_place() -> None:
    lines = rock4.FILE.read_text(encoding="utf-8").splitlines()
    assert [line.count(",") for line in lines] == [16] * 20
    assert not np.triu(A).any()
    np.testing.assert_array_equal(A.sum(axis=1), C)


def test_the_committed_coefficients_are_those_of_the_script() -> None:
    np.testing.assert_allclose(rock4.find(), np.vstack([A, B, C, E, D]), rtol=1e-6, atol=1e-9)


def test_order_four_and_an_estimate_of_order_three() -> None:
    trees = [np.ones_like(C), C, C**2, A @ C, C**3, C * (A @ C), A @ C**2, A @ A @ C]
    conditions = [1, 1 / 2, 1 / 3, 1 / 6, 1 / 4, 1 / 8, 1 / 12, 1 / 24]
    assert np.array([B @ tree for tree in trees]) == pytest.approx(conditions)
    assert np.array([E @ tree for tree in trees[:4]]) == pytest.approx(0, abs=1e-14)
    assert min(abs(E @ tree) for tree in trees[4:]) > 1e-3


def test_stable_on_the_negative_real_axis() -> None:
    z = -np.linspace(0.0, LENGTH, 2000)
    inner = stages(z)
    factor = np.abs(1 + z * (inner @ B))
    assert factor[1:].max() < 1
    assert factor[z < -6].max() <= 0.9501
    assert np.abs(inner).max() < 2
    beyond = -1.05 * LENGTH
    assert abs(1 + beyond * (stages(np.array([beyond]))[0] @ B)) > 1.5


@pytest.mark.parametrize("backend", ["c", pytest.param("python", marks=pytest.mark.soak)])
def test_a_stiff_loop_takes_few_steps(backend: str) -> None:
    """Eigenvalues of slosh under lyapunov-v2 go down to -80 1/s, where nothing else is faster than 1 1/s."""
    model = mehvar.load("slosh", backend=backend)
    options = {"t_end": 60.0, "dt_out": 1.0, "rtol": 1e-4, "atol": 1e-4}
    runs = {name: simulate(model, "lyapunov-v2", method=name, **options) for name in ("dopri5", "rock4")}
    np.testing.assert_allclose(runs["rock4"].x[-1], runs["dopri5"].x[-1], atol=1e-3, rtol=1e-3)
    assert runs["rock4"].statistics["evaluations"] < 0.6 * runs["dopri5"].statistics["evaluations"]


def test_dense_output_ends_where_the_step_does() -> None:
    solver = Rock4(lambda t, x: np.array([x[1], -x[0]]), 0.0, np.array([1.0, 0.0]), 5.0, rtol=1e-8, atol=1e-8)
    solver.step()
    dense = solver.dense_output()
    np.testing.assert_allclose(dense(solver.t), solver.y, atol=1e-14)
    np.testing.assert_allclose(dense(solver.t_old), [1.0, 0.0], rtol=1e-14)
    middle = 0.5 * solver.t
    np.testing.assert_allclose(dense(middle), [np.cos(middle), -np.sin(middle)], atol=1e-6)
