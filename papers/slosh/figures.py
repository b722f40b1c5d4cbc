# SPDX-License-Identifier: Apache-2.0
"""The diagrams of the slosh paper: the hull, the pendulums and the inputs over time. Axes in degrees."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from mehvar.pictures import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, VERMILLION, label, new_figure, time_axis
from mehvar.reproduction import Runs

from .rows import FULL, LAWS, REDUCED, axial

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from mehvar.runtime import Run

    FloatArray = NDArray[np.float64]

AXES = (BLUE, VERMILLION, GREEN)
"""Colours for x, y and z."""
BOBS = (PURPLE, ORANGE)
"""Colours of the two pendulums."""
V1, V2 = BLUE, VERMILLION
_DASHED = (0, (4, 2.5))


def claimed(ax: Axes, time: float) -> None:
    """Mark the instant that the paper names."""
    ax.axvline(time, color=GREY, ls=":", lw=1.2, zorder=0.95, label=_NAMED)


def _draw(ax: Axes, run: Run, name: str, color: str, until: float = np.inf, **look: Any) -> None:
    """Draw a series up to an instant; angles in degrees."""
    part, values = run.t <= until, run.variables()[name]
    in_degrees = name.removeprefix("u_").startswith(("att", "phi", "theta", "delta"))
    ax.plot(run.t[part], np.degrees(values[part]) if in_degrees else values[part], color=color, **look)


def _both(ax: Axes, runs: Runs, name: str, color: str, until: float = np.inf, symbol: str = "") -> None:
    """Draw a series of the full loop under V1 and, dashed, of the reduced one; `symbol` tells it from others there."""
    full, reduced = (f"{symbol}, {plant}" if symbol else plant for plant in ("full model", "reduced model"))
    _draw(ax, runs(LAWS[0], "paper", **FULL), name, color, until, label=full)
    _draw(ax, runs(LAWS[0], "paper", **REDUCED), name, BLACK, until, ls=_DASHED, lw=0.9, label=reduced)


def _legend(figure: Figure, handles: Sequence[tuple[str, Mapping[str, Any]]]) -> None:
    from matplotlib.lines import Line2D

    lines = [Line2D([], [], label=text, **look) for text, look in handles]
    figure.legend(handles=lines, loc="outside upper center", ncols=len(lines))


_REDUCED_LINE: Mapping[str, Any] = {"color": BLACK, "ls": _DASHED, "lw": 0.9}
_NAMED_LINE: Mapping[str, Any] = {"color": GREY, "ls": ":", "lw": 1.2}
_REDUCED = "the same, reduced model"
_NAMED = "time that the paper names"
_ALL = "all of the thrust"


def velocities(runs: Runs) -> Figure:
    """Draw diagram 1: the velocity of the tank's centre."""
    figure = new_figure(7.0, 5.6)
    axes = figure.subplots(3, 1, sharex=True)
    for k, (ax, axis) in enumerate(zip(axes, "xyz", strict=True)):
        _both(ax, runs, f"v{axis}", AXES[k])
        time_axis(ax, label(f"$v_{axis}$", "velocity", "m/s"), k == 2, zero=k > 0)
        if k:
            claimed(ax, 500)
    components = [(f"$v_{axis}$", {"color": AXES[k]}) for k, axis in enumerate("xyz")]
    _legend(figure, [*components, (_REDUCED, _REDUCED_LINE), (_NAMED, _NAMED_LINE)])
    return figure


def attitude(runs: Runs) -> Figure:
    """Draw diagram 2: the three attitude angles."""
    figure = new_figure(7.0, 3.4)
    ax = figure.subplots()
    for k in range(3):
        _both(ax, runs, f"att{k + 1}", AXES[k], until=300, symbol=rf"$\vartheta_{k + 1}$")
    claimed(ax, 200)
    time_axis(ax, label(r"$\vartheta_j$", "attitude", "°"))
    angles = [(rf"$\vartheta_{k + 1}$", {"color": AXES[k]}) for k in range(3)]
    _legend(figure, [*angles, (_REDUCED, _REDUCED_LINE), (_NAMED, _NAMED_LINE)])
    return figure


def pendulums(runs: Runs, angle: str, symbol: str, named: Sequence[float]) -> Figure:
    """Draw diagram 3 or 4: an angle of both pendulums, its first seconds and the whole run."""
    figure = new_figure(10.0, 4.8)
    axes = figure.subplots(2, 2, sharey="row", width_ratios=(1.0, 1.2))
    for k in range(2):
        for ax, until in zip(axes[k], (60.0, np.inf), strict=True):
            _both(ax, runs, f"{angle}{k + 1}", BOBS[k], until)
            time_axis(ax, label(rf"$\{symbol}_{k + 1}$", f"pendulum {k + 1},", "°"), k == 1)
        axes[k, 1].yaxis.label.set_visible(False)
        claimed(axes[k, 1], named[k])
    axes[0, 0].set_title("first minute")
    axes[0, 1].set_title("whole run")
    bobs = [(f"pendulum {k + 1}", {"color": BOBS[k]}) for k in range(2)]
    _legend(figure, [*bobs, (_REDUCED, _REDUCED_LINE), (_NAMED, _NAMED_LINE)])
    return figure


_MOMENTS = tuple((f"M{axis}", f"$M_{axis}$", "moment", "N m", AXES[k]) for k, axis in enumerate("xyz"))
_GIMBALS = tuple((f"delta{k}", rf"$\delta_{k}$", "gimbal angle", "°", AXES[3 - k]) for k in (1, 2))


def moments(runs: Runs) -> Figure:
    """Draw diagram 5: the three moments."""
    return _inputs(runs, _MOMENTS)


def gimbals(runs: Runs) -> Figure:
    """Draw diagram 6: the two gimbal angles."""
    return _inputs(runs, _GIMBALS)


def _inputs(runs: Runs, inputs: Sequence[tuple[str, str, str, str, str]]) -> Figure:
    figure = new_figure(10.0, 0.6 + 1.7 * len(inputs))
    axes = figure.subplots(len(inputs), 2, width_ratios=(1.0, 1.2), sharey="row")
    last = len(inputs) - 1
    for k, (name, symbol, meaning, unit, color) in enumerate(inputs):
        for ax, until in zip(axes[k], (20.0, 600.0), strict=True):
            _both(ax, runs, f"u_{name}", color, until)
            time_axis(ax, label(symbol, meaning, unit), k == last)
        axes[k, 1].yaxis.label.set_visible(False)
    axes[0, 0].set_title("first 20 s")
    axes[0, 1].set_title("first 600 s")
    named = [(symbol, {"color": color}) for _, symbol, _, _, color in inputs]
    _legend(figure, [*named, (_REDUCED, _REDUCED_LINE)])
    return figure


def laws(runs: Runs, angle: str, symbol: str) -> Figure:
    """Draw diagram 7 or 8: an angle of both pendulums under both laws, and the difference."""
    figure = new_figure(10.0, 4.8)
    axes = figure.subplots(2, 2, width_ratios=(1.0, 1.2))
    for k in range(2):
        name = f"{angle}{k + 1}"
        for law, color, line in zip(LAWS, (V1, V2), ("-", "--"), strict=True):
            _draw(axes[k, 0], runs(law, "paper"), name, color, 60.0, ls=line, label=law[-2:].upper())
        for plant, settings, look in (("full", FULL, {"color": GREEN}), ("reduced", REDUCED, _REDUCED_LINE)):
            first, second = (runs(law, "paper", **settings) for law in LAWS)
            off = np.degrees(second.variables()[name] - first.variables()[name])
            part = first.t <= 200.0
            axes[k, 1].plot(first.t[part], off[part], label=f"V2 − V1, {plant} model", **look)
        time_axis(axes[k, 0], label(rf"$\{symbol}_{k + 1}$", f"pendulum {k + 1},", "°"), k == 1)
        time_axis(axes[k, 1], label(rf"$\Delta\{symbol}_{k + 1}$", "V2 − V1,", "°"), k == 1)
    axes[0, 0].set_title("full model, first minute")
    axes[0, 1].set_title("difference of the laws, first 200 s")
    difference = [("V2 − V1, full model", {"color": GREEN}), ("V2 − V1, reduced model", _REDUCED_LINE)]
    _legend(figure, [("V1", {"color": V1}), ("V2", {"color": V2, "ls": "--"}), *difference])
    return figure


def thrust(runs: Runs) -> Figure:
    """Draw figure 11: the thrust in the full loop, in the reduced one, and in one with too large a demand."""
    figure = new_figure(10.0, 3.4)
    left, right = figure.subplots(1, 2)
    loops = (
        ("full", FULL, {"color": BLUE}),
        ("reduced", REDUCED, _REDUCED_LINE),
        ("full, $w_1 = w_2 = 10^5$", {"w1": 1e5, "w2": 1e5}, {"color": VERMILLION, "lw": 1.0}),
    )
    for text, settings, look in loops:
        run = runs(LAWS[0], "paper", **settings)
        part, series = run.t <= 400.0, run.variables()
        left.plot(run.t[part], series["lateral"][part], label=text, **look)
        ahead = np.full_like(run.t, axial(run)) if settings is REDUCED else series["ax"]
        right.plot(run.t[part], ahead[part], label=text, **look)
    time_axis(left, label(r"$f_\perp/F$", "lateral part of the thrust", "1"))
    left.axhline(1.0, label=_ALL, **_NAMED_LINE)
    time_axis(right, label("$a_x$", "acceleration", "m/s^2"))
    _legend(figure, [*((text, look) for text, _, look in loops), (_ALL, _NAMED_LINE)])
    return figure
