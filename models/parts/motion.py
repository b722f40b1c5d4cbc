# SPDX-License-Identifier: Apache-2.0
"""Motion of an assembly, and the terms of its rotation."""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from ..derivation import Expr
from ..mechanics import cross_matrix
from .frame import AXES, ZERO, Frame


@dataclass(frozen=True)
class Motion:
    """Accelerations of an assembly.

    Attributes
    ----------
    frame : Frame
        The axes of the hub.
    centre : sympy.Matrix
        Point of the hub for which `linear` holds, from O.
    linear, angular : sympy.Matrix
        Acceleration of that point, and W', in the axes of the hub.
    own : tuple of Expr
        q'' of the part's rows, in their order.
    pulls : tuple of Expr
        mass e . a_P - pull of the part's followers, N, in their order.
    """

    frame: Frame
    centre: sp.Matrix
    linear: sp.Matrix
    angular: sp.Matrix
    own: tuple[Expr, ...] = ()
    pulls: tuple[Expr, ...] = ()

    @property
    def origin(self) -> sp.Matrix:
        """Acceleration of O."""
        return self.at(ZERO, "aO", "O")

    def at(self, point: sp.Matrix, name: str, title: str) -> sp.Matrix:
        """Return the acceleration of a point of the hub; names of its steps begin with `name`."""
        arm = self.frame.vector(f"{name}_arm_", point - self.centre, f"{title}: place from the centre", "m")
        result = self.linear + transport(self.frame, self.angular, "turn_", arm)
        return self.frame.vector(name, result, f"acceleration of {title}", "m/s^2")


def transport(frame: Frame, angular: sp.Matrix, name: str, arm: sp.Matrix) -> sp.Matrix:
    """Return W' x r + W x (W x r): the relative acceleration of two points of the hub.

    The result is a matrix times r. Its columns are named once for all points; `name` is the start of their names.
    """
    products, result = rate_products(frame), ZERO
    turning = cross_matrix(angular) + products - products.trace() * sp.eye(3)
    for k, axis in enumerate(AXES):
        if arm[k] != 0:
            title = f"acceleration of a point per distance along {axis}"
            result += arm[k] * frame.vector(f"{name}{axis}_", turning[:, k], title, "1/s^2")
    return result


def rate_products(frame: Frame) -> sp.Matrix:
    """Return the matrix W W' with a name for each product."""
    w = frame.rate
    entry = {
        (i, j): frame.define(f"w{AXES[i]}w{AXES[j]}", w[i] * w[j], "product of rates", "rad^2/s^2")
        for i in range(3)
        for j in range(i, 3)
    }
    return sp.Matrix(3, 3, lambda i, j: entry[min(i, j), max(i, j)])


def gyroscopic(frame: Frame, inertia: sp.Matrix, angular: sp.Matrix) -> sp.Matrix:
    """Return W x (J W + h), with shared products of rates if J depends only on parameters."""
    w = frame.rate
    if any(e != 0 and not frame.is_constant(e) for e in inertia) or not angular.is_zero_matrix:
        spin = frame.vector("total_H", inertia * w + angular, "angular momentum", "kg m^2/s")
        return w.cross(spin)
    products = rate_products(frame)
    result = []
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        parts = [
            frame.define(f"gyro_J{AXES[i]}", inertia[k, k] - inertia[j, j], "difference of inertias", "kg m^2")
            * products[j, k],
            inertia[k, i] * products[i, j] - inertia[j, i] * products[i, k],
            inertia[j, k] * (products[j, j] - products[k, k]),
        ]
        result.append(sp.Add(*parts))
    return sp.Matrix(result)
