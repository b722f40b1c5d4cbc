# SPDX-License-Identifier: Apache-2.0
"""HTML page and JSON file about a run on a board."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mehvar.base.units import pretty_unit
from mehvar.pictures.style import BLUE, COLORS, VERMILLION, new_figure, style, time_axis
from mehvar.report.page import Block, Drawing, Page, Section, Table, Text, page_text
from mehvar.report.picture import picture
from mehvar.reproduction.paper import run_picture
from mehvar.runtime.board.run import BoardRun, ulps
from mehvar.runtime.files import filling
from mehvar.runtime.run.metrics import metrics
from mehvar.runtime.run.results import to_dataset

from .facts import fact_rows, facts

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


REPORT_NAMES = ("index.html", "board.json", "figures")
_INPUTS = (
    "what the board commanded, below it the host in float, their difference in units of the last place, and what float "
    "costs against double"
)


def write_report(outcome: BoardRun, out: Path, maker: str) -> None:
    """Write index.html, board.json and figures/ into a folder, with the command that made them."""
    results = facts(outcome) | {"metrics": metric_values(outcome)}
    page = _page(outcome, results)
    with filling(out, maker) as folder:
        (folder / "figures").mkdir()
        for block in page.sections[0].blocks:
            if isinstance(block, Drawing):
                (folder / "figures" / f"{block.picture.name}.png").write_bytes(block.picture.png)
        (folder / "index.html").write_text(page_text(page), encoding="utf-8")
        (folder / "board.json").write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")


def _page(outcome: BoardRun, results: dict[str, Any]) -> Page:
    """Return the page about a run: the law on the board, the closed loop, and where both come from."""
    board, link, image = outcome.board, results["link"], results["image"]
    loop = run_picture(to_dataset(board), board.manifest)
    metric_table = Table("Metrics", ("metric", "value", "where"), metric_rows(outcome, results["metrics"]))
    covered = [
        (row["function"], f"{row['run']} of {row['lines']}", ", ".join(map(str, row["missed"])) or "none")
        for row in results["coverage"]
    ]
    sides = [(side, ", ".join(f"{k} {v}" for k, v in link[side].items())) for side in ("host", "board") if link[side]]
    hashes = {
        "image": image["sha256"],
        "layout": results["hash"],
        "model": results["model_hash"],
        **results["versions"],
    }
    versions = [(name, text or "not installed") for name, text in hashes.items()]
    blocks = [
        *law_blocks(outcome, results, "inputs"),
        Drawing(picture("loop", "The closed loop, with the law on the board", "", loop)),
        metric_table,
        Table("Lines that ran on the target", ("function", "lines run", "lines not run"), covered),
    ]
    origin = [
        Table("Link", ("side", "counts"), [*sides, ("memory given back to the board", f"{link['restored']} times")]),
        Table("Versions", ("what", "version"), versions),
    ]
    title = f"{results['model']} under {results['controller']}, on {results['board']}"
    changed = "".join(f", {key} = {value}" for key, value in results["changed"].items())
    lead = f"Closed loop of scenario {results['scenario']}{changed}, delay of {results['delay']} sample(s)."
    sections = [Section("board", "On the board", blocks), Section("origin", "Where it comes from", origin)]
    return Page(title, sections, lead)


def law_blocks(outcome: BoardRun, results: dict[str, Any], name: str = "") -> list[Block]:
    """Return the blocks about a law on a board: verdict, inputs beside the host's, and numbers.

    Parameters
    ----------
    outcome : BoardRun
        The run.
    results : dict
        Its facts.
    name : str
        Of the picture; without one it has no chart, for pages of many laws.
    """
    law = results["controller"]
    verdict = "✓ 0 ulp, bit for bit" if outcome.same else "✗ board and host differ"
    case = f"{results['board']}, target {results['target']}; {_extent(outcome, results)}."
    shown = picture(
        name or f"{results['model']}-board-{law}", f"Law {law}: {_INPUTS}", "", inputs_figure(outcome),
        charted=bool(name),
    )  # fmt: skip
    rows = [("compiler", results["compiler"], "asked for its version"), *fact_rows(results)]
    numbers = Table(f"{law}: sizes, instructions and stack", ("what", "value", "how it is known"), rows)
    return [Text(f"{law}: {verdict}. {case}"), Drawing(shown), numbers]


def _extent(outcome: BoardRun, results: dict[str, Any]) -> str:
    """Return the simulated part of the scenario and the reason for an early end."""
    run = outcome.board
    whole, reached = run.scenario.duration, run.t[-1]
    part = "all" if reached >= whole else f"{reached:g} of the {whole:g} s"
    early = "" if results["status"] == "done" else f", where the run ended: {run.reason}"
    return f"{results['samples']} samples of {results['period']:g} s, {part} of scenario {run.scenario.name}{early}"


def metric_values(outcome: BoardRun) -> dict[str, dict[str, float]]:
    """Return finite metrics of the board, and of the host with and without the delay."""
    runs = {"board": outcome.board, "host_double": outcome.double, "host_without_delay": outcome.undelayed}
    values = {name: metrics(run, run.manifest) for name, run in runs.items() if run is not None}
    return {
        metric: {name: numbers[metric] for name, numbers in values.items()}
        for metric in outcome.board.manifest.metrics
        if all(math.isfinite(numbers[metric]) for numbers in values.values())
    }


def metric_rows(outcome: BoardRun, values: dict[str, dict[str, float]]) -> list[tuple[str, str, str]]:
    """Return table rows of metrics: description, value with its unit, and the run that has it."""
    known = outcome.board.manifest.metrics
    return [
        (known[metric].description, f"{value:.5g} {known[metric].unit}".removesuffix(" 1"), run.replace("_", " "))
        for metric, numbers in values.items()
        for run, value in numbers.items()
    ]


def inputs_figure(outcome: BoardRun) -> Figure:
    """Draw each input of board and host in float, with the difference below.

    There is one column per unit. The lowest panel shows the difference between float and double.
    """
    units = list(dict.fromkeys(q.unit for q in outcome.board.manifest.inputs))
    with style():
        figure = new_figure(max(8.0, 5.0 * len(units)), 7.0)
        for unit, column in zip(units, figure.subplots(4, len(units), sharex=True, squeeze=False).T, strict=True):
            _inputs_column(column, outcome, unit)
        return figure


def _inputs_column(column: Sequence[Axes], outcome: BoardRun, unit: str) -> None:
    """Draw the inputs in one unit: on the board, on this machine, their distance, and the error of float."""
    board, single, double = outcome.board, outcome.single, outcome.double
    inputs = {k: q.name for k, q in enumerate(board.manifest.inputs) if q.unit == unit}
    for ax, run, title in zip(column, (board, single), ("on the board", "on this machine, in float"), strict=False):
        for color, (k, name) in enumerate(inputs.items()):
            ax.step(run.t, run.u_cmd[:, k], where="post", color=COLORS[color], lw=1.0, label=name)
        time_axis(ax, f"input [{pretty_unit(unit)}]", last=False)
        ax.set_title(title)
    column[0].legend(ncols=5, loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2)
    places = list(inputs)
    apart = ulps(board.u_cmd[:, places], single.u_cmd[:, places]).max(axis=1, initial=0)
    column[2].plot(board.t[: len(apart)], apart, color=VERMILLION)
    column[2].set_ylim(-0.5, max(1.0, float(apart.max(initial=0))))
    time_axis(column[2], "board − float [ulp]", last=False)
    rows = min(len(board.t), len(double.t))
    cost = np.abs(board.u_cmd[:rows, places] - double.u_cmd[:rows, places]).max(axis=1, initial=0.0)
    column[3].plot(board.t[:rows], cost, color=BLUE)
    time_axis(column[3], f"float − double [{pretty_unit(unit)}]")
