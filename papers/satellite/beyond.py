# SPDX-License-Identifier: Apache-2.0
"""The paper's claims and new ones with any inertia, wheels, orbit, torquers and instruments."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from mehvar.pictures import BLUE, GREEN, GREY, VERMILLION, label, new_figure, time_axis
from mehvar.reproduction import AMPLITUDES, Check, Expected, Runs, about, below, read_beyond

from .checks import each_above, each_below
from .rows import AXES, LATE, measure

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    FloatArray = NDArray[np.float64]

_BEFORE = {"t_end": 199.5}
"""s: until the first switch of the reference."""


def _tracks(_: Runs, runs: Runs, expected: Expected) -> Sequence[Check]:
    return [
        each_below(f"RMS error from 200 s on, scenario {case}{words}", expected(bound), _rms(runs, "mrac", case, delay))
        for case in ("paper", "ellipse")
        for delay, words, bound in ((0, "", "error"), (1, ", delay", "late"))
    ]


def _rms(runs: Runs, law: str, scenario: str, delay: int = 0) -> FloatArray:
    return measure(runs(law, scenario, delay=delay)).rms


def _printed_is_lost(_: Runs, runs: Runs, expected: Expected) -> Sequence[Check]:
    return [each_above("RMS error from 200 s on", expected("error"), _rms(runs, "mrac-literal", "ellipse"), "deg")]


def _proportional(_: Runs, runs: Runs, expected: Expected) -> Sequence[Check]:
    off = runs.metrics("quaternion", "ellipse", **_BEFORE)["off"]
    return (
        each_above("pd: RMS error from 200 s on", expected("error"), _rms(runs, "pd", "ellipse"), "deg"),
        below("quaternion: largest angle from 150 s to the first switch", expected("off"), off, "rad"),
    )


def _unloads(_: Runs, runs: Runs, expected: Expected) -> Sequence[Check]:
    run = runs("quaternion", "unload")
    series, late = run.variables(), run.t >= run.t[-1] - 1000
    return (
        below("momentum of the wheels at the end", expected("stored"), float(series["stored"][-1]), "N m s"),
        below("largest angle in the last 1000 s", expected("off"), float(series["pointing"][late].max()), "rad"),
    )


def _detumbles(_: Runs, runs: Runs, expected: Expected) -> Sequence[Check]:
    rate = runs("b-dot", "tumble").variables()["tumbling"]
    return (
        about("rate at the start", expected("start"), float(np.degrees(rate[0])), "deg/s", AMPLITUDES),
        below("rate at the end over that of the orbit", expected("rate"), float(rate[-1]) / _orbit_rate(runs)),
    )


def _orbit_rate(runs: Runs) -> float:
    """Return the mean motion of the scenario's orbit, rad/s."""
    values = runs("b-dot", "tumble").parameters.values
    return float(np.sqrt(values["mu"] / values["semi_major_axis"] ** 3))


def _errors(paper: Runs, runs: Runs) -> Figure:
    figure = new_figure(8.0, 5.4)
    cases = (
        ("the paper's", paper("mrac", "paper"), GREY),
        ("all choices", runs("mrac", "paper"), BLUE),
        ("on the ellipse", runs("mrac", "ellipse"), VERMILLION),
    )
    axes = figure.subplots(3, 1, sharex=True)
    for k, (ax, axis) in enumerate(zip(axes, AXES, strict=True)):
        for title, run, color in cases:
            late, series = run.t >= LATE, run.variables()
            ax.plot(run.t[late], np.degrees(series[axis] - series[f"ym_{axis}"])[late], color=color, lw=1, label=title)
        time_axis(ax, label(axis, "error,", "°"), k == 2)
    axes[0].legend()
    return figure


def _unloading(_: Runs, runs: Runs) -> Figure:
    figure = new_figure(8.0, 2.8)
    ax = figure.subplots()
    run = runs("quaternion", "unload")
    for name, title, color in (("stored", "all wheels", BLUE), ("fullest", "fullest wheel", GREEN)):
        ax.plot(run.t, run.variables()[name], color=color, label=title)
    time_axis(ax, label("$h$", "momentum", "N m s"))
    ax.legend()
    return figure


def _tumbling(_: Runs, runs: Runs) -> Figure:
    figure = new_figure(8.0, 2.8)
    ax = figure.subplots()
    run = runs("b-dot", "tumble")
    ax.semilogy(run.t, np.degrees(run.variables()["tumbling"]), color=BLUE, label="rate")
    ax.axhline(np.degrees(_orbit_rate(runs)), color=GREY, ls=":", label="rate of the orbit")
    time_axis(ax, label("$|Ω|$", "rate", "°/s"), zero=False)
    ax.legend()
    return figure


BEYOND = read_beyond(
    Path(__file__).parent,
    draw={1: _errors, 2: _unloading, 3: _tumbling},
    checks={"B1": _tracks, "B2": _printed_is_lost, "B3": _proportional, "B4": _unloads, "B5": _detumbles},
)
