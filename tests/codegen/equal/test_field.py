# SPDX-License-Identifier: Apache-2.0
"""Laws of the field in which equal expressions have equal values."""

from fractions import Fraction

import pytest

from mehvar.codegen.equal.field import (
    MODULUS,
    ONE,
    Complex,
    P,
    Q,
    R,
    Undefined,
    add,
    circle,
    exponential,
    halved,
    hashed,
    inverse,
    mul,
    number,
    power,
    rational_power,
    sign,
    sqrt,
    sub,
    turn,
    turned,
)

DRAWS = range(24)


def real(*parts):
    return hashed(*parts) % P


def beyond(*parts):
    return Complex(real("re", *parts), real("im", *parts))


def test_the_primes_are_as_they_are_described():
    assert P % 4 == 3
    assert P + 1 == (P + 1) // Q * Q
    assert (P + 1) // Q % 24 == 0
    assert (2 * R + 1, Q * R) == (P, MODULUS)
    assert all(pow(2, n - 1, n) == 1 for n in (P, Q, R))


@pytest.mark.parametrize("kind", [real, beyond])
def test_roots_are_roots(kind):
    """A square has one of its two roots; a number without a root in F_P has i times a number."""
    for k in DRAWS:
        a = kind(k)
        square = mul(a, a)
        assert sqrt(square) in (a, sub(0, a))
        assert sqrt(square) == sqrt(mul(sub(0, a), sub(0, a)))
    for k in DRAWS:
        root = sqrt(real(k))
        assert mul(root, root) == real(k)
        assert isinstance(root, Complex) == (sign(real(k)) < 0)


def test_half_of_what_lies_beyond_has_a_root_there():
    answers = set()
    for k in DRAWS:
        try:
            root = sqrt(beyond(k))
        except Undefined:
            answers.add(False)
        else:
            assert mul(root, root) == beyond(k)
            answers.add(True)
    assert answers == {True, False}


@pytest.mark.parametrize("kind", [real, beyond])
def test_arithmetic_is_that_of_a_field(kind):
    for k in DRAWS:
        a, b = kind(k), kind(-1 - k)
        assert add(sub(a, b), b) == a
        assert mul(a, inverse(a)) == 1
        assert mul(power(a, -3), mul(a, mul(a, a))) == 1
        assert power(a, 0) == 1
    with pytest.raises(Undefined):
        inverse(0)
    assert mul(number(Fraction(-2, 7)), 7) == P - 2
    with pytest.raises(Undefined):
        number(Fraction(1, P))


def test_odd_roots_are_unique_and_even_ones_those_of_a_square():
    for k in DRAWS:
        a = real(k)
        assert power(rational_power(a, Fraction(1, 3)), 3) == a
        assert rational_power(a, Fraction(2, 3)) == power(rational_power(a, Fraction(1, 3)), 2)
        assert rational_power(mul(a, a), Fraction(1, 2)) == sqrt(mul(a, a))
    with pytest.raises(Undefined):
        rational_power(beyond(0), Fraction(1, 3))


def test_signs_multiply():
    assert [sign(a) for a in (0, 1, P - 1)] == [0, 1, -1]
    assert all(sign(mul(real(k), real(-1 - k))) == sign(real(k)) * sign(real(-1 - k)) for k in DRAWS)
    with pytest.raises(Undefined):
        sign(beyond(0))


def test_angles_add_and_exponentials_multiply():
    for k in DRAWS:
        a, b = hashed("a", k) % MODULUS, hashed("b", k) % MODULUS
        cosine, sine = circle(a, k)
        assert add(mul(cosine, cosine), mul(sine, sine)) == 1
        assert turn(circle(a, k), circle(b, 5)) == circle(a + b, k + 5)
        assert turned(circle(a, 0), -2) == circle(-2 * a, 0)
        half = halved(circle(a, 0))
        assert turn(half, half) == circle(a, 0)
        assert mul(exponential(a), exponential(b)) == exponential(a + b)
    assert circle(1, 0) != ONE == turned(circle(1, 0), Q)
    assert circle(0, 6) == (0, 1)
    assert circle(0, 2)[1] == inverse(2)
    assert exponential(1) != 1 == exponential(R)
