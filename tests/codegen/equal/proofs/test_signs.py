# SPDX-License-Identifier: Apache-2.0
"""The signs of parts give the sign of the whole, and only it; bounds of functions hold their values."""

import itertools
import random
from fractions import Fraction

import pytest
import sympy as sp

from mehvar.codegen.equal.pool import Pool
from mehvar.codegen.equal.proofs import linear
from mehvar.codegen.equal.proofs.intervals import Ranges
from mehvar.codegen.equal.proofs.signs import Signs
from mehvar.codegen.equal.reals import RealWorld
from mehvar.codegen.ledger.sides import Sides

x, y, k = sp.symbols("x y k", real=True)
m = sp.Symbol("m", positive=True)
f = sp.acos(sp.cos(x))
BOUNDS = {"m": (Fraction(0), None)}
WHOLES = [
    (f - 1) * (2 - f),
    (f - 1) ** 2 - sp.Rational(1, 4),
    9 * (x - y) ** 2 - (x + 1) ** 4 * 25,
    sp.sqrt(x**2 + y**2) - k,
    k - 2 * sp.sqrt(x**2 + y**2),
    1 - k / sp.sqrt(x**2 + y**2),
    y - m * sp.sqrt(1 + x**2),
    1 - 2 * k * sp.sqrt(1 + x**2) + y,
    x / y - k,
    x * y - k * y**2 + y**3,
    1 / x - sp.sqrt(m) / (y * sp.exp(k)),
    sp.acos(sp.cos(x) / 2) - sp.Rational(3, 2),
    1 - 2 * sp.acos(sp.tanh(x) * sp.cos(y)),
    sp.asin(sp.tanh(x)) - sp.tanh(y),
    sp.pi / 3 - sp.atan(x * y),
    sp.atan(x) - y,
    sp.sqrt(1 + x**2) - sp.exp(y / 2),
    x / (1 + y**2) ** 2 - 2 / sp.sqrt(1 + y**2),
    k - m / (x**2 * sp.sqrt(m + y**2)),
    sp.sqrt(m) - y,
    sp.Max(x, y, k) - 1,
    1 - sp.Max(x, sp.Min(y, k)),
    sp.Min(x - 1, 2 - y) * m,
    sp.Abs(f - 1) - sp.Rational(1, 10),
    sp.log(m) - x,
    y - 2 * sp.log(m),
    -3 * x * sp.exp(y) * (x - k) * y,
    x**3 * (y - 1) ** 2 / m,
    sp.Max(0, x - 1) * (k + y),
]


@pytest.mark.parametrize("whole", WHOLES, ids=str)
def test_parts_have_their_signs_where_the_whole_has_its_own(whole):
    pool = Pool()
    (node,) = Sides(pool).entries(whole)
    signs = Signs(pool, BOUNDS)
    alternatives = {sign: signs((node, sign)) for sign in (1, -1)}
    draw = random.Random(str(whole))
    for _ in range(200):
        point = {name: Fraction(draw.randrange(-4000, 4000), 1000) for name in "xyk"} | {
            "m": Fraction(draw.randrange(1, 4000), 1000)
        }
        world = RealWorld(pool, lambda _: None, point)
        value = world.value(node)
        if abs(value) < 1e-9:
            continue
        for sign in (1, -1):
            holds = any(all(world.value(part) * way > 0 for part, way in row) for row in alternatives[sign])
            assert holds == (value * sign > 0), (whole, point, sign)


@pytest.mark.parametrize("whole", [x**2 - y**2, 9 * (x - y) ** 2 - 25 * (x + 1) ** 4, 1 - x**6], ids=str)
def test_a_difference_of_squares_is_taken_apart(whole):
    pool = Pool()
    (node,) = Sides(pool).entries(whole)
    for sign in (1, -1):
        rows = Signs(pool, BOUNDS)((node, sign))
        assert all(node not in [part for part, _ in row] for row in rows)


WRITTEN_ANEW = [
    [1 - m / sp.sqrt(x**2 + y**2), sp.sqrt(x**2 + y**2) - m, x**2 + y**2 - m**2],
    [x / y - k, x * y - k * y**2],
    [sp.log(1 + x**2) - m, sp.sqrt(1 + x**2) - sp.exp(m / 2)],
    [1 - sp.acos(sp.tanh(x)), sp.tanh(x) - sp.cos(1)],
]


@pytest.mark.parametrize("wholes", WRITTEN_ANEW, ids=str)
def test_a_condition_that_is_written_anew_has_the_same_sign(wholes):
    pool = Pool()
    nodes = Sides(pool).entries(sp.Matrix(wholes))
    signs = Signs(pool, BOUNDS)
    for one, other in itertools.permutations(nodes, 2):
        assert all(linear.impossible(pool, row, BOUNDS) for row in signs.splits([(one, 1), (other, -1)]))


def test_a_window_is_the_same_signs_however_it_is_written():
    pool = Pool()
    texts = [(f - 1) * (2 - f), sp.Min(f - 1, 2 - f), sp.Rational(1, 2) - sp.Abs(f - sp.Rational(3, 2))]
    nodes = [Sides(pool).entries(text)[0] for text in [*texts, f - 1, 2 - f]]
    signs = Signs(pool, {})
    for node in nodes[:3]:
        for alternative in signs((node, 1)):
            for beyond in nodes[3:]:
                required = [*alternative, (beyond, -1)]
                assert linear.impossible(pool, required, {}) or Ranges(pool, {}).exclude(required)


NEVER = [
    (sp.acos(sp.cos(x)) - sp.Rational("3.15"), 1),
    (sp.sqrt(sp.acos(sp.cos(x))) - sp.Rational("1.8"), 1),
    (sp.asin(x) + sp.Rational("1.58"), -1),
    (2 * sp.acos(sp.cos(x)) - 2 * sp.pi, 1),
    (sp.atan2(y, x) + sp.pi, -1),
    (sp.pi / 2 - sp.atan(x), -1),
    (sp.exp(-(x**2)) - sp.Rational("1.001"), 1),
    (sp.log(1 + x**2) + sp.Rational("0.001"), -1),
    (sp.Mod(x, 2) - 2, 1),
    (x - sp.floor(x) - sp.Rational("1.001"), 1),
    (1 - (sp.cos(x) * sp.sin(y)) ** 2, -1),
]


@pytest.mark.parametrize(("whole", "sign"), NEVER, ids=str)
def test_a_sign_beyond_the_range_of_a_function_is_excluded(whole, sign):
    pool = Pool()
    (node,) = Sides(pool).entries(whole)
    ranges = Ranges(pool, {})
    assert linear.impossible(pool, [(node, sign)], {}) or ranges.never_have(node, sign)
    assert not linear.impossible(pool, [(node, -sign)], {})
    assert not ranges.never_have(node, -sign)


def test_no_whole_number_lies_between_two():
    pool = Pool()
    (low, high) = Sides(pool).entries(sp.Matrix([sp.floor(x) - sp.Rational(9, 4), sp.Rational(5, 2) - sp.floor(x)]))
    assert linear.impossible(pool, [(low, 1), (high, 1)], {})
    assert not linear.impossible(pool, [(low, 1), (high, -1)], {})
