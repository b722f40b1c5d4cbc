# SPDX-License-Identifier: Apache-2.0
"""Samples of continuous loops, which steps pass over: as exact as the steps, and no dearer where there are few."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import RK45, solve_ivp

from mehvar.runtime import Model, load, simulate
from tests.reference.scipy_loop.solvers import Rock4

Array = NDArray[np.float64]
LOOPS = {"smooth": ("triangle", "path", 5.0, 0.05), "stiff": ("slosh", "lyapunov-v2", 30.0, 0.1)}
ADAPTIVE = ("dop853", "dopri5", "rock4", "rodas5p")


@cache
def model(name: str) -> Model:
    return load(name, backend="c")


def run(loop: str, method: str, tolerance: float, **options: Any) -> Any:
    name, law, end, dt = LOOPS[loop]
    given = {"t_end": end, "dt_out": dt, "rtol": tolerance, "atol": tolerance, **options}
    return simulate(model(name), law, method=method, **given)


@cache
def exact(loop: str) -> Array:
    result: Array = run(loop, "dop853", 1e-13).x
    return result


@pytest.mark.parametrize("loop", LOOPS)
@pytest.mark.parametrize("method", ADAPTIVE)
@pytest.mark.parametrize("tolerance", [1e-5, 1e-7, 1e-9])
def test_samples_are_as_exact_as_the_tolerance(loop: str, method: str, tolerance: float) -> None:
    """The errors of single steps add up; what is between their ends may not stand out from that."""
    result = run(loop, method, tolerance)
    errors = np.max(np.abs(result.x - exact(loop)) / (1 + np.abs(exact(loop))), axis=1)
    assert errors.max() < 40 * tolerance


@pytest.mark.parametrize("loop", LOOPS)
@pytest.mark.parametrize("method", ADAPTIVE)
def test_a_sample_is_near_the_end_of_a_run_to_it(loop: str, method: str) -> None:
    """A run that ends at an instant has stepped to it."""
    samples, end = run(loop, method, 1e-6), LOOPS[loop][2]
    for row in range(len(samples.t) // 7, len(samples.t), len(samples.t) // 7):
        stepped = run(loop, method, 1e-6, t_end=min(samples.t[row], end))
        np.testing.assert_allclose(samples.x[row], stepped.x[-1], rtol=2e-5, atol=2e-5)


@pytest.mark.parametrize("loop", LOOPS)
@pytest.mark.parametrize("method", ADAPTIVE)
def test_fewer_samples_cost_no_more(loop: str, method: str) -> None:
    dt = LOOPS[loop][3]
    many, some, few = (run(loop, method, 1e-6, dt_out=factor * dt).statistics for factor in (1, 10, 100))
    assert few["evaluations"] <= some["evaluations"] <= many["evaluations"]
    if method != "dop853":  # dop853 shortens steps where its samples need it
        assert many == few


def test_an_end_at_a_sample_is_the_sample() -> None:
    """The last step ends at the last sample, whatever the others are."""
    last = [run("smooth", "dopri5", 1e-6, dt_out=dt).x[-1] for dt in (0.05, 5.0)]
    np.testing.assert_array_equal(*last)


def swing(t: float, x: Array) -> Array:
    return np.array([x[1], -np.sin(x[0]) - 0.2 * x[1]])


@pytest.mark.parametrize("solver", [Rock4, RK45])
def test_dense_output_is_of_order_four(solver: Any) -> None:
    """Rock4's own, and that of SciPy's RK45, which is dopri5 with a polynomial of its own."""
    start, lengths, errors = np.array([1.0, 0.5]), 0.8 / 2 ** np.arange(4), []
    dense = solve_ivp(swing, (0.0, 1.0), start, method="DOP853", rtol=1e-13, atol=1e-15, dense_output=True).sol
    for h in lengths:
        stepper = solver(swing, 0.0, start, h, rtol=1.0, atol=1e3, first_step=h)
        stepper.step()
        parts = np.linspace(0.1, 0.9, 9) * h
        errors.append(np.max(np.abs(stepper.dense_output()(parts) - dense(parts))))
    assert np.polyfit(np.log(lengths), np.log(errors), 1)[0] == pytest.approx(5.0, abs=0.4)
