# SPDX-License-Identifier: Apache-2.0
"""Picture of the spacecraft: a transparent hull with pendulums, and the thrust."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import cycle

import sympy as sp

from ..geometry import Shape
from ..mechanics import frame_turn
from ..system import Expr, Group
from .plant.equations import gimbal_position
from .states import Pendulum, angle_quantities, direction_quantities, rod

_REAR, _FRONT, _RADIUS = sp.Rational(-52, 100), sp.Rational(6, 5), sp.Rational(36, 100)
"""Rear end, front end and radius of the hull in the picture, m, which the paper does not give."""
_SIDES = 6
_PER_FORCE = sp.Rational(1, 5000)
"""Length of a force arrow, m/N, so that the paper's thrust is half a metre long."""
_COLORS = ("purple", "orange", "sky", "green")

Point = tuple[Expr, Expr, Expr]


def geometry(
    p: Group, pendulums: Sequence[Pendulum], inertia: str, angles: Sequence[Expr], force: Sequence[Expr]
) -> tuple[Shape, ...]:
    """Return the shapes in fixed axes.

    Parameters
    ----------
    p : Group
        Parameters of the plant.
    pendulums : sequence of Pendulum
        Drawn as a rod and a bob each.
    inertia : str
        Convention of inertia; on ball joints directions are states, else angles.
    angles : sequence of Expr
        The attitude; the paper's small angles are drawn as 3-2-1 angles.
    force : sequence of Expr
        The thrust in body axes, N.
    """
    turn = (frame_turn(0, angles[0]) * frame_turn(1, angles[1]) * frame_turn(2, angles[2])).T

    def placed(*points: sp.Matrix) -> tuple[Point, ...]:
        return tuple((place[0], place[1], place[2]) for place in (turn * point for point in points))

    rear, front = _ring(_REAR), _ring(_FRONT)
    gimbal = gimbal_position(p)
    shapes = [
        Shape("rear", "rod", placed(*rear, rear[0]), "grey"),
        Shape("front", "rod", placed(*front, front[0]), "grey"),
        *(Shape(f"stringer {k // 2 + 1}", "rod", placed(rear[k], front[k]), "grey") for k in range(0, _SIDES, 2)),
        Shape("nozzle", "ball", placed(gimbal), "black"),
        Shape("exhaust", "arrow", placed(gimbal, gimbal - _PER_FORCE * sp.Matrix(force)), "vermillion"),
    ]
    for k, (pendulum, color) in enumerate(zip(pendulums, cycle(_COLORS), strict=False), 1):
        pivot = sp.Matrix([pendulum.pivot, 0, 0])
        bob = pivot + pendulum.length * _direction(k, inertia)
        shapes += [
            Shape(f"arm {k}", "rod", placed(pivot, bob), color),
            Shape(f"bob {k}", "ball", placed(bob), color),
        ]
    return tuple(shapes)


def _ring(x: Expr) -> list[sp.Matrix]:
    turns = [2 * sp.pi * k / _SIDES for k in range(_SIDES)]
    return [sp.Matrix([x, _RADIUS * sp.sin(turn), _RADIUS * sp.cos(turn)]) for turn in turns]


def _direction(k: int, inertia: str) -> sp.Matrix:
    """Return the unit vector from the pivot to bob k in body axes: from angles (7), or three states."""
    if inertia == "ball":
        return sp.Matrix([q.symbol for q in direction_quantities(k)])
    return rod(*(q.symbol for q in angle_quantities(k)))
