# SPDX-License-Identifier: Apache-2.0
"""Picture of the satellite: body, panels, axes, desired directions of two axes, and torque."""

from __future__ import annotations

import sympy as sp

from ..geometry import Shape
from ..system import Expr
from .controllers import REFERENCES
from .dynamics import angles, euler_rotation

_HALF = tuple(sp.Rational(h, 100) for h in (32, 32, 38))
"""Half of the body's edge length, m. The paper gives no sizes, so all lengths here are chosen for the picture."""
_ROOT, _TIP, _WIDTH = sp.Rational(42, 100), sp.Rational(5, 4), sp.Rational(24, 100)
_REACH = (sp.Rational(19, 20), sp.Rational(31, 20), sp.Rational(19, 20))
"""Lengths of the arrows of the axes; the y arrow is longer than the panel."""
_PER_TORQUE = 30
"""Length of a torque arrow, m per N m; the paper's laws command a few hundredths of a N m."""
_COLORS = ("blue", "vermillion", "green")


def geometry(rotation: sp.Matrix, torque: sp.Matrix) -> tuple[Shape, ...]:
    """Return the shapes in orbit axes with the Earth below.

    Parameters
    ----------
    rotation : Matrix
        C, from orbit axes to body axes.
    torque : Matrix
        Of the wheels' motors on the body, N m.
    """
    at = dict(zip(angles, REFERENCES.symbols, strict=True))
    reference = euler_rotation().xreplace(at)
    centre, ways = _place(rotation, sp.zeros(3, 1)), sp.eye(3)
    middles = [_place(rotation, _HALF[k] * ways[:, k]) for k in range(3)]
    arms = [_place(rotation, _REACH[k] * ways[:, k]) for k in range(3)]
    twist = _PER_TORQUE * torque
    return (
        Shape("body", "box", (centre, *middles), "grey"),
        *(Shape(f"panel {name}", "face", _panel(rotation, side), "sky") for name, side in (("+y", 1), ("-y", -1))),
        *(Shape(f"axis {'xyz'[k]}", "arrow", (centre, arms[k]), _COLORS[k]) for k in range(3)),
        *(
            Shape(f"wanted {'xyz'[k]}", "arrow", (centre, _place(reference, _REACH[k] * ways[:, k])), "orange")
            for k in (0, 2)
        ),
        Shape("torque", "arrow", (centre, _place(rotation, twist)), "purple"),
    )


def _panel(rotation: sp.Matrix, side: int) -> tuple[tuple[Expr, Expr, Expr], ...]:
    corners = ((-_WIDTH, _ROOT), (_WIDTH, _ROOT), (_WIDTH, _TIP), (-_WIDTH, _TIP))
    return tuple(_place(rotation, sp.Matrix([x, side * y, 0])) for x, y in corners)


def _place(rotation: sp.Matrix, point: sp.Matrix) -> tuple[Expr, Expr, Expr]:
    """Convert a point of the body from orbit axes, z down, to picture axes, z up."""
    x, y, z = rotation.T * point
    return x, -y, -z
