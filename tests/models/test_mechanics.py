# SPDX-License-Identifier: Apache-2.0
"""Expansion and differentiation, compared with SymPy's."""

import pytest
import sympy as sp

from mehvar.models.mechanics import expanded, gradient

x, y, z = sp.symbols("x y z", real=True)
EXPRESSIONS = (
    sp.Integer(3),
    x,
    (x + 2 * y) ** 3 * (z - x / 3) - x**2 * (y - z),
    (sp.sin(x) * y + sp.cos(x)) ** 2 * (sp.cos(x) - z) * sp.atan2(y, x),
    sp.sin(x * (y + z)) * (x + y),
    sp.sqrt(x + y) * (x + sp.sqrt(x + y)),
    (x + y) ** sp.Rational(3, 2) * (z + 1),
    (x + 1) * (y + 2) / (x - z) ** 2,
    0.5 * (x + y) * (x - y),
    sp.exp(x) * (sp.exp(y) + x) ** 2,
    sp.Max(x, y) * (x + z),
    (x + y) ** z * (x + 1),
)  # fmt: skip


@pytest.mark.parametrize("expr", EXPRESSIONS, ids=str)
def test_expansion_is_that_of_sympy(expr):
    assert sp.srepr(expanded(expr)) == sp.srepr(sp.expand(expr))


@pytest.mark.parametrize("expr", EXPRESSIONS, ids=str)
def test_slopes_equal_those_of_sympy(expr):
    for slope, symbol in zip(gradient(expr, (x, y, z)), (x, y, z), strict=True):
        assert sp.simplify(slope - expr.diff(symbol)) == 0
