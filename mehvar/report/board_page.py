# SPDX-License-Identifier: Apache-2.0
"""What a run on a board has shown, as one HTML page and as JSON."""

from __future__ import annotations

import base64
import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mehvar.html import page
from mehvar.papers.reproduction import BoardPart, load_reproduction, paper_models, run_picture
from mehvar.pictures.files import save
from mehvar.pictures.style import BLACK, BLUE, COLORS, VERMILLION, label, new_figure, style
from mehvar.runtime.board.run import BoardRun
from mehvar.runtime.files import filling
from mehvar.runtime.run.results import to_dataset

from .board_facts import facts

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def write_report(outcome: BoardRun, out: Path) -> None:
    """Write index.html, board.json and figures/ into a folder."""
    part = _paper_part(outcome)
    numbers = _figure_numbers(outcome, part)
    results = facts(outcome) | {"figure": numbers}
    rows = fact_rows(results, part.rows(numbers) if part and numbers else ())
    with filling(out) as folder:
        (folder / "figures").mkdir()
        figures = [
            _saved(folder / "figures" / f"{name}.png", title, draw(outcome))
            for name, title, draw in _figures(outcome, part)
        ]
        (folder / "index.html").write_text(_page(results, figures, rows), encoding="utf-8")
        (folder / "board.json").write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")


def _paper_part(outcome: BoardRun) -> BoardPart | None:
    """Return what a paper has to do with the law on the board, None where it has not."""
    layout = outcome.image.program.layout
    part = load_reproduction(layout.model).board if layout.model in paper_models() else None
    return part if part and layout.law in part.figures else None


def _figures(outcome: BoardRun, part: BoardPart | None) -> list[tuple[str, str, Any]]:
    name = f"the paper's figure {part.figures[outcome.image.program.layout.law]}" if part else "the closed loop"
    return [
        ("loop", f"{name}, with the law on the board".capitalize(), lambda outcome: _loop_figure(outcome, part)),
        ("inputs", "What the board commanded, and how far from the host's float and double", inputs_figure),
    ]


def _figure_numbers(outcome: BoardRun, part: BoardPart | None) -> dict[str, Any] | None:
    """Return what the paper's figure shows, in numbers, of the board and of the host with and without the delay."""
    if part is None:
        return None
    program = outcome.image.program
    runs = {"board": outcome.board, "host_double": outcome.double, "host_without_delay": outcome.undelayed}
    return part.numbers(
        program.layout.law, {name: run for name, run in runs.items() if run is not None}, program.period
    )


def _saved(path: Path, title: str, figure: Figure) -> dict[str, str]:
    save(figure, path)
    return {"title": title, "uri": "data:image/png;base64," + base64.b64encode(path.read_bytes()).decode()}


def _loop_figure(outcome: BoardRun, part: BoardPart | None) -> Figure:
    run = outcome.board
    if part is None:
        return run_picture(to_dataset(run), run.manifest)
    with style():
        return part.draw(run)


def inputs_figure(outcome: BoardRun) -> Figure:
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


def _page(results: dict[str, Any], figures: Sequence[dict[str, str]], rows: Sequence[tuple[str, str, str]]) -> str:
    return page("board.html.j2", found=results, figures=figures, rows=rows)


def fact_rows(results: dict[str, Any], figure: Sequence[tuple[str, str, str]] = ()) -> list[tuple[str, str, str]]:
    """Return what, how much, and how it is known; `figure` are the rows of a paper's figure."""
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
    late = results["board_against_simulation_without_delay"]
    if late:
        rows += [
            ("states, board against simulation without the delay", f"{late['max_state']:.3g} at most", "measured"),
            ("the same, shifted by one sample", f"{late['max_state_shifted']:.3g} at most", "measured"),
        ]
    rows += figure
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
            ("stack, used", f"{used} bytes" if used else "not asked", "measured high water, self-test included"),
            ("stack, at most", f"{bound['bytes']} bytes" if bound else "not known", _chain(bound)),
            ("stack, reserved", f"{image['stack']} bytes", "exact"),
            ("routines in double precision", ", ".join(image["double_routines"]) or "none", "exact, by symbols"),
        ]
    if results["selftest"]:
        test = results["selftest"]
        rows += [("self-test", f"{test['crc32']} after {test['samples']} samples", "exact, plant on the target too")]
    if results["ticks"]:
        ticks = results["ticks"]
        rows += [
            ("ticks of a step", f"{ticks['least']} to {ticks['most']} at {ticks['per_second']} /s", ticks["meaning"])
        ]
    return [*rows, ("exchanges", f"{results['exchanges_per_second']} /s", "measured on this machine")]


def _chain(bound: dict[str, Any] | None) -> str:
    if bound is None:
        return "the image does not tell"
    calls = " → ".join(f"{link['function']} {link['bytes']}" for link in bound["chain"])
    return f"bound from instructions and calls, one fault included: {calls}"
