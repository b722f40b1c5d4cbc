# SPDX-License-Identifier: Apache-2.0
"""Runs of a batch one after the other by the loop of a single run, the reference for the kernel."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import replace

import numpy as np

from mehvar import runtime
from mehvar.base.names import identifier
from mehvar.runtime.batch.kernel import Block, Kernel
from mehvar.runtime.model.functions import CBackend
from mehvar.runtime.model.parameters import Resolved
from mehvar.runtime.run import loop
from mehvar.runtime.run.metrics import evaluate
from mehvar.runtime.run.noise import normals
from mehvar.runtime.run.problem import Problem, Status
from mehvar.runtime.run.ticks import rows_of, ticks_of


def run_alone(
    model: runtime.Model, kernel: Kernel, p, c, s, x0, *, t_end: float, dt: float, seed: int = 0, first_run: int = 0
) -> Block:
    """Compute the results of `kernel`, with every sample in the series."""
    manifest, law = model.manifest, kernel.loop.controller
    hold = kernel.options.hold
    if hold is None and law.period is not None:
        hold = float(p[0, model.parameter_names.index(law.period)])
    t, record_every, hold_every = ticks_of(t_end, dt, hold, "the test")
    regular_t = rows_of(dt, t_end, dt, "the test")
    block = Block.empty(kernel.loop, len(p), len(regular_t))
    evaluations = 0 if hold_every is None else (len(t) - 1) // hold_every + 1
    for i in range(len(p)):
        z0 = np.empty(0)
        if law.memory:
            r = model.functions["reference"](0.0, p[i], s[i])
            z0 = np.array(model.functions[f"{identifier(law.name)}_start"](x0[i], r, p[i], c[i]))
        noise = normals(seed, first_run + i, evaluations, len(manifest.noise))
        step = kernel.options.step or min(dt, hold or dt)
        problem = Problem(
            model, law, Resolved(p[i], c[i], s[i], {}, {}), replace(kernel.options, seed=seed, run=first_run + i),
            x0[i], z0, noise, kernel.loop.suffix, t, dt, hold, record_every, hold_every, (), kernel.loop.method, False,
            step, None,
        )  # fmt: skip
        assert isinstance(model.evaluator, CBackend)
        one = loop.run(problem, lambda: None)
        command = [one.u_cmd] if kernel.loop.records_command else []
        series = np.concatenate([one.x, one.u, *command, one.y, one.z], axis=1)
        columns = dict(zip(kernel.variables, series.T, strict=True))
        block.final[i], block.status[i], block.t_stop[i] = one.x_stop, one.status, one.t_stop
        block.violated[i] = one.violated
        block.steps[i] = one.statistics["steps"]
        block.minimum[i], block.maximum[i] = series.min(axis=0), series.max(axis=0)
        counts = Counter(problem.events[number].name for _, number in one.crossings)
        block.events[i] = [counts[event.name] for event in problem.events]
        cut = math.inf if one.status is Status.DONE else one.t_stop
        block.metric_values[i] = [evaluate(m, one.t, columns, counts, cut) for m in manifest.metrics.values()]
        regular = np.isin(one.t, regular_t)
        block.series[i, : regular.sum()] = series[regular]
    return block
