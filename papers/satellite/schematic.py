# SPDX-License-Identifier: Apache-2.0
"""Figures 1 to 3 of the satellite's paper, from its text: the controller, the test bed and its parts."""

from __future__ import annotations

from typing import TYPE_CHECKING

from matplotlib.patches import Circle, FancyBboxPatch, Polygon, Rectangle

from mehvar.pictures import BLACK, BLUE, GREEN, GREY, LIGHT, ORANGE, VERMILLION, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from mehvar.reproduction import Runs

Point = tuple[float, float]

_PAPER = "#F7F7F7"


def controller(runs: Runs) -> Figure:
    """Draw figure 1: reference model, law (32), plant, and the estimator that adapts the law."""
    figure, ax = _sheet(10.0, 4.4)
    _box(ax, (1.7, 3.0), 1.8, 0.8, "reference model (16)\n$q^{-d} D / C_1$", GREY)
    _box(ax, (4.0, 3.0), 1.1, 0.8, "$C_2\\,q^{d}$", BLUE)
    _sum(ax, (5.4, 3.0))
    _box(ax, (6.7, 3.0), 1.0, 0.8, "$1 / b_0$", BLUE)
    _box(ax, (9.4, 3.0), 1.9, 0.8, "satellite (13)\n$q^{-d} B / A$", VERMILLION)
    _box(ax, (6.7, 1.7), 1.6, 0.7, "$B_S = B S - b_0$ (33)", BLUE)
    _box(ax, (6.7, 0.6), 1.6, 0.7, "$T$", BLUE)
    _box(ax, (9.4, 4.6), 1.9, 0.8, "estimator (34)-(42)\n$\\hat a_1, \\hat a_2, \\hat b_0, \\hat b_1, \\hat d$", GREEN)
    _box(ax, (6.0, 4.6), 2.3, 0.8, "design, every sample\n$C_2 = A S + q^{-d} T$ (22)", GREEN)
    _arrow(ax, [(0.1, 3.0), (0.8, 3.0)], "$r(k)$")
    _arrow(ax, [(2.6, 3.0), (3.45, 3.0)], "$y_m(k)$")
    _arrow(ax, [(4.55, 3.0), (5.25, 3.0)])
    _arrow(ax, [(5.55, 3.0), (6.2, 3.0)])
    _arrow(ax, [(7.2, 3.0), (8.45, 3.0)], "$u(k)$")
    _arrow(ax, [(10.35, 3.0), (11.8, 3.0)])
    ax.text(11.4, 3.07, "$y(k)$", ha="center", va="bottom", fontsize=9)
    _arrow(ax, [(7.9, 3.0), (7.9, 1.7), (7.5, 1.7)])
    _arrow(ax, [(5.9, 1.7), (5.4, 1.7), (5.4, 2.85)])
    _arrow(ax, [(10.9, 3.0), (10.9, 0.6), (7.5, 0.6)])
    _arrow(ax, [(5.9, 0.6), (5.0, 0.6), (5.0, 2.4), (5.3, 2.88)])
    _arrow(ax, [(8.2, 3.0), (8.2, 4.6), (8.45, 4.6)])
    _arrow(ax, [(10.9, 3.0), (10.9, 4.6), (10.35, 4.6)])
    _arrow(ax, [(8.45, 4.85), (7.15, 4.85)], "$\\hat\\Theta$", color=GREEN)
    _arrow(ax, [(6.0, 4.2), (6.0, 3.75), (6.7, 3.75), (6.7, 3.4)], color=GREEN)
    ax.text(6.05, 3.82, "$b_0, B_S, T, \\hat d$", color=GREEN, va="bottom", ha="left", fontsize=8)
    for x, y in ((7.9, 3.0), (8.2, 3.0), (10.9, 3.0)):
        ax.add_patch(Circle((x, y), 0.04, color=BLACK))
    for (x, y), sign in (((5.15, 3.12), "+"), ((5.5, 2.68), "−"), ((5.1, 2.78), "−")):
        ax.text(x, y, sign, ha="center", va="bottom", fontsize=8)
    ax.set(xlim=(0.0, 11.9), ylim=(0.1, 5.15))
    return figure


def bed(runs: Runs) -> Figure:
    """Draw figure 2: the parts on the simulating computer, those on the board, and the data on the line."""
    p = runs("mrac", "paper").parameters.values
    figure, ax = _sheet(10.0, 3.6)
    _frame(ax, (0.1, 0.75), 4.2, 3.05, "1  simulating computer", VERMILLION)
    _frame(ax, (4.7, 0.75), 1.9, 3.05, "3  interface", GREY)
    _frame(ax, (7.0, 0.75), 4.5, 3.05, "2  control electronics", BLUE)
    _box(ax, (2.2, 2.8), 3.2, 0.7, "dynamics and kinematics (1)-(7)\nof the satellite", VERMILLION)
    _box(ax, (1.2, 1.6), 1.6, 0.7, "environment", VERMILLION)
    _box(ax, (3.2, 1.6), 1.5, 0.7, "three wheels", VERMILLION)
    _box(ax, (5.65, 2.2), 1.3, 1.6, "RS232\n115200 bit/s", GREY)
    _box(ax, (9.25, 2.8), 3.9, 0.7, "estimator (34)-(42) and law (32)\nin single precision", BLUE)
    _box(ax, (9.25, 1.6), 3.9, 0.7, "32-bit ARM microcontroller", BLUE)
    _arrow(ax, [(1.2, 1.95), (1.2, 2.45)])
    _arrow(ax, [(3.2, 1.95), (3.2, 2.45)])
    _arrow(ax, [(3.8, 2.8), (5.0, 2.8)])
    _arrow(ax, [(6.3, 2.8), (7.3, 2.8)])
    _arrow(ax, [(7.3, 1.6), (6.3, 1.6)])
    _arrow(ax, [(5.0, 1.6), (3.95, 1.6)])
    _arrow(ax, [(9.25, 1.95), (9.25, 2.45)], tail=True)
    ax.text(5.65, 3.15, "72 bytes:\nangles, rates, references", ha="center", va="bottom", fontsize=7)
    ax.text(5.65, 1.25, "12 bytes:\n$T_x, T_y, T_z$", ha="center", va="top", fontsize=7)
    late = f"one sample later: a torque computed from $y(k)$ acts from $(k+1)\\,T_s$ on, $T_s$ = {p['Ts']:g} s"
    ax.text(5.8, 0.4, late, ha="center", fontsize=8)
    ax.set(xlim=(0.0, 11.6), ylim=(0.1, 4.15))
    return figure


def parts(runs: Runs) -> Figure:
    """Draw figure 3: computer, interface and board as real devices."""
    figure, ax = _sheet(10.0, 3.0)
    _computer(ax, (1.7, 1.7))
    _interface(ax, (5.5, 1.4))
    _board(ax, (9.2, 1.5))
    _arrow(ax, [(3.0, 1.4), (4.6, 1.4)], "RS232", tail=True)
    _arrow(ax, [(6.4, 1.4), (7.7, 1.4)], "serial port", tail=True)
    texts = (
        "computer: simulates the\nsatellite and its environment",
        "interface circuit:\nexchanges the data",
        "control electronics: 32-bit ARM\nmicrocontroller, runs the law",
    )
    for x, text in zip((1.7, 5.5, 9.2), texts, strict=True):
        ax.text(x, 0.1, text, ha="center", va="bottom", fontsize=8)
    ax.set(xlim=(0.0, 11.0), ylim=(0.0, 3.2))
    return figure


def _computer(ax: Axes, at: Point) -> None:
    x, y = at
    ax.add_patch(FancyBboxPatch((x - 1.1, y - 0.3), 2.2, 1.5, "round,pad=0.05", fc=_PAPER, ec=VERMILLION, lw=1.4))
    ax.add_patch(Rectangle((x - 1.0, y - 0.2), 2.0, 1.3, fc="white", ec=LIGHT))
    ax.add_patch(Polygon([(x - 0.3, y - 0.35), (x + 0.3, y - 0.35), (x + 0.5, y - 0.7), (x - 0.5, y - 0.7)], fc=LIGHT))
    ax.add_patch(Circle((x, y + 0.4), 0.42, fill=False, ec=GREY, ls=":", lw=1.0))
    ax.add_patch(Rectangle((x + 0.3, y + 0.55), 0.22, 0.22, angle=25, fc=VERMILLION, ec=BLACK, lw=0.6))
    for dx, dy in ((0.03, 0.51), (0.47, 0.71)):
        ax.add_patch(Rectangle((x + dx, y + dy), 0.22, 0.09, angle=25, fc=BLUE, ec=BLACK, lw=0.4))


def _interface(ax: Axes, at: Point) -> None:
    x, y = at
    ax.add_patch(FancyBboxPatch((x - 0.8, y - 0.5), 1.6, 1.0, "round,pad=0.05", fc=_PAPER, ec=GREY, lw=1.4))
    ax.add_patch(Polygon([(x - 0.72, y + 0.22), (x - 0.1, y + 0.22), (x - 0.2, y - 0.22), (x - 0.62, y - 0.22)],
                         fc="white", ec=BLACK, lw=0.8))  # fmt: skip
    for k, row in enumerate((5, 4)):
        for i in range(row):
            ax.add_patch(Circle((x - 0.41 + 0.1 * (i - (row - 1) / 2), y + 0.09 - 0.18 * k), 0.025, color=BLACK))
    ax.add_patch(Rectangle((x + 0.15, y - 0.2), 0.45, 0.4, fc=BLACK, ec=BLACK))


def _board(ax: Axes, at: Point) -> None:
    x, y = at
    ax.add_patch(FancyBboxPatch((x - 1.3, y - 0.7), 2.6, 1.5, "round,pad=0.05", fc=_PAPER, ec=BLUE, lw=1.4))
    ax.add_patch(Rectangle((x - 0.45, y - 0.4), 0.9, 0.9, fc=BLACK, ec=BLACK))
    ax.text(x, y + 0.05, "ARM", color="white", ha="center", va="center", fontsize=9)
    for k in range(8):
        offset = -0.4 + 0.11 * k
        for start, end in (((x - 0.58, y + offset + 0.05), (x - 0.45, y + offset + 0.05)),
                           ((x + 0.45, y + offset + 0.05), (x + 0.58, y + offset + 0.05))):  # fmt: skip
            ax.plot(*zip(start, end, strict=True), color=ORANGE, lw=1.2)
    for dx in (-1.0, 0.95):
        ax.add_patch(Rectangle((x + dx - 0.1, y - 0.5), 0.2, 1.1, fc=LIGHT, ec=GREY, lw=0.6))


def _sheet(width: float, height: float) -> tuple[Figure, Axes]:
    figure = new_figure(width, height)
    ax = figure.subplots()
    ax.axis("off")
    ax.set_aspect("equal")
    return figure, ax


def _box(ax: Axes, centre: Point, width: float, height: float, text: str, color: str) -> None:
    x, y = centre
    corner = (x - width / 2, y - height / 2)
    ax.add_patch(FancyBboxPatch(corner, width, height, "round,pad=0,rounding_size=0.08", fc="white", ec=color, lw=1.4))
    ax.text(x, y, text, ha="center", va="center", fontsize=8)


def _frame(ax: Axes, corner: Point, width: float, height: float, title: str, color: str) -> None:
    ax.add_patch(FancyBboxPatch(corner, width, height, "round,pad=0,rounding_size=0.12", fc=_PAPER, ec=color, lw=0.9))
    ax.text(corner[0] + width / 2, corner[1] + height + 0.06, title, color=color, ha="center", va="bottom", fontsize=9)


def _sum(ax: Axes, at: Point) -> None:
    ax.add_patch(Circle(at, 0.15, fc="white", ec=BLUE, lw=1.4, zorder=3))


def _arrow(ax: Axes, points: list[Point], text: str = "", color: str = BLACK, tail: bool = False) -> None:
    """Draw an arrow along a line of points, with a text over its first stretch; `tail` gives it two heads."""
    *first, start, end = points
    if first:
        ax.plot(*zip(*first, start, strict=True), color=color, lw=1.1, solid_capstyle="butt")
    look = {"arrowstyle": "<|-|>" if tail else "-|>", "color": color, "lw": 1.1, "shrinkA": 0, "shrinkB": 0}
    ax.annotate("", end, start, arrowprops=look)
    if text:
        (x0, y0), (x1, _) = points[:2]
        ax.text((x0 + x1) / 2, y0 + 0.07, text, color=color, ha="center", va="bottom", fontsize=9)
