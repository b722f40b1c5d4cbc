# SPDX-License-Identifier: Apache-2.0
"""Script that finds the coefficients of `rock4` and writes rock4.inc.

    python -m tests.runtime.run.rock4

The construction is Abdulle's, SIAM J. Sci. Comput. 23 (2002) 2041, with a fixed number of stages. A stability
polynomial of order four stays below DAMPING on a long interval of the negative real axis. It is the product of an
orthogonal polynomial, whose recurrence gives the first stages, and a quartic for the last four. The last digits
depend on the libraries; test_rock4.py checks the committed coefficients.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray
from scipy.optimize import brentq, root

from mehvar.runtime.compiling.library import NATIVE

Array = NDArray[np.float64]

STAGES = 16
LAST = 4
DAMPING = 0.95
"""Largest value of the stability polynomial, with a stable length of 87.1; 0.9 gives 86.5 and 0.99 gives 87.7."""
FILE = NATIVE / "methods" / "rock4.inc"

QUARTIC = (-2.4505, 1.2982, -0.2841, 3.5036, 88.0)
"""Initial guess: real and imaginary parts of two zeros in z = h lambda, and the stable length."""
TAIL = (-0.12, 1.16, -0.76, -0.1, 0.2, 0.46, 0.44, -0.2, 0.2, 0.25)
"""Initial guess: a21, a31, a32, a41, a42, a43 and b of the last stages."""
END_POINTS = (0.72, 0.87)
"""Times of the last two stages, in steps."""
LINEAR_ERROR = 1 / 100
"""Difference in the coefficient of z^4 of the embedded method, which only scales the error estimate."""


@dataclass(frozen=True)
class Head:
    """Polynomials p_k in x = 1 + 2 z / length, with p_{k+1} = (x - middle_k) p_k - weight_k p_{k-1}."""

    middle: Array
    weight: Array
    quartic: Polynomial
    length: float

    def orthogonal(self, x: Any) -> list[Any]:
        """Return p_0, p_1, ... at x, a number or polynomial."""
        p = [x * 0 + 1, x - self.middle[0]]
        for middle, weight in zip(self.middle[1:], self.weight[1:], strict=True):
            p.append((x - middle) * p[-1] - weight * p[-2])
        return p

    def stability(self, x: Any) -> Any:
        """Return the stability polynomial, normalised to one at z = 0."""
        return self.quartic(x) * self.orthogonal(x)[-1] / (self.quartic(1.0) * self.orthogonal(1.0)[-1])


def head(unknown: Array) -> Head:
    """Return the polynomials of a quartic: orthogonal with weight quartic^2 / sqrt(1 - x^2)."""
    length = unknown[4]
    zeros = [1 + 2 * complex(unknown[i], unknown[i + 1]) / length for i in (0, 2)]
    quartic = Polynomial.fromroots([z for zero in zeros for z in (zero, zero.conjugate())])
    quartic = Polynomial(quartic.coef.real)
    x = np.cos((np.arange(400) + 0.5) * np.pi / 400)
    square = quartic(x) ** 2
    middle: list[float] = []
    weight: list[float] = []
    before, p = np.zeros_like(x), np.ones_like(x)
    for _ in range(STAGES - LAST):
        size = square @ p**2
        middle.append(square @ (x * p**2) / size)
        weight.append(size / (square @ before**2) if weight else 0.0)
        before, p = p, (x - middle[-1]) * p - weight[-1] * before
    return Head(np.array(middle), np.array(weight), quartic, float(length))


def find_head() -> Head:
    """Return the polynomials of order four with the maximum DAMPING on the stable length."""
    start = np.array(QUARTIC)

    def solution(end: float) -> Head:
        def residual(unknown: Array) -> Array:
            first = head(unknown)
            series = first.stability(1 + Polynomial([0.0, 2.0]) / first.length).coef[1 : LAST + 1]
            return np.array([*(series * [1, 2, 6, 24] - 1), first.stability(-1.0) - end])

        return head(root(residual, start, tol=1e-15).x)

    def beyond(end: float) -> float:
        first = solution(end)
        z = np.linspace(-first.length, -6.0, 4001)
        return float(np.abs(first.stability(1 + 2 * z / first.length)).max() - DAMPING)

    return solution(brentq(beyond, 0.8, 0.95, xtol=1e-13))


def tableau(first: Head, tail: Array) -> tuple[Array, Array]:
    """Return a and b of the method."""
    n, p = STAGES - LAST, first.orthogonal(1.0)
    a, b = np.zeros((STAGES, STAGES)), np.zeros(STAGES)
    for k in range(n):
        before = first.weight[k] * p[k - 1] * a[k - 1] if k else 0.0
        a[k + 1] = ((1 - first.middle[k]) * p[k] * a[k] - before) / p[k + 1]
        a[k + 1, k] += 2 / first.length * p[k] / p[k + 1]
    a[n + 1 :] = b[:] = a[n]
    a[n + 1, n : n + 1], a[n + 2, n : n + 2], a[n + 3, n : n + 3] = tail[:1], tail[1:3], tail[3:6]
    b[n:] = tail[6:]
    return a, b


def order_conditions(a: Array, b: Array) -> Array:
    """Return the residuals of the order conditions up to four."""
    c = a.sum(axis=1)
    sums = [b.sum(), b @ c, b @ c**2, b @ a @ c, b @ c**3, b @ (c * (a @ c)), b @ a @ c**2, b @ a @ a @ c]
    return np.array(sums) - [1, 1 / 2, 1 / 3, 1 / 6, 1 / 4, 1 / 8, 1 / 12, 1 / 24]


def find_tail(first: Head) -> Array:
    """Return the last stages of order four, with end times that nearly minimise the fifth-order error."""

    def residual(tail: Array) -> Array:
        a, b = tableau(first, tail)
        return np.concatenate([order_conditions(a, b), a[-2:].sum(axis=1) - END_POINTS])

    tail: Array = root(residual, TAIL, tol=1e-15).x
    return tail


def find_estimate(a: Array, length: float) -> Array:
    """Return the weights of an error estimate of order three that is small where the method is stable."""
    c = a.sum(axis=1)
    conditions = np.array([np.ones(STAGES), c, c**2, a @ c, a @ a @ c])
    return smallest(a, length, conditions, np.array([0, 0, 0, 0, LINEAR_ERROR]))


def find_dense(a: Array, length: float) -> Array:
    """Return the weights of h s^2 (1 - s)^2 for dense output of order four, small where the method is stable.

    The cubic Hermite interpolant differs from the solution by this polynomial times the fourth-order term.
    """
    c = a.sum(axis=1)
    conditions = np.array([np.ones(STAGES), c, c**2, a @ c, c**3, c * (a @ c), a @ c**2, a @ a @ c])
    return smallest(a, length, conditions, np.array([0, 0, 0, 0, 1 / 4, 1 / 8, 1 / 12, 1 / 24]))


def smallest(a: Array, length: float, conditions: Array, values: Array) -> Array:
    """Return weights of the stages that fulfil the conditions and are small on the stable length."""
    z = -length * (1 - np.cos(np.linspace(0, np.pi, 300))) / 2
    damped = np.array([v * np.linalg.solve(np.eye(STAGES) - v * a, np.ones(STAGES)) for v in z])
    quadratic = damped.T @ damped / len(z) + 1e-3 * np.eye(STAGES)
    size = len(values)
    system = np.block([[quadratic, conditions.T], [conditions, np.zeros((size, size))]])
    return np.linalg.solve(system, np.concatenate([np.zeros(STAGES), values]))[:STAGES]


def find() -> Array:
    """Return the rows of a, the vectors b and c, and the weights of error estimate and dense output."""
    first = find_head()
    a, b = tableau(first, find_tail(first))
    return np.array([*a, b, a.sum(axis=1), find_estimate(a, first.length), find_dense(a, first.length)])


def main() -> None:
    """Write the coefficients."""
    rows = find()
    FILE.write_text("".join(", ".join(repr(float(v)) for v in row) + ",\n" for row in rows), encoding="utf-8")
    print(f"order conditions to {np.abs(order_conditions(rows[:STAGES], rows[STAGES])).max():.0e}")


if __name__ == "__main__":
    main()
