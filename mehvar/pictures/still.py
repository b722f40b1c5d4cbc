# SPDX-License-Identifier: Apache-2.0
"""Still picture of shapes, such as those of a craft's parts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from mehvar.base.manifest import SHAPE_COLORS

from .style import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, VERMILLION, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from mehvar.models.geometry import Shape

    FloatArray = NDArray[np.float64]

_PALETTE = dict(zip(SHAPE_COLORS, (BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY, BLACK, GREY), strict=True))
_SIDES = ((0, 2, 6, 4), (1, 3, 7, 5), (0, 1, 5, 4), (2, 3, 7, 6), (0, 1, 3, 2), (4, 5, 7, 6))
"""Faces of a box by its corners; corner k is on the far side of middle i where bit i of k is set."""
_VIEW = {"elev": 20.0, "azim": -60.0}
"""Angles of the camera, degrees: no axis of the hub points at the reader."""


def still_picture(shapes: Sequence[Shape], parts: Sequence[str], title: str) -> Figure:
    """Draw shapes whose points are numbers; call it in `mehvar.pictures.style.style`.

    Parameters
    ----------
    shapes : sequence of Shape
        Each part is labelled at its first shape. The first word of a name tells the part.
    parts : sequence of str
        Names of all parts; those without a shape are listed below the picture.
    title : str
        Above the picture.
    """
    figure = new_figure(7.0, 5.0)
    ax: Any = figure.add_subplot(projection="3d")
    places = [np.array(shape.points, dtype=float) for shape in shapes]
    missing = dict.fromkeys(parts)
    for shape, points in zip(shapes, places, strict=True):
        part, _, detail = shape.name.partition(" ")
        first, arrow = part in missing, shape.kind == "arrow"
        if (arrow and np.allclose(*points)) or (shape.kind == "ball" and detail and part in parts):
            continue  # of a force, a torque or a speed, which is zero
        _draw(ax, shape.kind, points, _PALETTE[shape.color])
        text = part if first else "" if part in parts and not arrow else detail
        ax.text(*points[-1 if arrow or shape.kind == "box" else 0], f" {text}", color=BLACK)
        missing.pop(part, None)
    ax.auto_scale_xyz(*np.concatenate(places).T)
    ax.set(xlabel="x [m]", ylabel="y [m]", zlabel="z [m]", title=title)
    ax.set_box_aspect([np.ptp(ax.get_xlim()), np.ptp(ax.get_ylim()), np.ptp(ax.get_zlim())], zoom=1.15)
    ax.locator_params(nbins=5)  # more numbers overlap on the axis that runs away from the reader
    ax.view_init(**_VIEW)
    if missing:
        ax.text2D(0.0, 0.0, f"without a shape: {', '.join(missing)}", transform=ax.transAxes, color=GREY)
    return figure


def _draw(ax: Any, kind: str, points: FloatArray, color: str) -> None:
    """Draw one shape."""
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    if kind == "rod":
        ax.plot(*points.T, color=color, lw=2.5)
    elif kind == "arrow":
        ax.quiver(*points[0], *(points[1] - points[0]), color=color, arrow_length_ratio=0.08)
    elif kind == "ball":
        ax.scatter(*points.T, color=color, edgecolors=BLACK, s=40, depthshade=False)
    else:
        faces = points[None] if kind == "face" else _corners(points)[list(map(list, _SIDES))]
        ax.add_collection3d(Poly3DCollection(faces, facecolors=color, edgecolors=BLACK, alpha=0.2, linewidths=0.7))


def _corners(box: FloatArray) -> FloatArray:
    """Return the corners of a box from its centre and the middles of three faces, shape (8, 3)."""
    signs = np.array([[1 if k & (1 << i) else -1 for i in range(3)] for k in range(8)])
    corners: FloatArray = box[0] + signs @ (box[1:] - box[0])
    return corners
