# SPDX-License-Identifier: Apache-2.0
"""What the systems share: rotations, products and time derivatives."""

from __future__ import annotations

from collections.abc import Mapping

import sympy as sp

QUARTER_TURN = sp.Matrix([[0, -1], [1, 0]])
"""Rotation of the plane by +90 degrees, the paper's J."""


def time_derivative(expr: sp.Expr, rates: Mapping[sp.Symbol, sp.Expr]) -> sp.Expr:
    """Differentiate along a motion: the chain rule over the symbols that have a rate."""
    return sp.Add(*(sp.diff(expr, symbol) * rate for symbol, rate in rates.items()))


def matrix_rate(matrix: sp.Matrix, rates: Mapping[sp.Symbol, sp.Expr]) -> sp.Matrix:
    """Differentiate a matrix along a motion, entry by entry."""
    return matrix.applyfunc(lambda entry: time_derivative(entry, rates))


def planar_cross(a: sp.Matrix, b: sp.Matrix) -> sp.Expr:
    """Out-of-plane component of a x b for vectors in the plane."""
    return a[0] * b[1] - a[1] * b[0]


def rotate(vector: tuple[sp.Expr, sp.Expr], cosine: sp.Expr, sine: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
    """Rotate a vector of the plane by the angle with this cosine and sine."""
    x, y = vector
    return x * cosine - y * sine, x * sine + y * cosine
