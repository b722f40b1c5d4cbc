# SPDX-License-Identifier: Apache-2.0
"""Call every generated function and every loop of the named models, under sanitizers.

python tests/gates/exercise.py MODEL[:LAW]...
"""

from __future__ import annotations

import itertools
import sys
from collections.abc import Iterator

import numpy as np

from mehvar.base.manifest import Controller
from mehvar.runtime import Model, load, simulate
from mehvar.runtime.batch.kernel import compile_kernel
from mehvar.runtime.compiling.processor import widest
from mehvar.runtime.model.parameters import Resolved
from mehvar.runtime.run.options import Method, RunOptions

METHODS: tuple[Method, ...] = ("dop853", "dopri5", "rock4", "rodas5p", "rk4")
KERNELS = itertools.cycle(itertools.product((widest(), 1), METHODS))
PERIOD = 0.5  # s
LOOSE = {"rtol": 1e-5, "atol": 1e-5}
RUNS = 11  # not a multiple of the lanes


def functions(model: Model) -> Iterator[str]:
    """Call each function twice at ordinary numbers, at zero, at huge ones and at NaN."""
    random = np.random.default_rng(1)
    for name, function in model.functions.items():
        shapes = [(2, *argument.shape) for argument in model.manifest.functions[name].arguments]
        function(*(random.uniform(0.1, 1.0, shape) for shape in shapes))
        for value in (0.0, 1e300, -1e300, np.inf, np.nan):
            function(*(np.full(shape, value) for shape in shapes))
        yield name


def runs(model: Model, law: Controller) -> Iterator[str]:
    """Run a law with each method, continuous where it may be, sampled, delayed and in float."""
    for method in METHODS:
        step = {"step": PERIOD / 10} if method == "rk4" else LOOSE
        if law.period is None:
            simulate(model, law.name, t_end=4 * PERIOD, dt_out=PERIOD, method=method, **step)
            yield f"{law.name} {method} continuous"
        hold = {"hold": PERIOD} if law.period is None else {}
        for real in ("double", "float"):
            simulate(model, law.name, t_end=6.0, dt_out=PERIOD, method=method, delay=1, real=real, **hold, **step)
            yield f"{law.name} {method} sampled {real}"


def block(model: Model, law: Controller, lanes: int, method: Method) -> None:
    """Run a block whose last lanes are idle, with two threads, series and noise; NaN retires one run."""
    alone = simulate(model, law.name, t_end=PERIOD, dt_out=PERIOD)
    p, c, s, x0 = (np.tile(v, (RUNS, 1)) for v in (*vectors(alone.parameters), alone.x[0]))
    p[:, [name.startswith("noise") for name in model.parameter_names]] = 1e-5
    x0[3, 0] = np.nan
    hold = PERIOD if law.period is None else None
    tolerances = {} if method == "rk4" else LOOSE
    options = RunOptions(method=method, hold=hold, delay=1, **tolerances)
    kernel = compile_kernel(model, law.name, options=options, lanes=lanes)
    kernel.run(0, p, c, s, x0, seed=1, t_end=6.0, dt=PERIOD, save_every=2 * PERIOD, threads=2)


def vectors(found: Resolved) -> tuple[np.ndarray, ...]:
    return found.p, found.c, found.s


def main(names: list[str]) -> None:
    for name, _, only in (text.partition(":") for text in names):
        model = load(name, backend="c")
        done = list(functions(model))
        for law in (law for law in model.manifest.controllers.values() if only in ("", law.name)):
            done += runs(model, law)
            block(model, law, *next(KERNELS))
        print(f"{name}: {len(done)} exercises")


if __name__ == "__main__":
    main(sys.argv[1:])
