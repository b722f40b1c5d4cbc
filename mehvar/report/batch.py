# SPDX-License-Identifier: Apache-2.0
"""Page about a batch: dispersions, success, sensitivities, metrics, notable runs, pictures."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from mehvar.base.units import pretty_unit
from mehvar.pictures.spread import Runs, convergence_picture, metrics_picture, region_picture
from mehvar.pictures.style import case_text, require_matplotlib, style
from mehvar.runtime.batch.blocks import STATUS_TEXT
from mehvar.runtime.batch.evaluation.conditions import Criterion, Number
from mehvar.runtime.batch.evaluation.sensitivity import KINDS, Sensitivity, sensitivities, tables
from mehvar.runtime.batch.evaluation.statistics import (
    NO_INTERVAL,
    NO_METRICS,
    MetricStatistics,
    design_of,
    interval,
    metric_statistics,
    scalars,
    summary_names,
)
from mehvar.runtime.batch.repeat import repetition
from mehvar.runtime.batch.store.dataset import DatasetBatch
from mehvar.runtime.run.problem import Status

from .page import Drawing, Section, Table, Text
from .picture import picture
from .subjects import installed_derivation, version_table

_PANELS = 4
"""Largest number of panels in a batch picture; two rows of two are readable without zooming."""
_FAILURES = 5
"""Largest number of unsuccessful runs on the page; their commands fill a third of a screen."""
_SHARES = {
    "sobol": "Share of the metric's variance that a drawn value explains, alone / with its interactions: 0 is none, "
    "1 is all of it. Estimated from the groups of runs by Saltelli's formulas; brackets are 95 % bootstrap intervals.",
    "regression": "Change of the metric, in its standard deviations, when a drawn value rises by one of its own and "
    "the others stay: 0 is no effect, 1 or −1 is all of the scatter. From a least-squares fit to the runs in the last "
    "column; brackets are 95 % intervals, and R² is the share of the variance that the fit explains.",
}
"""Meaning of a sensitivity, its computation and its uncertainty."""
_UNDETERMINED = " Undetermined: the metric scatters by its integration error only, or the interval is wider than 1."
_QUANTILES = (
    "Of the runs that have a value of the metric, 5 % are below the first quantile, half below the median, 95 % below "
    "the last. With 95 % confidence the brackets contain the quantile of all possible runs."
)
_DRAWN = 4
"""Largest number of drawn values beside them; with more, the commands leave the screen."""


def batch_sections(runs: Runs, store: str = "") -> list[Section]:
    """Return the sections of a batch.

    Parameters
    ----------
    runs : Runs
        The runs.
    store : str
        Folder of the store, for commands that repeat a run; default: Python calls.

    Raises
    ------
    InputError
        If matplotlib is not installed.
    """
    require_matplotlib()
    about, design = runs.dataset.attrs, design_of(runs.dataset.attrs)
    rows = batch_metrics(runs)
    origin = [
        (name, str(about[name]))
        for name in ("model", "model_hash", "controller", "scenario", "seed", "campaign", "compiler")
    ]
    return [
        Section("batch", "Batch", [_varied(runs), Text(_success(runs, design)), *_endings(runs)]),
        Section("sensitivities", "Sensitivities", list(_sensitivities(sensitivities(_store(runs))))),
        Section("metrics", "Metrics", list(_metrics(rows, bool(runs.metrics)))),
        Section("runs", "Runs to look at", list(_extremes(runs, rows, store))),
        Section("pictures", "Pictures", list(_pictures(runs, design))),
        *installed_derivation(str(about["model"]), str(about["model_hash"])),
        Section(
            "provenance",
            "Where it comes from",
            [Table("Batch", ("what", "value"), origin), version_table(about["versions"])],
        ),
    ]


def batch_lead(runs: Runs) -> str:
    """Return what a reader of a batch's page needs first: its title, size, sampling and seed."""
    about = runs.dataset.attrs
    return f"{about['title']}. A batch of {runs.whole.sizes['run']} runs, {_sampled(about)}."


def _sampled(about: Mapping[str, Any]) -> str:
    design = design_of(about)
    return "of listed values" if design == "listed" else f"{design} sampling, seed {about['seed']}"


def batch_metrics(runs: Runs) -> list[MetricStatistics]:
    """Return the statistics of each metric; for a model without metrics, of each final state."""
    design = design_of(runs.dataset.attrs)
    return [metric_statistics(_store(runs), name, [0], design) for name in summary_names(_store(runs))]


def _store(runs: Runs) -> DatasetBatch:
    """Return the batch as a store with one block, for the statistics; missing runs are NaN."""
    return DatasetBatch(runs.whole, chunk=runs.whole.sizes["run"])


def _varied(runs: Runs) -> Table:
    """Return the dispersions of the campaign."""
    vary: dict[str, str] = json.loads(runs.dataset.attrs["campaign"])["vary"]
    rows = []
    for names, how in vary.items():
        each = [runs.dataset[name].attrs for name in map(str.strip, names.split(",")) if name in runs.dataset]
        units, meanings = (dict.fromkeys(str(attrs.get(key, "")) for attrs in each) for key in ("units", "long_name"))
        meaning = "; ".join(text.removesuffix(", drawn") for text in meanings)
        rows.append((names, how, ", ".join(map(pretty_unit, units)), meaning))
    return Table("What was varied", ("name", "distribution", "unit", "meaning"), rows)


def _success(runs: Runs, design: str) -> str:
    successes, n = int(runs.successful.sum()), runs.successful.size
    units = Criterion(runs.condition).units(scalars(runs.batch)) if runs.condition else ""
    condition = f" ({', '.join(filter(None, (runs.condition, units)))})" if runs.condition else ""
    ends = ", ".join(f"{end:.4g}" for end in interval(successes, n))
    estimate = f"{successes / n:.4g}, {NO_INTERVAL.get(design) or f'95 % interval [{ends}]'}"
    planned = runs.whole.sizes["run"]
    rest = f" {n} of {planned} runs are stored." if n < planned else ""
    return f"Scenario {case_text(runs.dataset.attrs)}: {successes} of {n} runs succeed{condition}: {estimate}.{rest}"


def _endings(runs: Runs) -> list[Table]:
    """Return the number of runs by kind of end, unless all reached the end time."""
    codes, counts = np.unique(runs.dataset["status"].values, return_counts=True)
    rows = [(STATUS_TEXT[int(code)], str(count)) for code, count in zip(codes, counts, strict=True)]
    return [Table("How the runs ended", ("ending", "runs"), rows)] if len(rows) > 1 else []


def _sensitivities(items: Sequence[Sensitivity]) -> Iterator[Text | Table]:
    if not items:
        yield Text("No metric scatters with a value that is drawn.")
    for kind, heads, rows in tables(items):
        note = _SHARES[kind] + (_UNDETERMINED if any("undetermined" in row for row in rows) else "")
        yield Table(KINDS[kind][0].upper() + KINDS[kind][1:], [head.replace("^2", "²") for head in heads], rows, note)


def _metrics(rows: Sequence[MetricStatistics], declared: bool) -> Iterator[Text | Table]:
    """Yield quantiles with their 95 % intervals."""
    if not declared:
        yield Text(f"{NO_METRICS[0].upper()}{NO_METRICS[1:]}: below are the states at the end.")
    columns = ("metric", "meaning", "unit", "runs", "mean", "5 %", "median", "95 %")
    yield Table(
        "Quantiles and their 95 % intervals, − where there are too few runs for an end",
        columns,
        [
            (row.name, row.description, pretty_unit(row.unit), str(row.finite), f"{row.mean:.4g}",
             *(f"{row.quantiles[q]:.4g} {_ends(row.intervals[q])}" for q in (0.05, 0.5, 0.95)))
            for row in rows
        ],
        _QUANTILES,
    )  # fmt: skip


def _ends(ends: tuple[float, float]) -> str:
    return "[" + ", ".join("−" if math.isnan(end) else f"{end:.4g}" for end in ends) + "]"


def _extremes(runs: Runs, rows: Sequence[MetricStatistics], store: str) -> Iterator[Table]:
    """Yield the worst unsuccessful runs and those at the ends of each metric, with commands to repeat them."""
    status, t_stop = runs.dataset["status"].values, runs.dataset["t_stop"].values
    failed, names, ordered = _failed(runs)
    names += [name for name in runs.drawn if name not in names][:_DRAWN]
    which = ("worst" if ordered else "first") + f" {_FAILURES} of {len(failed)}"
    yield Table(
        "Runs that do not succeed" if len(failed) <= _FAILURES else f"Runs that do not succeed, the {which}",
        ("run", *map(runs.axis, names), "ended", "at", "to repeat it"),
        [
            (
                str(runs.numbers[k]),
                *(f"{runs.column(name)[k]:.6g}" for name in names),
                "at its end time" if status[k] == Status.DONE else STATUS_TEXT[int(status[k])],
                f"{float(t_stop[k]):.6g} s",
                repetition(_store(runs), runs.numbers[k], store),
            )
            for k in failed[:_FAILURES]
        ],
    )
    yield Table(
        "Smallest and largest value of each metric",
        ("metric", "end", "value", "unit", "run", "to repeat it"),
        [
            (row.name, end, f"{value:.6g}", pretty_unit(row.unit), str(run), repetition(_store(runs), run, store))
            for row in rows
            for end, (run, value) in (("smallest", row.smallest), ("largest", row.largest))
            if run >= 0
        ],
    )


def _failed(runs: Runs) -> tuple[list[int], list[str], bool]:
    """Return the unsuccessful runs, the numbers that the condition names, and True if the runs are worst first."""
    failed = np.flatnonzero(~runs.successful)
    if not runs.condition:
        return failed.tolist(), [], False
    criterion = Criterion(runs.condition)
    names = sorted(criterion.names - {"status"})
    match criterion.nested():
        case ["and", ["<" | "<=" | ">" | ">=" as sign, _, float() | int()]]:
            left = Number(runs.condition.partition(sign)[0], "success")(runs.column)[failed]
            beyond = np.where(np.isnan(left), math.inf, left if sign in ("<", "<=") else -left)
            return failed[np.argsort(-beyond, kind="stable")].tolist(), names, True
    return failed.tolist(), names, False


def _pictures(runs: Runs, design: str) -> Iterator[Drawing]:
    """Yield the success rate, the region of success, and figures of _PANELS metrics or bands each."""
    groups = [("metrics", "Metrics of the runs", "Vermillion: runs that do not succeed.", runs.summaries)]
    groups += [("bands", "Series of the runs", "Median and 5 to 95 % of the runs over time.", runs.series)]
    with style():
        if 0 < int(runs.successful.sum()) < runs.successful.size:
            exact = "" if design in NO_INTERVAL else ", and its exact 95 % interval"
            caption = f"The share of runs that succeed{exact}."
            yield Drawing(picture("batch-share", "Convergence", caption, convergence_picture(runs)))
        if len(runs.drawn) > 1:
            first_two = region_picture(runs, *runs.drawn[:2])
            yield Drawing(
                picture(
                    "batch-region", "Where the runs succeed", "Over the first two values that are drawn.", first_two
                )
            )
        for name, title, caption, shown in groups:
            for k, start in enumerate(range(0, len(shown), _PANELS), 1):
                figure = metrics_picture(runs, shown[start : start + _PANELS])
                yield Drawing(picture(f"batch-{name}-{k}", title, caption, figure))
