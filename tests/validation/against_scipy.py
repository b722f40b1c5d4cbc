# SPDX-License-Identifier: Apache-2.0
"""The integrator against SciPy's: dop853 step for step, and Radau, which is implicit and shares nothing with it.

One tick of a run whose tolerance lets it go in one step is one step of SciPy's tableau; the run's own sequence of steps
is SciPy's stages, error norm and first step under the control that docs/explanation/numerics.md describes.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import scipy
from scipy.integrate import DOP853, solve_ivp
from scipy.integrate._ivp.rk import rk_step

import mehvar
from mehvar.runtime import simulate
from tests.runtime.native.test_steps import steps
from tests.validation.table import record

EPS = np.finfo(float).eps
LOOPS = {"triangle": "path", "slosh": "lyapunov-v1"}
"""Continuous loops, integrated in regular coordinates."""


@pytest.mark.parametrize("name", LOOPS)
def test_one_tick_is_one_step_of_scipy(name: str) -> None:
    model, law = mehvar.load(name), LOOPS[name]
    errors = []
    for x0 in simulate(model, law, t_end=0.4, dt_out=0.01).x[:-1]:  # a run with one tick: samples between are dense
        initial = dict(zip(model.state_names, x0, strict=True))
        run = simulate(model, law, initial=initial, t_end=0.01, dt_out=0.01, method="dop853", rtol=1e-2, atol=0.9)
        assert run.statistics["steps"] == 1
        slope, q, end = slopes(model, run), coordinates(model, run.x[0]), run.t[-1]
        solver = DOP853(slope, 0.0, q, end)
        q, _ = rk_step(slope, 0.0, q, slope(0.0, q), end, solver.A, solver.B, solver.C, solver.K)
        expected = from_coordinates(model, q)
        errors.append((run.x[-1] - expected) / np.maximum(1.0, np.abs(expected)))
    record(
        f"{name}: {len(errors)} steps of dop853 under {law}, values",
        "SciPy DOP853",
        scipy.__version__,
        errors,
        12 * len(errors) * EPS,
        "of the state or 1",
        "allowed: a rounding for each of the twelve stages of a step",
    )


@pytest.mark.parametrize(("name", "law"), [("triangle", "sliding"), *LOOPS.items()])
def test_the_sequence_of_steps_is_that_of_scipys_estimates(name: str, law: str) -> None:
    model = mehvar.load(name)
    random, errors, moves = np.random.default_rng(1), [], [0]
    for tolerance in (1e-4, 1e-6, 1e-8):
        run = simulate(model, law, t_end=5.0, dt_out=5.0, method="dop853", rtol=tolerance, atol=tolerance)
        start = coordinates(model, run.x[0])
        starts = [start, *(start * (1 + EPS * random.integers(-1, 2, len(start))) for _ in range(8))]
        first, *others = (steps("dop853", slopes(model, run), q, run.t, (tolerance,) * 2)[1:3] for q in starts)
        errors.append(np.subtract((run.statistics["steps"], run.statistics["rejected"]), first))
        moves += [np.abs(np.subtract(other, first)).max() for other in others]
    record(
        f"{name}: steps under {law}, taken and refused in five seconds at 1e-4, 1e-6, 1e-8",
        "SciPy DOP853",
        scipy.__version__,
        errors,
        max(moves),
        "steps",
        "change when SciPy's stages, norm and first step under our control start a rounding away",
    )


def slopes(model: Any, run: Any) -> Any:
    """Return t, q -> q' of the loop of a run."""
    p, c, s = run.parameters.p, run.parameters.c, run.parameters.s
    function, reference = model.functions[f"{run.controller.name.replace('-', '_')}_loop"], model.functions["reference"]
    return lambda t, q: function(q, reference(t, p, s), p, c)


def coordinates(model: Any, x: np.ndarray) -> np.ndarray:
    functions = model.manifest.functions
    return model.functions["to_coordinates"](x) if "to_coordinates" in functions else x


def from_coordinates(model: Any, q: np.ndarray) -> np.ndarray:
    functions = model.manifest.functions
    return model.functions["from_coordinates"](q) if "from_coordinates" in functions else q


@pytest.mark.parametrize("name", LOOPS)
def test_runs_against_radau(name: str) -> None:
    model, law = mehvar.load(name), LOOPS[name]
    run = simulate(model, law, t_end=20.0, dt_out=1.0)
    start = coordinates(model, run.x[0])
    ends = [
        solve_ivp(slopes(model, run), (0, 20), start, "Radau", run.t, rtol=rtol, atol=rtol).y.T for rtol in (1e-7, 1e-9)
    ]
    coarse, fine = (np.array([from_coordinates(model, q) for q in end]) for end in ends)
    size = np.maximum(1.0, np.abs(fine).max(axis=0))
    record(
        f"{name}: twenty seconds under {law} with the defaults",
        "SciPy Radau",
        scipy.__version__,
        (run.x - fine) / size,
        np.abs((coarse - fine) / size).max(),
        "of the state or 1",
        "change of Radau's result between tolerances 1e-7 and 1e-9",
    )
