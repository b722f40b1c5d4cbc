# SPDX-License-Identifier: Apache-2.0
"""An expression without a value in a whole region is not the same as one that has a value there."""

import pytest
import sympy as sp

from mehvar.codegen.equal.equality import EqualityTest
from mehvar.codegen.equal.meaning import Meaning
from mehvar.codegen.equal.pool import Pool
from mehvar.codegen.equal.sampler import PointSampler
from mehvar.codegen.ledger.sides import Sides

U, D = "Max(0, x - 1)", "(Max(0, x - 1) + Min(0, x + 1))"
NAMES = {name: sp.Symbol(name, real=True) for name in ("x", "a")}


def are_equal(*sides: str) -> bool | None:
    pool = Pool()
    meaning = Meaning(pool, lambda _: None)
    old, new = ((meaning, Sides(pool).entries(sp.sympify(side, locals=NAMES))[0]) for side in sides)
    return EqualityTest(pool, lambda _: False, PointSampler({}, frozenset())).decide(old, new).equal


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("x + 1", f"(x*{U} + {U}) / {U}"),
        ("Max(0, x + 1)", f"Max(0, (x*{U} + {U}) / {U})"),
        ("Piecewise((5, x + 1 > 0), (7, True))", f"Piecewise((5, (x*{U} + {U}) / {U} > 0), (7, True))"),
        (f"sign({D})", f"{D} / Abs({D})"),
        (f"3*pi/4*sign({D})", f"atan2({D}, -Abs({D}))"),
        ("x", f"x + log({U}) - log({U})*1 + 0*x + log(2*{U}) - log({U}) - log(2)"),
        ("x + 1", "(x*floor(x) + floor(x)) / floor(x)"),
        ("x + 1", "(x*(Max(0, x) + ceiling(x)) + Max(0, x) + ceiling(x)) / (Max(0, x) + ceiling(x))"),
    ],
)
def test_a_denominator_that_is_zero_in_a_region_takes_the_value_away(old, new):
    assert are_equal(old, new) is False


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("x / Max(1, Abs(x))", "(2*x) / (2*Max(1, Abs(x)))"),
        ("x / Max(a, Abs(x) + 1)", "(a*x) / (a*Max(a, Abs(x) + 1))"),
        (f"x / {U}", f"2*x / (2*{U})"),
        ("x / Abs(x)", "2*x / Abs(2*x)"),
        ("x / floor(x)", "2*x / (2*floor(x))"),
    ],
)
def test_a_denominator_of_both_sides_is_the_same(old, new):
    assert are_equal(old, new)
