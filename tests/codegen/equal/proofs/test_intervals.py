# SPDX-License-Identifier: Apache-2.0
"""A condition that is proved impossible holds at no point; a plainly impossible one is proved."""

import random
from fractions import Fraction

import pytest

from mehvar.codegen.equal.pool import Pool
from mehvar.codegen.equal.proofs.intervals import Ranges

BOUNDS = {"x": (Fraction(0), None), "y": (None, Fraction(0)), "z": (None, None), "q": (Fraction(1, 4), Fraction(1, 2))}


def node(pool, text):
    """Write a product of powers, one less it, or what is one of these with a function before it."""
    if text.startswith("1-"):
        return pool.many("add", [pool.number(1), pool.many("mul", [pool.number(-1), node(pool, text[2:])])])
    if text.startswith("abs "):
        return pool.intern("abs", node(pool, text[4:]))
    powers = (factor.partition("^") for factor in text.split("*"))
    return pool.many("mul", [pool.power(pool.intern("sym", name), Fraction(n or 1)) for name, _, n in powers])


IMPOSSIBLE = [("x", -1), ("x^-1", -1), ("x^3", -1), ("y^3", 1), ("z^2", -1), ("z^-2", -1),
              ("x*y", 1), ("x^-1*y", 1), ("1-q", -1), ("1-q^2", -1), ("q^-1", -1), ("abs z", -1), ("abs q", 0),
              ("1-abs q", -1), ("y^-2", -1), ("x^1/2", -1), ("1-q^-1", 1)]  # fmt: skip


@pytest.mark.parametrize(("text", "sign"), IMPOSSIBLE)
def test_a_sign_that_bounds_exclude_is_impossible_and_the_others_are_not(text, sign):
    pool = Pool()
    assert Ranges(pool, BOUNDS).exclude([(node(pool, text), sign)])
    assert not Ranges(pool, BOUNDS).exclude([(node(pool, text), -sign or 1)])
    assert not Ranges(pool, BOUNDS).exclude([(node(pool, "z"), sign)])


def test_what_happens_at_a_point_is_not_impossible():
    draw = random.Random(0)
    for _ in range(3000):
        values = {
            "x": Fraction(draw.choice((0, 1, 3, 7)), 2), "y": -Fraction(draw.choice((0, 1, 2, 9)), 4),
            "z": Fraction(draw.randrange(-6, 7), 3), "q": Fraction(draw.choice((1, 2)), 4),
        }  # fmt: skip
        pool, atoms = Pool(), []
        for _ in range(3):
            factors = [(draw.choice("xyzq"), draw.choice((1, 2, 3, -1, -2))) for _ in range(draw.choice((1, 2)))]
            if any(n < 0 and not values[name] for name, n in factors):
                continue
            value = Fraction(1)
            for name, n in factors:
                value *= values[name] ** n
            text, form = "*".join(f"{name}^{n}" for name, n in factors), draw.choice(("", "1-", "abs "))
            value = {"": value, "1-": 1 - value, "abs ": abs(value)}[form]
            atoms.append((node(pool, form + text), (value > 0) - (value < 0)))
        assert not Ranges(pool, BOUNDS).exclude(atoms), (values, pool.nodes, atoms)


def test_a_sum_of_unbounded_squares_is_never_negative():
    pool = Pool()
    squares = [pool.power(pool.intern("sym", name), Fraction(2)) for name in "uvw"]
    ranges = Ranges(pool, {})
    assert ranges.never_have(pool.many("add", squares), -1)
    assert ranges.never_have(pool.many("add", [*squares, pool.number(Fraction(1, 10))]), 0)
    assert not ranges.never_have(pool.many("add", [*squares, pool.number(Fraction(-1, 10))]), -1)
