# SPDX-License-Identifier: Apache-2.0
"""Gravity gradient over the craft, with V relative to free fall with O.

A point at r from O is pulled by Gamma r more than O is, Gamma = n^2 (3 o o^T - 1) in a circular orbit of rate n with
the local vertical o. The vertical turns by n in the fixed x-z plane.
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from ...mechanics import quaternion_rotation
from ...system import TIME, Derivation, Group
from ..states import QUATERNION


@dataclass(frozen=True)
class Gradient:
    """The gradient of gravity in body axes.

    Attributes
    ----------
    vertical : sympy.Matrix
        o.
    pull : sympy.Matrix
        n^2 o, 1/s^2.
    square : Expr
        n^2, 1/s^2.
    """

    vertical: sp.Matrix
    pull: sp.Matrix
    square: sp.Expr

    def of(self, r: sp.Matrix) -> sp.Matrix:
        """Return Gamma r."""
        return 3 * self.pull * self.vertical.dot(r) - self.square * r

    def turning(self, inertia: sp.Matrix) -> sp.Matrix:
        """Return the moment 3 n^2 o x J o on a body of the inertia J, N m."""
        return 3 * self.pull.cross(inertia * self.vertical)


def gradient(p: Group, d: Derivation) -> Gradient:
    """Define the local vertical in body axes."""
    d.section("Gradient of gravity")
    angle = d.define(
        "zenith", p.zenith_0 + p.orbit_rate * TIME.symbol, title="angle of the local vertical", unit="rad", latex=r"\nu"
    )
    fixed = sp.Matrix([sp.cos(angle), 0, sp.sin(angle)])
    body = quaternion_rotation(tuple(q.symbol for q in QUATERNION)) * fixed
    vertical = sp.Matrix(
        [
            d.define(f"up_{axis}", entry, title=f"local vertical, body {axis}", unit="1", latex=f"o_{axis}")
            for axis, entry in zip("xyz", body, strict=True)
        ]
    )
    square = d.define("n_sq", p.orbit_rate**2, title="n^2", unit="rad^2/s^2", latex="n^2")
    pull = sp.Matrix(
        [
            d.define(
                f"pull_{axis}", square * entry, title=f"n^2 o, body {axis}", unit="rad^2/s^2", latex=f"n^2 o_{axis}"
            )
            for axis, entry in zip("xyz", vertical, strict=True)
        ]
    )
    return Gradient(vertical, pull, square)
