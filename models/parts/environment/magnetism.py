# SPDX-License-Identifier: Apache-2.0
"""Magnetic field of the Earth from Gauss coefficients, such as those of the IGRF."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

import sympy as sp

from mehvar.base.errors import value_text

from ...derivation import Expr
from ...quantities import ModelError
from ..values import Parameters, Value

Harmonics = Sequence[tuple[int, int, float, float]]
Coefficients = Mapping[tuple[int, int], tuple[Expr, Expr]]
Define = Callable[[str, Expr, str], Expr]
MOST = 13
"""Highest degree of the IGRF."""


def check(harmonics: Harmonics) -> None:
    """Refuse rows that do not consist of a degree, an order and two coefficients."""
    for row in harmonics:
        if len(row) != 4 or not all(isinstance(n, int) for n in row[:2]) or not 0 <= row[1] <= row[0] <= MOST:
            raise ModelError(
                f"orbit: harmonics = {value_text(row)}: must be rows n, m, g, h with 0 <= m <= n <= {MOST}, g, h in nT"
            )
    if idle := next((row for row in harmonics if row[1] == 0 and row[3] != 0), None):
        raise ModelError(f"orbit: harmonics = {value_text(idle)}: h of the order m = 0 has no effect; must be 0")
    if not harmonics or len({row[:2] for row in harmonics}) < len(harmonics) or any(row[0] < 1 for row in harmonics):
        raise ModelError("orbit: harmonics: must be one row or more, each of another degree n >= 1 and order m")


def coefficients(harmonics: Harmonics, parameters: Parameters, name: str) -> Coefficients:
    """Declare a parameter for each Gauss coefficient, Wb/m^2, and return their symbols by degree and order."""

    def declared(letter: str, n: int, m: int, value: float) -> Expr:
        if value == 0:
            return sp.S.Zero
        given = Value(value * 1e-9, source="addition: Gauss coefficients")
        meaning = f"Gauss coefficient {letter}, degree {n}, order {m}"
        return parameters.add(f"{name}_{letter}{n}_{m}", given, "Wb/m^2", meaning, "(-inf, inf)")

    return {(n, m): (declared("g", n, m, g), declared("h", n, m, h)) for n, m, g, h in harmonics}


def field(given: Coefficients, place: sp.Matrix, radius: Expr, define: Define) -> sp.Matrix:
    """Return the field at a place, both in axes that turn with the Earth, for a reference radius R.

    It is minus the gradient of R sum (R/r)^(n + 1) P_nm(sin latitude) (g cos m longitude + h sin m longitude), with the
    functions P_nm in Schmidt's normalisation. The functions and their gradients follow by recursion. (Montenbruck and
    Gill, Satellite Orbits, 2000, 3.2.4 and 3.2.5.)
    """
    last = max(n for n, _ in given) + 1
    functions = _functions(place, radius, last, define)
    result = sp.zeros(3, 1)
    for (n, m), pair in given.items():
        size = math.factorial(n - m) * (1 if m == 0 else 2)
        norm = sp.sqrt(sp.Rational(size, math.factorial(n + m)))
        g, h = (norm * entry for entry in pair)
        above, along = functions[n + 1, m + 1], functions[n + 1, m]
        rise = sp.Matrix([g * above[0] + h * above[1], g * above[1] - h * above[0]])
        if m == 0:
            across = rise
        else:
            below = functions[n + 1, m - 1]
            fall = sp.Matrix([g * below[0] + h * below[1], h * below[0] - g * below[1]])
            across = (rise - (n - m + 2) * (n - m + 1) * fall) / 2
        result += sp.Matrix([*across, (n - m + 1) * (g * along[0] + h * along[1])])
    return result


def _functions(place: sp.Matrix, radius: Expr, last: int, define: Define) -> dict[tuple[int, int], tuple[Expr, Expr]]:
    """Return (R/r)^(n + 1) P_nm times cosine and sine of m longitude, for n, m to `last`, by names."""
    square = define("r2", radius / place.dot(place), "reference radius over the squared distance")
    x, y, z = (define(f"s{axis}", square * entry, "scaled place") for axis, entry in zip("xyz", place, strict=True))
    rho = define("s", square * radius, "squared ratio of radii")
    result: dict[tuple[int, int], tuple[Expr, Expr]] = {(0, 0): (sp.sqrt(rho), sp.S.Zero)}

    def named(n: int, m: int, pair: Sequence[Expr]) -> None:
        titles = zip(("V", "W"), pair, strict=True)
        cosine, sine = (define(f"{letter}{n}_{m}", entry, f"harmonic {n}, {m}") for letter, entry in titles)
        result[n, m] = cosine, sine

    for m in range(last + 1):
        if m:
            v, w = result[m - 1, m - 1]
            named(m, m, [(2 * m - 1) * (x * v - y * w), (2 * m - 1) * (x * w + y * v)])
        for n in range(m + 1, last + 1):
            one, two = result[n - 1, m], result.get((n - 2, m), (sp.S.Zero, sp.S.Zero))
            named(n, m, [
                ((2 * n - 1) * z * a - (n + m - 1) * rho * b) / (n - m) for a, b in zip(one, two, strict=True)
            ])  # fmt: skip
    return result
