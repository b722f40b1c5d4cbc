# SPDX-License-Identifier: Apache-2.0
"""Figures 1 and 2 of the slosh paper: the craft with its partly filled tank, and its two pendulums."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.patches import Arc, Circle, FancyBboxPatch, Polygon

from mehvar.pictures import BLACK, GREY, LIGHT, VERMILLION, new_figure
from mehvar.reproduction import Runs

from .figures import AXES, BOBS

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_PHI, _GIMBAL = np.radians(40.0), np.radians(18.0)
_AZIMUTH = np.radians(35.0)
_TANK = 0.55
"""Radius that the tank is drawn with, m; none is printed. One of 0.5 m would be full of fuel as heavy as water, one of
0.6 m would reach the gimbal."""
_WATER = 1000.0
"""Density, kg/m^3; hydrazine has 1004."""
_TILT = np.radians(20.0)
"""Tilt of the fuel's surface; as large as the apparent gravity turns early in the paper's run."""


def craft(runs: Runs) -> Figure:
    """Draw the craft with its partly filled tank, distances to scale."""
    p = runs("lyapunov-v1", "paper").parameters.values
    figure = new_figure(7.0, 4.4)
    ax = figure.subplots()
    _hull(ax, p)
    _fuel(ax, (p["m0"] + p["m1"] + p["m2"]) / _WATER)
    _points(ax, ((0.0, "$O$", BLACK), (-p["b"], "$m$", AXES[0])))
    _thrust(ax, _gimbal(p))
    _distances(ax, ((-p["b"], "$-b$", -0.74), (_gimbal(p), "$b + d$", -0.74)))
    for x, z, axis, color in ((1.42, 0.1, "x", AXES[0]), (-0.1, 0.8, "z", AXES[2])):
        ax.text(x, z, f"$M_{axis}$", color=color, ha="center", fontsize=10)
    ax.set_title("from the side; $y$ points away from the reader")
    return figure


def pendulums_drawn(runs: Runs) -> Figure:
    """Draw the two pendulums from the side, distances to scale, and the azimuth of a bob along the thrust."""
    p = runs("lyapunov-v1", "paper").parameters.values
    figure = new_figure(10.0, 4.2)
    side, across = figure.subplots(1, 2, width_ratios=(2.3, 1.0))
    _hull(side, p)
    side.add_patch(Circle((0, 0), _TANK, fill=False, ec=GREY, lw=1.0))
    for k, color in enumerate(BOBS, 1):
        _pendulum(side, p[f"h{k}"], p[f"l{k}"], str(k), color)
    _points(side, ((0.0, "$O$", BLACK), (-p["h0"], "$m_0$", AXES[2])))
    _distances(side, ((p["h1"], "$h_1$", -0.2), (p["h2"], "$h_2$", -0.32)))
    _across(across)
    across.set_aspect("equal")
    across.grid(False)
    side.set_title("from the side, distances to scale")
    across.set_title("a bob, seen along $-x$")
    return figure


def _gimbal(p: Mapping[str, float]) -> float:
    return -(p["b"] + p["d"])


def _hull(ax: Axes, p: Mapping[str, float]) -> None:
    """Draw the hull, its nozzle and the axes x and z."""
    nozzle = _gimbal(p)
    ax.add_patch(FancyBboxPatch((-0.54, -0.54), 1.74, 1.08, "round,pad=0.06", fc="#F7F7F7", ec=GREY, lw=1.0))
    ax.add_patch(Polygon([(nozzle + 0.06, 0), (nozzle - 0.12, 0.1), (nozzle - 0.12, -0.1)], fc=LIGHT, ec=GREY))
    for end, at, text in (((1.42, 0), (1.44, 0), "$x$"), ((0, 0.76), (0.03, 0.72), "$z$")):
        start = (-0.9 if end[0] else 0, 0)
        ax.annotate("", end, start, arrowprops={"arrowstyle": "-|>", "color": GREY, "lw": 0.8}, zorder=4)
        ax.text(at[0], at[1], text, va="center", color=GREY)
    ax.set(xlim=(-1.15, 1.6), ylim=(-0.88, 0.88), xlabel="ahead of the tank's centre $x$ [m]", ylabel="$z$ [m]")
    ax.set_aspect("equal")
    ax.grid(False)


def _fuel(ax: Axes, volume: float) -> None:
    """Draw the tank and the fuel at its back, with a tilted surface."""
    part = volume / (4 / 3 * np.pi * _TANK**3)
    heights = np.linspace(-1.0, 1.0, 2001)
    surface = np.interp(part, (2 + 3 * heights - heights**3) / 4, heights)  # of a sphere's part below a height
    edge = np.arccos(surface)
    angles = np.linspace(edge, 2 * np.pi - edge, 200) + _TILT
    ax.add_patch(Circle((0, 0), _TANK, fc="white", ec=GREY, lw=1.2))
    ax.add_patch(Polygon(_TANK * np.column_stack((np.cos(angles), np.sin(angles))), fc="#CFE3F3", ec=AXES[0], lw=0.8))
    ax.text(-0.2, 0.25, f"fuel, {100 * part:.0f} %", color=AXES[0], ha="center", fontsize=9)


def _points(ax: Axes, points: Iterable[tuple[float, str, str]]) -> None:
    for x, text, color in points:
        ax.add_patch(Circle((x, 0), 0.018, fc=color, ec="white", lw=0.5, zorder=5))
        ax.text(x + (0.05 if text == "$O$" else 0.0), -0.07, text, color=color, ha="center", va="center", fontsize=10)


def _pendulum(ax: Axes, pivot: float, length: float, name: str, color: str) -> None:
    x, z = pivot - length * np.cos(_PHI), length * np.sin(_PHI)
    ax.plot([pivot, x], [0, z], color=color, lw=1.8, zorder=4)
    ax.add_patch(Circle((x, z), 0.03, fc=color, ec="white", lw=0.5, zorder=6))
    ax.text(x - 0.02, z + 0.075, f"$m_{name}$", color=color, ha="center", va="center", fontsize=10)
    size = 1.1 * length
    ax.add_patch(Arc((pivot, 0), size, size, theta1=180 - np.degrees(_PHI), theta2=180, color=color, lw=1.2, zorder=5))
    ax.text(pivot + 0.03, 0.05, rf"$\varphi_{name}$", color=color, fontsize=10)


def _thrust(ax: Axes, nozzle: float) -> None:
    """Draw the thrust (cos d1, -sin d1) that pushes at the gimbal, in the x-z plane."""
    tail = (nozzle - 0.42 * np.cos(_GIMBAL), 0.42 * np.sin(_GIMBAL))
    look = {"arrowstyle": "-|>", "color": VERMILLION, "lw": 2.0, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 13}
    ax.annotate("", (nozzle, 0), tail, arrowprops=look, zorder=6)
    ax.text(tail[0] - 0.02, tail[1] + 0.06, "$F$", color=VERMILLION, fontsize=11, ha="center")
    ax.add_patch(Arc((nozzle, 0), 0.52, 0.52, theta1=180 - np.degrees(_GIMBAL), theta2=180, color=VERMILLION, lw=1.2))
    ax.text(nozzle - 0.32, 0.035, r"$\delta_1$", color=VERMILLION, ha="right", fontsize=10)


def _distances(ax: Axes, rows: Sequence[tuple[float, str, float]]) -> None:
    """Draw distances from O below the craft."""
    look = {"arrowstyle": "<->", "color": GREY, "lw": 0.8, "shrinkA": 0, "shrinkB": 0}
    box = {"fc": "#F7F7F7", "ec": "none", "pad": 1}
    for x, text, z in rows:
        ax.annotate("", (x, z), (0, z), arrowprops=look)
        ax.plot([x, x], [z, 0], color=GREY, lw=0.5, ls=":")
        ax.text(x / 2, z, text, color=BLACK, ha="center", va="center", fontsize=9, bbox=box)
    ax.plot([0, 0], [min(z for *_, z in rows), 0], color=GREY, lw=0.5, ls=":")


def _across(ax: Axes) -> None:
    bob = np.array([np.sin(_AZIMUTH), np.cos(_AZIMUTH)])
    for head, text, at in (((0, 1.25), "$z$", (0.06, 1.16)), ((1.25, 0), "$y$", (1.16, 0.07))):
        ax.annotate("", head, (0, 0), arrowprops={"arrowstyle": "-|>", "color": GREY, "lw": 0.8})
        ax.text(*at, text, color=GREY)
    ax.add_patch(Circle((0, 0), 1.0, fill=False, ec=GREY, ls=":", lw=0.8))
    ax.plot([0, bob[0]], [0, bob[1]], color=BOBS[0], lw=1.8)
    ax.add_patch(Circle((bob[0], bob[1]), 0.07, fc=BOBS[0], ec="white", lw=0.5, zorder=5))
    ax.add_patch(Arc((0, 0), 1.0, 1.0, theta1=90 - np.degrees(_AZIMUTH), theta2=90, color=BOBS[0], lw=1.2))
    ax.text(0.2, 0.6, r"$\theta_i$", color=BOBS[0], ha="center", fontsize=11)
    ax.text(0.34, 0.3, r"$l_i\,\sin\varphi_i$", color=BOBS[0], fontsize=10)
    ax.set(
        xlim=(-0.45, 1.4), ylim=(-0.45, 1.4), xlabel=r"$y$ [$l_i \sin\varphi_i$]", ylabel=r"$z$ [$l_i \sin\varphi_i$]"
    )
