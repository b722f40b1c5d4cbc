# SPDX-License-Identifier: Apache-2.0
"""Initial value problems x' = f(x, k) with constants k of each run, the same for everybody."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from codegen.generate import generate, installed_tree
from codegen.texts import PrintedFunction
from peers.equations import Equations, packed
from runtime import Model, load, simulate
from runtime.batch_kernel import compile_kernel

Array = NDArray[np.float64]

RUNS = 2048
SPREAD = 0.05  # of every parameter and initial state, relative, uniform
REFERENCE_TOLERANCE = 1e-13
CHECKED = 64  # runs that errors are taken of


@dataclass(frozen=True)
class Case:
    """A model without its law: the law's first input is held to the end."""

    title: str
    model: str
    law: str
    t_end: float
    structure: Mapping[str, str]


CASES = {
    "slosh": Case("slosh, two pendulums, 10 s", "slosh", "lyapunov-v1", 10.0, {}),
    "ball": Case("slosh on ball joints, 10 s", "slosh", "lyapunov-v1", 10.0,
                 {"inertia": "ball", "attitude": "quaternion"}),
    "satellite": Case("satellite, 100 s", "satellite", "pd", 100.0, {}),
    "triangle": Case("triangle, 10 s", "triangle", "path", 10.0, {}),
}  # fmt: skip


@dataclass(frozen=True)
class Problem:
    """Who integrates what from where to when.

    Attributes
    ----------
    slope : PrintedFunction
        What our kernel calls at every stage, as a function of (x, k).
    x0, k : array, (runs, states) and (runs, constants)
        Initial states; what depends on parameters and held input alone.
    p, c, s, u : array
        What our kernel takes instead, and the input that it holds.
    reference : array, (CHECKED, states)
        The first runs' states at the end.
    """

    case: Case
    model: Model
    slope: PrintedFunction
    x0: Array
    k: Array
    p: Array
    c: Array
    s: Array
    u: Array
    reference: Array

    def error(self, final: Array) -> Array:
        """Return the error of each checked run: the largest |x - x_ref| / (1 + |x_ref|) over the states."""
        wanted = self.reference
        distance: Array = np.max(np.abs(final[:CHECKED] - wanted) / (1 + np.abs(wanted)), axis=1)
        return distance


def problem(name: str, scratch: Path) -> Problem:
    """Make a problem: dispersed runs, the held input, the equations, the reference."""
    case = CASES[name]
    model = _load(case, scratch)
    p, c, s, x0 = dispersed(model, case.law, case.t_end, RUNS)
    exact = {"hold": case.t_end, "rtol": REFERENCE_TOLERANCE, "atol": REFERENCE_TOLERANCE}
    kernel = compile_kernel(model, case.law, **exact)
    found = kernel.run(0, p, c, s, x0, seed=0, t_end=case.t_end, dt=case.t_end, save_every=case.t_end)
    assert found is not None and not found.status.any(), "a run of the reference ended early"
    columns = [kernel.variables.index(f"u_{name}") for name in model.input_names]
    u = np.ascontiguousarray(found.series[:, 0, columns])
    equations = Equations(case.model, case.structure)
    known = {"u": u, "p": p}
    for part in equations.parts("rhs"):
        given = [known[argument] for argument, _ in part.arguments]
        known[part.results[0][0]] = np.array(model.functions[part.name](*given))
    slope, held = packed(equations.best("rhs"), "x")
    k = np.stack([known[argument][:, element] for argument, element in held], axis=1)
    return Problem(case, model, slope, x0, k, p, c, s, u, found.final[:CHECKED])


def _load(case: Case, scratch: Path) -> Model:
    if not case.structure:
        return load(case.model, backend="c")
    folder = scratch / "-".join([case.model, *case.structure.values()])
    generate(installed_tree(), case.model, folder, case.structure)
    return load(folder, backend="c")


def dispersed(model: Model, law: str, hold: float | None, runs: int) -> tuple[Array, Array, Array, Array]:
    """Return parameters of plant, law and scenario and the initial states of all runs."""
    options = {} if hold is None else {"hold": hold}
    nominal = simulate(model, law, t_end=1.0 if hold is None else hold, dt_out=1.0 if hold is None else hold, **options)
    generator = np.random.Generator(np.random.Philox(1))
    resolved, period = nominal.parameters, nominal.controller.period
    p, c, s = (v * (1 + SPREAD * generator.uniform(-1, 1, (runs, v.size))) for v in
               (resolved.p, resolved.c, resolved.s))  # fmt: skip
    if period is not None:
        column = model.parameter_names.index(period)
        p[:, column] = resolved.p[column]
    return p, c, s, np.array(model.functions["initial"](p, s))
