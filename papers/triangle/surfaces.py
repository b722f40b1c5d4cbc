# SPDX-License-Identifier: Apache-2.0
"""Figures 5 to 8 of the triangle's paper: sliding surfaces and arcs.

Points of the disc are complex numbers, as in `triangle_chart`. The laws are evaluated by the model's closed loops.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from mehvar.pictures import BLACK, BLUE, GREEN, GREY, PURPLE, SKY, VERMILLION, label, new_figure
from mehvar.reproduction import Runs

from .chart import law_direction, target_shape
from .shapes import PATH, START, TARGET, boundary_names, shape_disc

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import ArrayLike, NDArray

    from mehvar.runtime import Run

_CIRCLE = np.exp(1j * np.linspace(0, 2 * np.pi, 241))


def law_xi(runs: Runs, ratio: ArrayLike) -> NDArray[np.float64]:
    """Return xi (42) as the path law computes it, from w' = -k w exp(i alpha (pi - xi)/2).

    The target is put at rho = 0 and the shape close to it, where neither the bound rho < R nor the escape acts.
    """
    close, run = 1e-3, runs("path", "paper", rho_escape=1e-12)
    theta = np.asarray(ratio, dtype=float) * close**2 / 2
    direction = law_direction(runs.model, run, np.full(theta.shape, close), theta, 0j)
    xi: NDArray[np.float64] = np.pi - 2 * np.angle(-direction)
    return xi


def arc_to(w: complex, x: float, alpha: float) -> NDArray[np.complex128]:
    """Return points of the arc from w to zero that leaves the chord at the angle x, on the side alpha."""
    chord = np.linspace(0.0, x, 200)
    arc: NDArray[np.complex128] = w * np.sin(x - chord) / np.sin(x) * np.exp(1j * alpha * (-chord))
    return arc


def nested_surfaces(runs: Runs) -> Figure:
    """Draw figure 5: where s = 0 for several shifted attitudes."""
    run = runs("sliding", "paper")
    target, values = target_shape(runs.model, run), run.parameters.values
    figure = new_figure(5.8, 5.8)
    ax = figure.subplots()
    shape_disc(ax, values["R"])
    boundary_names(ax)
    levels = (0.01, 0.1, 0.5, 1.6, values["theta_star"])
    for level, color in zip(levels, (PURPLE, GREEN, SKY, BLUE, BLACK), strict=True):
        circle = target + surface_scale(run, level) * (values["R"] * _CIRCLE - target)
        ax.plot(circle.real, circle.imag, color=color, lw=1.8)
        top = circle[np.argmax(circle.imag)]
        text = rf"$|\tilde\theta|={level:g}$ rad" if level == levels[-1] else f"{level:g} rad"
        look = {"facecolor": "white", "edgecolor": "none", "pad": 1.0}
        ax.text(top.real, top.imag, text, color=color, ha="center", va="center", fontsize=8, bbox=look)
    ax.plot(target.real, target.imag, "o", color=TARGET, ms=6, mec="white", zorder=7)
    ax.annotate(
        r"target: $\tilde\theta=0$",
        (target.real, target.imag),
        (0.74, -0.68),
        color=TARGET,
        ha="right",
        fontsize=8,
        arrowprops={"arrowstyle": "-", "color": TARGET, "lw": 0.8},
    )
    return figure


def surface_scale(run: Run, theta: ArrayLike) -> NDArray[np.float64]:
    """Return f of (31): the surface at theta~ is the circle rho = R, shrunk by f towards the target."""
    values = run.parameters.values
    scale: NDArray[np.float64] = np.abs(np.asarray(theta) / values["theta_star"]) ** (1 / values["m"])
    return scale


def cylinder(runs: Runs) -> Figure:
    """Draw figure 6: the sliding run on its surface inside the cylinder rho = R."""
    run = runs("sliding", "paper")
    series, values = run.variables(), run.parameters.values
    a, top = abs(target_shape(runs.model, run)), 1.2
    figure = new_figure(6.4, 5.2)
    ax: Any = figure.add_subplot(projection="3d")
    theta = top * np.linspace(0, 1, 60)[:, None] ** 3
    surface = surface_scale(run, theta) * (a + values["R"] * _CIRCLE[None, ::4])
    wall = np.broadcast_to(a + values["R"] * _CIRCLE[None, ::4], surface.shape)
    heights = np.broadcast_to(theta, surface.shape)
    ax.plot_surface(wall.real, wall.imag, heights, color=GREY, alpha=0.07, lw=0, antialiased=False)
    ax.plot_surface(surface.real, surface.imag, heights, color=SKY, alpha=0.30, lw=0, antialiased=False)
    for level in (0.0, top):
        edge = a + values["R"] * _CIRCLE
        ax.plot(edge.real, edge.imag, level, color=GREY, lw=1.0)
    w = series["rho_error"] * np.exp(1j * series["phi_error"])
    ax.plot(w.real, w.imag, series["theta_shifted"], color=BLUE, lw=1.6)
    ax.plot([w[0].real], [w[0].imag], [series["theta_shifted"][0]], "o", color=START, ms=7, label="start")
    ax.plot([0], [0], [0], "o", color=TARGET, ms=7, label="target")
    ax.plot([], [], color=BLUE, label="sliding run")
    ax.plot([], [], color=SKY, lw=6, alpha=0.5, label=r"sliding surface $s=0$")
    ax.plot([], [], color=GREY, lw=6, alpha=0.3, label=r"cylinder $\rho=R$")
    _cylinder_axes(ax)
    figure.legend(loc="outside upper center", ncols=5, columnspacing=1.2, handlelength=1.4)
    return figure


def _cylinder_axes(ax: Any) -> None:
    ax.set_xlabel(r"$\tilde\rho\,\cos\tilde\varphi$ [1]")
    ax.set_ylabel(r"$\tilde\rho\,\sin\tilde\varphi$ [1]", labelpad=8)
    ax.set_zlabel(label(r"$\tilde\theta$", "shifted attitude", "rad"))
    ax.set_xticks([-0.2, 0.2, 0.6, 1.0])
    ax.set_yticks([-0.6, -0.2, 0.2, 0.6])
    ax.set_box_aspect((1, 1, 1), zoom=0.93)
    ax.view_init(elev=24, azim=-58)
    for axis in (ax.xaxis, ax.yaxis, ax.zaxis):
        axis.set_pane_color((1, 1, 1, 0))


def xi_curve(runs: Runs) -> Figure:
    """Draw figure 7: the solution of (42), the curve from the equation and dots from the law."""
    xi = np.linspace(-0.985 * np.pi, 0.9995 * np.pi, 2000)
    ratio = (np.pi - xi - np.sin(xi)) / (1 + np.cos(xi))
    sampled = np.geomspace(1e-2, 1e3, 26)
    figure = new_figure(5.8, 3.8)
    ax = figure.subplots()
    ax.semilogx(ratio, xi, color=BLUE, label="equation (42)")
    ax.plot(
        sampled,
        law_xi(runs, sampled),
        "o",
        ms=4.5,
        mfc="none",
        color=VERMILLION,
        label="path law, as generated",
    )
    ax.plot(np.pi / 2, 0, "s", ms=6, color=BLACK, label=r"$K=\pi/2$: the chord is a diameter")
    ax.set(xlim=(8e-3, 1.3e3), ylim=(-3.4, 3.4))
    ax.set_yticks(np.pi * np.array([-1, -0.5, 0, 0.5, 1]), ["−π", "−π/2", "0", "π/2", "π"])
    ax.set_xlabel(r"ratio $K=2|\tilde\theta|/\tilde\rho^2$ [rad]")
    ax.set_ylabel(label(r"$\xi$", "arc parameter", "rad"))
    ax.legend(loc="lower left")
    return figure


def limited_arc(runs: Runs) -> Figure:
    """Draw figure 8: the arc free for, the arc touching, and the run."""
    run = runs("path", "paper")
    series, target = run.variables(), target_shape(runs.model, run)
    w = series["rho_error"] * np.exp(1j * series["phi_error"])
    theta, start = float(series["theta_shifted"][0]), complex(w[0])
    alpha = float(np.sign(theta))
    free = (np.pi - law_xi(runs, 2 * abs(theta) / abs(start) ** 2)) / 2
    touching = abs(np.angle(-law_direction(runs.model, run, start, theta, target)))
    zeta = series["rho"] * np.exp(1j * series["phi"])
    figure = new_figure(6.2, 6.2)
    ax = figure.subplots()
    shape_disc(ax, run.parameters.values["R"])
    for x, color, style, name in (
        (free, VERMILLION, "--", rf"encloses $|\tilde\theta|={abs(theta):.2g}$ rad, leaves the disc"),
        (touching, GREEN, "-", r"encloses $\tilde\theta_{max}$, touches $\rho=R$"),
    ):
        arc = target - arc_to(start, float(x), alpha) * target / abs(target)
        ax.plot(arc.real, arc.imag, style, color=color, lw=1.6, label=name)
    ax.plot(zeta.real, zeta.imag, color=PATH, lw=1.4, label="the run")
    _ends(ax, complex(zeta[0]), target)
    ax.set(xlim=(-0.78, 0.86), ylim=(-0.78, 0.86))
    boundary_names(ax)
    figure.legend(loc="outside upper center", ncols=2)
    return figure


def _ends(ax: Axes, start: complex, target: complex) -> None:
    for at, color, name in ((start, START, "start"), (target, TARGET, "target")):
        ax.plot(at.real, at.imag, "o", color=color, ms=7, mec="white", zorder=7, label=name)
