# SPDX-License-Identifier: Apache-2.0
"""`mehvar stats`: statistics of a batch store."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict
from itertools import islice
from pathlib import Path
from typing import Annotated

import typer

from mehvar.base.errors import InputError
from mehvar.runtime.batch.blocks import IMPOSSIBLE, STATUS_TEXT
from mehvar.runtime.batch.evaluation.sensitivity import KINDS, sensitivities, tables
from mehvar.runtime.batch.evaluation.statistics import NO_INTERVAL, NO_METRICS, Statistics, metric_names, summarise
from mehvar.runtime.batch.fill import REFUSALS
from mehvar.runtime.batch.store.store import Store, open_store
from mehvar.runtime.files import check_file
from mehvar.runtime.run.metrics import grouped_notes
from mehvar.settings import AsJson
from mehvar.terminal import print_folded, print_json, print_table


def command(
    path: Annotated[Path, typer.Argument(metavar="STORE", help="A batch, finished or not.")],
    success: Annotated[
        str | None,
        typer.Option(metavar="EXPR", help="Success condition; default: the one stored with the batch."),
    ] = None,
    plot: Annotated[Path | None, typer.Option(metavar="FILE.png", help="Draw quantile bands and worst runs.")] = None,
    as_json: AsJson = False,
    of: Annotated[
        list[str] | None, typer.Option(metavar="NAME", help="Variable or metric to draw; repeat as needed.")
    ] = None,
) -> None:
    """Print the statistics of a store, and draw it.

    Raises
    ------
    InputError
        If the store is invalid or empty, or a condition or variable is unknown.
    """
    if plot is not None:
        from mehvar.pictures.files import checked_suffix

        checked_suffix(plot)
        check_file(plot)
    elif of:
        raise InputError("--of selects variables for the picture: add --plot FILE.png")
    store = open_store(path)
    if as_json:
        print_json(asdict(summarise(store, success)) | {"sensitivities": [asdict(s) for s in sensitivities(store)]})
    else:
        print_statistics(store, success)
    if plot is not None:
        from mehvar.pictures.batch import batch_picture
        from mehvar.pictures.files import save

        save(batch_picture(store, of or []), plot)
        typer.echo(f"saved {plot}", err=as_json)


def print_statistics(store: Store, success: str | None = None) -> None:
    """Print success, endings, metrics, extreme runs and sensitivities."""
    statistics, attributes = summarise(store, success), store.attributes
    typer.echo(
        f"{attributes['model']} {attributes['controller']} {attributes['scenario']}: "
        f"{_extent(statistics)}, seed {attributes['seed']}"
    )
    if statistics.writer is not None:
        typer.echo(f"being written by {statistics.writer}: the statistics use the runs stored so far")
    typer.echo("  ".join(f"{text} {number}" for text, number in statistics.statuses.items()))
    for name, (ended, begins) in statistics.endings.items():
        at_start = f", {begins} of them at the start, because the guard had the forbidden sign" if begins else ""
        typer.echo(f"the event {name} ended {ended} runs{at_start}")
    condition = success or attributes["success"]
    typer.echo(
        f"success{f' ({condition})' if condition else ''}: {statistics.successes} of {statistics.stored}, "
        f"{_estimate(statistics)}\n"
    )
    if not metric_names(store):
        typer.echo(f"{NO_METRICS}: below are the states at the end\n")
    _print_metrics(statistics)
    for kind, heads, rows in tables(sensitivities(store)):
        typer.echo(f"\n{KINDS[kind]}")
        print_folded(heads, rows)
    _print_refusals(store, statistics)


def _print_metrics(statistics: Statistics) -> None:
    """Print tables that fit a page: moments and quantiles, intervals, runs with extreme values."""
    rows, quantiles = statistics.rows, {q: f"{100 * q:g} %" for q in (0.05, 0.5, 0.95)}
    incomplete = any(row.finite < statistics.stored for row in rows)
    print_table(
        "",
        ["metric", "unit", *(["not finite"] if incomplete else []), "mean", "sd", *quantiles.values()],
        [
            [
                row.name,
                row.unit,
                *([str(statistics.stored - row.finite)] if incomplete else []),
                f"{row.mean:.6g}",
                f"{row.sd:.3g}",
                *(f"{row.quantiles[q]:.5g}" for q in quantiles),
            ]
            for row in rows
        ],
    )
    for text in grouped_notes({row.name: row.note for row in rows if row.note}):
        typer.echo(f"note: {text}")
    if statistics.design not in NO_INTERVAL:
        typer.echo("\n95 % intervals of the quantiles; - if a bound needs more runs")
        intervals = [[row.name, *(_interval(*row.intervals[q]) for q in quantiles)] for row in rows]
        print_table("", ["metric", *quantiles.values()], intervals)
    typer.echo("\nextreme runs")
    ends = [[row.name, *(text for run, value in (row.smallest, row.largest) for text in (f"{value:.6g}", str(run)))]
            for row in rows]  # fmt: skip
    print_table("", ["metric", "smallest", "run", "largest", "run"], ends)


def _estimate(statistics: Statistics) -> str:
    """Return the success probability with its interval, or the share of runs and why there is no interval."""
    if statistics.design in NO_INTERVAL:
        return f"share {statistics.probability:.6g}; {NO_INTERVAL[statistics.design]}"
    ends = f"[{statistics.low:.6g}, {statistics.high:.6g}]"
    return f"probability {statistics.probability:.6g}, 95 % interval {ends}"


def _extent(statistics: Statistics) -> str:
    return (
        f"{statistics.stored} runs"
        if statistics.stored == statistics.planned
        else f"{statistics.stored} of {statistics.planned} runs"
    )


def _interval(low: float, high: float) -> str:
    return f"[{', '.join('-' if math.isnan(end) else f'{end:.4g}' for end in (low, high))}]"


def _print_refusals(store: Store, statistics: Statistics) -> None:
    """Print the reasons of the first impossible runs."""
    number = statistics.statuses.get(STATUS_TEXT[IMPOSSIBLE], 0)
    if not number:
        return
    typer.echo(f"\n{number} runs were drawn with values that are not allowed and were not computed:")
    for run, text in islice(_refusals(store), REFUSALS):
        typer.echo(f"  run {run}: {text}")
    if number > REFUSALS:
        typer.echo("  ...")


def _refusals(store: Store) -> Iterator[tuple[str, str]]:
    for block in store.stored():
        yield from sorted(store.about(block)["refusals"].items(), key=lambda item: int(item[0]))
