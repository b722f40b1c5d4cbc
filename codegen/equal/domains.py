# SPDX-License-Identifier: Apache-2.0
"""Domain of an expression, represented by an expression that is one inside the domain and zero outside.

Roots, logarithms, arc functions and case distinctions without a last case have no value on open sets of points. A
quotient has none only on a set of measure zero, which is ignored. Domains are expressions with branches, so two of them
are compared like any other expressions.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction

from ..equations.document import reached
from .branches import Atom, difference
from .pool import Pool
from .proofs.known import KnownSigns

Factors = frozenset[int]
"""Nodes with values one or zero; the domain is the set where all are one."""


class Domains:
    """Builder of domains of expressions with free names.

    Parameters
    ----------
    pool : Pool
        Pool of the expressions.
    known : KnownSigns
        Proofs about signs.
    shortest : bool
        Omit parts that are provably positive almost everywhere; this costs time.
    """

    def __init__(self, pool: Pool, known: KnownSigns, shortest: bool) -> None:
        self.pool = pool
        self._known = known
        self._shortest = shortest
        self.positive: dict[int, int] = {}
        """Expression that must be positive, for each factor."""
        self._memo: dict[int, Factors] = {}

    def __call__(self, root: int) -> Factors:
        """Return the factors of an expression's domain."""
        for node in reached(self.pool.nodes, [root]):
            if node not in self._memo:
                self._memo[node] = self._of(node)
        return self._memo[root]

    def product(self, factors: Iterable[int]) -> int:
        """Return the node that is one where all factors are one."""
        return self.pool.many("mul", sorted(factors))

    def inside(self, *roots: int) -> list[Atom]:
        """Return the signs of factors that are certain wherever all expressions have a value."""
        factors = sorted(frozenset[int]().union(*map(self, roots)))
        return [(self.positive[factor], 1) for factor in factors if factor in self.positive]

    def _of(self, node: int) -> Factors:
        operands = self.pool.operands(node)
        if self.pool.nodes[node][0] == "piecewise":
            return self._cases(operands)
        own = {self._inside(part) for part in self._parts(node, operands)} - {self.pool.number(1)}
        return frozenset(own).union(*(self._memo[operand] for operand in operands))

    def _parts(self, node: int, operands: Sequence[int]) -> list[int]:
        """Return the expressions that must be positive so that an operation on valid operands has a value."""
        operation = self.pool.nodes[node][0]
        if operation == "pow":
            exponent = self.pool.constant(operands[1])
            return [] if exponent is not None and exponent.denominator == 1 else [operands[0]]
        if operation == "log":
            return [operands[0]]
        if operation == "acosh":
            return [difference(self.pool, operands[0], self.pool.number(1))]
        if operation in ("asin", "acos", "atanh"):
            return [difference(self.pool, self.pool.number(1), self.pool.power(operands[0], Fraction(2)))]
        return []

    def _inside(self, part: int) -> int:
        """Return the factor that is one where an expression is positive."""
        part = self._signed(part)
        value = self.pool.constant(part)
        if value is not None or self.pool.nodes[part][0] == "const":
            return self.pool.number(value is None or value >= 0)
        if self._shortest and (self._known.is_positive(part) or self._known.never_has(part, -1)):
            return self.pool.number(1)
        zero = self.pool.number(0)
        factor = self._case(self.pool.intern("strictgreaterthan", part, zero), self.pool.number(1), zero)
        self.positive[factor] = part
        return factor

    def _signed(self, part: int) -> int:
        """Return a simpler expression of equal sign for a sum with a root, or for a positive multiple of such a sum.

        P + c sqrt(Q) with c > 0 is positive if c^2 Q - P^2 is positive; otherwise it has the sign of P.
        """
        if self.pool.nodes[part][0] == "mul":
            rest = [factor for factor in self.pool.operands(part) if not self._known.is_positive(factor)]
            return self._signed(rest[0]) if len(rest) == 1 else part
        if self.pool.nodes[part][0] != "add":
            return part
        terms = self.pool.operands(part)
        roots = [(term, square) for term in terms if (square := self._square_of_root(term)) is not None]
        if len(roots) != 1:
            return part
        ((root, square),) = roots
        others = self.pool.many("add", [term for term in terms if term != root])
        margin = difference(self.pool, square, self.pool.power(others, Fraction(2)))
        if self._known.never_has(margin, -1):
            return self.pool.number(1)
        return self._signed(others) if self._known.never_has(margin, 1) else part

    def _square_of_root(self, term: int) -> int | None:
        """Return c^2 Q of c sqrt(Q) with c > 0; None for other terms."""
        squares = list[int]()
        rooted = False
        for factor in self.pool.factors(term):
            inner, exponent = self.pool.raised(factor)
            if exponent == Fraction(1, 2):
                rooted = True
                squares.append(inner)
            elif self._known.is_positive(factor):
                squares.append(self.pool.power(factor, Fraction(2)))
            else:
                return None
        return self.pool.many("mul", squares) if rooted else None

    def _case(self, condition: int, value: int, other: int) -> int:
        always = self.pool.intern("const", "True")
        pairs = (self.pool.intern("exprcondpair", *pair) for pair in ((value, condition), (other, always)))
        return self.pool.intern("piecewise", *pairs)

    def _cases(self, pairs: Sequence[int]) -> Factors:
        """Return the domain of a case distinction: of its conditions up to the true one, and of the selected value."""
        rest = frozenset([self.pool.number(Fraction(0))])
        for pair in reversed(pairs):
            value, condition = self.pool.operands(pair)
            case = self._memo[value]
            if self.pool.nodes[condition] == ("const", "True"):
                rest = case
                continue
            common = case & rest
            if case != rest:
                factors = self._case(condition, self.product(case - common), self.product(rest - common))
                common |= {factors}
            rest = self._memo[condition] | common
        return rest
