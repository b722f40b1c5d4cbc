# SPDX-License-Identifier: Apache-2.0
"""Finite field with sine, cosine, exponential and roots that fulfil their identities exactly.

Equal expressions have equal values there, without rounding, so that values can be looked up in dictionaries. Different
expressions agree at a random point with a probability of about degree / 2^89.

`P + 1 = 8*3*5*...*47*15*Q` with Q prime, and (P - 1)/2 is prime too. P is 3 mod 4, so -1 has no root and F_P(i) has P^2
elements; its unit circle has P + 1 elements. Angles are exponents of an element of order Q of the circle, multiples of
pi/12 are powers of an element of order 24. The exponential is a power of an element of order (P - 1)/2. Exponents are
numbers modulo Q (P - 1)/2, so one number serves both. Odd roots are unique in F_P; square roots of elements that have
none there lie in F_P(i).
"""

from __future__ import annotations

import functools
import hashlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TypeAlias, TypeVar

Q = 618970019642690137449574501
P = 22835900448413279767030398965606561039612184599
R = (P - 1) // 2
MODULUS = Q * R
BITS = P.bit_length()


class Undefined(ArithmeticError):  # noqa: N818
    """An operation without a value, such as division by zero."""


@dataclass(frozen=True, slots=True)
class Complex:
    """An element of F_P(i) outside of F_P."""

    re: int
    im: int


Element: TypeAlias = int | Complex
Circle: TypeAlias = tuple[Element, Element]
"""Cosine and sine as an element of the unit circle."""
ONE: Circle = (1, 0)
UNIT: Element = 1
T = TypeVar("T")


def _element(re: int, im: int) -> Element:
    return Complex(re % P, im % P) if im % P else re % P


def _split(a: Element) -> tuple[int, int]:
    return (a.re, a.im) if isinstance(a, Complex) else (a, 0)


def add(a: Element, b: Element) -> Element:
    """Return a + b."""
    if isinstance(a, int) and isinstance(b, int):
        return (a + b) % P
    (ar, ai), (br, bi) = _split(a), _split(b)
    return _element(ar + br, ai + bi)


def mul(a: Element, b: Element) -> Element:
    """Return a b."""
    if isinstance(a, int) and isinstance(b, int):
        return a * b % P
    (ar, ai), (br, bi) = _split(a), _split(b)
    return _element(ar * br - ai * bi, ar * bi + ai * br)


def sub(a: Element, b: Element) -> Element:
    """Return a - b."""
    return add(a, mul(P - 1, b))


def inverse(a: Element) -> Element:
    """Return 1/a."""
    if a == 0:
        raise Undefined("division by zero")
    if isinstance(a, int):
        return pow(a, -1, P)
    size = pow(a.re * a.re + a.im * a.im, -1, P)
    return _element(a.re * size, -a.im * size)


def power(a: Element, n: int) -> Element:
    """Return a^n."""
    if n < 0:
        return power(inverse(a), -n)
    return pow(a, n, P) if isinstance(a, int) else _repeated(mul, UNIT, a, n)


def _repeated(operation: Callable[[T, T], T], neutral: T, a: T, n: int) -> T:
    """Return n times a by repeated doubling with the given operation."""
    result = neutral
    while n:
        if n & 1:
            result = operation(result, a)
        a, n = operation(a, a), n >> 1
    return result


def number(value: Fraction) -> Element:
    """Return a fraction as a field element."""
    if value.denominator % P == 0:
        raise Undefined("division by zero")
    return value.numerator * pow(value.denominator, -1, P) % P


def sign(a: Element) -> int:
    """Return the Legendre symbol, which replaces the sign in a field without order.

    Raises
    ------
    Undefined
        For an element outside F_P.
    """
    if isinstance(a, Complex):
        raise Undefined("the sign of a complex number")
    if a == 0:
        return 0
    return 1 if pow(a, R, P) == 1 else -1


def sqrt(a: Element) -> Element:
    """Return the root that is itself a square or, without a root in F_P, i times the root of the negative.

    The root is a power of `a`, and so a square where `a` is one. The exponent is even, so -a has the same power.
    """
    if isinstance(a, Complex):
        return _complex_root(a)
    root = pow(a, (P + 1) // 4, P)
    return root if root * root % P == a else _element(0, root)


def _complex_root(a: Complex) -> Element:
    """Return one of the two roots, always the same."""
    size = (a.re * a.re + a.im * a.im) % P
    norm = pow(size, (P + 1) // 4, P)
    if norm * norm % P != size:
        raise Undefined("a root outside F_P(i)")
    for length in (norm, P - norm):
        half = (a.re + length) * pow(2, -1, P) % P
        re = pow(half, (P + 1) // 4, P)
        if re and re * re % P == half:
            im = a.im * pow(2 * re, -1, P) % P
            return min(_element(re, im), _element(-re, -im), key=_split)
    raise Undefined("a root outside F_P(i)")


class Roots:
    """Square roots at one point, some of them with reversed sign; equal squares have equal roots.

    Parameters
    ----------
    turned : sequence of bool
        True for each root with reversed sign, in the order of use; later roots are those of `sqrt`.
    """

    def __init__(self, turned: Sequence[bool] = ()) -> None:
        self.turned = tuple(turned)
        self.known: dict[Element, Element] = {}

    def __call__(self, a: Element) -> Element:
        """Return a root."""
        if a not in self.known:
            number = len(self.known)
            root = sqrt(a)
            self.known[a] = sub(0, root) if number < len(self.turned) and self.turned[number] else root
        return self.known[a]

    def others(self) -> Iterator[Roots]:
        """Yield copies with one further root reversed, for each root used after the given ones."""
        given = len(self.turned)
        for number in range(given, len(self.known)):
            yield Roots((*self.turned, *(False for _ in range(given, number)), True))


def rational_power(a: Element, exponent: Fraction, roots: Callable[[Element], Element] = sqrt) -> Element:
    """Return a^(p/q); odd roots are unique, even ones come from `roots`."""
    q, root = exponent.denominator, a
    while q % 2 == 0:
        root, q = roots(root), q // 2
    if q > 1:
        if isinstance(root, Complex):
            raise Undefined("an odd root of a complex number")
        root = pow(root, pow(q, -1, P - 1), P)
    return power(root, exponent.numerator)


def hashed(*parts: object) -> int:
    """Return a pseudorandom element that depends on these values only."""
    return int.from_bytes(hashlib.blake2b(repr(parts).encode(), digest_size=48).digest(), "big")


def turn(a: Circle, b: Circle) -> Circle:
    """Return the circle element of the sum of two angles."""
    return sub(mul(a[0], b[0]), mul(a[1], b[1])), add(mul(a[1], b[0]), mul(a[0], b[1]))


def turned(a: Circle, n: int) -> Circle:
    """Return the circle element of n times an angle."""
    if n < 0:
        return turned((a[0], sub(0, a[1])), -n)
    return _repeated(turn, ONE, a, n)


def halved(a: Circle, roots: Callable[[Element], Element] = sqrt) -> Circle:
    """Return the circle element of half of an angle that is between -pi and pi."""
    half = number(Fraction(1, 2))
    cosine = roots(mul(half, add(1, a[0])))
    return cosine, mul(half, mul(a[1], inverse(cosine)))


@functools.cache
def _generators() -> tuple[Circle, Circle, int]:
    """Return circle elements of order Q and of order 24 (a rotation by pi/12), and a field element of order R."""
    for k in range(2, 100):
        norm = (1 + k * k) % P
        unit = turn((1, k), (1, k))
        point: Circle = (mul(unit[0], inverse(norm)), mul(unit[1], inverse(norm)))
        angle, small = turned(point, (P + 1) // Q), turned(point, (P + 1) // 24)
        third, quarter = mul(sqrt(3), inverse(2)), mul(sqrt(2), inverse(2))
        for n in range(1, 24):
            twelfth = turned(small, n)
            if turned(twelfth, 3) == (quarter, quarter) and turned(twelfth, 4) == (inverse(2), third):
                return angle, twelfth, 4
    raise AssertionError("no generator found")


@functools.lru_cache(maxsize=4096)
def circle(exponent: int, twelfths: int) -> Circle:
    """Return the circle element of an angle, given as an exponent and a multiple of pi/12."""
    angle, twelfth, _ = _generators()
    return turn(turned(angle, exponent % Q), turned(twelfth, twelfths % 24))


def exponential(exponent: int) -> int:
    """Return the exponential of an exponent."""
    return pow(_generators()[2], exponent % R, P)
