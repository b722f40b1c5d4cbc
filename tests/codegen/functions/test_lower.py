# SPDX-License-Identifier: Apache-2.0
"""SymPy to CasADi: every supported operation, against SymPy's own evaluation."""

import casadi as ca
import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from mehvar.codegen.functions.lower import LoweringError, to_casadi

X, Y = sp.symbols("x y", real=True)
POSITIVE = [
    sp.sqrt(X), X ** sp.Rational(3, 2), X**-3, X**5, X ** sp.Rational(1, 3), X**Y, sp.log(X), sp.exp(-Y), sp.tanh(X),
    sp.sin(X) * sp.cos(Y), sp.tan(X / 5), sp.asin(X / 10), sp.acos(X / 10), sp.atan(X), sp.atan2(Y, X), sp.Abs(Y - X),
    sp.sign(Y - X), sp.Min(X, Y, 1), sp.Max(X, Y, 1), sp.floor(X), sp.ceiling(X), sp.sinh(X), sp.cosh(X), sp.asinh(X),
    sp.Piecewise((X, X < Y), (Y**2, sp.And(Y > 1, X > 2)), (sp.pi, True)),
    sp.Piecewise((1, sp.Or(X < 1, ~(Y < 2))), (0, True)),
    X / Y - sp.Rational(1, 3), sp.erf(X),
    sp.Piecewise((1, sp.ITE(X < 1, Y > 2, Y > 3)), (0, True)), sp.Piecewise((1, sp.Xor(X < 1, Y < 2)), (0, True)),
]  # fmt: skip


def evaluate(expr: sp.Expr, x: float, y: float) -> float:
    sx, sy = ca.SX.sym("x"), ca.SX.sym("y")
    (graph,) = to_casadi([expr], {X: sx, Y: sy})
    return float(ca.Function("f", [sx, sy], [graph])(x, y))


@pytest.mark.parametrize("divisor", [2.0, -2.0, 1000.0, 0.3, -0.3])
@pytest.mark.parametrize("dividend", [-5.5, -4.0, -0.1, -1e-30, 0.0, 0.1, 3.9, 4.0, 7.25])
def test_mod_has_the_sign_of_the_divisor(dividend, divisor):
    """As SymPy's has, by which equations are compared; the fmod of C has that of the dividend."""
    assert evaluate(sp.Mod(X, Y), dividend, divisor) == dividend % divisor


@pytest.mark.parametrize("expr", POSITIVE, ids=str)
def test_agrees_with_sympy(expr):
    for x, y in [(0.3, 0.7), (2.1, 1.4), (1.5, 3.25), (2.6, 0.2)]:
        expected = float(expr.subs({X: sp.Rational(str(x)), Y: sp.Rational(str(y))}).evalf(30))
        assert evaluate(expr, x, y) == pytest.approx(expected, rel=1e-14, abs=1e-14)


def test_numbers_are_rounded_once():
    assert evaluate(sp.Rational(1, 3) + 0 * X, 0, 0) == 1 / 3
    assert evaluate(sp.sqrt(3) / 3, 0, 0) == float(sp.N(sp.sqrt(3) / 3, 30))
    assert evaluate(sp.Float("0.1"), 0, 0) == 0.1


@given(st.recursive(
    st.one_of(st.sampled_from([X, Y]), st.integers(-9, 9).map(sp.Integer), st.fractions(-3, 3, max_denominator=12).map(
        lambda f: sp.Rational(f.numerator, f.denominator))),
    lambda inner: st.one_of(
        st.tuples(inner, inner).map(lambda p: p[0] + p[1]), st.tuples(inner, inner).map(lambda p: p[0] * p[1]),
        inner.map(sp.sin), inner.map(sp.Abs), inner.map(lambda e: sp.sqrt(1 + e**2)), st.tuples(inner, inner).map(
            lambda p: sp.Max(p[0], p[1])),
    ), max_leaves=12))  # fmt: skip
@settings(max_examples=60, deadline=None)
def test_random_expressions_agree_with_sympy(expr):
    expected = float(sp.N(expr.subs({X: sp.Rational(7, 10), Y: sp.Rational(-13, 10)}), 30))
    assert evaluate(expr, 0.7, -1.3) == pytest.approx(expected, rel=1e-11, abs=1e-11)


def test_definitions_are_followed_in_any_order():
    a, b = sp.symbols("a b")
    sx = ca.SX.sym("x")
    (graph,) = to_casadi([b], {X: sx}, {b: a**2, a: X + 1})
    assert float(ca.Function("f", [sx], [graph])(2.0)) == 9.0


def test_common_parts_are_shared():
    sx = ca.SX.sym("x")
    first, second = to_casadi([sp.sin(X) + 1, sp.sin(X) + 2], {X: sx})
    assert ca.Function("f", [sx], [first, second]).n_instructions() == 8


def test_deep_expressions_do_not_recurse():
    expr = X
    for _ in range(3000):
        expr = sp.sin(expr, evaluate=False)
    sx = ca.SX.sym("x")
    assert to_casadi([expr], {X: sx})[0].n_dep() == 1


@pytest.mark.parametrize(
    ("expr", "message"),
    [
        (sp.Symbol("z"), "'z' has neither"),
        (sp.gamma(X), "'gamma' has no CasADi counterpart"),
        (sp.Piecewise((X, X > 0)), "without a last branch"),
    ],
)
def test_what_cannot_be_converted_is_named(expr, message):
    with pytest.raises(LoweringError, match=message):
        to_casadi([expr], {X: ca.SX.sym("x")})


def test_circular_definitions_are_refused():
    a, b = sp.symbols("a b")
    with pytest.raises(LoweringError, match="defined by itself"):
        to_casadi([a], {}, {a: b + 1, b: a + 1})


def test_a_definition_that_divides_by_zero_whatever_the_values_is_refused() -> None:
    x, whole, over = sp.symbols("x whole over")
    definitions = {whole: x - x * (1 / x) * x, over: 1 / whole}
    with sp.evaluate(False):
        definitions[whole] = sp.Add(x, sp.Mul(-1, x))
    with pytest.raises(LoweringError, match="definition over is always inf, since it divides by zero"):
        to_casadi([over], {x: ca.SX.sym("x")}, definitions)


def test_matches_numpy_for_atan2_quadrants():
    for x, y in [(-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0), (0.0, -2.0)]:
        assert evaluate(sp.atan2(Y, X), x, y) == np.arctan2(y, x)
