# SPDX-License-Identifier: Apache-2.0
"""The coefficients of `rodas5p` against what they promise, and what they are for: a stiff loop in few steps."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from mehvar.runtime import InputError, Status, load, simulate
from tests.models.test_clock import shaken, written
from tests.reference.scipy_loop import by_scipy, solvers
from tests.reference.scipy_loop.solvers import Rodas5P

Array = NDArray[np.float64]
START = np.array([1.0, 0.0, 0.5])


def slope(t: float, y: Array) -> Array:
    """Return a pendulum's rates that a fast quantity pulls, both driven by time."""
    return np.array([y[1], -np.sin(y[0]) - 5 * (y[2] - np.cos(t)), -8 * (y[2] - np.cos(y[0]) * np.cos(t))])


def jacobian(t: float, y: Array) -> Array:
    return np.array([[0, 1, 0], [-np.cos(y[0]), 0, -5], [-8 * np.sin(y[0]) * np.cos(t), 0, -8]])


def step(h: float) -> tuple[Any, Any]:
    """Return the solver after one step of a length, and its dense output."""
    solver = Rodas5P(slope, 0.0, START, h, rtol=1.0, atol=1e3, first_step=h, jac=jacobian)
    solver.step()
    return solver, solver.dense_output()


def test_a_step_is_of_order_five_and_between_its_ends_of_order_four() -> None:
    exact = solve_ivp(slope, (0.0, 0.1), START, method="DOP853", rtol=1e-13, atol=1e-15, dense_output=True).sol
    lengths = 0.1 / 2 ** np.arange(3)
    ends, between = [], []
    for h in lengths:
        solver, dense = step(h)
        ends.append(np.max(np.abs(solver.y - exact(h))))
        between.append(max(np.max(np.abs(dense(part * h) - exact(part * h))) for part in (0.2, 0.5, 0.8)))
        np.testing.assert_allclose(dense(h), solver.y, rtol=1e-15)
    assert np.polyfit(np.log(lengths), np.log(ends), 1)[0] == pytest.approx(6.0, abs=0.35)
    assert np.polyfit(np.log(lengths), np.log(between), 1)[0] == pytest.approx(5.0, abs=0.35)


@pytest.mark.parametrize("rate", [1e2, 1e5, 1e9])
def test_what_decays_fast_is_gone_after_a_step(rate: float) -> None:
    """The method is stiffly accurate: the end lies at the slow solution, whatever the rate."""
    solver = Rodas5P(
        lambda t, y: -rate * (y - np.cos(t)) - np.sin(t), 0.0, np.array([1.0]), 1.0, 1.0, 1.0, 1.0,
        lambda t, y: np.array([[-rate]]),
    )  # fmt: skip
    solver.step()
    assert solver.y[0] == pytest.approx(np.cos(1.0), abs=1e-3)


def test_the_jacobian_may_come_from_differences() -> None:
    exact = solve_ivp(slope, (0.0, 2.0), START, method="DOP853", rtol=1e-13, atol=1e-13).y[:, -1]
    for known in (jacobian, None):
        solver = Rodas5P(slope, 0.0, START, 2.0, rtol=1e-7, atol=1e-7, jac=known)
        while solver.status == "running":
            solver.step()
        np.testing.assert_allclose(solver.y, exact, atol=1e-6)


def test_a_stiff_loop_takes_few_steps_whatever_the_samples() -> None:
    """Slosh under lyapunov-v2: three eigenvalues near -80 1/s, all others below 1.2; samples are no ends of steps."""
    model = load("slosh")
    exact = simulate(model, "lyapunov-v2", t_end=60.0, dt_out=1.0, rtol=1e-11, atol=1e-11)
    counts = set()
    for dt in (0.25, 1.0, 20.0):
        run = simulate(model, "lyapunov-v2", t_end=60.0, dt_out=dt, method="rodas5p", rtol=1e-6, atol=1e-6)
        common, rows, other = np.intersect1d(np.round(run.t, 9), np.round(exact.t, 9), return_indices=True)
        assert len(common) == min(len(run.t), len(exact.t))
        np.testing.assert_allclose(run.x[rows], exact.x[other], atol=3e-6)
        counts.add((run.statistics["steps"], run.statistics["evaluations"]))
    assert len(counts) == 1
    rock4 = simulate(model, "lyapunov-v2", t_end=60.0, dt_out=1.0, method="rock4", rtol=1e-6, atol=1e-6)
    assert 3 * counts.pop()[1] < rock4.statistics["evaluations"]


@pytest.mark.parametrize("backend", ["c", pytest.param("python", marks=pytest.mark.soak)])
def test_a_jacobian_without_a_value_stops_no_run(backend: Any) -> None:
    """On the barrier of the triangle's path law, rho = R, the law has a kink, and its derivative is 0/0."""
    model = load("triangle", backend=backend)
    run = simulate(model, "path", method="rodas5p", rtol=1e-10, atol=1e-10, t_end=12.0, dt_out=0.5)
    exact = simulate(model, "path", rtol=1e-12, atol=1e-12, t_end=12.0, dt_out=0.5)
    assert run.status is Status.DONE
    assert np.max(run.x[:, 0]) > 0.65 * (1 - 1e-9)
    np.testing.assert_allclose(run.x, exact.x, atol=3e-7)


def test_a_loop_that_drives_itself_follows_the_tolerance(tmp_path: Path) -> None:
    """v' = 20 v: the step of 1/(20 gamma) s has no matrix to divide by, and longer ones would turn its sign."""
    folder, options = (
        written(shaken(), tmp_path),
        {"t_end": 1.0, "dt_out": 1.0, "parameters": {"gain": -20.0, "top": 1e12}},
    )
    exact = simulate(folder, "brake", rtol=1e-12, atol=1e-12, **options).x[-1]
    for tolerance in (1e-2, 1e-4, 1e-7):
        run = simulate(folder, "brake", method="rodas5p", rtol=tolerance, atol=tolerance, **options)
        assert run.status is Status.DONE
        np.testing.assert_allclose(run.x[-1], exact, rtol=300 * tolerance)


def test_a_variant_without_a_jacobian_is_refused() -> None:
    with pytest.raises(InputError, match=r"method = 'rodas5p'.*must be rk4, dopri5, dop853 or rock4: slosh has no Jac"):
        simulate(load("slosh"), "lyapunov-v2", method="rodas5p", t_end=1.0, attitude="euler")


@pytest.mark.parametrize("tolerance", [1e-2, 1e-5, 1e-9])
def test_steps_follow_errors_as_those_of_scipy(tolerance: float) -> None:
    """Nine tenths of what would just be good, at most ten times the last one, no longer one after a refusal."""
    solver = Rodas5P(slope, 0.0, START, 10.0, rtol=tolerance, atol=tolerance, first_step=1e-9, jac=jacobian)
    factors = []
    while solver.h_abs < 10.0 - solver.t:
        asked = solver.h_abs
        solver.step()
        _, before, h, stages = solver._last
        assert h <= asked
        scale = tolerance * (1 + np.maximum(np.abs(before), np.abs(solver.y)))
        error = np.sqrt(np.mean((stages[-1] / scale) ** 2))
        factors.append(min(1.0 if h < asked else 10.0, 0.9 * max(error, 1e-10) ** -0.2))
        assert solver.h_abs == pytest.approx(h * factors[-1], rel=1e-12)
    assert max(factors) == 10.0
    assert min(factors) < 5.0


@pytest.mark.parametrize("hold", [None, 0.02])
@pytest.mark.parametrize("name", ["Rock4", "Rodas5P"])
def test_a_solver_has_the_tolerances_of_the_run(monkeypatch: pytest.MonkeyPatch, name: str, hold: float | None) -> None:
    """An explicit one has a hundredth where dense output, whose error nobody estimates, is looked at."""
    original, seen = getattr(solvers, name), set()

    class Noted(original):  # type: ignore[misc, valid-type]
        def __init__(self, *arguments: Any, rtol: float, atol: float, **more: Any) -> None:
            seen.add((rtol, atol))
            super().__init__(*arguments, rtol=rtol, atol=atol, **more)

    monkeypatch.setattr(solvers, name, Noted)
    options = {} if hold is None else {"hold": hold}
    triangle = load("triangle", backend="python")
    with by_scipy():
        simulate(triangle, "path", method=name.lower(), rtol=1e-5, atol=1e-6, t_end=0.04, dt_out=0.02, **options)
    part = 0.01 if hold is None and name == "Rock4" else 1.0
    assert seen == {(1e-5 * part, 1e-6 * part)}
