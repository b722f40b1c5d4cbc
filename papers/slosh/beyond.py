# SPDX-License-Identifier: Apache-2.0
"""Draining tanks, an engine with lag and a regulator: validity of the proofs, and the performance of the laws."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from mehvar.pictures import BLACK, BLUE, GREEN, VERMILLION, label, new_figure, time_axis
from mehvar.reproduction import AMPLITUDES, Check, Expected, Runs, about, above, below, read_beyond

from .rows import LAWS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_V1, _V2 = LAWS
_REGULATOR = "regulator"
_WITHIN = 1e-6
"""rad, beyond a command's limit: a gimbal that follows by a lag comes no further than rounding."""
_DASHED = (0, (4, 2.5))


def _neutral(paper: Runs, runs: Runs, expected: Expected) -> Sequence[Check]:
    return [
        about(f"{law}: settling time of v_y over the paper's craft's", expected("ratio"), ours / theirs, "", AMPLITUDES)
        for law in LAWS
        for ours, theirs in [[which.metrics(law, "paper")["t_vy"] for which in (runs, paper)]]
    ]


def _share(runs: Runs, law: str, scenario: str, name: str) -> float:
    """Return in which part of the samples a series is above zero."""
    return float((runs(law, scenario).variables()[name] > 0).mean())


def _proofs(_: Runs, runs: Runs, expected: Expected) -> Sequence[Check]:
    rising = "part of the time in which V rises"
    return (
        *(below(f"{law}: {rising}", expected("rising"), _share(runs, law, "paper", "V_dot")) for law in LAWS),
        about(f"{_V1}: part in which A > 0", expected("positive"), _share(runs, _V1, "paper", "V_rest")),
        about(f"{_V2}, draining: {rising}", expected("quarter"), _share(runs, _V2, "burn", "V_dot"), "", AMPLITUDES),
        below(f"{_V2}, draining: v_y settles", expected("settled"), runs.metrics(_V2, "burn")["t_vy"], "s"),
    )


def _draining(_: Runs, runs: Runs, expected: Expected) -> Sequence[Check]:
    flown = {law: runs.metrics(law, "burn") for law in (_V1, _V2, _REGULATOR)}
    return (
        above(f"{_V1}: the hull turns by", expected("turned"), flown[_V1]["max_turn"], "rad"),
        *(below(f"{law}: the same", expected("held"), flown[law]["max_turn"], "rad") for law in (_V2, _REGULATOR)),
        about(
            "settling time of v_y, regulator over V2",
            expected("sooner"),
            flown[_REGULATOR]["t_vy"] / flown[_V2]["t_vy"],
        ),
    )


def _narrow(_: Runs, runs: Runs, expected: Expected) -> Sequence[Check]:
    flown = {law: runs.metrics(law, "narrow") for law in (_V1, _V2, _REGULATOR)}
    limit = np.degrees(runs(_REGULATOR, "narrow").parameters.values["delta1_max"])
    return (
        about("limit of the gimbals", expected("limit"), float(limit), "deg"),
        *(above(f"{law}: the hull turns by", expected("turned"), flown[law]["max_turn"], "rad") for law in LAWS),
        about("regulator: settling time of v_y", expected("time"), flown[_REGULATOR]["t_vy"], "s"),
        below("regulator: largest gimbal angle", expected("angle") + _WITHIN, flown[_REGULATOR]["max_gimbal"], "rad"),
    )


_SHOWN = 580.0
"""s: when the run with draining tanks ends."""
_CASES = (("paper", "the paper's case"), ("burn", "tanks that drain"), ("narrow", "gimbals of 20°"))
_LOOKS = ((_V2, "V2", VERMILLION), (_REGULATOR, "regulator", GREEN))


def _flights(paper: Runs, runs: Runs) -> Figure:
    figure = new_figure(10.0, 6.0)
    axes = figure.subplots(3, 2, sharex=True)
    for row, (scenario, title) in zip(axes, _CASES, strict=True):
        for law, words, color in _LOOKS:
            run = runs(law, scenario)
            until = run.t <= _SHOWN
            row[0].plot(run.t[until], run.variables()["vy"][until], color=color, label=words)
            row[1].plot(run.t[until], np.degrees(run.variables()["gimbal2"][until]), color=color, label=words)
        if scenario == "paper":
            run = paper(_V2, scenario)
            until, look = run.t <= _SHOWN, {"color": BLACK, "ls": _DASHED, "lw": 0.9, "label": "V2, the paper's craft"}
            row[0].plot(run.t[until], run.variables()["vy"][until], **look)
            row[1].plot(run.t[until], np.degrees(run.variables()["u_delta2"][until]), **look)
        row[0].set_title(title)
        last = row[0] is axes[-1, 0]
        time_axis(row[0], label("$v_y$", "velocity", "m/s"), last)
        time_axis(row[1], label(r"$\delta_2$", "gimbal angle", "°"), last)
    axes[0, 0].legend()
    return figure


def _functions(_: Runs, runs: Runs) -> Figure:
    figure = new_figure(8.0, 3.0)
    ax = figure.subplots()
    for (scenario, title), color in zip(_CASES[:2], (BLUE, VERMILLION), strict=True):
        run = runs(_V2, scenario)
        until = run.t <= _SHOWN
        ax.semilogy(run.t[until], run.variables()["V"][until], color=color, label=title)
    time_axis(ax, label("$V$", "function", "1"), zero=False)
    ax.legend()
    return figure


BEYOND = read_beyond(
    Path(__file__).parent,
    draw={1: _flights, 2: _functions},
    checks={"B1": _neutral, "B2": _proofs, "B3": _draining, "B4": _narrow},
)
