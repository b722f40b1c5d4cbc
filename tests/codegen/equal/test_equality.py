# SPDX-License-Identifier: Apache-2.0
"""Proofs of the test of equality about one expression."""

from fractions import Fraction

import pytest
import sympy as sp

from mehvar.codegen.equal import field
from mehvar.codegen.equal.equality import EqualityTest
from mehvar.codegen.equal.meaning import Meaning
from mehvar.codegen.equal.pool import Pool
from mehvar.codegen.equal.sampler import PointSampler
from mehvar.codegen.ledger.sides import Sides

x, y = sp.symbols("x y", real=True)
m = sp.Symbol("m", positive=True)
WHOLE = (None, None, None)
NEVER = [sp.exp(x), x**2 + 1, m, m * sp.exp(x), (x**2 + 1) * m**3 / (2 + sp.cos(y)), (y**2 + m) * sp.exp(-x) / 7]
SOMETIMES = [x, x * sp.exp(y), sp.exp(x) - 1, (x**2 + 1) * y, m - 1, m * sp.sin(x), (x - y) ** 3 * m]


def judged(whole):
    """Return a test of equality and an expression."""
    pool = Pool()
    (node,) = Sides(pool).entries(whole)
    sampler = PointSampler({"x": WHOLE, "y": WHOLE, "m": (Fraction(0), None, None)}, frozenset())
    return EqualityTest(pool, lambda name: name == "m", sampler), (Meaning(pool, lambda _: None), node)


@pytest.mark.parametrize(("whole", "never"), [*((w, True) for w in NEVER), *((w, False) for w in SOMETIMES)], ids=str)
def test_what_is_proved_never_zero_is_never_zero(whole, never):
    equality, expression = judged(whole)
    assert equality.is_never_zero(expression) is never


@pytest.mark.parametrize(
    ("whole", "points"),
    [(x + y, 3), (sp.sqrt(m), 3), (sp.cbrt(x**2 + y), 3), (sp.sqrt(x**2 + y), 32), (1 + sp.acos(sp.cos(x)), 32)],
)
def test_a_root_whose_sign_is_drawn_takes_more_points(whole, points):
    """All of 3 points have one sign once in 8 times, all of 32 once in 2^32."""
    equality, expression = judged(whole)
    assert equality.field.how(expression) == f"{points} points of a {field.BITS}-bit field, seed {equality.field.seed}"
    assert equality.field.is_rooted(expression) is (points == 32)


def test_the_root_of_a_square_that_is_written_out_exists_everywhere():
    """The other side has no root: that both exist together is proved, not tried at points."""
    root = sp.sqrt(x**2 + 4 * x * y + 4 * y**2)
    pool = Pool()
    sides = Sides(pool).entries(sp.Matrix([x * (root + 1) - x * root, x]))
    equality = EqualityTest(pool, lambda name: name == "m", PointSampler({"x": WHOLE, "y": WHOLE}, frozenset()))
    free = Meaning(pool, lambda _: None)
    verdict = equality.decide((free, sides[0]), (free, sides[1]))
    assert verdict.equal
    assert verdict.how == equality.field.how((free, sides[0]), (free, sides[1]))
