# SPDX-License-Identifier: Apache-2.0
"""Polynomial equations of the laws, A S + q^-d B T = Ac, for delays d = 1 and d = 2.

A = 1 + a1 q^-1 + a2 q^-2, B = b0 + b1 q^-1. Solutions are expressions in the symbols of this module, which a law
replaces by its own.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import sympy as sp

from ..system import Expr

a1, a2, b0, b1 = sp.symbols("a1 a2 b0 b1", real=True)
q = sp.Symbol("q_inv")
"""Delay of one sample, q^-1."""
_A = 1 + a1 * q + a2 * q**2
_B = b0 + b1 * q


@dataclass(frozen=True)
class Solution:
    """Solution S and T of a polynomial equation, lowest power first; S is monic."""

    S: tuple[Expr, ...]
    T: tuple[Expr, ...]


@dataclass(frozen=True)
class Retained:
    """Equation of the law that keeps B; the degrees are d for S, 1 for T and d + 2 for Ac.

    The leading coefficients s_1 ... s_(d-1) follow one by one. The last three unknowns (s_d, t0, t1) solve a linear
    system whose matrix does not depend on d.

    Attributes
    ----------
    first : tuple of Expr
        The leading coefficients.
    matrix : sympy.Matrix
        Matrix of the linear system.
    right : tuple of Expr
        Its right-hand side, with `s1` for the first coefficient when d = 2.
    """

    first: tuple[Expr, ...]
    matrix: sp.Matrix
    right: tuple[Expr, Expr, Expr]


s1 = sp.Symbol("s1", real=True)
RIGHT = sp.symbols("e1 e2 e3", real=True)
"""Right-hand side of the equations for (s_d, t0, t1)."""


def closed_loop(pole: Expr, degree: int) -> list[Expr]:
    """Return the coefficients of (1 - pole q^-1)^degree, lowest power first."""
    return _coefficients((1 - pole * q) ** degree, degree)


def cancelling(poles: tuple[Expr, ...], d: int) -> Solution:
    """Solve C2 = A S + q^-d T (22) with deg S = d - 1 (25) and deg T = max(nA - 1, nC2 - d) (26)."""
    degree_t = max(2 - 1, len(poles) - d)
    s = sp.symbols(f"s_1:{d}") if d > 1 else ()
    t = sp.symbols(f"t_0:{degree_t + 1}")
    S = _polynomial((sp.S.One, *s))
    C2 = sp.Mul(*(1 - pole * q for pole in poles))
    balance = _coefficients(_A * S + q**d * _polynomial(t) - C2, max(d + 1, d + degree_t))
    solution = sp.solve(balance[1:], [*s, *t], dict=True)[0]
    return Solution((sp.S.One, *(solution[x] for x in s)), tuple(solution[x] for x in t))


def retaining(pole: Expr, d: int) -> Retained:
    """Write A S + q^-d B T = Ac as linear equations, for d = 1 or 2."""
    s = (s1,)[: d - 1]
    last, t0, t1 = sp.symbols("s_d t_0 t_1", real=True)
    S = _polynomial((sp.S.One, *s, last))
    balance = _coefficients(_A * S + q**d * _B * (t0 + t1 * q) - (1 - pole * q) ** (d + 2), d + 2)[1:]
    unknown = (last, t0, t1)
    first = tuple(sp.solve(e, x)[0] for e, x in zip(balance, s, strict=False))
    system = sp.Matrix(balance[d - 1 :])
    return Retained(
        first, system.jacobian(unknown), tuple(-system.subs(dict.fromkeys(unknown, 0)).applyfunc(sp.expand))
    )


def resultant(matrix: sp.Matrix) -> Expr:
    """Return the determinant of the equations for (s_d, t0, t1); it is zero if A and B share a root."""
    return sp.expand(matrix.det())


def numerators(matrix: sp.Matrix) -> tuple[Expr, Expr, Expr]:
    """Return (s_d, t0, t1) times the determinant, by Cramer's rule."""
    return tuple(sp.expand(entry) for entry in matrix.adjugate() * sp.Matrix(RIGHT))


def put(expr: Expr, values: Mapping[sp.Symbol, Expr]) -> Expr:
    """Replace the symbols of this module by those of a law."""
    return sp.sympify(expr).subs(values, simultaneous=True)


def _polynomial(coefficients: tuple[Expr, ...]) -> Expr:
    return sp.Add(*(c * q**k for k, c in enumerate(coefficients)))


def _coefficients(expr: Expr, degree: int) -> list[Expr]:
    expanded = sp.expand(expr)
    return [expanded.coeff(q, k) for k in range(degree + 1)]
