# SPDX-License-Identifier: Apache-2.0
"""The two Lyapunov laws, equations (27)-(36).

Each law follows from its function V. Along the reduced model (20)-(26) dV/dt is linear in the inputs: V' = A + B u1 +
C u2 + (f u345 + g).Omega (29). The inputs (31)-(36) make their terms negative. The printed u1 = w1 B, u2 = w2 C have
the wrong sign for positive gains; the derivation gives u1 = -w1 B, u2 = -w2 C.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import sympy as sp

from ...derivation import vector
from ...mechanics import expanded, gradient, time_derivative
from ...parts.assembly import solve
from ...parts.frame import Frame
from ...system import Derivation, Expr, Group, ModelError
from ..plant.reduced import demand, reduced_velocity
from ..states import rate, velocity


@dataclass(frozen=True)
class Form:
    """Derivative of a Lyapunov function: V' = A + B u1 + C u2 + (f u345 + g).Omega (29).

    Attributes
    ----------
    A, B, C : Expr
        Coefficients.
    f : sympy.Matrix
        Symmetric 3 x 3.
    g : sympy.Matrix
        Three entries.
    """

    A: Expr
    B: Expr
    C: Expr
    f: sp.Matrix
    g: sp.Matrix


@dataclass(frozen=True)
class Law:
    """A Lyapunov function and the inputs of its law.

    Attributes
    ----------
    value : Expr
        V.
    demand : tuple of Expr
        u1..u5.
    """

    value: Expr
    demand: tuple[Expr, ...]


def derivative_form(value: Expr, rates: Mapping[sp.Symbol, Expr]) -> Form:
    """Differentiate V along the reduced model and collect terms as in (29)."""
    return collect(time_derivative(value, rates))


def collect(derivative: Expr) -> Form:
    """Collect the inputs and body rates of V' (29).

    Raises
    ------
    ModelError
        If V' is not of the form (29): Omega' must appear multiplied by Omega only.
    """
    derivative = expanded(derivative)
    at_rest = dict.fromkeys(rate, sp.S.Zero)
    first, second, *turning = gradient(derivative, demand)
    if any(sp.expand(term.xreplace(at_rest)) is not sp.S.Zero for term in turning):
        raise ModelError("V' contains Omega' without the factor Omega: it is not of the form (29)")
    free = derivative.xreplace(dict.fromkeys(demand, sp.S.Zero))
    return Form(
        free.xreplace(at_rest),
        first,
        second,
        sp.Matrix([gradient(term, rate) for term in turning]).T,
        sp.Matrix([slope.xreplace(at_rest) for slope in gradient(free, rate)]),
    )


def mapped(form: Form, change: Callable[[Expr], Expr]) -> Form:
    """Apply a function to every coefficient."""
    return Form(change(form.A), change(form.B), change(form.C), form.f.applyfunc(change), form.g.applyfunc(change))


def placed(form: Form, values: Mapping[sp.Symbol, Expr]) -> Form:
    """Replace symbols in every coefficient."""
    return mapped(form, lambda expr: expr.xreplace(dict(values)))


def hull_value(c: Group, attitude: Sequence[Expr]) -> Expr:
    """Return V2 (28) as a function of velocities, attitude angles and body rates."""
    _, vy, vz = velocity
    a1, a2, a3 = attitude
    squares = (
        c.r1 * vy**2,
        c.r2 * vz**2,
        c.r3 * a1**2,
        c.r4 * rate[0] ** 2,
        c.r5 * a2**2,
        c.r6 * rate[1] ** 2,
        c.r7 * a3**2,
        c.r8 * rate[2] ** 2,
    )
    return sp.Add(*squares) / 2


def hull_rates(axial: Expr, attitude: Sequence[sp.Symbol]) -> dict[sp.Symbol, Expr]:
    """Return the hull's reduced model (20)-(24), with a_j' = Omega_j."""
    linear = reduced_velocity(axial, demand)
    symbols = (*velocity, *rate, *attitude)
    return dict(zip(symbols, (*linear, *demand[2:], *rate), strict=True))


def lyapunov_v2(c: Group, axial: Expr, attitude: Sequence[sp.Symbol], angles: Sequence[Expr], d: Derivation) -> Law:
    """Derive the law (34)-(36) of V2 (28), which involves only the hull."""
    value = hull_value(c, attitude)
    named = _renamed(attitude, angles)
    form = placed(derivative_form(value, hull_rates(axial, attitude)), named)
    return _law("v2", ("(28)", "(34)", "(35)", "(36)"), value.xreplace(named), form, c, d)


def lyapunov_v1(
    c: Group,
    axial: Expr,
    attitude: Sequence[sp.Symbol],
    angles: Sequence[Expr],
    terms: Sequence[tuple[Expr, Form]],
    d: Derivation,
) -> Law:
    """Derive the law (31)-(33) of V1 (27), which also weights the pendulums' rates.

    Parameters
    ----------
    c : Group
        Parameters of the law.
    axial : Expr
        a_x (19).
    attitude, angles : sequence
        Symbols of the attitude angles, and their expressions.
    terms : sequence of (Expr, Form)
        The pendulums' terms of V1 and their part of (29).
    d : Derivation
        Receives the steps.
    """
    value, named = hull_value(c, attitude), _renamed(attitude, angles)
    values = [value.xreplace(named), *(term for term, _ in terms)]
    forms = [placed(derivative_form(value, hull_rates(axial, attitude)), named), *(form for _, form in terms)]
    total = Form(
        sp.Add(*(form.A for form in forms)),
        sp.Add(*(form.B for form in forms)),
        sp.Add(*(form.C for form in forms)),
        sp.Matrix(3, 3, lambda i, j: sp.Add(*(form.f[i, j] for form in forms))),
        sp.Matrix(3, 1, lambda i, _: sp.Add(*(form.g[i] for form in forms))),
    )
    return _law("v1", ("(27)", "(31)", "(32)", "(33)"), sp.Add(*values), total, c, d)


def _renamed(attitude: Sequence[sp.Symbol], angles: Sequence[Expr]) -> dict[sp.Symbol, Expr]:
    """Return the attitude angles if another chart is the state."""
    return {s: a for s, a in zip(attitude, angles, strict=True) if s is not a}


def _law(tag: str, numbers: Sequence[str], value: Expr, form: Form, c: Group, d: Derivation) -> Law:
    """Choose u1..u5 for V' = A - w1 B^2 - w2 C^2 - w3 W1^2 - w4 W2^2 - w5 W3^2 (30)."""
    value = d.define(f"V_{tag}", value, numbers[0], "Lyapunov function", latex=f"V_{tag[1]}")
    d.define(f"A_{tag}", form.A, "(29)", "derivative of V without inputs and body rates", "1/s", "A")
    b = d.define(f"B_{tag}", form.B, "(29)", "coefficient of u1", "s/m", "B")
    cc = d.define(f"C_{tag}", form.C, "(29)", "coefficient of u2", "s/m", "C")
    g = vector(f"g*_{tag}", form.g, "coefficient of Omega_*", "1/rad", "g_*", d, "(29)", "123")
    f = sp.Matrix(3, 3, lambda i, j: form.f[i, j] if j <= i else sp.S.Zero)
    for i in range(3):
        for j in range(i + 1):
            if f[i, j].is_number is not True:
                place, title = f"{i + 1}{j + 1}", "coefficient of Omega_i u_j"
                f[i, j] = d.define(f"f{place}_{tag}", f[i, j], "(29)", title, "s^2/rad^2", f"f_{{{place}}}")
    gains = (c.w3, c.w4, c.w5)
    right = [-(g[k] + gains[k] * rate[k]) for k in range(3)]
    turns = solve(Frame(d, sp.Matrix(rate)), f, right, [f"u_{tag}_x{k + 3}" for k in range(3)])
    u1 = d.define(f"u1_{tag}", -c.w1 * b, numbers[1], "demanded a_y", "m/s^2", "u_1")
    u2 = d.define(f"u2_{tag}", -c.w2 * cc, numbers[2], "demanded a_z", "m/s^2", "u_2")
    u345 = [
        d.define(f"u{k + 3}_{tag}", turn, numbers[3], f"demanded Omega'_{k + 1}", "rad/s^2", f"u_{k + 3}")
        for k, turn in enumerate(turns)
    ]
    return Law(value, (u1, u2, *u345))
