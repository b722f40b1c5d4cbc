# SPDX-License-Identifier: Apache-2.0
"""Effect of the tolerance: metrics of the default scenarios by tolerance, and error against time of all methods.

python -m benchmarks.batch.precision
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from statistics import median
from time import process_time
from typing import Any

import numpy as np
from numpy.typing import NDArray

import mehvar
from benchmarks.machine import RESULTS, command_line, machine, table, write
from mehvar.runtime.batch.blocks import Blocks
from mehvar.runtime.batch.kernel import compile_kernel
from mehvar.runtime.batch.plan import Campaign, Plan
from mehvar.runtime.run.options import Method, RunOptions

Array = NDArray[np.float64]

REPEATS = 5
REFERENCE = 1e-13
ALLOWED = 1e-7
"""Allowed difference of a metric between a looser default and the present one."""
DEFAULT = RunOptions().rtol
LOOSER = (1e-7, 1e-8, 1e-9, 1e-10, 3e-11, DEFAULT)
TOLERANCES = tuple(10.0**-k for k in range(4, 12))
METHODS: tuple[Method, ...] = ("dop853", "dopri5", "rock4", "rodas5p", "auto")
COLOURS = ("#000000", "#56B4E9", "#009E73", "#D55E00", "#CC79A7")
"""Palette of Okabe and Ito; and a marker for each, so that the picture can be read without colour."""
MARKERS = "os^Dx"


@dataclass(frozen=True)
class Case:
    """A dispersed loop: number of runs; duration and samples for the comparison of methods."""

    model: str
    law: str
    vary: Mapping[str, str]
    runs: int
    t_end: float
    dt: float


CASES = (
    Case("triangle", "path", {"k_phi": "uniform(0.3, 0.7)"}, 256, 35.0, 0.1),
    Case("triangle", "sliding", {"k_phi": "uniform(0.3, 0.7)"}, 256, 60.0, 0.1),
    Case("slosh", "lyapunov-v2", {"m1": "normal(50, 2)", "eps1": "uniform(2, 5)"}, 64, 100.0, 1.0),
    Case("satellite", "mrac", {"yaw_0_deg": "uniform(3, 7)"}, 64, 100.0, 0.5),
)


def main() -> None:
    """Measure and write the page with its pictures."""
    command_line(__doc__).parse_args()
    lines = [*_head(), *machine(), "", *_metrics_part()]
    ladders = {f"{case.model}, {case.law}": _ladder(case) for case in CASES}
    _picture(ladders)
    lines += ["## All methods", "", "![error against time](precision.svg)", ""]
    for title, rows in ladders.items():
        lines += _ladder_table(title, rows)
    write("precision.md", lines)


def _head() -> list[str]:
    return [
        "# What a tolerance buys",
        "",
        "Written by `python -m benchmarks.batch.precision`, which takes ten minutes. Processor time of one thread in",
        f"batches; of {REPEATS} repeats in which all take turns the least, and the median beside it. The machine was",
        "shared.",
        "",
    ]


def _metrics_part() -> list[str]:
    """Return the table of metric errors of default batches, by tolerance."""
    rows = [row for case in CASES for row in _metric_rows(case)]
    columns = ["loop", "tolerance", "ms a run", "largest difference", "of", f"above {ALLOWED:g}"]
    return [
        "## Metrics of default batches",
        "",
        "Whole scenarios with their own samples. The largest difference of a metric from that at the default tolerance",
        f"of {DEFAULT:g}, relative to 1 + |metric|, which metric that is, and how many of all runs' metrics differ by",
        f"more than {ALLOWED:g}. The default stays: ten times as loose it would save a quarter of the triangle's time",
        "and nothing elsewhere, and a run alone would not have the bits of a batch, unless all results were new.",
        "",
        *table(columns, rows),
        "",
    ]


def _metric_rows(case: Case) -> list[list[str]]:
    model = mehvar.load(case.model, backend="c")
    rows, present = [], None
    for tolerance in reversed(LOOSER):
        options = {} if tolerance == DEFAULT else {"rtol": tolerance, "atol": tolerance}
        blocks = Blocks(Plan(model, Campaign(case.law, case.runs, vary=dict(case.vary), options=options)), 1)
        least, _, values = _timed(lambda blocks=blocks: blocks.compute(0, case.runs))
        names = [metric.name for metric in blocks.metrics]
        metrics = np.stack([values[name] for name in names], axis=1)
        present = metrics if present is None else present
        gaps = _gaps(metrics, present)
        worst = names[int(np.argmax(gaps.max(axis=0)))] if gaps.any() else "-"
        above = f"{np.count_nonzero(gaps > ALLOWED)} of {gaps.size}"
        title = f"{case.model}, {case.law}"
        rows.append([title, f"{tolerance:g}", f"{least / case.runs * 1e3:.2f}", f"{gaps.max():.1e}", worst, above])
    return rows


def _gaps(values: Array, expected: Array) -> Array:
    """Return relative differences: zero if both values are equally not finite, infinite if only one is."""
    with np.errstate(invalid="ignore"):
        gaps: Array = np.abs(values - expected) / (1 + np.abs(expected))
    alike = (values == expected) | (np.isnan(values) & np.isnan(expected))
    return np.where(alike, 0.0, np.where(np.isfinite(gaps), gaps, np.inf))


@dataclass(frozen=True)
class _Rung:
    method: str
    tolerance: float
    least: float
    usual: float
    error: float
    steps: float


def _ladder(case: Case, runs: int = 16) -> list[_Rung]:
    """Return time and error of every method at every tolerance; the error is the median over runs."""
    model = mehvar.load(case.model, backend="c")
    draw = Plan(model, Campaign(case.law, runs, vary=dict(case.vary))).draw(0, runs)
    states = len(model.state_names)

    def batch(method: Method, tolerance: float) -> Callable[[], Any]:
        kernel = compile_kernel(model, case.law, options=RunOptions(method=method, rtol=tolerance, atol=tolerance))
        request = {"seed": 0, "t_end": case.t_end, "dt": case.dt, "save_every": case.dt}
        return lambda: kernel.run(0, draw.p, draw.c, draw.s, draw.x0, **request)

    exact = batch("dop853", REFERENCE)().series[:, :, :states]
    jobs = {(method, tolerance): batch(method, tolerance) for method in METHODS for tolerance in TOLERANCES}
    blocks = {key: job() for key, job in jobs.items()}
    times: dict[Any, list[float]] = {key: [] for key in jobs}
    for _ in range(REPEATS):
        for key, job in jobs.items():
            started = process_time()
            job()
            times[key].append((process_time() - started) / runs)
    return [
        _Rung(
            *key, min(times[key]), median(times[key]),
            float(np.median(_gaps(block.series[:, :, :states], exact).max(axis=(1, 2)))), float(block.steps.mean()),
        )
        for key, block in blocks.items()
    ]  # fmt: skip


def _timed(job: Callable[[], Any]) -> tuple[float, float, Any]:
    """Return minimum and median processor time after a first call, and the result of the job."""
    times, result = [], job()
    for _ in range(REPEATS):
        started = process_time()
        result = job()
        times.append(process_time() - started)
    return min(times), median(times), result


def _ladder_table(title: str, rungs: Sequence[_Rung]) -> list[str]:
    cells = {(r.method, r.tolerance): f"{r.least * 1e3:.3f} ({r.usual * 1e3:.3f}) / {r.error:.0e}" for r in rungs}
    rows = [[f"{tolerance:.0e}", *(cells[method, tolerance] for method in METHODS)] for tolerance in TOLERANCES]
    about = "Least (median) time in ms a run / error of the states at the samples, of the median run."
    return [f"### {title}", "", about, "", *table(["tolerance", *METHODS], rows), ""]


def _picture(ladders: Mapping[str, Sequence[_Rung]]) -> None:
    import matplotlib as mpl

    mpl.use("Agg")
    mpl.rcParams["svg.hashsalt"] = "mehvar"
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, len(ladders), figsize=(3.2 * len(ladders), 3.4), squeeze=False)
    for axis, (title, rungs) in zip(axes[0], ladders.items(), strict=True):
        for method, colour, marker in zip(METHODS, COLOURS, MARKERS, strict=True):
            points = [(r.error, r.least * 1e3) for r in rungs if r.method == method]
            axis.plot(*zip(*points, strict=True), color=colour, marker=marker, markersize=4, label=method)
        axis.set(xscale="log", yscale="log", title=title, xlabel="error of the samples [1]")
        axis.invert_xaxis()
        axis.grid(True, alpha=0.3)
    axes[0][0].set_ylabel("processor time a run [ms]")
    figure.legend(*axes[0][0].get_legend_handles_labels(), loc="lower center", ncols=len(METHODS), frameon=False)
    figure.tight_layout(rect=(0, 0.1, 1, 1))
    figure.savefig(RESULTS / "precision.svg", metadata={"Date": None})
    plt.close(figure)


if __name__ == "__main__":
    main()
