# SPDX-License-Identifier: Apache-2.0
"""Figures 1 to 4 of the triangle's paper: the definition of shapes and their position in the disc.

Points of the plane are complex numbers. Shapes come from the model's `lengths` and `shape`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.patches import Arc, Circle, Polygon

from mehvar.pictures import BLACK, BLUE, GREEN, GREY, LIGHT, ORANGE, PURPLE, VERMILLION, new_figure
from mehvar.reproduction import Runs

from .chart import target_shape

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import ArrayLike, NDArray

RODS = (BLUE, VERMILLION, GREEN)
R = 0.65
"""Bound of the laws; the figures without a run show its default."""
COLLINEAR = float(np.sqrt(0.5))
START, TARGET, PATH = ORANGE, PURPLE, BLUE

Complex = complex | np.complex128


def vertices(lengths: ArrayLike, theta: float = 0.0) -> NDArray[np.complex128]:
    """Place a triangle of equal masses from its rods.

    Parameters
    ----------
    lengths : array_like, (3,)
        l1, l2, l3 in m; rod k lies opposite vertex k, vertices run counter-clockwise.
    theta : float
        Attitude in rad: the angle of the rotation Q in X_i = Q S x_i.

    Returns
    -------
    array, (3,)
        Vertices in m, as complex numbers; their centre is zero.
    """
    placed, base = _on_edge(lengths), _on_edge((1.0, 1.0, 1.0))
    own = np.vdot(base, placed)
    turned: NDArray[np.complex128] = placed * np.exp(1j * theta) * abs(own) / own
    return turned


def _on_edge(lengths: ArrayLike) -> NDArray[np.complex128]:
    """Return the vertices with rod 3 along +x, the centre at zero."""
    l1, l2, l3 = np.asarray(lengths, dtype=float)
    along = (l3**2 + l2**2 - l1**2) / (2 * l3)
    points: NDArray[np.complex128] = np.array([0, l3, along + 1j * np.sqrt(max(l2**2 - along**2, 0.0))])
    points -= points.mean()
    return points


def draw_triangle(ax: Axes, points: NDArray[np.complex128], mass: float, width: float) -> None:
    """Draw rods in their colours, and masses as discs of radius `mass` in data units."""
    for k in range(3):
        i, j = points[(k + 1) % 3], points[(k + 2) % 3]
        ax.plot([i.real, j.real], [i.imag, j.imag], color=RODS[k], lw=width, solid_capstyle="round", zorder=3)
    for point in points:
        ax.add_patch(Circle((point.real, point.imag), mass, facecolor=BLACK, edgecolor="white", lw=0.5, zorder=4))


def arrow(ax: Axes, tail: Complex, head: Complex, color: str, **style: Any) -> None:
    """Draw an arrow between two points of the plane."""
    look = {"arrowstyle": "-|>", "color": color, "lw": 1.6, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 11, **style}
    ax.annotate("", (head.real, head.imag), (tail.real, tail.imag), arrowprops=look, annotation_clip=False, zorder=5)


def angle_mark(ax: Axes, centre: Complex, radius: float, start: float, end: float, text: str, color: str) -> None:
    """Draw an arc between two directions (rad) and name the angle beside its middle."""
    first, last = sorted((start, end))
    size, at = 2 * radius, (centre.real, centre.imag)
    ax.add_patch(Arc(at, size, size, theta1=np.degrees(first), theta2=np.degrees(last), color=color, lw=1.3, zorder=5))
    place = centre + 1.28 * radius * np.exp(0.5j * (start + end))
    ax.text(place.real, place.imag, text, color=color, ha="center", va="center", fontsize=11, zorder=6)


def shape_disc(ax: Axes, radius: float = R) -> None:
    """Draw the disc of shapes: the allowed circle rho = R and the collinear boundary."""
    ax.set_aspect("equal")
    ax.add_patch(Circle((0, 0), COLLINEAR, facecolor="#F7F7F7", edgecolor=GREY, ls="--", lw=1.0, zorder=0.5))
    ax.add_patch(Circle((0, 0), radius, facecolor="white", edgecolor=BLACK, lw=1.2, zorder=0.6))
    ax.set(xlabel=r"$\rho\,\cos\varphi$ [1]", ylabel=r"$\rho\,\sin\varphi$ [1]")
    ax.set(xlim=(-0.76, 0.76), ylim=(-0.76, 0.76))
    ax.set_xticks(np.linspace(-0.6, 0.6, 5))
    ax.set_yticks(np.linspace(-0.6, 0.6, 5))


def schematic(runs: Runs) -> Figure:
    """Draw figure 1: masses, rods and the attitude."""
    theta, lengths = np.radians(28.0), (0.40, 0.34, 0.56)
    figure = new_figure(6.2, 4.0)
    ax = figure.subplots()
    points = vertices(lengths, theta)
    base = vertices(np.full(3, np.sqrt(np.square(lengths).mean())), theta)
    ax.add_patch(Polygon(np.c_[base.real, base.imag], fill=False, edgecolor=GREY, ls=(0, (4, 3)), lw=1.1))
    draw_triangle(ax, points, 0.024, 4.0)
    for k in range(3):
        ax.text(points[k].real, points[k].imag, str(k + 1), color="white", ha="center", va="center", zorder=6)
        middle = (points[(k + 1) % 3] + points[(k + 2) % 3]) / 2
        at = middle * (1 + 0.075 / abs(middle))
        ax.text(at.real, at.imag, rf"$l_{k + 1}$", color=RODS[k], ha="center", va="center", fontsize=14)
    _attitude_axes(ax, theta)
    at = base[1]
    ax.annotate(
        "base triangle\nturned by θ",
        (at.real, at.imag),
        (at.real + 0.10, at.imag - 0.10),
        arrowprops={"arrowstyle": "-", "color": GREY, "lw": 0.8},
        color=GREY,
        ha="left",
        va="center",
    )
    ax.set_aspect("equal")
    ax.set(xlim=(-0.40, 0.56), ylim=(-0.27, 0.34))
    ax.axis("off")
    return figure


def _attitude_axes(ax: Axes, theta: float) -> None:
    """Draw the fixed axes at the centre of mass, and the first one turned by theta."""
    for head, name, color in ((0.44, "x", GREY), (0.30j, "y", GREY), (0.44 * np.exp(1j * theta), "x'", BLACK)):
        arrow(ax, 0j, head, color, lw=1.1)
        at = head * (1 + 0.022 / abs(head))
        ax.text(at.real, at.imag, name, color=color, ha="center", va="center", style="italic")
    angle_mark(ax, 0j, 0.10, 0.0, theta, "θ", BLACK)
    ax.plot(0, 0, "o", color=BLACK, ms=4, zorder=6)


def shape_grid(runs: Runs) -> Figure:
    """Draw figure 2: one small triangle for each pair of rho and phi, all of the same mu."""
    distances, turns = np.array([0.0, 0.2, 0.4, 0.6]), np.arange(-120, 181, 60)
    figure = new_figure(7.2, 4.9)
    ax = figure.subplots()
    for row, distance in enumerate(distances):
        for column, turn in enumerate(turns):
            lengths = runs.model.functions["lengths"](distance, np.radians(turn), 1.0)
            draw_triangle(ax, 0.62 * vertices(lengths) + complex(column, row), 0.033, 2.2)
    ax.set_aspect("equal")
    ax.set_xticks(range(len(turns)), [f"{turn}°".replace("-", "−") for turn in turns])
    ax.set_yticks(range(len(distances)), [f"{distance:g}" for distance in distances])
    ax.set(xlim=(-0.6, len(turns) - 0.4), ylim=(-0.5, len(distances) - 0.5))
    ax.set(xlabel=r"direction $\varphi$ in the shape disc [°]", ylabel=r"distance $\rho$ from the base shape [1]")
    _rod_legend(figure)
    return figure


def polar_plane(runs: Runs) -> Figure:
    """Draw figure 3: the triangles at sample points of the disc."""
    figure = new_figure(6.4, 6.6)
    ax = figure.subplots()
    shape_disc(ax)
    _polar_grid(ax, (0.2, 0.4, 0.57))
    for distance, count in ((0.0, 1), (0.2, 6), (0.4, 12), (0.57, 12)):
        for turn in np.linspace(0, 2 * np.pi, count, endpoint=False):
            lengths = runs.model.functions["lengths"](distance, turn, 1.0)
            centre = distance * np.exp(1j * turn)
            draw_triangle(ax, 0.115 * vertices(lengths) + centre, 0.0085, 1.8)
    _rod_legend(figure)
    return figure


def _polar_grid(ax: Axes, distances: tuple[float, ...]) -> None:
    """Draw circles and spokes in place of the square grid, and name the boundaries and directions."""
    ax.grid(False)
    for distance in distances:
        ax.add_patch(Circle((0, 0), distance, fill=False, edgecolor=LIGHT, lw=0.7, zorder=0.8))
    for turn in range(0, 360, 30):
        way = np.exp(1j * np.radians(turn))
        ax.plot([0, R * way.real], [0, R * way.imag], color=LIGHT, lw=0.7, zorder=0.8)
        if turn % 90:
            at = 0.755 * way
            ax.text(at.real, at.imag, f"{turn}°", color=GREY, ha="center", va="center", fontsize=8)
    boundary_names(ax)


def boundary_names(ax: Axes, radius: float = R) -> None:
    """Name the circle rho = R and the collinear boundary at the lower left, outside the disc."""
    way = np.exp(1j * np.radians(225))
    for at, shift, text, color in (
        (radius * way, -0.02 - 0.10j, r"$\rho=R$", BLACK),
        (COLLINEAR * way, -0.10 - 0.01j, "collinear", GREY),
    ):
        look = {"arrowstyle": "-", "color": color, "lw": 0.8}
        place = COLLINEAR * way + shift
        ax.annotate(
            text,
            (at.real, at.imag),
            (place.real, place.imag),
            color=color,
            ha="center",
            va="center",
            fontsize=8,
            arrowprops=look,
        )


def _rod_legend(figure: Figure) -> None:
    from matplotlib.lines import Line2D

    handles = [Line2D([], [], color=color, lw=2.5, label=f"rod {k}") for k, color in enumerate(RODS, 1)]
    figure.legend(handles=handles, loc="outside upper center", ncols=3)


def shifted_origin(runs: Runs) -> Figure:
    """Draw figure 4: the shape relative to the target of scenario paper-b."""
    target = target_shape(runs.model, runs("path", "paper-b"))
    target_phi, point = float(np.angle(target)), 0.50 * np.exp(1j * np.radians(66))
    way = target - point
    figure = new_figure(5.8, 5.8)
    ax = figure.subplots()
    shape_disc(ax)
    boundary_names(ax)
    ax.plot([0, R], [0, 0], color=GREY, lw=0.9)
    far = point + 0.28 * np.exp(1j * target_phi)
    ax.plot([point.real, far.real], [point.imag, far.imag], color=TARGET, ls=":", lw=1.6)
    arrow(ax, 0j, point, START)
    arrow(ax, 0j, target, TARGET)
    arrow(ax, point, target, BLACK, lw=2.0)
    angle_mark(ax, 0j, 0.09, 0.0, float(np.angle(point)), r"$\varphi$", START)
    angle_mark(ax, 0j, 0.13, 0.0, target_phi, r"$\varphi_f$", TARGET)
    angle_mark(ax, point, 0.17, target_phi, float(np.angle(way)), r"$\tilde\varphi$", BLACK)
    for at, shift, name, color in (
        (point / 2, -0.045 - 0.02j, r"$\rho$", START),
        (target / 2, -0.04 - 0.05j, r"$\rho_f=a$", TARGET),
        (point + way / 2, 0.045 + 0.02j, r"$\tilde\rho$", BLACK),
    ):
        place = at + shift
        ax.text(place.real, place.imag, name, color=color, ha="center", va="center", fontsize=12)
    _point(ax, point, START, "current shape", 0.05j)
    _point(ax, target, TARGET, "target: the new origin", 0.02 - 0.05j)
    return figure


def _point(ax: Axes, at: Complex, color: str, text: str, shift: Complex) -> None:
    ax.plot(at.real, at.imag, "o", color=color, ms=7, mec="white", zorder=7)
    place = at + shift
    ax.text(place.real, place.imag, text, color=color, ha="center", va="center", fontsize=9)
