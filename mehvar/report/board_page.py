# SPDX-License-Identifier: Apache-2.0
"""What a run on a board has shown, as one HTML page and as JSON."""

from __future__ import annotations

import base64
import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import jinja2
import numpy as np

from mehvar.pictures.plots import (
    BLACK,
    BLUE,
    COLORS,
    VERMILLION,
    label,
    new_figure,
    picture,
    save,
    style,
)
from mehvar.report.board_facts import facts
from mehvar.runtime.board.run import Outcome
from mehvar.runtime.files import filling
from mehvar.runtime.run.results import to_dataset

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_TEMPLATES = Path(__file__).parents[1] / "templates"
_PAPER = {("satellite", "mrac"): 10, ("satellite", "pd"): 11}
"""Figures of the paper that show a law behind the link's delay."""


def write_report(outcome: Outcome, out: Path) -> None:
    """Write index.html, board.json and figures/ into a folder."""
    found = facts(outcome) | {"figure": _figure_numbers(outcome)}
    with filling(out) as folder:
        (folder / "figures").mkdir()
        figures = [
            _saved(folder / "figures" / f"{name}.png", title, draw(outcome)) for name, title, draw in _figures(outcome)
        ]
        (folder / "index.html").write_text(_page(found, figures), encoding="utf-8")
        (folder / "board.json").write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


def _figures(outcome: Outcome) -> list[tuple[str, str, Any]]:
    layout = outcome.image.program.layout
    number = _PAPER.get((layout.model, layout.law))
    name = "the closed loop" if number is None else f"the paper's figure {number}"
    return [
        ("loop", f"{name}, with the law on the board".capitalize(), _loop_figure),
        ("inputs", "What the board commanded, and how far from the host's float and double", inputs_figure),
    ]


def _figure_numbers(outcome: Outcome) -> dict[str, Any] | None:
    """Return what the paper's figure shows, in numbers, of the board and of the host with and without the delay."""
    from mehvar.papers.satellite.rows import LATE, measure

    layout, period = outcome.image.program.layout, outcome.image.program.period
    number = _PAPER.get((layout.model, layout.law))
    if number is None or outcome.board.t[-1] <= LATE + period:
        return None
    runs = {"board": outcome.board, "host_double": outcome.double, "host_without_delay": outcome.undelayed}
    measured = {name: measure(run) for name, run in runs.items() if run is not None}
    return {
        "number": number,
        "from": LATE,
        "rms_error_degrees": {name: list(m.rms) for name, m in measured.items()},
        "largest_error_degrees": {name: list(m.largest) for name, m in measured.items()},
        "largest_torque": {name: list(m.torque) for name, m in measured.items()},
    }


def _saved(path: Path, title: str, figure: Figure) -> dict[str, str]:
    save(figure, path)
    return {"title": title, "uri": "data:image/png;base64," + base64.b64encode(path.read_bytes()).decode()}


def _loop_figure(outcome: Outcome) -> Figure:
    run, layout = outcome.board, outcome.image.program.layout
    with style():
        if (layout.model, layout.law) in _PAPER:
            from mehvar.papers.satellite.figures import both_figure

            return both_figure(run.variables(), run.t)
        return picture(to_dataset(run), run.manifest)


def inputs_figure(outcome: Outcome) -> Figure:
    """Draw what the board commanded, and how far that is from the law in float and in double on this machine."""
    board, single, double = outcome.board, outcome.single, outcome.double
    rows = min(len(board.t), len(double.t))
    with style():
        figure = new_figure(8.0, 6.0)
        upper, middle, lower = figure.subplots(3, 1, sharex=True)
        for k, q in enumerate(board.manifest.inputs):
            upper.step(
                board.t, board.u_cmd[:, k], where="post", color=COLORS[k % len(COLORS)], label=f"{q.name} [{q.unit}]"
            )
        upper.legend(ncols=5, loc="upper right")
        upper.set_ylabel("input commanded")
        apart = np.abs(board.u_cmd - single.u_cmd[: len(board.u_cmd)]).max(axis=1)
        middle.plot(board.t, apart, color=VERMILLION)
        middle.set_ylabel("board − host, float")
        lower.plot(board.t[:rows], np.abs(board.u_cmd[:rows] - double.u_cmd[:rows]).max(axis=1), color=BLUE)
        lower.set_ylabel("float − double")
        lower.set_xlabel(label("$t$", "time", "s"))
        for ax in (middle, lower):
            ax.axhline(0.0, color=BLACK, lw=0.6)
        return figure


def _page(found: dict[str, Any], figures: Sequence[dict[str, str]]) -> str:
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(_TEMPLATES), autoescape=True, trim_blocks=True, lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )  # fmt: skip
    return environment.get_template("board.html.j2").render(found=found, figures=figures, rows=fact_rows(found))


def fact_rows(found: dict[str, Any]) -> list[tuple[str, str, str]]:
    """Return what, how much, and how it is known."""
    image, same = found["image"], found["equivalence"]
    rows = [
        (
            "inputs, board against host in float",
            f"{same['inputs']['max_ulp']} ulp of {same['inputs']['compared']}",
            "exact",
        ),
        ("memory of the law", f"{same['memory']['max_ulp']} ulp of {same['memory']['compared']}", "exact"),
        ("states of the plant", f"{same['states']['max_ulp']} ulp of {same['states']['compared']}", "exact"),
        ("inputs, float against double", f"{found['float_against_double']['max_input']:.3g} at most", "measured"),
    ]
    late = found["board_against_simulation_without_delay"]
    if late:
        rows += [
            ("states, board against simulation without the delay", f"{late['max_state']:.3g} at most", "measured"),
            ("the same, shifted by one sample", f"{late['max_state_shifted']:.3g} at most", "measured"),
        ]
    figure = found.get("figure")
    if figure:
        rows += [
            (
                f"RMS error of roll, pitch, yaw from {figure['from']:g} s on, {name.replace('_', ' ')}",
                ", ".join(f"{value:.4f}" for value in values) + " deg",
                f"measured, as in figure {figure['number']}",
            )
            for name, values in figure["rms_error_degrees"].items()
        ]
    if found["instructions_per_step"] is not None:
        least, most = found["instructions_least"], found["instructions_per_step"]
        rows += [("instructions of a step", f"{least} to {most}", "exact, counted by the emulator")]
    if found["cycles_per_step"]:
        text = f"{found['cycles_per_step']}, {found['microseconds_per_step']} µs"
        rows += [("cycles of a step", text, "estimate: Cortex-M4F timings, no wait states")]
    if "flash" in image:
        used, bound = found["stack_used"], found["stack_bound"]
        rows += [
            ("flash", f"{image['flash']} bytes", "exact"),
            ("static RAM", f"{image['ram']} bytes", "exact, without the stack"),
            ("stack, used", f"{used} bytes" if used else "not asked", "measured high water, self-test included"),
            ("stack, at most", f"{bound['bytes']} bytes" if bound else "not known", _chain(bound)),
            ("stack, reserved", f"{image['stack']} bytes", "exact"),
            ("routines in double precision", ", ".join(image["double_routines"]) or "none", "exact, by symbols"),
        ]
    if found["selftest"]:
        test = found["selftest"]
        rows += [("self-test", f"{test['crc32']} after {test['samples']} samples", "exact, plant on the target too")]
    if found["ticks"]:
        ticks = found["ticks"]
        rows += [
            ("ticks of a step", f"{ticks['least']} to {ticks['most']} at {ticks['per_second']} /s", ticks["meaning"])
        ]
    return [*rows, ("exchanges", f"{found['exchanges_per_second']} /s", "measured on this machine")]


def _chain(bound: dict[str, Any] | None) -> str:
    if bound is None:
        return "the image does not tell"
    calls = " → ".join(f"{link['function']} {link['bytes']}" for link in bound["chain"])
    return f"bound from instructions and calls, one fault included: {calls}"
