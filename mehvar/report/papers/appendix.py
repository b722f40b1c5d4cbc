# SPDX-License-Identifier: Apache-2.0
"""Sections of a paper's page that are texts and tables: batch, code of CasADi, metrics, eigenvalues."""

from __future__ import annotations

import math
from collections.abc import Iterator

from mehvar.comparison.effects import number as eigenvalue
from mehvar.report.page import Block, Drawing, Table, Text
from mehvar.runtime.batch.evaluation.statistics import MetricStatistics
from mehvar.runtime.run.metrics import Deviation

from .backends import POINTS, TOLERANCE
from .content import PaperReport
from .eigenvalues import LoopSpectrum
from .study import SEED

_LINEARISED = (
    "Each loop linearised exactly where its run ends: eigenvalues in 1/s, or of the map over a period. The table shows "
    "those nearest to instability, and none where a step within the run's tolerance changes them. A run that still "
    "moves at its end is not at an equilibrium: a positive real part there does not make the loop unstable."
)
_INTERVALS = (
    f"Seed {SEED}; the interval of the probability is Clopper and Pearson's, those of quantiles are between order "
    "statistics. mehvar batch runs such campaigns."
)
_WHOLE_RUNS = (
    "Whole runs of the first scenario. A loop passes the rounding on: one that is unstable makes it grow, and one that "
    "switches comes to a switch a step earlier or later."
)


def batch_blocks(report: PaperReport) -> Iterator[Block]:
    """Yield question, bands, success and metrics of a paper's batches."""
    if report.batch is None or report.bands is None:
        yield Text("Not run: batches need a C compiler.")
        return
    study, known = report.batch.study, (*report.manifest.parameters, *report.manifest.scenario_parameters)
    units = {q.name: q.unit for q in known}
    drawn = [(what, how, units.get(what, "1")) for what, how in study.vary.items()]
    success = [
        (title, str(law.stored), str(law.successes), f"{law.probability:.3f} [{law.low:.3f}, {law.high:.3f}]")
        for title, law in report.batch.laws
    ]
    metrics = [
        (f"{row.name}, {title}", *(_quantile(row, q) for q in (0.05, 0.5, 0.95)), row.unit)
        for title, row in report.batch.metrics
    ]
    yield Text(study.text)
    yield Drawing(report.bands)
    yield Table("Success", ("law", "runs", "success", "probability, 95 % interval"), success)
    yield Table("Drawn", ("name", "distribution", "unit"), drawn, _INTERVALS)
    yield Table("Metrics", ("metric", "5 %", "median", "95 %", "unit"), metrics)


def _quantile(row: MetricStatistics, q: float) -> str:
    ends = ("−" if math.isnan(end) else _number(end) for end in row.intervals[q])
    return f"{_number(row.quantiles[q])} [{', '.join(ends)}]"


def casadi_blocks(report: PaperReport) -> Iterator[Block]:
    """Yield the comparison of our text with CasADi's own C: functions at random points, and whole runs."""
    compared = report.agreement
    if compared is None:
        yield Text("Not compared: this needs a C compiler.")
        return
    verdict = (
        f"✓ all are the same to {compared.largest:.0e}, where {TOLERANCE:.0e} is asked"
        if compared.same
        else f"✗ some differ by more than {TOLERANCE:.0e}"
    )
    yield Text(
        f"CasADi prints C of the same graphs; mehvar simulate {report.manifest.model} --set backend=casadi runs it. "
        f"Each function at {POINTS} random points around those of a run, Jacobians too (fewer where its result is not "
        f"finite, or a rounding of the arguments moves it further): {verdict}, relative to the largest "
        "result at the point."
    )
    functions = [
        (f.name, str(f.points), f"{f.difference:.1e}", "✓ the same" if f.same else "✗ differs")
        for f in compared.functions
    ]
    yield Table("Functions", ("function", "points", "largest relative difference", "verdict"), functions)
    runs = [(run.law, *run.ends, f"{run.state:.1e}", f"{run.metric:.1e}") for run in compared.runs]
    yield Table(
        "Runs", ("law", "our text", "CasADi's", "largest difference of a state", "of a metric"), runs, _WHOLE_RUNS
    )


def metric_tables(report: PaperReport) -> Iterator[Block]:
    """Yield the expected and measured metrics of each run."""
    columns = ("metric", "meaning", "expected", "measured", "unit", "deviation", "verdict")
    for (scenario, law), numbers in report.rows:
        rows = [
            (n.metric.name, n.metric.description, _number(n.expected), _number(n.measured), n.metric.unit,
             _deviation(n), "✓ holds" if n.holds else "✗ does not hold")
            for n in numbers
        ]  # fmt: skip
        yield Table(f"{scenario}, {law}", columns, rows, report.manifest.scenarios[scenario].title)


def eigenvalue_table(report: PaperReport) -> Table:
    """Return the eigenvalues of each loop at the end of its run."""
    rows = [
        (loop.scenario, loop.law, f"{_number(loop.t)} s", _time(loop), str(loop.count),
         ", ".join(map(eigenvalue, loop.nearest)) or "not defined: the loop is not smooth there")
        for loop in report.spectra
    ]  # fmt: skip
    return Table("Loops", ("scenario", "law", "at", "time", "of", "eigenvalues"), rows, _LINEARISED)


def _time(loop: LoopSpectrum) -> str:
    return "continuous" if loop.period is None else f"period {_number(loop.period)} s"


def _number(value: float) -> str:
    return f"{value + 0.0:.4g}" if math.isfinite(value) else "does not settle"


def _deviation(number: Deviation) -> str:
    """Return the deviation of a number from its expected value as text."""
    value = number.size
    if not math.isfinite(value) or not math.isfinite(number.expected):
        return "–"
    if number.metric.kind == "sign_changes":
        return f"{value:+.0f}" if value else "0"
    return f"{100 * value:+.2f} %" if abs(value) >= 5e-5 else "0.00 %"
