# SPDX-License-Identifier: Apache-2.0
"""The native loop step for step: SciPy's stages, error norm and first step under the step control as it is documented.

Weights of the error, factors and exponents change how many steps are taken, not where a run ends; so they are counted.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import DOP853, RK45

from mehvar.runtime import Model, Status, simulate
from mehvar.runtime.batch.fill import run_batch
from mehvar.runtime.batch.plan import Campaign
from tests.reference.scipy_loop.solvers import Rock4

Array = NDArray[np.float64]
SOLVERS = {"dop853": (DOP853, 8), "dopri5": (RK45, 5), "rock4": (Rock4, 4)}
SAFETY, SHRINK, GROW, MOST_RESERVE, STRETCH = 0.85, 0.2, 10.0, 4 / 3, 1.01
LOOPS = {
    "wild": {"angle_0": 2.5, "k_p": 20.0, "k_d": 0.0, "ref_rate": 0.3, "cube": -40.0},
    "from rest": {"angle_0": 0.0, "angle_ref": 0.0, "k_p": 20.0, "k_d": 0.0, "ref_rate": 0.3},
    "at rest": {"angle_0": 0.0, "angle_ref": 0.0, "k_p": 20.0, "k_d": 0.0},
}
"""The first is refused steps; the second begins without size and slope; the third no error."""
TOLERANCES = ((1e-3, 1e-6), (1e-6, 1e-3), (1e-7, 1e-7))


def steps(
    method: str, slope: Any, q: Array, ticks: Array, tolerance: tuple[float, float]
) -> tuple[Array, int, int, float]:
    """Return the end of a run, its good steps and refused ones, the largest error; control as of Gustafsson."""
    kind, order = SOLVERS[method]
    rtol, atol = tolerance
    solver = kind(slope, ticks[0], q, ticks[1], rtol=rtol, atol=atol)
    t, h, kept, good, refused, largest = ticks[0], solver.h_abs, 1.0, 0, 0, 0.0
    for target in ticks[1:]:
        bounded = False
        while t < target:
            last = target - t <= STRETCH * h
            trial = target - t if last else h
            y, f = _step(solver, slope, t, trial)
            size = atol + rtol * np.maximum(np.abs(solver.y), np.abs(y))
            ratio = solver._estimate_error_norm(solver.K, trial, size)
            reserve = np.inf if ratio == 0 else ratio ** (-0.25 / order)
            if not ratio <= 1:
                h, bounded, refused = trial * min(1.0, _within(reserve**4)), True, refused + 1
                continue
            factor = min(1.0 if bounded else GROW, _within(reserve**3 / kept))
            largest, cut = max(largest, ratio), trial < h
            h = max(h, trial * factor) if cut and factor >= 1 else trial * factor
            kept = kept if cut else min(reserve, MOST_RESERVE)
            t, solver.y, solver.f, bounded, good = target if last else t + trial, y, f, False, good + 1
    return solver.y, good, refused, largest


def _step(solver: Any, slope: Any, t: float, h: float) -> tuple[Array, Array]:
    from scipy.integrate._ivp.rk import rk_step

    y, f = rk_step(slope, t, solver.y, solver.f, h, solver.A, solver.B, solver.C, solver.K)
    return y, f


def _within(factor: float) -> float:
    return float(min(GROW, max(SHRINK, SAFETY * factor)))


@pytest.fixture
def sums_in_order(monkeypatch: pytest.MonkeyPatch) -> None:
    """Sum stages one after the other, as C does: a vector unit sums in an order of its own, and errors cancel."""

    def dot(rows: Array, weights: Array) -> Array:
        return np.asarray(sum((w * row for row, w in zip(rows.T, weights, strict=True)), np.zeros(len(rows))))

    monkeypatch.setattr("numpy.dot", dot)


@pytest.mark.usefixtures("sums_in_order")
@pytest.mark.parametrize("loop", LOOPS)
@pytest.mark.parametrize("method", SOLVERS)
@pytest.mark.share(6)
def test_a_loop_takes_the_steps_of_its_description(pendulum: Model, method: Any, loop: str) -> None:
    values = LOOPS[loop]
    p = pendulum.parameters(**{name: v for name, v in values.items() if name == "cube"})
    refusals = 0
    for rtol, atol in TOLERANCES:
        run = simulate(pendulum, "pd", method=method, rtol=rtol, atol=atol, t_end=3.0, dt_out=1.1, **values)
        assert run.status is Status.DONE

        def slope(t: float, q: Array) -> Array:
            x = np.array([q[0] / 2, q[1]])
            u = -20.0 * (x[0] - values.get("angle_ref", 0.5) - values.get("ref_rate", 0.0) * t)
            dx = pendulum.rhs(x, [u], p)
            return np.array([2 * dx[0], dx[1]])

        start = np.array([2 * values["angle_0"], 0.0])
        end, good, refused, largest = steps(method, slope, start, run.t, (rtol, atol))
        assert (run.statistics["steps"], run.statistics["rejected"]) == (good, refused)
        if rtol < 1e-3:  # there long steps of dop853 magnify rounding to the first digit of their errors
            assert run.error == pytest.approx(largest, rel=1e-3)
        np.testing.assert_allclose(run.x[-1], [end[0] / 2, end[1]], rtol=1e4 * rtol, atol=1e4 * atol)
        refusals += refused
    assert refusals > 0 or loop != "wild"


def test_the_error_of_rk4_is_its_last_slope_against_that_at_its_end(pendulum):
    """A sixth of their difference, over tolerances of 1e-11: another formula has the slope at the end instead."""
    h = 0.01
    campaign = Campaign("pd", n=1, options={"method": "rk4", "step": h, "t_end": h, "dt_out": h})
    error = float(run_batch(pendulum, campaign).dataset()["error"][0])
    run = simulate(pendulum, "pd", method="rk4", step=h, t_end=h, dt_out=h)
    p, c = run.parameters.p, run.parameters.c

    def slope(t: float, q: Array) -> Array:
        r = pendulum.functions["reference"](t, p, run.parameters.s)
        return np.asarray(pendulum.functions["pd_loop"](q, r, p, c))

    q = pendulum.functions["to_coordinates"](run.x[0])
    one = slope(0.0, q)
    two = slope(h / 2, q + h / 2 * one)
    three = slope(h / 2, q + h / 2 * two)
    four = slope(h, q + h * three)
    end = q + h / 6 * (one + 2 * two + 2 * three + four)
    tolerance = 1e-11 * (1 + np.maximum(np.abs(q), np.abs(end)))
    expected = h * np.sqrt(np.mean(((four - slope(h, end)) / 6 / tolerance) ** 2))
    assert error == pytest.approx(expected, rel=1e-6)
