# SPDX-License-Identifier: Apache-2.0
"""Points at which expressions are evaluated: a fixed sequence in the finite field, and real points."""

from __future__ import annotations

from collections import ChainMap, defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import Any

from . import field, reals
from .meaning import Expression, Meaning
from .pool import Pool
from .reals import RealWorld, SteppedWorld
from .sampler import Point, PointSampler
from .values import FieldWorld, Lookup, World

SEED = 5
"""Seed of the field's points: arbitrary but fixed, so that a question always has the same answer."""
POINTS = 3
"""Number of field points. Different functions agree at one by chance with probability degree / 2^89. Three also check
the arithmetic; matching by value needs two.
"""
_ROOTED = 32
"""Number of field points for expressions with even roots. A root of a square has a random sign, for (a + b)^2 that of
a + b at every second point. Three points have this sign in one of 8 cases, 32 points in one of 2^32.
"""
_ARCS = frozenset(("asin", "acos", "atan", "atan2"))
"""Functions whose angle the field represents by a root: acos(cos(a)) is a or -a at random."""
_DRAWS = 4
"""Number of field points that are tried for each needed one; nested roots exist at every second or fourth point."""
_TRIES = 6
"""Number of real points that are tried for each needed one, enough if a sixth of them is in the domain."""
_HOPELESS = 48
"""Number of points without a value after which the search stops; 99 of 100 searches find a domain of 0.1 earlier."""
_MOST_NAMES = 60
"""Largest number of names that are set to extreme values in turn; each costs two evaluations of all expressions."""


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

    def value(self, expression: Expression) -> Any:
        """Return the value of an expression; None if it has none."""
        meaning, root = expression
        return self[meaning].defined(root)

    def sized(self, expression: Expression) -> reals.Sized | None:
        """Return the real value of an expression with its size; None if it has none."""
        value, (meaning, root) = self.value(expression), expression
        return None if value is None else (value, self[meaning].size(root))

    def _lookup(self, meaning: Meaning, name: str) -> tuple[World[Any], int] | None:
        target = meaning.targets(name)
        return None if target is None else (self[target[0]], target[1])


class FieldPoints:
    """Fixed sequence of points of the finite field, with cached values.

    Parameters
    ----------
    pool : Pool
        Pool of all expressions.
    positive : callable
        True for a positive free name.
    seed : int
        Seed of the points.
    """

    def __init__(self, pool: Pool, positive: Callable[[str], bool], seed: int = SEED) -> None:
        self.pool = pool
        self.positive = positive
        self.seed = seed
        self._worlds: list[Worlds] = []
        self._rooted: dict[Meaning, dict[int, bool]] = defaultdict(dict)

    def at(
        self,
        number: int,
        fixed: Mapping[str, field.Element] = MappingProxyType({}),
        roots: Callable[[field.Element], field.Element] = field.sqrt,
    ) -> Worlds:
        """Return new evaluations at a point, with optional values of names and signs of roots."""
        seed = 100_000 * self.seed + number
        return Worlds(lambda pool, lookup: FieldWorld(pool, lookup, seed, self.positive, fixed, roots))

    def __getitem__(self, number: int) -> Worlds:
        while number >= len(self._worlds):
            self._worlds.append(self.at(len(self._worlds)))
        return self._worlds[number]

    def values(self, meaning: Meaning, root: int, count: int = POINTS) -> tuple[Any, ...]:
        """Return the values of an expression at the first points; None for missing ones."""
        return tuple(self[number][meaning].defined(root) for number in range(count))

    def same(self, old: Expression, new: Expression) -> bool | None:
        """Compare values at the first points where both exist; None if there are too few."""
        same = self._same_at(old, new, POINTS)
        return self._same_at(old, new, _ROOTED) if same and self.is_rooted(old, new) else same

    def how(self, *sides: Expression) -> str:
        """Return the reason for equality as text."""
        return f"{self.count(*sides)} points of a {field.BITS}-bit field, seed {self.seed}"

    def is_rooted(self, *sides: Expression) -> bool:
        """Return True if an expression has even roots, whose signs in the field are random."""
        return any(self._is_rooted(*side) for side in sides)

    def count(self, *sides: Expression) -> int:
        """Return the number of points needed to decide equality of expressions."""
        return _ROOTED if self.is_rooted(*sides) else POINTS

    def _same_at(self, old: Expression, new: Expression, count: int) -> bool | None:
        """Compare values at a number of points where both exist; None if there are too few."""
        matches = 0
        for number in range(count * _DRAWS):
            a, b = self[number].value(old), self[number].value(new)
            if a is None or b is None:
                continue
            if a != b:
                return False
            matches += 1
            if matches == count:
                return True
        return None

    def _is_rooted(self, meaning: Meaning, root: int) -> bool:
        """Return True if an expression has an even root whose operand may be the square of a signed value."""
        return self.pool.cached(self._rooted[meaning], root, lambda node: self._is_root(meaning, node))

    def _is_root(self, meaning: Meaning, node: int) -> bool:
        """Return True if a node is, or depends on, an even root or inverse function: the field draws its sign."""
        operation, *operands = self.pool.nodes[node]
        if operation == "sym":
            target = meaning.targets(operands[0])
            return target is not None and self._is_rooted(*target)
        if operation in _ARCS or any(self._rooted[meaning][operand] for operand in self.pool.operands(node)):
            return True
        inner, exponent = self.pool.raised(node)
        if exponent.denominator % 2:
            return False
        base, *names = self.pool.nodes[inner]
        return base != "num" and (base != "sym" or meaning.targets(names[0]) is not None)


class RealPoints:
    """Real points, drawn in a fixed sequence or given, at which expressions are evaluated with 50 digits.

    Parameters
    ----------
    sampler : PointSampler
        Draws values of free names.
    """

    def __init__(self, sampler: PointSampler) -> None:
        self.sampler = sampler
        self._worlds: list[Worlds] = []

    def __getitem__(self, number: int) -> Worlds:
        while number >= len(self._worlds):
            self._worlds.append(self.at(self.sampler.point(len(self._worlds))))
        return self._worlds[number]

    def at(self, point: Point) -> Worlds:
        """Return new evaluations at a point."""
        return Worlds(lambda pool, lookup: RealWorld(pool, lookup, point))

    def stepped(self, point: Point) -> Worlds:
        """Return new evaluations at a point on a step."""
        return Worlds(lambda pool, lookup: SteppedWorld(pool, lookup, point))

    def where(
        self,
        sides: Sequence[Expression],
        count: int,
        domain: Sequence[Expression] = (),
        tries: int = _TRIES,
        hopeless: int = _HOPELESS,
    ) -> Iterator[Worlds]:
        """Yield evaluations at points where all expressions are real and those of the domain are positive.

        The points are reproducible. There may be fewer than `count`.

        Parameters
        ----------
        sides, domain : sequence of Expression
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
            worlds = self[number]
            if inside(worlds, domain) and all(worlds.value(side) is not None for side in sides):
                yield worlds
                matches += 1
            if matches == count or (not matches and number >= hopeless):
                return

    def extremes(self, old: Expression, new: Expression) -> Iterator[Worlds]:
        """Yield evaluations with one free name at a time at an extreme value."""
        base = self.sampler.point(0)
        for name in sorted({*old[0].free(old[1]), *new[0].free(new[1])})[:_MOST_NAMES]:
            for value in self.sampler.extremes(name):
                worlds = self.at(ChainMap({name: value}, base))  # type: ignore[arg-type]
                if all(worlds.value(side) is not None for side in (old, new)):
                    yield worlds


def inside(worlds: Worlds, domain: Sequence[Expression]) -> bool:
    """Return True if all expressions of a domain are positive at a real point."""
    values = map(worlds.value, domain)
    return all(value is not None and value > 0 for value in values)


def one_exists(worlds: Worlds, old: Expression, new: Expression) -> bool:
    """Return True if exactly one of two expressions has a value at a real point."""
    return (worlds.value(old) is None) is not (worlds.value(new) is None)


def differ(worlds: Worlds, old: Expression, new: Expression) -> bool:
    """Return True if two expressions differ at a real point, and still differ when computed with twice the digits.

    Sizes ignore the amplification of errors by functions such as `atanh` near one. More digits remove such errors.
    """
    first, second = worlds.sized(old), worlds.sized(new)
    if first is None or second is None or not reals.apart(first, second):
        return False
    with reals.digits_doubled():
        again = worlds.again()
        one, other = again.sized(old), again.sized(new)
        if one is None or other is None or any(isinstance(side[0], bool | tuple) for side in (first, second)):
            return one is not None and other is not None and reals.apart(one, other)
        return bool(2 * abs(one[0] - other[0]) > abs(first[0] - second[0]))
