# SPDX-License-Identifier: Apache-2.0
"""Evaluators of an expression (digits, doubles, intervals) against mpmath, operation by operation."""

from fractions import Fraction
from itertools import combinations_with_replacement

import mpmath as mp
import numpy as np
import pytest

from mehvar.codegen.equal import doubles
from mehvar.codegen.equal.pool import Pool
from mehvar.codegen.equal.proofs.intervals import Ranges
from mehvar.codegen.equal.reals import DIGITS, RealWorld, real, vanishes

WITHIN_ONE = [Fraction(n, 8) for n in (-8, -7, -3, -1, 0, 2, 5, 8)]
ABOVE_ONE = [Fraction(n, 4) for n in (4, 5, 9, 70)]
ABOVE_ZERO = [Fraction(n, 8) for n in (1, 3, 8, 20, 800)]
ANY = [Fraction(n, 4) for n in (-50, -10, -4, -3, -1, 0, 1, 2, 4, 9, 21, 50)]
FUNCTIONS = {
    "sin": ANY, "cos": ANY, "tan": ANY, "exp": ANY, "sinh": ANY, "cosh": ANY, "tanh": ANY, "atan": ANY, "asinh": ANY,
    "asin": WITHIN_ONE, "acos": WITHIN_ONE, "atanh": WITHIN_ONE[1:-1], "acosh": ABOVE_ONE, "log": ABOVE_ZERO,
    "abs": ANY, "floor": ANY, "ceiling": ANY, "sign": ANY, "sec": ANY,
}  # fmt: skip
EXPONENTS = [Fraction(n) for n in (2, 3, 4, -1, -2, -3)]
POWERS = {n: [x for x in ANY if x or n > 0] for n in EXPONENTS}
POWERS |= dict.fromkeys((Fraction(1, 2), Fraction(-1, 2), Fraction(3, 2)), ABOVE_ZERO)
PAIRS = {
    "atan2": mp.atan2, "mod": lambda a, b: a - b * mp.floor(a / b), "max": max, "min": min,
    "add": lambda a, b: a + b, "mul": lambda a, b: a * b,
}  # fmt: skip
RISING = ("exp", "log", "atan", "tanh", "asin", "acos", "sinh", "asinh", "acosh", "atanh", "abs", "floor", "ceiling")
NAMES = {"abs": abs, "ceiling": mp.ceil}
CLOSE = 1e-11
"""Relative; the operations of an interval err by some spacings of doubles, 2e-16 each."""


def value(name, x):
    """Return a function or a power of a number, with 60 digits."""
    with mp.workdps(60):
        number = mp.mpf(x.numerator) / x.denominator
        if isinstance(name, Fraction):
            return number ** (mp.mpf(name.numerator) / name.denominator)
        return NAMES.get(name, getattr(mp, name, None))(number)


def written(pool, name, *operands):
    """Write a function or a power of names."""
    nodes = [pool.intern("sym", operand) for operand in operands]
    return pool.power(nodes[0], name) if isinstance(name, Fraction) else pool.intern(name, *nodes)


@pytest.mark.parametrize("name", [*FUNCTIONS, *POWERS], ids=str)
def test_a_function_has_its_value_in_digits_and_in_doubles(name):
    pool, points = Pool(), (FUNCTIONS | POWERS)[name]
    node = written(pool, name, "x")
    inexact = doubles.values(pool, range(len(pool.nodes)), {"x": np.array([float(x) for x in points])})[node]
    for x, double in zip(points, inexact, strict=True):
        exact = value(name, x)
        assert abs(RealWorld(pool, lambda _: None, {"x": x}).value(node) - exact) <= abs(exact) * mp.mpf(10) ** -49
        assert double == pytest.approx(float(exact), rel=1e-13, abs=1e-300)


@pytest.mark.parametrize("name", PAIRS)
def test_an_operation_on_two_has_its_value_in_digits_and_in_doubles(name):
    pool = Pool()
    node = written(pool, name, "x", "y")
    for x in ANY:
        for y in ANY:
            if name in ("atan2", "mod") and not y:
                continue
            exact = PAIRS[name](*(mp.mpf(v.numerator) / v.denominator for v in (x, y)))
            double = doubles.values(pool, range(len(pool.nodes)), {"x": np.float64(x), "y": np.float64(y)})[node]
            digits = RealWorld(pool, lambda _: None, {"x": x, "y": y}).value(node)
            assert double == pytest.approx(float(exact), rel=1e-13, abs=1e-14)
            assert float(digits) == pytest.approx(float(exact), rel=1e-13, abs=1e-14)


@pytest.mark.parametrize("sign", [1, -1])
def test_a_number_beyond_doubles_is_infinite_with_its_sign(sign):
    pool = Pool()
    node = pool.number(Fraction(sign * 10**400))
    assert doubles.values(pool, [node], {})[node] == sign * np.inf


@pytest.mark.parametrize("size", [0, 40, -40])
def test_what_vanishes_is_below_the_last_digit_of_its_size(size):
    for power, answer in ((DIGITS + 2, True), (DIGITS - 2, False), (0, False)):
        assert vanishes(real(Fraction(2) ** size / 10**power), size) == answer


def ends(name, low, high):
    """Return the least and the greatest value over an interval; what rises or falls does so on either side of zero."""
    if isinstance(name, Fraction) and (str(name) in ("-1/2", "3/2") or (name < 0 and low <= 0 <= high)):
        return (0.0 if low == 0 or name % 2 != 1 else -mp.inf), mp.inf  # all that is known of these, and beside a pole
    values = [value(name, x) for x in (low, high, *([Fraction(0)] if low < 0 < high else []))]
    return min(values), max(values)


@pytest.mark.parametrize("name", [*RISING, *POWERS], ids=str)
def test_an_interval_has_the_values_of_a_function_and_hardly_more(name):
    points = ANY if name in EXPONENTS else (FUNCTIONS | POWERS)[name]
    for low, high in combinations_with_replacement(points, 2):
        pool = Pool()
        node = written(pool, name, "x")
        for end, sign in zip(ends(name, low, high), (-1, 1), strict=True):
            if mp.isinf(end):
                continue
            double = Fraction(float(end))
            near = sign * Fraction(CLOSE) * max(1, abs(double))
            for place, beyond in ((double + near, True), (double - near, False)):
                over = pool.many("add", [node, pool.number(-place)])
                assert Ranges(pool, {"x": (low, high)}).never_have(over, sign) == beyond, (low, high, sign)


@pytest.mark.parametrize("name", ["abs", "floor", "ceiling", *EXPONENTS], ids=str)
def test_what_is_not_rounded_is_a_point(name):
    for x in map(Fraction, (-4, -2, -1, 1, 2, 4, 8)):
        pool = Pool()
        less = pool.many("add", [written(pool, name, "x"), pool.number(-Fraction(float(value(name, x))))])
        assert Ranges(pool, {"x": (x, x)})[less] == (0.0, 0.0), x
