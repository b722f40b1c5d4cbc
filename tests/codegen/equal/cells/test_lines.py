# SPDX-License-Identifier: Apache-2.0
"""Lines have points on both sides of every change of a condition."""

import numpy as np
import pytest
import sympy as sp

from mehvar.codegen.equal.cells.conditions import Conditions
from mehvar.codegen.equal.cells.lines import Lines, Work
from mehvar.codegen.equal.pool import Pool
from mehvar.codegen.equal.proofs.signs import Signs
from mehvar.codegen.ledger.sides import Sides

x, y, z = sp.symbols("x y z", real=True)


def lines_of(*sides, bounds=()):
    pool = Pool()
    roots = tuple(Sides(pool).entries(sp.Matrix(sides)))
    return Lines(Conditions.of(pool, roots, Signs(pool, {})), dict(bounds), frozenset(), Work(pool, 10**8))


@pytest.mark.parametrize("place", [1, 2, 7, -20])
def test_a_line_has_points_beside_a_change_that_falls_on_its_grid(place):
    old = sp.Piecewise((x, x > place), (y, x > place - sp.Rational(3, 7)), (y * z, True))
    new = sp.Piecewise((x + 0 * y, x >= place), (y, x > place - sp.Rational(3, 7)), (y * z, True))
    line = lines_of(old, new).points({"x": 0.3, "y": 0.7, "z": 5.0}, "x")["x"]
    for change in (place, place - 3 / 7):
        beside = np.abs(line - change)
        assert (beside[line < change].min(), beside[line > change].min()) == pytest.approx((0, 0), abs=1e-10)


def test_a_line_stays_within_the_bounds_of_its_name():
    line = lines_of(sp.Abs(x - y), x, bounds={"x": (-2, 3)}.items()).points({"x": 0.0, "y": 1.0}, "x")
    assert -2 <= line["x"].min() < 1 < line["x"].max() <= 3
    assert set(line["y"]) == {1.0}


def test_whole_numbers_of_a_step_have_points_on_both_sides():
    line = lines_of(sp.floor(x), y).points({"x": 0.3, "y": 0.0}, "x")["x"]
    assert {-1, 0, 1} <= {*np.floor(line[np.abs(line) < 2])}


def test_a_zero_of_a_node_is_located_on_a_line():
    lines = lines_of(x * y - 6, x)
    root = lines.conditions.roots[0]
    assert lines.zero(root, {"x": 1.0, "y": 4.0}, "x") == pytest.approx({"x": 1.5, "y": 4.0})
    assert lines.zero(root, {"x": 0.0, "y": 4.0}, "y") is None
