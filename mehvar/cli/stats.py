# SPDX-License-Identifier: Apache-2.0
"""`mehvar stats`: what the runs of a store say, for people."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from pathlib import Path

import numpy as np
import typer

from mehvar.errors import InputError
from mehvar.runtime.batch.blocks import IMPOSSIBLE, STATUS_TEXT
from mehvar.runtime.batch.fill import plan_of
from mehvar.runtime.batch.sensitivity import Sensitivity, sensitivities
from mehvar.runtime.batch.statistics import Statistics, summarise
from mehvar.runtime.batch.store import STATUS, Store, open_store
from mehvar.terminal import print_table

_REFUSALS = 3  # that are shown


def stats_command(path: Path, success: str | None, plot: Path | None, of: list[str]) -> int:
    """Print the statistics of a store, finished or not, and draw it if asked; return the exit status.

    Raises
    ------
    InputError
        For a store that is none or empty, or a condition or a variable that it does not know.
    """
    if plot is not None:
        from mehvar.pictures.files import checked_suffix

        checked_suffix(plot)
    elif of:
        raise InputError("--of says what --plot draws: give both")
    store = open_store(path)
    print_statistics(store, success)
    if plot is not None:
        from mehvar.pictures.batch import batch_picture
        from mehvar.pictures.files import save

        save(batch_picture(store, of), plot)
        typer.echo(f"saved {plot}")
    return 0


def print_statistics(store: Store, success: str | None = None) -> None:
    """Print success, endings, metrics, extreme runs and sensitivities."""
    found = summarise(store, success)
    said = store.attributes
    typer.echo(f"{said['model']} {said['controller']} {said['scenario']}: {_extent(found)}, seed {said['seed']}")
    typer.echo("  ".join(f"{text} {number}" for text, number in found.statuses.items()))
    condition = success or said["success"]
    typer.echo(
        f"success{f' ({condition})' if condition else ''}: {found.successes} of {found.stored}, probability "
        f"{found.probability:.6g}, 95 % interval [{found.low:.6g}, {found.high:.6g}]\n"
    )
    shown = (0.05, 0.5, 0.95)
    rows = [
        [
            row.name,
            row.unit,
            str(found.stored - row.finite),
            f"{row.mean:.6g}",
            f"{row.sd:.3g}",
            *(f"{row.quantiles[q]:.6g}" for q in shown),
            f"{row.smallest[1]:.6g} (run {row.smallest[0]})",
            f"{row.largest[1]:.6g} (run {row.largest[0]})",
        ]
        for row in found.rows
    ]
    titles = ["metric", "unit", "not finite", "mean", "sd", *(f"{100 * q:g} %" for q in shown), "smallest", "largest"]
    print_table("", titles, rows)
    _print_sensitivities(sensitivities(store))
    _print_refusals(store, found)


def _extent(found: Statistics) -> str:
    return f"{found.stored} runs" if found.stored == found.planned else f"{found.stored} of {found.planned} runs"


def _print_sensitivities(found: list[Sensitivity]) -> None:
    for kind, title in (
        ("sobol", "Sobol indices, first order / total: shares of the variance"),
        ("regression", "sensitivities: standardised regression coefficients"),
    ):
        group = [item for item in found if item.kind == kind]
        if not group:
            continue
        names = list(dict.fromkeys(name for item in group for name in item.first))
        typer.echo(f"\n{title}")
        print_table(
            "",
            ["metric", *names, "R^2" if kind == "regression" else "sum", "runs"],
            [
                [item.metric, *(_cell(item, name) for name in names), f"{item.explained:.3f}", str(item.runs)]
                for item in group
            ],
        )


def _cell(item: Sensitivity, name: str) -> str:
    if name not in item.first:
        return "-"
    return f"{item.first[name]:.3f}" + (f" / {item.total[name]:.3f}" if item.total else "")


def _print_refusals(store: Store, found: Statistics) -> None:
    """Show why the first impossible runs are impossible."""
    number = found.statuses.get(STATUS_TEXT[IMPOSSIBLE], 0)
    if not number:
        return
    plan = plan_of(store)
    typer.echo(f"\n{number} runs were drawn with values that are not allowed and were not computed:")
    for run in islice(_impossible(store), _REFUSALS):
        typer.echo(f"  run {run}: {plan.refusal(run)}")
    if number > _REFUSALS:
        typer.echo("  ...")


def _impossible(store: Store) -> Iterator[int]:
    for block in store.stored():
        first = store.runs(block).start
        yield from (first + int(k) for k in np.flatnonzero(store.read(STATUS, [block]) == IMPOSSIBLE))
