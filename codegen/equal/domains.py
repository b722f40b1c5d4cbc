# SPDX-License-Identifier: Apache-2.0
"""Domain of an expression, represented by an expression that is one inside the domain and zero outside.

Roots, logarithms, arc functions and case distinctions without a last case have no value on open sets of points. So has
a quotient whose denominator is zero in a whole branch, such as max(0, x). Other quotients have none only on a set of
measure zero, which is ignored. Domains are expressions with branches, so two of them are compared like any other
expressions.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from itertools import combinations

from .branches import COMPARISONS, Atom, counted, difference, every, requirements, smooth, ways_of
from .pool import Pool
from .proofs.known import KnownSigns

_MOST_BRANCHES = 256
"""Largest number of combinations of branches in which a denominator is examined. Twice as many are one branch more."""
_ROUNDED, _MOST_STEPS = frozenset(("floor", "ceiling")), 4
"""Steps that may be zero in a region, and the largest number of them: each doubles the combinations."""
_EITHER = frozenset(("abs", "sign", "max", "min"))
"""Operations whose branches agree where what decides between them is zero."""
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
    """

    def __init__(self, pool: Pool, known: KnownSigns) -> None:
        self.pool = pool
        self._known = known
        self.positive: dict[int, int] = {}
        """Expression that must be positive, for each factor."""
        self._memo: dict[int, Factors] = {}

    def __call__(self, root: int) -> Factors:
        """Return the factors of an expression's domain."""
        return self.pool.cached(self._memo, root, self._of)

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
        own = {self._inside(part) for part in self._parts(node, operands)}
        for divisor in self._divisors(node, operands):
            own |= {self._outside(region) for region in self._zeros(divisor)}
        return frozenset(own - {self.pool.number(1)}).union(*(self._memo[operand] for operand in operands))

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

    def _divisors(self, node: int, operands: Sequence[int]) -> list[int]:
        """Return the expressions that must not be zero so that an operation on valid operands has a value."""
        operation = self.pool.nodes[node][0]
        if operation == "pow":
            exponent = self.pool.constant(operands[1])
            return [operands[0]] if exponent is not None and exponent < 0 else []
        if operation == "mod":
            return [operands[1]]
        if operation == "atan2":
            return [self.pool.many("add", [self.pool.power(operand, Fraction(2)) for operand in operands])]
        return self._parts(node, operands) if operation in ("log", "atanh") else []

    def _zeros(self, divisor: int) -> Iterator[tuple[Atom, ...]]:
        """Yield the regions, as signs of nodes, where an expression is zero because of the branches that it takes.

        Other zeros have measure zero. Of the infinitely many branches of a step, the one in which it is zero is
        examined.
        """
        if self._known.is_never_zero(divisor):
            return
        steps = [k for k in self.pool.reached(divisor) if self.pool.nodes[k][0] in _ROUNDED][:_MOST_STEPS]
        subsets = (zeros for count in range(len(steps) + 1) for zeros in combinations(steps, count))
        waiting = [dict.fromkeys(zeros, 0) for zeros in subsets]
        for _ in range(_MOST_BRANCHES):
            if not waiting:
                return
            taken = waiting.pop()
            open_ = (k for k in counted(self.pool, divisor, taken) if k not in taken and ways_of(self.pool, k))
            if free := [k for k in open_ if self.pool.nodes[k][0] not in COMPARISONS]:
                waiting += [{**taken, node: way} for node, way in ways_of(self.pool, max(free))]
            elif taken and self._known.is_zero(smooth(self.pool, divisor, taken)):
                yield from self._regions(taken)

    def _regions(self, taken: dict[int, int]) -> Iterator[tuple[Atom, ...]]:
        """Yield the possible alternatives of signs that make nodes take their branches."""
        needed = []
        for node, way in taken.items():
            atoms = [
                tuple((smooth(self.pool, part, taken), sign) for part, sign in required)
                for required in self._requirements(node, way)
            ]
            if self.pool.nodes[node][0] in _EITHER:
                atoms = [tuple(atom for atom in required if not self._known.is_zero(atom[0])) for required in atoms]
            needed.append(atoms)
        for region in every(needed) or []:
            if all(sign for _, sign in region) and not self._known.exclude(region):
                yield tuple(dict.fromkeys(region))

    def _requirements(self, node: int, way: int) -> list[tuple[Atom, ...]]:
        """Return the alternative conditions of a branch, or of a step that is zero; none if there are too many."""
        operation, operands = self.pool.nodes[node][0], self.pool.operands(node)
        if operation not in _ROUNDED:
            return requirements(self.pool, (node, way)) or []
        above = operation == "floor"
        end = difference(self.pool, operands[0], self.pool.number(1 if above else -1))
        return [((operands[0], 1 if above else -1), (end, -1 if above else 1))]

    def _outside(self, region: Sequence[Atom]) -> int:
        """Return the factor that is zero in a region and one elsewhere."""
        zero, one = self.pool.number(0), self.pool.number(1)
        factor = zero
        for node, sign in region:
            comparison = "strictgreaterthan" if sign > 0 else "strictlessthan"
            factor = self._case(self.pool.intern(comparison, node, zero), factor, one)
        return factor

    def _inside(self, part: int) -> int:
        """Return the factor that is one where an expression is positive; one if it provably is everywhere."""
        value = self.pool.constant(part)
        if value is not None or self.pool.nodes[part][0] == "const":
            return self.pool.number(value is None or value >= 0)
        if self._known.is_positive(part) or self._known.never_has(part, -1):
            return self.pool.number(1)
        zero = self.pool.number(0)
        factor = self._case(self.pool.intern("strictgreaterthan", part, zero), self.pool.number(1), zero)
        self.positive[factor] = part
        return factor

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
