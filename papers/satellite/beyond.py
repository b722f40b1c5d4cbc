# SPDX-License-Identifier: Apache-2.0
"""The paper's claims with products of inertia and four wheels along any axes."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from mehvar.pictures import BLUE, GREY, VERMILLION, label, new_figure, time_axis
from mehvar.reproduction import Check, Expected, Runs, above, below, read_beyond

from .rows import AXES, LATE, measure

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    FloatArray = NDArray[np.float64]


def _tracks(runs: Runs, expected: Expected) -> Sequence[Check]:
    return [
        below(
            f"RMS error from 200 s on, scenario {case}{words}", expected(bound), _rms(runs, "mrac", case, delay), "deg"
        )
        for case in ("paper", "flight")
        for delay, words, bound in ((0, "", "error"), (1, ", delay", "late"))
    ]


def _rms(runs: Runs, law: str, scenario: str, delay: int = 0) -> FloatArray:
    return measure(runs(law, scenario, delay=delay)).rms


def _printed_is_lost(runs: Runs, expected: Expected) -> Sequence[Check]:
    return [above("RMS error from 200 s on", expected("error"), _rms(runs, "mrac-literal", "flight"), "deg")]


def _errors(runs: Runs) -> Figure:
    figure = new_figure(8.0, 5.4)
    cases = (
        ("the paper's", runs.paper("mrac", "paper"), GREY),
        ("other inertia and wheels", runs("mrac", "paper"), BLUE),
        ("and disturbances", runs("mrac", "flight"), VERMILLION),
    )
    axes = figure.subplots(3, 1, sharex=True)
    for k, (ax, axis) in enumerate(zip(axes, AXES, strict=True)):
        for title, run, color in cases:
            late, series = run.t >= LATE, run.variables()
            ax.plot(run.t[late], np.degrees(series[axis] - series[f"ym_{axis}"])[late], color=color, lw=1, label=title)
        time_axis(ax, label(axis, "error,", "°"), k == 2)
    axes[0].legend()
    return figure


BEYOND = read_beyond(
    Path(__file__).parent,
    draw={1: _errors},
    checks={"B1": _tracks, "B2": _printed_is_lost},
)
