# SPDX-License-Identifier: Apache-2.0
"""Derivatives against those of SymPy, and centres of narrow features."""

from fractions import Fraction

import pytest
import sympy as sp

from mehvar.codegen.equal.cells.centres import centres
from mehvar.codegen.equal.cells.slopes import slope
from mehvar.codegen.equal.pool import Pool
from mehvar.codegen.equal.reals import RealWorld
from mehvar.codegen.ledger.sides import Sides

x, y = sp.symbols("x y", real=True)
FUNCTIONS = (sp.sin, sp.cos, sp.tan, sp.exp, sp.log, sp.asin, sp.acos, sp.atan, sp.sinh, sp.cosh, sp.tanh, sp.asinh,
             sp.atanh)  # fmt: skip
CASES = [
    *(f(x * y / 3) for f in FUNCTIONS), sp.acosh(2 + x * y), sp.atan2(y * x, 1 + x**2), x**3 * y + 5 * x - y,
    sp.sqrt(x + y) / x, sp.Integer(4) + y,
]  # fmt: skip


@pytest.mark.parametrize("whole", CASES, ids=str)
def test_a_slope_is_the_derivative(whole):
    pool = Pool()
    root, right = Sides(pool).entries(sp.Matrix([whole, sp.diff(whole, x)]))
    world = RealWorld(pool, lambda _: None, {"x": Fraction(3, 7), "y": Fraction(5, 4)})
    assert abs(world.value(slope(pool, root, pool.intern("sym", "x"))) - world.value(right)) < 1e-45


@pytest.mark.parametrize("whole", [sp.Abs(x), sp.Max(x, y), sp.Piecewise((x, y > 0), (2, True)), y**x], ids=str)
def test_a_branch_has_no_slope_unless_it_is_constant(whole):
    pool = Pool()
    (root,) = Sides(pool).entries(whole)
    assert slope(pool, root, pool.intern("sym", "x")) is None
    assert slope(pool, root, pool.intern("sym", "z")) == pool.number(0)


def test_the_centre_of_a_bump_is_a_zero_of_its_operand():
    pool = Pool()
    roots = tuple(Sides(pool).entries(sp.Matrix([sp.exp(-((x - 2) ** 2)), x * y])))
    difference = pool.many("add", [pool.intern("sym", "x"), pool.number(-2)])
    assert difference in centres(pool, roots, ())
    assert difference not in centres(pool, roots, (difference,))
