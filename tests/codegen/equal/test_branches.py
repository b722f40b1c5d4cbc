# SPDX-License-Identifier: Apache-2.0
"""The condition of a branch holds exactly where the node takes that branch."""

import random
from fractions import Fraction

import pytest
import sympy as sp

from mehvar.codegen.equal.branches import requirements, smooth, ways_of
from mehvar.codegen.equal.pool import Pool
from mehvar.codegen.equal.reals import RealWorld
from mehvar.codegen.ledger.sides import Sides

x, y, k = sp.symbols("x y k", real=True)


@pytest.mark.parametrize(
    "whole",
    [sp.Abs(x), sp.Max(x, y, k), sp.Min(x, y, k), sp.Piecewise((x, (x > y) & (x < k)), (y, x > k), (k, True))],
    ids=str,
)
def test_one_way_has_its_requirements_at_a_point_and_gives_the_value(whole):
    pool = Pool()
    (node,) = Sides(pool).entries(whole)
    draw = random.Random(1)
    for _ in range(50):
        point = {name: Fraction(draw.randrange(-4000, 4000), 1001) for name in "xyk"}
        world = RealWorld(pool, lambda _: None, point)
        (way,) = (
            way
            for way in ways_of(pool, node)
            if any(all(world.value(part) * sign > 0 for part, sign in row) for row in requirements(pool, way))
        )
        assert world.value(smooth(pool, node, dict([way]))) == world.value(node)
