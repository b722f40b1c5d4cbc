# SPDX-License-Identifier: Apache-2.0
"""Initial value problems x' = f(x, k) with constants k of each run, equal for all integrators."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.peers.equations import Equations, packed
from mehvar.base.names import identifier
from mehvar.codegen.code.files import PrintedFunction
from mehvar.codegen.generate import generate, installed_tree
from mehvar.runtime import Model, load, simulate
from mehvar.runtime.batch.kernel import compile_kernel
from mehvar.runtime.run.options import RunOptions

Array = NDArray[np.float64]

RUNS = 2048
SPREAD = 0.05  # of every parameter and initial state, relative, uniform
REFERENCE_TOLERANCE = 1e-13
CHECKED = 64  # runs that errors are taken of


@dataclass(frozen=True)
class Case:
    """A model under a law, or with the law's first input held to the end.

    `sample` is the distance of our samples in a closed loop, s; None for an open loop.
    `share` tells how many runs a timing takes, of those that are usual.
    """

    title: str
    model: str
    law: str
    t_end: float
    structure: Mapping[str, str] = field(default_factory=dict)
    scenario: str | None = None
    sample: float | None = None
    share: float = 1.0


CASES = {
    "slosh": Case("slosh, two pendulums, 10 s", "slosh", "lyapunov-v1", 10.0),
    "ball": Case("slosh on ball joints, 10 s", "slosh", "lyapunov-v1", 10.0,
                 {"inertia": "ball", "attitude": "quaternion"}),
    "satellite": Case("satellite, 100 s", "satellite", "pd", 100.0),
}  # fmt: skip
LOOPS = {
    "slosh": Case("slosh, lyapunov-v2, 100 s", "slosh", "lyapunov-v2", 100.0, sample=1.0, share=1 / 16),
    "triangle": Case("triangle, path, 35 s", "triangle", "path", 35.0, sample=0.1, share=1 / 32),
}


@dataclass(frozen=True)
class Problem:
    """An initial value problem and its contender.

    Attributes
    ----------
    slope : PrintedFunction
        What our kernel calls at every stage, as a function of (x, k).
    start, k : array, (runs, states) and (runs, constants)
        Initial states, in regular coordinates where a loop has them; what depends on parameters and held input alone.
    p, c, s, x0 : array
        What our kernel takes instead.
    reference : array, (CHECKED, states)
        The first runs' states at the end.
    """

    case: Case
    model: Model
    slope: PrintedFunction
    start: Array
    k: Array
    p: Array
    c: Array
    s: Array
    x0: Array
    reference: Array

    def ours(self, options: Mapping[str, Any]) -> Callable[[int], Array]:
        """Compile mehvar's kernel; return a function that integrates the first n runs."""
        case = self.case
        held = {} if case.sample else {"hold": case.t_end}
        kernel = compile_kernel(self.model, case.law, options=RunOptions(**held, **options))
        functions = self.model.functions
        charted = case.sample and "to_coordinates" in functions

        def integrate(n: int) -> Array:
            given = (v[:n] for v in (self.p, self.c, self.s, self.x0))
            block = kernel.run(0, *given, seed=0, t_end=case.t_end, dt=case.sample or case.t_end)
            assert block is not None
            assert not block.status.any(), "a run ended early"
            return np.array(functions["to_coordinates"](block.final)) if charted else block.final

        return integrate

    def error(self, final: Array) -> Array:
        """Return the error of each checked run: the largest |x - x_ref| / (1 + |x_ref|) over the states."""
        n = min(CHECKED, len(final))
        wanted = self.reference[:n]
        distance: Array = np.max(np.abs(final[:n] - wanted) / (1 + np.abs(wanted)), axis=1)
        return distance


def problem(case: Case, scratch: Path) -> Problem:
    """Make a problem: dispersed runs, the held input or the law's loop, the equations, the reference."""
    model = loaded(case, scratch)
    held = {} if case.sample else {"hold": case.t_end}
    p, c, s, x0 = dispersed(model, case.law, case.scenario, held, RUNS)
    equations, functions = Equations(case.model, case.structure), model.functions
    known = {"p": p, "c": c}
    if case.sample:
        name, state = f"{identifier(case.law)}_loop", "q"
        known["r"] = np.array(functions["reference"](0.0, p, s))
        start = np.array(functions["to_coordinates"](x0)) if "to_coordinates" in functions else x0
    else:
        name, state, start = "rhs", "x", x0
        known["u"] = first_input(case, model, p, c, s, x0)
    for part in equations.parts(name):
        given = [known[argument] for argument, _ in part.arguments]
        known[part.results[0][0]] = np.array(functions[part.name](*given))
    slope, constants = packed(equations.best(name), state)
    k = np.stack([known[argument][:, element] for argument, element in constants], axis=1)
    found = Problem(case, model, slope, start, k, p, c, s, x0, np.empty(0))
    exact = found.ours({"rtol": REFERENCE_TOLERANCE, "atol": REFERENCE_TOLERANCE})
    return replace(found, reference=exact(CHECKED))


def first_input(case: Case, model: Model, *vectors: Array) -> Array:
    """Return the input that mehvar's kernel holds in each run."""
    kernel = compile_kernel(model, case.law, options=RunOptions(hold=case.t_end))
    block = kernel.run(0, *vectors, seed=0, t_end=case.t_end, dt=case.t_end, save_every=case.t_end)
    assert block is not None
    return np.ascontiguousarray(block.series[:, 0, [kernel.variables.index(f"u_{u}") for u in model.input_names]])


def loaded(case: Case, scratch: Path) -> Model:
    if not case.structure:
        return load(case.model, backend="c")
    folder = scratch / "-".join([case.model, *case.structure.values()])
    generate(installed_tree(), case.model, folder, case.structure)
    return load(folder, backend="c")


def dispersed(
    model: Model, law: str, scenario: str | None, options: Mapping[str, Any], runs: int
) -> tuple[Array, Array, Array, Array]:
    """Return parameters of plant, law and scenario and the initial states of all runs."""
    period = model.manifest.controller(law).period
    short = {} if period is not None else {k: min(v, 1.0) for k, v in options.items()}
    resolved = simulate(model, law, scenario, t_end=1.0, dt_out=1.0, **short).parameters
    generator = np.random.Generator(np.random.Philox(1))
    vectors = (resolved.p, resolved.c, resolved.s)
    p, c, s = (v * (1 + SPREAD * generator.uniform(-1, 1, (runs, v.size))) for v in vectors)
    if period is not None:
        column = model.parameter_names.index(period)
        p[:, column] = options.get("hold", resolved.p[column])
    return p, c, s, np.array(model.functions["initial"](p, s))
