# SPDX-License-Identifier: Apache-2.0
"""Elements of the satellite's figures: angles, torques and estimates over time. Axes in degrees."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np

from mehvar.pictures import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, VERMILLION, label, new_figure, time_axis
from mehvar.reproduction import Runs

from .rows import AXES, PRINTED_B

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import ArrayLike, NDArray

    from mehvar.runtime import Run

    Series = Mapping[str, NDArray[np.float64]]

Place = Literal["outside upper center", "outside lower center"]

SYMBOLS = (r"$\varphi$", r"$\theta$", r"$\psi$")
COLORS = (BLUE, VERMILLION, GREEN)
"""Colours of roll, pitch and yaw, and of related series."""
_DASHED = (0, (4, 2.5))
_PROPER, _LITERAL = "law that keeps the zero", "law (32)"
_HOST = "host, float"
_TORQUE_SCALES = {"mN m": 1e3, "N m": 1.0}


def angle(ax: Axes, t: ArrayLike, series: Series, k: int, last: bool = True) -> None:
    """Draw an angle, the reference model and the wanted angle."""
    axis = AXES[k]
    ax.step(t, np.degrees(_held(series[f"ref_{axis}"])), where="post", color=GREY, lw=0.9, label="reference")
    ax.plot(t, np.degrees(series[axis]), color=COLORS[k], label=axis)
    ax.plot(t, np.degrees(series[f"ym_{axis}"]), color=BLACK, ls=_DASHED, lw=1.0, label="reference model")
    time_axis(ax, label(SYMBOLS[k], axis, "°"), last)


def torque(ax: Axes, t: ArrayLike, series: Series, k: int, last: bool = True, unit: str = "") -> None:
    """Draw the torque about an axis, held from sample to sample; in N m if it is large, unless a unit is given."""
    held = _held(series[f"u_T{'xyz'[k]}"])
    unit = unit or torque_unit(held)
    ax.step(t, _TORQUE_SCALES[unit] * held, where="post", color=COLORS[k], lw=1.2, label=AXES[k])
    time_axis(ax, label(f"$T_{'xyz'[k]}$", f"{AXES[k]} torque", unit), last)


def torque_unit(*torques: NDArray[np.float64]) -> str:
    """Return the unit in which some torques read well."""
    return "mN m" if max(np.abs(_held(values)).max() for values in torques) < 1 else "N m"


def _held(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a series without the step at its last instant, after which nothing is held any more."""
    return np.append(values[:-1], values[-2:][0])


def angles_figure(adaptive: Run, literal: Run) -> Figure:
    """Draw figure 4: roll, pitch and yaw under both adaptive laws, against reference and reference model."""
    figure = new_figure(10.0, 6.0)
    axes = figure.subplots(3, 2, sharex=True, sharey="row")
    for column, (run, title) in enumerate(((adaptive, _PROPER), (literal, _LITERAL))):
        for k in range(3):
            angle(axes[k, column], run.t, run.variables(), k, k == 2)
        axes[0, column].set_title(title)
    legend(figure)
    return figure


def torques_figure(*runs: tuple[str, Run]) -> Figure:
    """Draw the three torques of each run below each other, with a scale for each run: figures 5 and 9."""
    figure = new_figure(5.0 * len(runs) + (2.0 if len(runs) == 1 else 0.0), 5.6)
    axes = figure.subplots(3, len(runs), sharex=True, sharey="col", squeeze=False)
    for column, (title, run) in enumerate(runs):
        series = run.variables()
        unit = torque_unit(*(series[f"u_T{i}"] for i in "xyz"))
        for k in range(3):
            torque(axes[k, column], run.t, series, k, k == 2, unit)
        axes[0, column].set_title(title)
    return figure


def angle_figure(run: Run, k: int) -> Figure:
    """Draw one angle against reference and reference model: figures 6 to 8."""
    figure = new_figure(7.0, 3.4)
    ax = figure.subplots()
    angle(ax, run.t, run.variables(), k)
    figure.legend(loc="outside upper center", ncols=3)
    return figure


def board_angles_figure(runs: Runs) -> Figure:
    """Draw figure 10: the angles with the law on the board, and under them those with the law in float on the host."""
    outcome = runs.board("mrac", "paper")
    figure = new_figure(7.0, 6.2)
    axes = figure.subplots(3, 1, sharex=True)
    board, host = outcome.board.variables(), outcome.single.variables()
    for k, (ax, axis) in enumerate(zip(axes, AXES, strict=True)):
        ax.plot(outcome.single.t, np.degrees(host[axis]), color=SKY, lw=4.0, label=_HOST)
        angle(ax, outcome.board.t, board, k, k == 2)
    axes[0].set_title(_apart("states of the satellite", outcome.x.ulp, outcome.x.compared))
    legend(figure, host=True)
    return figure


def board_torques_figure(runs: Runs) -> Figure:
    """Draw figure 11: the torques that the board commanded as they act, and under them those of the host's law."""
    outcome = runs.board("mrac", "paper")
    figure = new_figure(7.0, 6.0)
    axes = figure.subplots(3, 1, sharex=True, sharey=True)
    board, host = outcome.board.variables(), outcome.single.variables()
    names = [f"u_T{i}" for i in "xyz"]
    unit = torque_unit(*(board[name] for name in names))
    for k, (ax, name) in enumerate(zip(axes, names, strict=True)):
        scale = _TORQUE_SCALES[unit]
        ax.step(outcome.single.t, scale * _held(host[name]), where="post", color=SKY, lw=4.0, label=_HOST)
        torque(ax, outcome.board.t, board, k, k == 2, unit)
    axes[0].set_title(_apart("torques", outcome.u.ulp, outcome.u.compared))
    figure.legend(*_once(axes), loc="outside upper center", ncols=4)
    return figure


def _once(axes: Iterable[Axes]) -> tuple[list[Artist], list[str]]:
    """Return handles and labels of the lines of some panels, each label once."""
    named = {text: handle for ax in axes for handle, text in zip(*ax.get_legend_handles_labels(), strict=True)}
    return list(named.values()), list(named)


def _apart(what: str, ulp: int, compared: int) -> str:
    return f"board and host are {ulp} ulp apart in all {compared} {what}"


def both_figure(series: Series, t: ArrayLike) -> Figure:
    """Draw angles at the left and torques at the right."""
    figure = new_figure(10.0, 6.0)
    axes = figure.subplots(3, 2, sharex=True)
    unit = torque_unit(*(series[f"u_T{i}"] for i in "xyz"))
    for k, (left, right) in enumerate(axes):
        angle(left, t, series, k, k == 2)
        torque(right, t, series, k, k == 2, unit)
        if k:
            right.sharey(axes[0, 1])
    axes[0, 1].autoscale(axis="y")
    legend(figure)
    return figure


def legend(figure: Figure, place: Place = "outside upper center", host: bool = False) -> None:
    """Explain the lines of the angles in a legend outside the panels."""
    from matplotlib.lines import Line2D

    handles = [
        *([Line2D([], [], color=SKY, lw=4.0, label=_HOST)] if host else []),
        *(Line2D([], [], color=color, label=axis) for axis, color in zip(AXES, COLORS, strict=True)),
        Line2D([], [], color=BLACK, ls=_DASHED, lw=1.0, label="reference model"),
        Line2D([], [], color=GREY, lw=0.9, label="reference"),
    ]
    figure.legend(handles=handles, loc=place, ncols=6)


_ESTIMATES: tuple[tuple[tuple[tuple[str, str, str], ...], str, str], ...] = (
    ((("a1", "$a_1 + 2$", PURPLE), ("a2", "$a_2 - 1$", SKY)), r"$\Delta a$", "1"),
    ((("b0", "$b_0$", BLUE), ("b1", "$b_1$", ORANGE)), "$b$", "rad/(N m)"),
    ((("d", "$d$", GREEN),), "$d$", "mrad"),
)
_MEANINGS = ("coefficients", "coefficients", "offset")
_SHIFT = {"a1": 2.0, "a2": -1.0}


def estimates_figure(runs: Runs) -> Figure:
    """Draw figure 12: the estimates of each axis from the printed B, and the true values."""
    run = runs("mrac", "printed")
    series, values = run.variables(), run.parameters.values
    figure = new_figure(10.0, 6.4)
    axes = figure.subplots(3, 3, sharex=True, sharey="row")
    for k, axis in enumerate(AXES):
        nominal = values["Ts"] ** 2 / (2 * values[f"I_{'xyz'[k]}"])
        for row, true in enumerate((0.0, nominal, 0.0)):
            ax = axes[row, k]
            ax.axhline(true, color=BLACK, ls=_DASHED, lw=0.9, zorder=3, label="nominal plant")
            _estimates(ax, run.t, series, axis, row)
        axes[0, k].set_title(axis)
        b0, b1 = PRINTED_B[k]
        axes[1, k].plot(2 * [values["Ts"]], [b0, b1], "o", color=GREY, ms=5, mfc="none", clip_on=False, zorder=4)
    _estimates_legend(figure)
    return figure


def _estimates(ax: Axes, t: NDArray[np.float64], series: Series, axis: str, row: int) -> None:
    names, symbol, unit = _ESTIMATES[row]
    scale = 1e3 if unit == "mrad" else 1.0
    for name, title, color in names:
        ax.semilogx(t[1:], scale * (series[f"{name}_{axis}"][1:] + _SHIFT.get(name, 0.0)), color=color, label=title)
    ax.set_xlim(t[1], t[-1])
    ax.set_xlabel(label("$t$", "time", "s"))
    ax.xaxis.label.set_visible(row == 2)
    ax.set_ylabel(label(symbol, _MEANINGS[row], unit))
    ax.yaxis.label.set_visible(axis == AXES[0])


def _estimates_legend(figure: Figure) -> None:
    from matplotlib.lines import Line2D

    handles = [Line2D([], [], color=color, label=symbol) for names, *_ in _ESTIMATES for _, symbol, color in names]
    handles += [
        Line2D([], [], color=BLACK, ls=_DASHED, lw=0.9, label="nominal plant"),
        Line2D([], [], color=GREY, marker="o", mfc="none", ms=5, lw=0, label="printed B"),
    ]
    figure.legend(handles=handles, loc="outside upper center", ncols=7)


def errors_figure(runs: Runs) -> Figure:
    """Draw figure 13: the error between angle and reference model, for the adaptive law and PD."""
    figure = new_figure(10.0, 6.0)
    axes = figure.subplots(3, 2, sharex=True, sharey="col")
    for column, (law, title) in enumerate((("mrac", "adaptive law"), ("pd", "PD"))):
        run = runs(law, "paper")
        series = run.variables()
        for k, axis in enumerate(AXES):
            ax = axes[k, column]
            ax.plot(run.t, np.degrees(series[axis] - series[f"ym_{axis}"]), color=COLORS[k], lw=1.2, label=axis)
            time_axis(ax, label(f"{SYMBOLS[k]} − {SYMBOLS[k]}$_m$", f"{axis} error", "°"), k == 2)
        axes[0, column].set_title(title)
    return figure


def ringing_figure(runs: Runs) -> Figure:
    """Draw figure 15: the torque of law (32) beside that of the law that keeps the zero."""
    literal, proper = runs("mrac-literal", "printed"), runs("mrac", "printed")
    figure = new_figure(10.0, 5.6)
    axes = figure.subplot_mosaic([["whole", "near"], ["whole", "error"]], width_ratios=(1.15, 1.0))
    _whole(axes["whole"], literal.t, literal.variables(), proper.variables())
    window = (300.0, 308.0)
    _near(axes["near"], window, ((proper, BLUE, _PROPER), (literal, VERMILLION, _LITERAL)))
    series = literal.variables()
    for k, axis in enumerate(AXES):
        off = np.degrees(series[axis] - series[f"ym_{axis}"])
        axes["error"].plot(literal.t, off, color=COLORS[k], lw=1.0, label=axis)
    time_axis(axes["error"], label("$e$", "error of (32)", "°"))
    axes["error"].set(xlim=(100, 800), ylim=(-0.75, 0.75))
    axes["error"].set_title("and yet the samples look well")
    axes["error"].legend(ncols=3, loc="lower right")
    return figure


def _whole(ax: Axes, t: NDArray[np.float64], literal: Series, proper: Series) -> None:
    smallest = 2e-5
    for series, color, name in ((literal, VERMILLION, _LITERAL), (proper, BLUE, _PROPER)):
        ax.semilogy(t[:-1], np.abs(series["u_Ty"][:-1]), color=color, lw=0.7, label=name)
    ax.set(xlim=(0.0, t[-1]), ylim=(smallest, 40.0))
    ax.set_xlabel(label("$t$", "time", "s"))
    ax.set_ylabel(label("$|T_y|$", "pitch torque", "N m"))
    ax.set_title("size of the pitch torque")
    ax.legend(loc="upper right", ncols=2)


def _near(ax: Axes, window: tuple[float, float], loops: Sequence[tuple[Run, str, str]]) -> None:
    for run, color, name in loops:
        inside = (run.t >= window[0]) & (run.t <= window[1])
        ax.step(run.t[inside], run.variables()["u_Ty"][inside], where="post", color=color, lw=1.4, label=name)
    time_axis(ax, label("$T_y$", "pitch torque", "N m"))
    ax.set_title("sixteen samples of it")
