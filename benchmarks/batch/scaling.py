# SPDX-License-Identifier: Apache-2.0
"""Scaling of a batch with threads and with the number of pendulums.

python -m benchmarks.batch.scaling          # all parts
python -m benchmarks.batch.scaling threads  # some
"""

from __future__ import annotations

import os
import resource
import tempfile
from collections.abc import Callable
from pathlib import Path
from statistics import median
from time import perf_counter, process_time

import numpy as np

from benchmarks.machine import command_line, machine, table, write
from mehvar.codegen.generate import generate, installed_tree
from mehvar.runtime import load
from mehvar.runtime.batch.kernel import Kernel, compile_kernel
from mehvar.runtime.model.parameters import resolve
from mehvar.runtime.run.options import RunOptions

REPEATS = 5
RUNS = 2048
PENDULUMS = (2, 4, 8, 16, 32, 64)
TIGHT = {"rtol": 1e-6, "atol": 1e-6}
INERTIAS = {"paper": "angles", "ball": "quaternion"}
PARTS = ("threads", "pendulums")


def main() -> None:
    """Measure, and write a page for each part."""
    makers: dict[str, Callable[[], list[str]]] = {"threads": threads, "pendulums": pendulums}
    for name in command_line(__doc__, makers).parse_args().parts or makers:
        write(f"batch_scaling_{name}.md", makers[name]())


def threads() -> list[str]:
    """Compare one thread with two on the same runs, in turns."""
    model = load("slosh", backend="c")
    vectors = _nominal("slosh", model)
    kernel = compile_kernel(model, "lyapunov-v1", options=RunOptions(**TIGHT))
    times: dict[int, list[tuple[float, float]]] = {1: [], 2: []}
    for _ in range(REPEATS):
        for count, several in times.items():
            wall, processor = perf_counter(), process_time()
            kernel.run(0, *vectors, seed=0, t_end=100.0, dt=1.0, threads=count)
            several.append((perf_counter() - wall, process_time() - processor))
    rows = [
        [
            *(str(count), f"{median(w for w, _ in several):.2f}", f"{min(w for w, _ in several):.2f}"),
            *(f"{median(c for _, c in several):.2f}", f"{min(c for _, c in several):.2f}"),
        ]
        for count, several in times.items()
    ]
    columns = ["threads", "wall time, s", "least", "processor time, s", "least"]
    return [
        "# Threads",
        "",
        "Written by `python -m benchmarks.batch.scaling threads`.",
        f"{RUNS} runs of slosh, lyapunov-v1, 100 s, tolerance 1e-6; medians of {REPEATS} repeats in turns.",
        "",
        *machine(),
        "- other programs ran on the two cores, so wall time says little; equal processor time says that the threads",
        "  do not wait for one another",
        "",
        *table(columns, rows),
    ]


def pendulums() -> list[str]:
    """Integrate slosh with more and more pendulums; operations and time per pendulum."""
    rows = []
    for inertia, attitude in INERTIAS.items():
        for count in PENDULUMS:
            structure = {"pendulums": str(count), "inertia": inertia, "attitude": attitude}
            with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryDirectory() as cache:
                os.environ["MEHVAR_CACHE"] = cache  # nothing has been compiled before
                started = process_time()
                generate(installed_tree(), "slosh", Path(folder), structure)
                derived = process_time() - started
                model = load(folder, backend="python")
                vectors = _nominal("slosh", model)
                before = _children()
                kernel = compile_kernel(model, "lyapunov-v1", options=RunOptions(hold=10.0, method="rk4", step=0.1))
                compiled = _children() - before
                rows.append([inertia, str(count), *_timed(kernel, vectors, count), f"{derived:.0f}", f"{compiled:.1f}"])
                operations = model.manifest.functions["rhs_prepared"].operations
                rows[-1][2:2] = [str(operations), f"{operations / count:.0f}"]
            print(rows[-1], flush=True)
            write("batch_scaling_pendulums.md", _pendulum_page(rows))
    return _pendulum_page(rows)


def _pendulum_page(rows: list[list[str]]) -> list[str]:
    columns = ["inertia", "pendulums", "operations", "per pendulum", "ns per right-hand side and run",
               "per pendulum", "deriving, s", "compiling the kernel, s"]  # fmt: skip
    return [
        "# Number of pendulums",
        "",
        "Written by `python -m benchmarks.batch.scaling pendulums`.",
        "Slosh with held input, rk4, 100 steps of 0.1 s. The time of a run over its 400 right-hand sides, so it",
        "contains the sums of the stages and what a run costs besides. Operations: of the right-hand side without what",
        "is computed once per run. Times of deriving and compiling are those of the processor.",
        "",
        *machine(),
        "",
        *table(columns, rows),
    ]


def _children() -> float:
    """Return the processor time of the compilers that have ended, s."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _timed(kernel: Kernel, vectors: tuple[np.ndarray, ...], count: int) -> list[str]:
    runs = max(32, RUNS // count // 2)
    times = []
    for _ in range(REPEATS):
        started = process_time()
        kernel.run(0, *(v[:runs] for v in vectors), seed=0, t_end=10.0, dt=10.0)
        times.append(process_time() - started)
    ns = median(times) / runs / 400 * 1e9
    return [f"{ns:.0f}", f"{ns / count:.0f}"]


def _nominal(name: str, model: object) -> tuple[np.ndarray, ...]:
    """Return the vectors of the first scenario, with initial states that differ a little."""
    manifest, functions = model.manifest, model.functions  # type: ignore[attr-defined]
    law = manifest.controller("lyapunov-v1")
    result = resolve(manifest, functions, law, manifest.scenario(None), {}, name, ())
    p, c, s = (np.tile(v, (RUNS, 1)) for v in (result.p, result.c, result.s))
    s *= 1 + 0.05 * np.random.Generator(np.random.Philox(1)).uniform(-1, 1, s.shape)
    return p, c, s, np.array(functions["initial"](p, s))


if __name__ == "__main__":
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    main()
