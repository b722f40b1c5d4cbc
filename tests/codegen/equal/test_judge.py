# SPDX-License-Identifier: Apache-2.0
"""Proofs of a judge about one expression."""

from fractions import Fraction

import pytest
import sympy as sp

from mehvar.codegen.equal.judge import Judge, Meaning
from mehvar.codegen.equal.pool import Pool
from mehvar.codegen.equal.reals import PointSampler
from mehvar.codegen.ledger.sides import Sides

x, y = sp.symbols("x y", real=True)
m = sp.Symbol("m", positive=True)
WHOLE = (None, None, None)
NEVER = [sp.exp(x), x**2 + 1, m, m * sp.exp(x), (x**2 + 1) * m**3 / (2 + sp.cos(y)), (y**2 + m) * sp.exp(-x) / 7]
SOMETIMES = [x, x * sp.exp(y), sp.exp(x) - 1, (x**2 + 1) * y, m - 1, m * sp.sin(x), (x - y) ** 3 * m]


@pytest.mark.parametrize(("whole", "never"), [*((w, True) for w in NEVER), *((w, False) for w in SOMETIMES)], ids=str)
def test_what_is_proved_never_zero_is_never_zero(whole, never):
    pool = Pool()
    (node,) = Sides(pool).entries(whole)
    sampler = PointSampler({"x": WHOLE, "y": WHOLE, "m": (Fraction(0), None, None)}, frozenset())
    judge = Judge(pool, lambda name: name == "m", sampler)
    assert judge.never_zero((Meaning(pool, lambda _: None), node)) is never
