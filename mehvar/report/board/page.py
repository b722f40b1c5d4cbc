# SPDX-License-Identifier: Apache-2.0
"""HTML page and JSON file about a run on a board."""

from __future__ import annotations

import base64
import json
import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mehvar.base.units import pretty_unit
from mehvar.html import page
from mehvar.pictures.files import pixels, save
from mehvar.pictures.style import BLUE, COLORS, VERMILLION, new_figure, style, time_axis
from mehvar.reproduction.paper import run_picture
from mehvar.runtime.board.run import BoardRun, ulps
from mehvar.runtime.files import filling
from mehvar.runtime.run.metrics import metrics
from mehvar.runtime.run.results import to_dataset

from .facts import facts

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


REPORT_NAMES = ("index.html", "board.json", "figures")


def write_report(outcome: BoardRun, out: Path, maker: str) -> None:
    """Write index.html, board.json and figures/ into a folder, with the command that made them."""
    results = facts(outcome) | {"metrics": metric_values(outcome)}
    rows = fact_rows(results, metric_rows(outcome, results["metrics"]))
    with filling(out, maker) as folder:
        (folder / "figures").mkdir()
        figures = [_saved(folder / "figures" / f"{name}.png", title, draw(outcome)) for name, title, draw in _FIGURES]
        (folder / "index.html").write_text(_page(results, figures, rows), encoding="utf-8")
        (folder / "board.json").write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")


def metric_values(outcome: BoardRun) -> dict[str, dict[str, float]]:
    """Return finite metrics of the board, and of the host with and without the delay."""
    runs = {"board": outcome.board, "host_double": outcome.double, "host_without_delay": outcome.undelayed}
    values = {name: metrics(run, run.manifest) for name, run in runs.items() if run is not None}
    return {
        metric: {name: numbers[metric] for name, numbers in values.items()}
        for metric in outcome.board.manifest.metrics
        if all(math.isfinite(numbers[metric]) for numbers in values.values())
    }


def metric_rows(outcome: BoardRun, values: Mapping[str, Mapping[str, float]]) -> list[tuple[str, str, str]]:
    """Return table rows of metrics: description, values on board and host, evidence."""
    known = outcome.board.manifest.metrics
    return [
        (
            known[metric].description,
            ", ".join(
                f"{value:.5g}{f' {known[metric].unit}'.removesuffix(' 1')} ({name.replace('_', ' ')})"
                for name, value in numbers.items()
            ),
            "measured",
        )
        for metric, numbers in values.items()
    ]


def _saved(path: Path, title: str, figure: Figure) -> dict[str, Any]:
    save(figure, path)
    png = path.read_bytes()
    return {"title": title, "uri": "data:image/png;base64," + base64.b64encode(png).decode(), "size": pixels(png)}


def _loop_figure(outcome: BoardRun) -> Figure:
    return run_picture(to_dataset(outcome.board), outcome.board.manifest)


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


_FIGURES: tuple[tuple[str, str, Callable[[BoardRun], Figure]], ...] = (
    ("loop", "The closed loop, with the law on the board", _loop_figure),
    (
        "inputs",
        "What the board commanded, the same in float on this machine, and how far they are apart",
        inputs_figure,
    ),
)


def _page(results: dict[str, Any], figures: Sequence[dict[str, Any]], rows: Sequence[tuple[str, str, str]]) -> str:
    return page("board.html.j2", results=results, figures=figures, rows=rows)


def fact_rows(results: dict[str, Any], more: Sequence[tuple[str, str, str]] = ()) -> list[tuple[str, str, str]]:
    """Return table rows of facts: description, value, evidence; `more` has rows about the closed loop."""
    image, same = results["image"], results["equivalence"]
    rows = [
        (
            "inputs, board against host in float",
            f"{same['inputs']['max_ulp']} ulp of {same['inputs']['compared']}",
            "exact",
        ),
        ("memory of the law", f"{same['memory']['max_ulp']} ulp of {same['memory']['compared']}", "exact"),
        ("states of the plant", f"{same['states']['max_ulp']} ulp of {same['states']['compared']}", "exact"),
        ("inputs, float against double", f"{results['float_against_double']['max_input']:.3g} at most", "measured"),
    ]
    undelayed = results["board_against_simulation_without_delay"]
    if undelayed:
        rows += [
            ("states, board against simulation without the delay", f"{undelayed['max_state']:.3g} at most", "measured"),
            ("the same, shifted by one sample", f"{undelayed['max_state_shifted']:.3g} at most", "measured"),
        ]
    rows += more
    if results["instructions_per_step"] is not None:
        least, most = results["instructions_least"], results["instructions_per_step"]
        rows += [("instructions of a step", f"{least} to {most}", "exact, counted by the emulator")]
    if results["cycles_per_step"]:
        text = f"{results['cycles_per_step']}, {results['microseconds_per_step']} µs"
        rows += [("cycles of a step", text, "estimate: Cortex-M4F timings, no wait states")]
    if "flash" in image:
        used, bound = results["stack_used"], results["stack_bound"]
        rows += [
            ("flash", f"{image['flash']} bytes", "exact"),
            ("static RAM", f"{image['ram']} bytes", "exact, without the stack"),
            ("stack, used", f"{used} bytes" if used else "not asked", "measured largest use, self-test included"),
            ("stack, at most", f"{bound['bytes']} bytes" if bound else "not known", _chain(bound)),
            ("stack, reserved", f"{image['stack']} bytes", "exact"),
            ("routines in double precision", ", ".join(image["double_routines"]) or "none", "exact, by symbols"),
        ]
    if results["selftest"]:
        test = results["selftest"]
        rows += [("self-test", f"0x{test['crc32']} after {test['samples']} samples", "exact, plant on the target too")]
    if (ticks := results["ticks"]) and ticks["most"]:  # an emulated clock stands still
        rows += [
            ("ticks of a step", f"{ticks['least']} to {ticks['most']} at {ticks['per_second']} /s", ticks["meaning"])
        ]
    return [*rows, ("exchanges", f"{results['exchanges_per_second']} /s", "measured on this machine")]


def _chain(bound: dict[str, Any] | None) -> str:
    if bound is None:
        return "unknown from the image"
    calls = " → ".join(f"{link['function']} {link['bytes']}" for link in bound["chain"])
    return f"bound from instructions and calls, one fault included: {calls}"
