# SPDX-License-Identifier: Apache-2.0
"""Picture of the triangle: masses, rods, the attitude and its target."""

from __future__ import annotations

import sympy as sp

from ..geometry import Shape
from ..mechanics import rotate
from ..system import Expr
from .dynamics import THETA, BaseTriangle

_COLORS = ("blue", "vermillion", "green")
_POINTER = sp.Rational(3, 10)
"""Length of an arrow, m, equal to that of a rod."""


def geometry(masses: tuple[Expr, ...], stretch: sp.Matrix, base: BaseTriangle, wanted: Expr) -> tuple[Shape, ...]:
    """Return masses and rods at X_i = Q S x_i (5) in a vertical plane.

    Parameters
    ----------
    masses : tuple of Expr
        The three masses, kg.
    stretch : Matrix
        S, m.
    base : BaseTriangle
        Base triangle, whose corners S moves.
    wanted : Expr
        Desired attitude, rad.
    """
    places = [_upright(stretch * corner, THETA.symbol) for corner in _corners(masses, base)]
    ends = [(places[(k + 1) % 3], places[(k + 2) % 3]) for k in range(3)]
    centre, ahead = (sp.S.Zero,) * 3, sp.Matrix([_POINTER, 0])
    return (
        *(Shape(f"rod {k + 1}", "rod", ends[k], _COLORS[k]) for k in range(3)),
        *(Shape(f"mass {k + 1}", "ball", (places[k],), "black") for k in range(3)),
        Shape("attitude", "arrow", (centre, _upright(ahead, THETA.symbol)), "purple"),
        Shape("attitude wanted", "arrow", (centre, _upright(ahead, wanted)), "grey"),
    )


def _corners(masses: tuple[Expr, ...], base: BaseTriangle) -> list[sp.Matrix]:
    """Return x_i from the edges d_3 = x_2 - x_1 and d_2 = x_1 - x_3, with the centre of mass at zero."""
    edges = [
        sp.sqrt(squared) * sp.Matrix(way) for squared, way in zip(base.length_squared, base.direction, strict=True)
    ]
    first = (masses[2] * edges[1] - masses[1] * edges[2]) / sp.Add(*masses)
    return [first, first + edges[2], first - edges[1]]


def _upright(place: sp.Matrix, angle: Expr) -> tuple[Expr, Expr, Expr]:
    x, y = rotate((place[0], place[1]), sp.cos(angle), sp.sin(angle))
    return x, sp.S.Zero, y
