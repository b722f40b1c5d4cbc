# SPDX-License-Identifier: Apache-2.0
"""Roots with either sign: what is equal among the reals is equal for one choice, what is not is for none."""

import pytest
import sympy as sp

from mehvar.codegen.equal import field
from mehvar.codegen.equal.cells.smooth import SmoothTest
from mehvar.codegen.equal.meaning import Meaning
from mehvar.codegen.equal.points import FieldPoints
from mehvar.codegen.equal.pool import Pool
from mehvar.codegen.ledger.sides import Sides

a, x, y = sp.symbols("a x y", real=True)


def smooth_test(*sides):
    pool = Pool()
    smooth = SmoothTest(FieldPoints(pool, lambda _: False), Meaning(pool, lambda _: None))
    return smooth, [Sides(pool).entries(side)[0] for side in sides]


@pytest.mark.parametrize(("old", "new"), [
    (sp.sqrt(x**2 + 2 * x * y + y**2), x + y),
    (sp.sqrt(1 - sp.cos(a) ** 2), -sp.sin(a)),
    (sp.sqrt(x) * sp.sqrt(y), sp.sqrt(x * y)),
    (sp.sqrt(3 + 2 * sp.sqrt(2)), 1 + sp.sqrt(2)),
])  # fmt: skip
def test_what_a_sign_of_a_root_makes_equal_is_not_told_apart(old, new):
    smooth, sides = smooth_test(old, new)
    assert not smooth.are_apart(*sides)


@pytest.mark.parametrize("root", [sp.sqrt(1 - sp.cos(a) ** 2), sp.sqrt(x) * sp.sqrt(y) + sp.sqrt(1 + x**2)])
def test_what_no_sign_of_a_root_makes_equal_is_told_apart(root):
    smooth, sides = smooth_test(root, root + sp.exp(-(10**8) * (a - 1) ** 2))
    assert smooth.are_apart(*sides)


def test_all_signs_of_roots_come_once():
    seen, waiting = [], [field.Roots()]
    while waiting:
        roots = waiting.pop()
        seen.append(tuple(roots(square) for square in (4, 9, 25)))
        waiting += roots.others()
    assert len(set(seen)) == len(seen) == 8
