# SPDX-License-Identifier: Apache-2.0
"""Trajectories per core-second of batches, with the error they have: open loop and closed loop, all models.

Run: python benchmarks/batch.py
"""

from __future__ import annotations

from dataclasses import dataclass, field
from statistics import median
from time import process_time
from typing import Any

import numpy as np
from machine import machine, table, write
from numpy.typing import NDArray

from runtime import Model, load, simulate
from runtime.batch_kernel import compile_kernel
from runtime.processor import widest

Array = NDArray[np.float64]

RUNS = 2048
REPEATS = 5
LONG = 100.0  # seconds of simulated time, from which fewer runs are enough
SPREAD = 0.05  # of every parameter and initial state, relative, uniform
REFERENCE = {"rtol": 1e-12, "atol": 1e-12}


@dataclass(frozen=True)
class Case:
    """A loop to run: model, law, duration, sampling step, and how it is integrated."""

    title: str
    model: str
    law: str
    t_end: float
    dt: float
    options: dict[str, Any] = field(default_factory=dict)


def cases() -> list[Case]:
    """List the loops, each at a few tolerances."""
    found = []
    for tolerance in (1e-6, 1e-8, 1e-10):
        held = {"hold": 10.0, "rtol": tolerance, "atol": tolerance}
        found.append(Case("slosh, input held for 10 s", "slosh", "lyapunov-v1", 10.0, 10.0, held))
    for tolerance in (1e-6, 1e-8):
        options = {"rtol": tolerance, "atol": tolerance}
        found += [
            Case("slosh, lyapunov-v1, 10 s", "slosh", "lyapunov-v1", 10.0, 1.0, options),
            Case("triangle, path, 35 s", "triangle", "path", 35.0, 0.1, options),
            Case(
                "triangle, sliding, sampled at 0.1 s, 35 s", "triangle", "sliding", 35.0, 0.1, {"hold": 0.1, **options}
            ),
            Case("satellite, mrac, 800 s", "satellite", "mrac", 800.0, 0.5, options),
        ]
    found.append(Case("satellite, pd, rk4, 800 s", "satellite", "pd", 800.0, 0.5, {"method": "rk4"}))
    return found


def main() -> None:
    """Run every case in both profiles and write the table."""
    rows = [row for case in cases() for row in measured(case)]
    columns = ["loop", "method", "tolerance", "profile", "runs per core-second", "ns per step", "steps", "median error",
               "largest error", "ended early"]  # fmt: skip
    caveats = [
        f"- {RUNS} runs with {100 * SPREAD:g} % uniform spread of parameters and initial states, {widest()} lanes, "
        "one thread; processor time of the process, median of repeats",
        f"- error: largest |x - x_ref|/(1 + |x_ref|) over the states at the end; reference at tolerance "
        f"{REFERENCE['rtol']:g}, runs that end early left out",
    ]
    write("batch.md", ["# Batches", "", *machine(), *caveats, "", *table(columns, rows)])


def measured(case: Case) -> list[list[str]]:
    """Return a row for each profile."""
    model = load(case.model, backend="c")
    vectors = dispersed(model, case)
    runs = RUNS if case.t_end < LONG else RUNS // 8
    few = [v[: min(runs, 64)] for v in vectors]
    span = {"seed": 0, "t_end": case.t_end, "dt": case.dt}
    exact = {k: v for k, v in case.options.items() if k == "hold"}
    reference = compile_kernel(model, case.law, **exact, **REFERENCE).run(0, *few, **span)
    rows = []
    for profile in ("portable", "fast"):
        kernel = compile_kernel(model, case.law, profile=profile, **case.options)
        times = []
        for _ in range(REPEATS):
            start = process_time()
            block = kernel.run(0, *(v[:runs] for v in vectors), **span)
            times.append(process_time() - start)
        good = (reference.status == 0) & (block.status[: len(few[0])] == 0)
        error = np.abs(block.final[: len(few[0])] - reference.final) / (1 + np.abs(reference.final))
        worst, steps, best = error[good].max(axis=1), block.steps.mean(), median(times)
        rows.append(
            [
                *(case.title, kernel.loop.method, f"{case.options.get('rtol', float('nan')):g}", profile),
                *(f"{runs / best:,.0f}", f"{best / block.steps.sum() * 1e9:.0f}", f"{steps:.1f}"),
                *(f"{np.median(worst):.1e}", f"{worst.max():.1e}", f"{(block.status != 0).mean():.1%}"),
            ]
        )
        print(*rows[-1], sep=" | ", flush=True)
    return rows


def dispersed(model: Model, case: Case) -> list[Array]:
    """Return parameters and initial states of all runs."""
    hold = {"hold": case.options["hold"]} if "hold" in case.options else {}
    nominal = simulate(model, case.law, t_end=case.dt, dt_out=case.dt, **hold)
    generator = np.random.Generator(np.random.Philox(1))
    resolved, period = nominal.parameters, nominal.controller.period
    p, c, s = (
        v * (1 + SPREAD * generator.uniform(-1, 1, (RUNS, v.size))) for v in (resolved.p, resolved.c, resolved.s)
    )
    if period is not None:
        column = model.parameter_names.index(period)
        p[:, column] = resolved.p[column]
    return [p, c, s, np.array(model.functions["initial"](p, s))]


if __name__ == "__main__":
    main()
