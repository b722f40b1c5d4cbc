# SPDX-License-Identifier: Apache-2.0
"""Lines through the cells of two expressions, and the budget of joint states."""

import numpy as np
import pytest
import sympy as sp

from mehvar.codegen.equal import cells
from mehvar.codegen.equal.cells import Cells
from mehvar.codegen.equal.equality import EqualityTest, Meaning
from mehvar.codegen.equal.pool import Pool
from mehvar.codegen.equal.reals import PointSampler
from mehvar.codegen.ledger.sides import Sides

NAMES = sp.symbols("x y z", real=True)
x, y, z = NAMES


def judged(old, new):
    pool = Pool()
    left, right = Sides(pool).entries(sp.Matrix([old, new]))
    sampler = PointSampler({name.name: (None, None, None) for name in NAMES}, frozenset())
    free = Meaning(pool, lambda _: None)
    return EqualityTest(pool, lambda _: False, sampler).decide((free, left), (free, right))


@pytest.fixture
def made(monkeypatch):
    """Return the cells of a test of equality."""
    seen = []
    real = Cells.walk
    monkeypatch.setattr(Cells, "walk", lambda self: (seen.append(self), real(self))[1])
    return seen


@pytest.mark.parametrize("place", [1, 2, 7, -20])
def test_a_line_has_points_beside_a_change_that_falls_on_its_grid(made, place):
    old = sp.Piecewise((x, x > place), (y, x > place - sp.Rational(3, 7)), (y * z, True))
    judged(old, sp.Piecewise((x + 0 * y, x >= place), (y, x > place - sp.Rational(3, 7)), (y * z, True)))
    line = made[0]._line({"x": 0.3, "y": 0.7, "z": 5.0}, "x")["x"]
    for change in (place, place - 3 / 7):
        beside = np.abs(line - change)
        assert (beside[line < change].min(), beside[line > change].min()) == pytest.approx((0, 0), abs=1e-10)


def test_the_budget_of_joint_states_is_used_to_its_end(made, monkeypatch):
    """Each joint state that is not equal costs the nodes of both sides; the last one may take what is left."""
    old = sp.Piecewise((x, x > 1), (y, x > 0), (y * z, True)) * sp.Piecewise((x, y > 1), (z, True))
    judged(old, sp.Piecewise((x, x >= 1), (y, x >= 0), (y * z, True)) * sp.Piecewise((x, y >= 1), (z, True)))

    def decided(budget):
        monkeypatch.setattr(cells, "_MOST_JOINT", budget)
        return made[0]._joint() is None

    each = len(made[0]._nodes)
    states = next(count for count in range(40) if decided(count * each))
    assert states > 1
    assert not decided(states * each - 1)
