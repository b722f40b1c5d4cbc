# SPDX-License-Identifier: Apache-2.0
"""Fixed costs of a batch: per call, run and store.

python -m benchmarks.batch.fixed_costs
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path
from statistics import median
from time import process_time
from typing import Any

import mehvar
from benchmarks.machine import command_line, machine, table, write
from mehvar.runtime.batch.fill import run_batch
from mehvar.runtime.batch.kernel import compile_kernel
from mehvar.runtime.batch.plan import Campaign, Plan
from mehvar.runtime.run.options import RunOptions

REPEATS = 7
MANY = 4096
TIGHT: dict[str, Any] = {"rtol": 1e-6, "atol": 1e-6}
LOOPS = {"triangle": ("path", 35.0), "slosh": ("lyapunov-v2", 20.0), "satellite": ("mrac", 20.0)}
SHORT = 1e-3
"""Duration of a run with few steps, s; for a sampled law, the period."""


def main() -> None:
    """Measure and write the page."""
    command_line(__doc__).parse_args()
    rows = [_row(name, law, end) for name, (law, end) in LOOPS.items()]
    columns = ["loop", "a call, us", "a run without steps, us", "64 runs, us each", f"{MANY} runs, us each",
               "64 / many", "a store of 8 runs, ms"]  # fmt: skip
    about = [
        "# Fixed costs of a batch",
        "",
        "Written by `python -m benchmarks.batch.fixed_costs`. Processor time of one thread, medians of "
        f"{REPEATS}; tolerance 1e-6, one sample at the end. The machine was shared: compare columns, not absolutes.",
        "",
        *machine(),
        "",
    ]
    write("fixed_costs.md", [*about, *table(columns, rows)])


def _row(name: str, law: str, end: float) -> list[str]:
    model = mehvar.load(name, backend="c")
    draw = Plan(model, Campaign(law, MANY)).draw(0, MANY)
    kernel = compile_kernel(model, law, options=RunOptions(**TIGHT))
    short = 0.5 if kernel.loop.sampled else SHORT

    def batch(runs: int, t_end: float, dt: float) -> float:
        vectors = (draw.p[:runs], draw.c[:runs], draw.s[:runs], draw.x0[:runs])
        return _seconds(lambda: kernel.run(0, *vectors, seed=0, t_end=t_end, dt=dt))

    call, runs = batch(8, short, short), batch(MANY, short, short)
    dt = 0.5 if kernel.loop.sampled else end
    few, many = batch(64, end, dt) / 64, batch(MANY, end, dt) / MANY
    numbers = [call * 1e6, (runs - call) / MANY * 1e6, few * 1e6, many * 1e6]
    store = _seconds(lambda: _store(name, Campaign(law, 8, options={"t_end": short, "dt_out": short, **TIGHT})))
    return [f"{name}, {law}", f"{numbers[0]:.0f}", *(f"{v:.2f}" for v in numbers[1:]), f"{few / many:.2f}",
            f"{store * 1e3:.0f}"]  # fmt: skip


def _store(model: str, campaign: Campaign) -> None:
    with tempfile.TemporaryDirectory() as folder:
        run_batch(model, campaign, Path(folder) / "runs.zarr", threads=1)


def _seconds(job: Callable[[], object]) -> float:
    """Return the median processor time of calls after the first one; each call is long enough to measure."""
    times = []
    for _ in range(REPEATS + 1):
        started, count = process_time(), 0
        while process_time() - started < 0.02:
            job()
            count += 1
        times.append((process_time() - started) / count)
    return median(times[1:])


if __name__ == "__main__":
    main()
