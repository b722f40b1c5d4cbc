# SPDX-License-Identifier: Apache-2.0
"""Conversion of an expression's sign into signs of its parts.

A product is positive if an even number of factors is negative; `sqrt(Q) - k` if `k` is negative or `Q - k^2`
positive; a minimum if all operands are positive. One condition on one side and several on the other thus become the
same signs.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from fractions import Fraction
from math import isqrt

from ..branches import Atom, difference, either, every
from ..pool import Pool
from .intervals import QUARTERS, Bounds, Ranges

_FACTORS = 4
"""Largest number of factors of a product whose signs are split: eight alternatives."""

_INVERSE = {"log": "exp", "acos": "cos", "asin": "sin", "atan": "tan"}
"""Inverses of monotonic functions; only `acos` decreases."""


class Signs:
    """Splitter of signs of expressions into signs of their parts.

    Parameters
    ----------
    pool : Pool
        Pool of the expressions.
    bounds : mapping
        Bounds of free names.
    """

    def __init__(self, pool: Pool, bounds: Bounds) -> None:
        self.pool = pool
        self.ranges = Ranges(pool, bounds)
        self._memo: dict[Atom, list[tuple[Atom, ...]] | None] = {}

    def __call__(self, atom: Atom) -> list[tuple[Atom, ...]] | None:
        """Return the alternatives that give a node its sign, almost everywhere; None if there are too many."""
        if atom not in self._memo:
            self._memo[atom] = self._of(*atom)
        return self._memo[atom]

    def splits(self, atoms: Sequence[Atom]) -> list[tuple[Atom, ...]]:
        """Return the alternatives that give several nodes their signs, or the given signs if there are too many."""
        alternatives = every([self(atom) for atom in atoms])
        return [tuple(atoms)] if alternatives is None else alternatives

    def parts(self, node: int) -> set[int]:
        """Return the nodes whose signs determine a node's sign."""
        alternatives = [*(self((node, 1)) or ()), *(self((node, -1)) or ())]
        return {part for alternative in alternatives for part, _ in alternative}

    def _of(self, node: int, sign: int) -> list[tuple[Atom, ...]] | None:
        """Return the alternatives, as signs of parts, that give a node a sign; None if there are too many."""
        value = self.pool.constant(node)
        if not sign:
            return [((node, sign),)]
        if value is not None:
            return [()] if value * sign > 0 else []
        if self._is_positive(node):
            return [()] if sign > 0 else []
        operation, *operands = self.pool.nodes[node]
        if operation == "mul":
            return self._of_product(node, sign)
        if operation == "pow" and self._is_odd(operands[1]):
            return self((operands[0], sign))
        if operation in ("max", "min"):
            return self._of_extremum(operands, operation == "max", sign)
        return self._of_sum(node, sign) if operation == "add" else [((node, sign),)]

    def _of_product(self, node: int, sign: int) -> list[tuple[Atom, ...]] | None:
        """Return the alternatives for a product: the signs of its factors that multiply to this sign."""
        factors = [factor for factor in self.pool.operands(node) if not self._is_positive(factor)]
        values = [self.pool.constant(factor) for factor in factors]
        rest = [factor for factor, value in zip(factors, values, strict=True) if value is None]
        if any(value is not None and value < 0 for value in values):
            sign = -sign
        if len(rest) > _FACTORS:
            return [((node, sign),)] if len(rest) == len(factors) else [((self.pool.many("mul", rest), sign),)]
        signs = (row for row in itertools.product((1, -1), repeat=len(rest)) if _product(row) == sign)
        return either([every([self(atom) for atom in zip(rest, row, strict=True)]) for row in signs])

    def _of_extremum(self, parts: Sequence[int], is_max: bool, sign: int) -> list[tuple[Atom, ...]] | None:
        return (either if is_max == (sign > 0) else every)([self((part, sign)) for part in parts])

    def _of_sum(self, node: int, sign: int) -> list[tuple[Atom, ...]] | None:
        """Return the alternatives for a sum, by a common factor, an extremum, a root or an inverse function in it."""
        if (flat := self._times(node, Fraction(1))) != node:
            return self((flat, sign))
        terms = self.pool.operands(node)
        if shared := self._shared(terms):
            base, exponent = shared
            rest = self.pool.many("add", [self._multiplied(term, base, -exponent) for term in terms])
            return self((self.pool.many("mul", [self.pool.power(base, exponent), rest]), sign))
        for number, term in enumerate(terms):
            factor, rest = self._split(term)
            others = self.pool.many("add", [other for k, other in enumerate(terms) if k != number])
            operation, *operands = self.pool.nodes[rest]
            if operation in ("max", "min", "abs"):
                values = [*operands, self._times(operands[0], Fraction(-1))] if operation == "abs" else operands
                parts = [self.pool.many("add", [self._times(value, factor), others]) for value in values]
                return self._of_extremum(parts, (operation != "min") == (factor > 0), sign)
            if any(self.pool.raised(part)[1] == Fraction(1, 2) for part in self.pool.factors(rest)):
                return self._of_root(rest, factor, others, sign)
            if operation in _INVERSE:
                limit = self._limit(operation, self._times(others, -1 / factor))
                if limit is not None:
                    way = sign if (factor > 0) != (operation == "acos") else -sign
                    inner = self((difference(self.pool, operands[0], limit), way))
                    return every([inner, [((node, sign),)]])
        return self._of_squares(terms, sign) or [((node, sign),)]

    def _limit(self, operation: str, value: int) -> int | None:
        """Return the operand at which a function has a given value; None if the value may be outside its range."""
        for quarters, beyond in zip(QUARTERS.get(operation, ()), (-1, 1), strict=False):
            end = self.pool.many("mul", [self.pool.intern("const", "pi"), self.pool.number(Fraction(quarters, 2))])
            if not self.ranges.never_have(difference(self.pool, value, end), beyond):
                return None
        return self.pool.intern(_INVERSE[operation], value)

    def _shared(self, terms: Sequence[int]) -> tuple[int, Fraction] | None:
        """Return a power that divides all terms or is the divisor of some, or None."""
        powers = [self._powers(term) for term in terms]
        for base in dict.fromkeys(base for of_term in powers for base in of_term):
            least = min(of_term.get(base, Fraction(0)) for of_term in powers)
            if least and self.pool.constant(base) is None:
                return base, least
        return None

    def _multiplied(self, term: int, base: int, exponent: Fraction) -> int:
        """Return the product of a term and a power, with one power per base."""
        powers = self._powers(term)
        powers[base] = powers.get(base, Fraction(0)) + exponent
        return self.pool.many("mul", [self.pool.power(*power) for power in powers.items()])

    def _powers(self, term: int) -> dict[int, Fraction]:
        """Return a product's exponents by base."""
        powers: dict[int, Fraction] = {}
        for base, exponent in map(self.pool.raised, self.pool.factors(term)):
            powers[base] = powers.get(base, Fraction(0)) + exponent
        return powers

    def _of_root(self, term: int, number: Fraction, rest: int, sign: int) -> list[tuple[Atom, ...]] | None:
        """Split the sign of P + c f sqrt(Q); if P and c f differ in sign, the larger magnitude decides."""
        roots = [part for part in self.pool.factors(term) if self.pool.raised(part)[1] == Fraction(1, 2)]
        others = [part for part in self.pool.factors(term) if part not in roots]
        factor = self.pool.many("mul", [*others, self.pool.number(number)])
        squares = self._times(self._square(term), number**2), self._times(self._square(rest), Fraction(-1))
        margin = self.pool.many("add", squares)
        along, own = self((rest, sign)), self((factor, sign))
        larger, smaller = self((margin, 1)), self((margin, -1))
        if own in ([()], []):
            return either([along, larger]) if own else every([along, smaller])
        return either([every([along, own]), every([along, smaller]), every([own, larger])])

    def _of_squares(self, terms: Sequence[int], sign: int) -> list[tuple[Atom, ...]] | None:
        """Split the sign of A^2 - B^2 into those of A - B and A + B."""
        roots = [self._root(term) for term in terms]
        if len(roots) != 2 or None in roots:
            return None
        (first, plus), (second, other) = (root for root in roots if root)
        if plus == other:
            return None
        minus = self._times(second, Fraction(-1))
        product = self.pool.many("mul", [self.pool.many("add", [first, k]) for k in (second, minus)])
        return self((product, sign * plus))

    def _root(self, term: int) -> tuple[int, int] | None:
        """Return root and sign of a term that is a square up to its sign; None for other terms."""
        factor, rest = self._split(term)
        size = _rational_root(abs(factor))
        if size is None:
            return None
        sign = 1 if factor > 0 else -1
        if self.pool.constant(rest) is not None:
            return self.pool.number(size), sign
        base, exponent = self.pool.raised(rest)
        if exponent.denominator != 1 or exponent % 2:
            return None
        return self._times(self.pool.power(base, exponent / 2), size), sign

    def _split(self, term: int) -> tuple[Fraction, int]:
        """Return a term's numeric factor and the rest."""
        value = self.pool.constant(term)
        if value is not None:
            return value, self.pool.number(1)
        factors = self.pool.factors(term)
        number = next((value for value in map(self.pool.constant, factors) if value is not None), Fraction(1))
        return number, self.pool.many("mul", [factor for factor in factors if self.pool.constant(factor) is None])

    def _times(self, node: int, factor: Fraction) -> int:
        """Return a multiple of a node, term by term for a sum, so that equal terms combine."""
        own, rest = self._split(node)
        if self.pool.nodes[rest][0] == "add":
            return self.pool.many("add", [self._times(term, factor * own) for term in self.pool.operands(rest)])
        return self.pool.many("mul", [node, self.pool.number(factor)])

    def _square(self, node: int) -> int:
        return self.pool.many("mul", [*map(self._squared, self.pool.factors(node))])

    def _squared(self, node: int) -> int:
        value = self.pool.constant(node)
        if value is not None:
            return self.pool.number(value**2)
        if self.pool.nodes[node][0] == "exp":
            return self.pool.intern("exp", self._times(self.pool.operands(node)[0], Fraction(2)))
        base, exponent = self.pool.raised(node)
        return self.pool.power(base, 2 * exponent)

    def _is_odd(self, exponent: int) -> bool:
        value = self.pool.constant(exponent)
        return value is not None and value.denominator == 1 and value % 2 == 1

    def _is_positive(self, node: int) -> bool:
        """Return True if a node is provably never negative, and so does not change the sign of a product."""
        return self.ranges.never_have(node, -1)


def _product(signs: Sequence[int]) -> int:
    return -1 if signs.count(-1) % 2 else 1


def _rational_root(value: Fraction) -> Fraction | None:
    root = Fraction(isqrt(value.numerator), isqrt(value.denominator))
    return root if root**2 == value else None
