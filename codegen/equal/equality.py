# SPDX-License-Identifier: Apache-2.0
"""Decision if two expressions are equal, with a reason and, if they differ, a point.

Methods are tried from cheap to expensive: the same node; the same value in the finite field, with arbitrary functions
in place of maxima, absolute values and the like; ordinary real points; cells with fixed branches. Without branches,
different values in the field prove that expressions differ. With branches, expressions count as equal only after
every branch, and every pair of branches, was reached or excluded. If the field cannot prove equality in a cell, real
points inside the cell decide.
"""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from math import prod
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import mpmath

from ..equations.document import reached
from . import field, reals, slopes
from .branches import COMPARISONS, Way, branching, counted, ways_of
from .domains import Domains
from .meaning import Expression, Flat, Meaning
from .pool import Pool
from .proofs import intervals
from .reals import Point, PointSampler, RealWorld, SteppedWorld, Verdict
from .shared import INEXACT, Shared
from .values import FieldWorld, Lookup, World

if TYPE_CHECKING:
    from .cells import Cells

SEED = 5
"""Seed of the field's points: arbitrary but fixed, so that a question always has the same answer."""
_POINTS = 3
"""Number of field points. Different functions agree at one by chance with probability degree / 2^89. Three also check
the arithmetic; matching by value needs two.
"""
_ROOTED = 32
"""Number of field points for expressions with even roots. A root of a square has a random sign, for (a + b)^2 that of
a + b at every second point. Three points have this sign in one of 8 cases, 32 points in one of 2^32.
"""
_BRANCHED = 64
"""Number of real points, and of field points with signs, for two branching nodes. They miss one of the four joint
branches in one of 10^8 cases. Each further node doubles branches and points.
"""
_MOST_SIGNED = 512
"""Largest number of field points with signs: enough for all joint branches of five nodes. With more nodes real points
decide. Twice as many points cost seconds per law and add one node.
"""
_SIGNS = 64
"""Number of sign choices of roots that are compared at a field point: all choices of six roots."""
_ARCS = frozenset(("asin", "acos", "atan", "atan2"))
"""Functions whose angle the field represents by a root: acos(cos(a)) is a or -a at random."""
_LOOKS, _LOOK_DIGITS = 8, 12
"""Numbers of points and digits with which presumably equal parts of both sides are paired before the comparison.
Fewer points pair unequal parts; with more digits, rounding separates equal parts.
"""
_MOST_DOUBTFUL = 24
"""Largest number of branch combinations for which real points are searched; further ones are similar."""
_FEW = 16
"""Number of points with values on both sides from which agreement counts; fewer may not reach all branches."""
_DRAWS = 4
"""Number of field points that are tried for each needed one; nested roots exist at every second or fourth point."""
_HOPELESS = 48
"""Number of points without a value after which the search stops; 99 of 100 searches find a domain of 0.1 earlier."""
_MOST_NAMES = 60
"""Largest number of names that are set to extreme values in turn; each costs two evaluations of all expressions."""
_SQUARES = 64
"""Number of field points at which all values of a square must be squares; other functions pass once in 2^64 cases."""
_LEAST = Fraction(1, 10**300)
"""Smallest positive number in proofs with doubles: smaller doubles have fewer digits."""
VISIBLE = 1e-4
"""Relative difference that a counterexample must show, so that at least two of six printed digits differ."""
_PASSES = 2
"""Number of passes over all names, because some names allow a simple value only after others have one."""
_TRIES = 6
"""Number of points that are tried for each needed one, enough if a sixth of them is in the domain."""


class Worlds:
    """Evaluations of expressions with several meanings at one point."""

    def __init__(self, make: Callable[[Pool, Lookup], World[Any]]) -> None:
        self._make = make
        self._worlds: dict[Meaning, World[Any]] = {}

    def __getitem__(self, meaning: Meaning) -> Any:
        if meaning not in self._worlds:
            self._worlds[meaning] = self._make(meaning.pool, lambda name: self._lookup(meaning, name))
        return self._worlds[meaning]

    def __iter__(self) -> Iterator[Any]:
        return iter(self._worlds.values())

    def again(self) -> Worlds:
        """Return empty evaluations at the same point."""
        return Worlds(self._make)

    def _lookup(self, meaning: Meaning, name: str) -> tuple[World[Any], int] | None:
        target = meaning.targets(name)
        return None if target is None else (self[target[0]], target[1])


class EqualityTest:
    """Test of equality, which evaluates at a fixed sequence of points and caches the values.

    Parameters
    ----------
    pool : Pool
        Pool of all expressions.
    positive : callable
        True for a positive free name.
    sampler : PointSampler
        Draws real values of free names.
    seed : int
        Seed of the points of the field.

    Attributes
    ----------
    written_out : Flat
        Expands an expression until all names are free.
    """

    def __init__(self, pool: Pool, positive: Callable[[str], bool], sampler: PointSampler, seed: int = SEED) -> None:
        self.pool = pool
        self.positive = positive
        self.sampler = sampler
        self.seed = seed
        self._plain = [self.at(k) for k in range(_POINTS)]
        self._signed: list[Worlds] = []
        self._real: list[Worlds] = []
        self._rooted: dict[Expression, bool] = {}
        self._free = Meaning(pool, lambda _: None)
        self._squares: dict[int, bool] = {}
        self.written_out = Flat(pool)
        self._domain = Domains(pool, self._is_positive, self._never_has, shortest=False)
        self._shared = Shared(pool, self._values_of, self._look_of, self._points_of)
        self._needed = Domains(pool, self._is_positive, self._never_has, shortest=True)

    def how(self, *sides: Expression) -> str:
        """Return the reason for equality in the field as text."""
        return f"{self.count(*sides)} points of a {field.BITS}-bit field, seed {self.seed}"

    def is_rooted(self, *sides: Expression) -> bool:
        """Return True if an expression has even roots, whose signs in the field are random."""
        return self.count(*sides) == _ROOTED

    def count(self, *sides: Expression) -> int:
        """Return the number of field points needed to decide equality of expressions."""
        return _ROOTED if any(self._is_rooted(*side) for side in sides) else _POINTS

    def _is_rooted(self, meaning: Meaning, root: int) -> bool:
        """Return True if an expression has an even root whose operand may be the square of a signed value."""
        if (meaning, root) not in self._rooted:
            for node in reached(self.pool.nodes, [root]):
                if (meaning, node) not in self._rooted:
                    self._rooted[meaning, node] = self._is_root(meaning, node)
        return self._rooted[meaning, root]

    def _is_root(self, meaning: Meaning, node: int) -> bool:
        """Return True if a node is, or depends on, an even root or inverse function: the field draws its sign."""
        operation, *operands = self.pool.nodes[node]
        if operation == "sym":
            target = meaning.targets(operands[0])
            return target is not None and self._is_rooted(*target)
        if operation in _ARCS or any(self._rooted[meaning, operand] for operand in self.pool.operands(node)):
            return True
        inner, exponent = self.pool.raised(node)
        if exponent.denominator % 2:
            return False
        base, *names = self.pool.nodes[inner]
        return base != "num" and (base != "sym" or meaning.targets(names[0]) is not None)

    def at(
        self,
        number: int,
        interpreted: bool = False,
        fixed: Mapping[str, field.Element] = MappingProxyType({}),
        roots: Callable[[field.Element], field.Element] = field.sqrt,
    ) -> Worlds:
        """Return new evaluations at a point of the field, with optional values of names and signs of roots."""
        seed = 100_000 * self.seed + number
        return Worlds(lambda pool, lookup: FieldWorld(pool, lookup, seed, self.positive, interpreted, fixed, roots))

    def point(self, number: int) -> Worlds:
        """Return the cached evaluations at a point of the field."""
        while number >= len(self._plain):
            self._plain.append(self.at(len(self._plain)))
        return self._plain[number]

    def values(self, meaning: Meaning, root: int, count: int = _POINTS) -> tuple[Any, ...]:
        """Return the values of an expression at points of the field; None for missing ones."""
        return tuple(self.point(number)[meaning].defined(root) for number in range(count))

    def decide(self, old: Expression, new: Expression) -> Verdict:
        """Decide whether two expressions are the same function."""
        if old[1] == new[1] and old[0] is new[0]:
            return Verdict(True, "node identity")
        return self.where_defined(self._by_values(old, new), old, new)

    def where_defined(self, verdict: Verdict, old: Expression, new: Expression) -> Verdict:
        """Compare the domains of two sides: the verdict is "different" if only one has a value at some point."""
        roots = self.written_out(old), self.written_out(new)
        if verdict.equal is False or self._domain(roots[0]) == self._domain(roots[1]):
            return verdict
        first, second = map(self._needed, roots)
        if first == second:
            return verdict
        outcome = self._by_cells(self._needed.product(first), self._needed.product(second))
        if outcome.equal:
            return replace(verdict, how=f"{verdict.how}; both sides exist together at {outcome.how}")
        if verdict.equal is None and outcome.equal is None:
            return verdict
        how = "where both sides exist they are equal, but " if verdict.equal else ""
        how += "only one of them does at a point" if outcome.equal is False else f"of their domains: {outcome.how}"
        point = outcome.point and {**self._drawn(old, new), **outcome.point}
        return Verdict(outcome.equal, how, point=point)

    def _drawn(self, *sides: Expression) -> dict[str, Fraction]:
        """Return drawn values of all names that expressions depend on."""
        point = self.sampler.point(0)
        return {name: point[name] for side in sides for name in side[0].free(side[1])}

    def _is_positive(self, node: int) -> bool:
        return intervals.impossible(self.pool, [(node, -1)], self._bounds())

    def _never_has(self, node: int, sign: int) -> bool:
        """Return True if an expression never has this sign, because it or its negative is a square.

        An expression whose values at many field points are squares is a number times a square. A real point gives the
        sign of the number.
        """
        if node not in self._squares:
            self._squares[node] = self._is_square(node)
        if not self._squares[node]:
            return False
        worlds = next(iter(self.real_points([(self._free, node)], 1)), None)
        value = None if worlds is None else worlds[self._free].value(node)
        return value is not None and bool(value * sign < 0)

    def _is_square(self, node: int) -> bool:
        """Return True if an expression, its negative, or its product with a positive inner sum is probably a square."""
        sums = (part for part in reached(self.pool.nodes, [node]) if self.pool.nodes[part][0] == "add")
        return any(
            self._has_one_sign(factors) for factors in ([node], *([node, part] for part in sums if part != node))
        )

    def _has_one_sign(self, factors: Sequence[int]) -> bool:
        signs: set[int] = set()
        for number in range(_SQUARES):
            values = [self.point(number)[self._free].defined(factor) for factor in factors]
            signs.add(prod(field.sign(value) if isinstance(value, int) else 0 for value in values))
            if len(signs) > 1 or 0 in signs:
                return False
        return all(self._is_positive(factor) for factor in factors[1:])

    def _by_values(self, old: Expression, new: Expression) -> Verdict:
        """Decide if two expressions have equal values at all points where both have a value."""
        equal = self.same_in_field(old, new)
        if equal:
            return Verdict(True, self.how(old, new))
        worlds = self._plain[0]
        if equal is False and worlds[old[0]].exact(old[1]) and worlds[new[0]].exact(new[1]):
            return Verdict(False, self.how())
        return self._by_reals(old, new)

    def same_in_field(self, old: Expression, new: Expression) -> bool | None:
        """Compare values at the first points where both exist; None if there are too few."""
        same = self._same_at(old, new, _POINTS)
        return self._same_at(old, new, _ROOTED) if same and self.count(old, new) == _ROOTED else same

    def _same_at(self, old: Expression, new: Expression, count: int) -> bool | None:
        """Return True if both sides agree at `count` points where both exist; None if there are too few."""
        matches = 0
        for number in range(count * _DRAWS):
            worlds = self.point(number)
            a, b = worlds[old[0]].defined(old[1]), worlds[new[0]].defined(new[1])
            if a is None or b is None:
                continue
            if a != b:
                return False
            matches += 1
            if matches == count:
                return True
        return None

    def _by_branches(self, old: Expression, new: Expression) -> Verdict:
        """Decide by cells, if needed with free numbers in place of common parts."""
        roots = self.written_out(old), self.written_out(new)
        if roots[0] == roots[1]:
            return Verdict(True, "the same expression with all definitions inserted")
        verdict = self._by_parts(*roots)
        if not verdict.points:
            return verdict
        used = {self.pool.nodes[node][0] for node in reached(self.pool.nodes, roots)} & INEXACT or {"roots"}
        evidence = f"compared at {verdict.points} points with {reals.DIGITS} digits: {', '.join(sorted(used))}"
        return replace(
            verdict, how=f"{verdict.how}; {evidence} {'is' if len(used) == 1 else 'are'} not decided exactly"
        )

    def _by_parts(self, old: int, new: int) -> Verdict:
        """Decide by cells, first by points, then with free numbers in place of common parts."""
        cells = self._cells(old, new)
        if outcome := cells.walk():
            return outcome
        simple = self._shared.united(old, new)
        if simple[0] == simple[1]:
            return Verdict(True, "the same expression with equal parts merged")
        united = self._cells(*simple)
        if united.open_states() == []:
            return united.settle([])
        *simpler, points = self._shared.freed(*simple)
        if simpler != [old, new] and (verdict := self._by_cells(*simpler)).equal:
            return replace(verdict, points=min(filter(None, (points, verdict.points)), default=0))
        return self._settled(cells, old, new)

    def _points_of(self, old: int, new: int) -> int | None:
        """Return the number of agreeing points; 0 if equality is proved, None if the sides are not equal."""
        verdict = self._by_cells(old, new)
        return verdict.points if verdict.equal else None

    def _values_of(self, node: int) -> tuple[Any, ...]:
        """Return enough field values of a node to identify equal nodes."""
        return self.values(self._free, node, self.count((self._free, node)))

    def _look_of(self, node: int) -> tuple[str, ...]:
        """Return an expression's values at a few real points; parts with the same values are paired."""
        worlds = self._real[:_LOOKS]
        return tuple(
            mpmath.nstr(value, _LOOK_DIGITS) for w in worlds if (value := w[self._free].defined(node)) is not None
        )

    def _by_cells(self, old: int, new: int) -> Verdict:
        if old == new:
            return Verdict(True, "the same expression with equal parts merged")
        cells = self._cells(old, new)
        if outcome := cells.walk():
            return outcome
        return self._settled(cells, old, new)

    def _cells(self, old: int, new: int) -> Cells:
        from .cells import Cells  # imports numpy, which most comparisons do not need

        return Cells(
            self.pool, self.sampler, self._bounds(), lambda point: self.real(point)[self._free], self._smooth_sides,
            self._never_has, (old, new), self._domain.inside(old, new),
        )  # fmt: skip

    def _settled(self, cells: Cells, old: int, new: int) -> Verdict:
        """Decide after a walk without a difference: by joint states, and for open ones by the field with signs."""
        states = cells.open_states()
        outcome = None if states is None else cells.settle(states)
        if outcome is None or outcome.equal is None:
            doubtful, count = self._doubtful(old, new)
            if count and not doubtful:
                return Verdict(True, f"{count} points of a {field.BITS}-bit field with signs, {cells.points}")
            if count or outcome is None:
                outcome = cells.decide(doubtful, bool(count))
        return outcome

    def never_zero(self, expression: Expression) -> bool:
        """Return True if an expression is provably never zero within the bounds of its names."""
        stack = [self.written_out(expression)]
        while stack:
            operation, *operands = self.pool.nodes[node := stack.pop()]
            if operation == "mul":
                stack += operands
            elif operation == "pow":
                stack.append(operands[0])
            elif operation != "exp" and not intervals.impossible(self.pool, [(node, 0)], self._bounds()):
                return False
        return True

    def _bounds(self) -> dict[str, tuple[Fraction | None, Fraction | None]]:
        """Return the bounds of all free names; the lower bound of a positive name is above zero."""
        bounds = {name: row[:2] for name, row in self.sampler.names.items()}
        return {
            name: (_LEAST if low == 0 and self.positive(name) else low, high) for name, (low, high) in bounds.items()
        }

    def _smooth_sides(self, old: int, new: int) -> bool | None:
        """Return True if two expressions without branches are equal; None if the field proves no difference."""
        equal = old == new or self.same_in_field((self._free, old), (self._free, new))
        if equal is not False:
            return equal
        return False if self._are_apart(old, new) or self._have_other_slopes(old, new) else None

    def _are_apart(self, old: int, new: int) -> bool:
        """Return True if the field proves a difference, at some point and for all signs of the roots."""
        world = self._plain[0][self._free]
        if not all(world.exact(root, rooted=True) for root in (old, new)):
            return False
        if all(world.exact(root) for root in (old, new)):
            return self.same_in_field((self._free, old), (self._free, new)) is False
        return any(self._never_meet(old, new, number) for number in range(_POINTS))

    def _never_meet(self, old: int, new: int, number: int) -> bool:
        """Return True if two expressions differ at a field point for all signs of their roots."""
        waiting = [field.Roots()]
        for _ in range(_SIGNS):
            roots = waiting.pop()
            world = self.at(number, roots=roots)[self._free]
            a, b = world.defined(old), world.defined(new)
            if a is None or b is None or a == b:
                return False
            waiting += roots.others()
            if not waiting:
                return True
        return False

    def _have_other_slopes(self, old: int, new: int) -> bool:
        """Return True if the field proves that derivatives differ, which reveals differences between the test points.

        The field does not know logarithms and arcs, but it knows their derivatives.
        """
        for name in sorted(slopes.names(self.pool, old) | slopes.names(self.pool, new)):
            first, second = (slopes.slope(self.pool, root, name) for root in (old, new))
            if first is not None and second is not None and self._are_apart(first, second):
                return True
        return False

    def _doubtful(self, old: int, new: int) -> tuple[list[tuple[Way, ...]], int]:
        """Return the branch combinations in which the field shows a difference, and the number of compared points.

        Signs in the field are random and multiplicative, so some combinations may be impossible for real numbers. The
        number is zero if there are too few points for all joint branches.
        """
        units = [node for node in branching(self.pool, [old, new]) if ways_of(self.pool, node)]
        needed = _BRANCHED << max(len(units) - 2, 0)
        left = {way for node in units for way in ways_of(self.pool, node)}
        states: dict[tuple[Way, ...], None] = {}
        matches = 0
        for number in range(4 * min(needed, _MOST_SIGNED)):
            if number == len(self._signed):
                self._signed.append(self.at(10_000 + number, interpreted=True))
            world = self._signed[number][self._free]
            a, b = world.defined(old), world.defined(new)
            if a is None or b is None or isinstance(a, field.Complex) or isinstance(b, field.Complex):
                if number > _HOPELESS and not matches:
                    break
                continue
            matches += 1
            ways = self._ways_at(world, units, old, new)
            left -= {*ways}
            if a != b:
                states[ways] = None
            if matches == min(needed, _MOST_SIGNED) or len(states) == _MOST_DOUBTFUL:
                break
        return list(states), matches if matches == needed and not left else 0

    def _ways_at(self, world: FieldWorld, units: Sequence[int], old: int, new: int) -> tuple[Way, ...]:
        taken = {
            node: int(world.value(node)) if self.pool.nodes[node][0] in COMPARISONS else world.ways[node]
            for node in units
            if world.memo.get(node) is not None
        }
        counting = counted(self.pool, old, taken) | counted(self.pool, new, taken)
        return tuple(sorted((node, taken[node]) for node in counting if node in taken))

    def real_points(
        self,
        pairs: Sequence[Expression],
        count: int,
        domain: Sequence[Expression] = (),
        tries: int = _TRIES,
        hopeless: int = _HOPELESS,
    ) -> Iterator[Worlds]:
        """Yield evaluations at points where all expressions are real and those of the domain are positive.

        The points are reproducible. There may be fewer than `count`.

        Parameters
        ----------
        pairs, domain : sequence of Expression
            Expressions that must have a value, and those that must be positive.
        count : int
            Number of points.
        tries : int
            Points tried for each one.
        hopeless : int
            Points without a value after which the search stops.
        """
        matches = 0
        for number in range(count * tries):
            while number >= len(self._real):
                self._real.append(self.real(self.sampler.point(len(self._real))))
            worlds = self._real[number]
            if inside(worlds, domain) and all(worlds[meaning].defined(root) is not None for meaning, root in pairs):
                yield worlds
                matches += 1
            if matches == count or (not matches and number >= hopeless):
                return

    def real(self, point: Point) -> Worlds:
        """Return new evaluations at a real point."""
        return Worlds(lambda pool, lookup: RealWorld(pool, lookup, point))

    def stepped(self, point: Point) -> Worlds:
        """Return new evaluations at a real point on a step."""
        return Worlds(lambda pool, lookup: SteppedWorld(pool, lookup, point))

    def _by_reals(self, old: Expression, new: Expression) -> Verdict:
        """Decide by points with 50 digits, also where only one side exists; without a difference, by branches."""
        matches = 0
        for worlds in self.real_points([old, new], _BRANCHED):
            matches += 1
            if self.differ(worlds, old, new):
                return Verdict(False, f"a point with {reals.DIGITS} digits")
        if matches < _FEW:
            for side, other, name in ((old, new, "old"), (new, old, "new")):
                alone = sum(
                    1 for worlds in self.real_points([side], _FEW) if worlds[other[0]].defined(other[1]) is None
                )
                if alone == _FEW:
                    return Verdict(False, f"only the {name} side exists at {alone} points")
            return Verdict(None, f"no difference, but both sides exist at only {matches} of the points tried")
        return self._by_branches(old, new)

    def extreme_points(self, old: Expression, new: Expression) -> Iterator[Worlds]:
        """Yield evaluations with one free name at a time at an extreme value."""
        base = self.sampler.point(0)
        for name in sorted({*old[0].free(old[1]), *new[0].free(new[1])})[:_MOST_NAMES]:
            for value in self.sampler.extremes(name):
                worlds = self.real(ChainMap({name: value}, base))  # type: ignore[arg-type]
                if all(worlds[meaning].defined(root) is not None for meaning, root in (old, new)):
                    yield worlds

    @staticmethod
    def one_exists(worlds: Worlds, old: Expression, new: Expression) -> bool:
        """Return True if exactly one of two expressions has a value at a real point."""
        return (worlds[old[0]].defined(old[1]) is None) is not (worlds[new[0]].defined(new[1]) is None)

    @staticmethod
    def differ(worlds: Worlds, old: Expression, new: Expression) -> bool:
        """Return True if two expressions have different values at a real point."""
        looks = iter((worlds, worlds.again()))

        def sides() -> tuple[reals.Sized, reals.Sized] | None:
            look = next(looks)
            first, second = look[old[0]], look[new[0]]
            a, b = first.defined(old[1]), second.defined(new[1])
            return None if a is None or b is None else ((a, first.size(old[1])), (b, second.size(new[1])))

        return reals.differ(sides)


def simplified(
    point: Mapping[str, Fraction],
    candidates: Callable[[str, Fraction], Iterable[Fraction]],
    fails: Callable[[Point], bool],
) -> dict[str, Fraction]:
    """Simplify the coordinates of a point of difference, name by name."""
    simple = dict(point)
    for _ in range(_PASSES):
        for name in (name for name in sorted(point) if simple[name] == point[name]):
            for value in candidates(name, simple[name]):
                if fails({**simple, name: value}):
                    simple[name] = value
                    break
    return simple


def inside(worlds: Worlds, domain: Sequence[Expression]) -> bool:
    """Return True if all expressions of a domain are positive at a real point."""
    values = (worlds[meaning].defined(root) for meaning, root in domain)
    return all(value is not None and value > 0 for value in values)


def shown(worlds: Worlds, old: Expression, new: Expression) -> tuple[str, str]:
    """Return two values at a real point with six, twelve, ... digits, until they differ."""
    digits = 6
    while True:
        first, second = (_shown(worlds, expression, digits) for expression in (old, new))
        if first != second or digits > reals.DIGITS:
            return first, second
        digits *= 2


def _shown(worlds: Worlds, expression: Expression, digits: int) -> str:
    """Return a real value as text: "no value" without one, zero for rounding error."""
    meaning, root = expression
    value = worlds[meaning].defined(root)
    if value is None:
        return "no value"
    if isinstance(value, bool | tuple):
        return str(value)
    if reals.vanishes(value, worlds[meaning].size(root)):
        return "0.0"
    return str(mpmath.nstr(value, digits, strip_zeros=True))
