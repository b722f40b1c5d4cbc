# SPDX-License-Identifier: Apache-2.0
"""Shapes of a picture: rods, arrows, balls, boxes, faces; their points are functions of the state."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain

from mehvar.base.manifest import ShapeKind

from .derivation import Expr
from .quantities import Located

_AXES = "xyz"


@dataclass(frozen=True)
class Shape(Located):
    """A part of the picture of a system.

    Parameters
    ----------
    name : str
        Name for readers.
    kind : str
        One of `mehvar.base.manifest.SHAPE_KINDS`: a "rod" connects its points; an "arrow" from the first to the
        second; a "ball" is drawn around its one point; a "box" has its centre and the centres of three faces; a "face"
        is the polygon of its points.
    points : tuple of (Expr, Expr, Expr)
        Points in fixed axes, z up, in metres, as functions of state, input, reference and p. Their units are not
        checked, because the picture chooses sizes and lengths of arrows.
    color : str
        One of `mehvar.base.manifest.SHAPE_COLORS`.
    """

    name: str
    kind: ShapeKind
    points: tuple[tuple[Expr, Expr, Expr], ...]
    color: str = "blue"


def shape_coordinates(geometry: Sequence[Shape]) -> Iterator[tuple[Shape, str, Expr]]:
    """Yield all coordinates of a picture in the order of `geometry`: shape, name, description."""
    for shape in geometry:
        for k, expr in enumerate(chain(*shape.points)):
            yield shape, f"{shape.name} {k // 3 + 1} {_AXES[k % 3]}", expr
