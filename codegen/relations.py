# SPDX-License-Identifier: Apache-2.0
"""Whether a printed relation holds once every symbol has its derived meaning.

Equal forms are proved. What has no such proof is tested at random points with 50 digits, drawn from the bounds of the
names; that finds every difference that is not confined to a set of measure zero, a branch that was not visited, or an
amount below 1e-40.
"""

from __future__ import annotations

import functools
import random
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace

import mpmath  # type: ignore[import-untyped]
import sympy as sp

from models.derivation import Expr
from models.mechanics import reduce_sines
from models.paper import Case, Name, Names, Relation, Side, symbols_of

_DIGITS = 50
_TOLERANCE = mpmath.mpf(10) ** -40
_VISIBLE = mpmath.mpf(10) ** -6
"""Relative difference that a counterexample shows."""
_POINTS, _BRANCHED_POINTS, _INEQUALITY_POINTS = 16, 64, 256
_DRAWS = 200
"""Attempts for each point wanted, before a domain counts as not found."""
_PROVABLE = 250
"""Operations up to which a normal form is tried."""
_BRANCHING = (sp.Abs, sp.sign, sp.Max, sp.Min, sp.Piecewise, sp.atan2, sp.acos, sp.asin)
_UNEVALUATED = (sp.Integral, sp.Derivative, sp.Limit, sp.Sum, sp.UnevaluatedExpr)
_OPS: dict[str, Callable[[mpmath.mpf, mpmath.mpf], bool]] = {
    "<": lambda a, b: a < b,
    "<=": lambda a, b: a <= b + _TOLERANCE * (1 + abs(b)),
    ">": lambda a, b: a > b,
    ">=": lambda a, b: a >= b - _TOLERANCE * (1 + abs(b)),
}

Point = Mapping[Expr, sp.Rational]


@dataclass(frozen=True)
class Counterexample:
    """Values at which a printed relation fails.

    Attributes
    ----------
    at : tuple of (str, str)
        Names and their exact values, members of a family first; names that are not listed do not matter.
    left, right : str
        Both sides of the printed relation there, to six digits; for an equation of motion, the printed left minus right
        and the derived residual.
    """

    at: tuple[tuple[str, str], ...]
    left: str
    right: str


@dataclass(frozen=True)
class Comparison:
    """Whether a relation holds (None: could not be decided), how that is known, and where it fails."""

    equal: bool | None
    how: str
    counterexample: Counterexample | None = None


@dataclass(frozen=True)
class _Pair:
    """Two numbers to compare, written in free names."""

    left: Expr
    right: Expr
    op: str
    within: Expr
    domain: tuple[Expr, ...]


def compare(relation: Relation, names: Names, left: Side | None = None, right: Side | None = None) -> Comparison:
    """Decide a relation.

    Parameters
    ----------
    relation : Relation
        Its cases, domain and tolerance count in any case.
    names : Names
        The meanings.
    left, right : Expr or Matrix, optional
        Sides to judge in place of the printed ones.
    """
    left = relation.left if left is None else left
    right = relation.right if right is None else right
    results = []
    for case in relation.cases:
        pairs = _pairs(relation, left, right, names, case)
        if isinstance(pairs, str):
            return Comparison(False, pairs)
        results += [_in_case(_decide(pair, names), case) for pair in pairs]
    worst = next((r for r in results if r.equal is False), None) or next((r for r in results if r.equal is None), None)
    return worst or Comparison(True, _weakest(result.how for result in results))


def _in_case(result: Comparison, case: Case) -> Comparison:
    """Say in a counterexample which members of a family it is about."""
    found = result.counterexample
    if found is None:
        return result
    members = tuple((str(name), str(meaning)) for name, meaning in case.items() if not sp.sympify(meaning).args)
    return replace(result, counterexample=replace(found, at=(*members, *found.at)))


def _weakest(hows: Iterable[str]) -> str:
    """Sum up how several comparisons are known: as sure as the least sure of them."""
    found = list(dict.fromkeys(hows))
    return next((how for how in found if not how.startswith("proved")), found[0])


def _pairs(relation: Relation, left: Side, right: Side, names: Names, case: Case) -> list[_Pair] | str:
    """Write both sides out entry by entry; say so in words when their shapes differ."""
    domain = tuple(_number(write_out(expr, names, case)) for expr in relation.domain)
    written = [write_out(side, names, case) for side in (left, right)]
    shapes = [_shape(side) for side in written]
    if shapes[0] != shapes[1]:
        return f"proved: {_named(shapes[0])} cannot equal {_named(shapes[1])}"
    if relation.against is not None:
        written = [written[0] - written[1], write_out(relation.against, names, case)]
    entries = zip(_entries(written[0]), _entries(written[1]), strict=True)
    return [_Pair(a, b, relation.op, relation.within, domain) for a, b in entries]


def write_out(side: Side, names: Names, case: Case) -> Side:
    """Replace every name by its meaning, down to free names, and carry out what is written unevaluated.

    Raises
    ------
    ValueError
        If meanings refer to each other in a circle.
    """
    meanings = {name.symbol: name.meaning for name in names.table.values() if name.meaning is not None} | dict(case)
    written = sp.sympify(side)
    for _ in range(len(meanings) + 1):
        found = {symbol: _frozen(meanings[symbol]) for symbol in symbols_of(written) if symbol in meanings}
        if not found:
            return _carried_out(written)
        written = written.xreplace(found)
    raise ValueError(f"the meanings of {sorted(map(str, found))} refer to each other in a circle")


def _frozen(side: Side) -> Side:
    return side.as_immutable() if isinstance(side, sp.MatrixBase) else sp.sympify(side)


def _carried_out(side: Side) -> Side:
    if isinstance(side, sp.MatrixExpr) or side.has(sp.MatrixExpr, sp.Trace, *_UNEVALUATED):
        side = side.doit()
    return side.as_explicit() if isinstance(side, sp.MatrixExpr) else side


def _shape(side: Side) -> tuple[int, int]:
    return tuple(side.shape) if isinstance(side, sp.MatrixBase) else (1, 1)


def _named(shape: tuple[int, int]) -> str:
    return "a number" if shape == (1, 1) else f"a {shape[0]} x {shape[1]} matrix"


def _entries(side: Side) -> list[Expr]:
    return list(side) if isinstance(side, sp.MatrixBase) else [side]


def _number(side: Side) -> Expr:
    return side[0] if isinstance(side, sp.MatrixBase) else side


def _decide(pair: _Pair, names: Names) -> Comparison:
    """Compare two numbers: their form first, then random points, then a normal form."""
    if pair.op == "=" and pair.left == pair.right:
        return Comparison(True, "proved: both sides are the same expression")
    if any(expr.has(sp.oo, -sp.oo, sp.nan, sp.zoo) for expr in (pair.left, pair.right)):
        return Comparison(False, f"proved: {pair.left} is not {pair.right}")
    test = _Test(pair, names)
    points = list(test.points())
    if len(points) < test.wanted:
        return Comparison(None, f"only {len(points)} of {test.wanted} points were found at which both sides exist")
    bad = next((point for point in points if test.fails(point)), None)
    if bad is not None:
        return Comparison(False, "differs at 50 digits", test.simplest(bad))
    if not test.symbols:
        return Comparison(True, f"compared as numbers, within {pair.within}" if pair.within else "compared as numbers")
    if pair.op != "=":
        return Comparison(True, f"tested at {len(points)} random points")
    if _same_normal_form(pair.left - pair.right):
        return Comparison(True, "proved: the difference vanishes in normal form")
    return Comparison(True, f"tested at {len(points)} random points with 50 digits")


def _same_normal_form(difference: Expr) -> bool:
    """Whether a difference is zero as a polynomial in cosines, sines and roots with their squares reduced."""
    if difference.has(*_BRANCHING) or sp.count_ops(difference) > _PROVABLE:
        return False
    numerator = sp.fraction(sp.together(sp.expand_trig(difference)))[0]
    return bool(reduce_sines(sp.expand(numerator)) == 0)


class _Test:
    """Random points of a pair's free names, and both sides there with 50 digits."""

    def __init__(self, pair: _Pair, names: Names) -> None:
        self.pair = pair
        self.symbols = tuple(sorted(_free(pair), key=str))
        self.names: tuple[Name, ...] = tuple(names.table[symbol] for symbol in self.symbols)
        branched = pair.left.has(*_BRANCHING) or pair.right.has(*_BRANCHING)
        self.wanted = 1 if not self.symbols else _BRANCHED_POINTS if branched else _POINTS
        if pair.op != "=":
            self.wanted = max(self.wanted, _INEQUALITY_POINTS) if self.symbols else 1
        self._evaluate = sp.lambdify(self.symbols, [pair.left, pair.right, *pair.domain], "mpmath", cse=True)

    def points(self) -> Iterator[Point]:
        """Draw points of the domain at which both sides exist; the same ones each time."""
        draw = random.Random(2024)
        found = 0
        for _ in range(self.wanted * _DRAWS):
            point = {name.symbol: _drawn(name, draw) for name in self.names}
            if self.values(point) is not None:
                yield point
                found += 1
            if found == self.wanted or not self.symbols:
                return

    def values(self, point: Point) -> tuple[mpmath.mpf, mpmath.mpf] | None:
        """Both sides at a point, or None where they do not exist or the domain ends."""
        with mpmath.workdps(_DIGITS + 10):
            try:
                arguments = [mpmath.mpf(point[symbol].p) / point[symbol].q for symbol in self.symbols]
                left, right, *domain = self._evaluate(*arguments)
                real = [mpmath.mpf(value) for value in (left, right, *domain)]
            except (ArithmeticError, TypeError, ValueError):
                return None
            if not all(map(mpmath.isfinite, real)) or any(value <= 0 for value in real[2:]):
                return None
            return real[0], real[1]

    def fails(self, point: Point, visible: bool = False) -> bool:
        """Whether the relation fails at a point of the domain, and by an amount that a reader can see."""
        values = self.values(point)
        if values is None:
            return False
        with mpmath.workdps(_DIGITS + 10):
            left, right = values
            size = 1 if self.pair.op == "=" and not visible else 0
            apart = abs(left - right)
            limit = (_VISIBLE if visible else _TOLERANCE) * (size + abs(left) + abs(right))
            limit += mpmath.mpf(self.pair.within.p) / self.pair.within.q if self.pair.within else 0
            if self.pair.op == "=":
                return bool(apart > limit)
            return not _OPS[self.pair.op](left, right) and (not visible or bool(apart > limit))

    def simplest(self, point: Point) -> Counterexample:
        """Turn a point of failure into simple numbers, with as many zeros as the failure allows."""
        simple = dict(point)
        for name in self.names:
            for value in _candidates(simple[name.symbol], name):
                if self.fails({**simple, name.symbol: value}, visible=True):
                    simple[name.symbol] = value
                    break
        values = self.values(simple)
        assert values is not None
        shown = tuple((str(symbol), str(value)) for symbol, value in simple.items())
        return Counterexample(shown, *(mpmath.nstr(value, 6) for value in values))


def _free(pair: _Pair) -> set[Expr]:
    return functools.reduce(set.union, (expr.free_symbols for expr in (pair.left, pair.right, *pair.domain)), set())


def _drawn(name: Name, draw: random.Random) -> sp.Rational:
    """Draw a value between the bounds of a name."""
    if name.symbol.is_integer:
        return sp.Integer(draw.randint(int(name.low), int(name.high)))
    return name.low + (name.high - name.low) * sp.Rational(draw.randrange(1, 10**6), 10**6)


def _candidates(value: sp.Rational, name: Name) -> Iterator[sp.Rational]:
    """Offer simple values to try in place of a drawn one, the simplest first."""
    for digits in (0, 1, 2, 3):
        rounded = sp.Rational(round(value * 10**digits), 10**digits)
        for candidate in (sp.S.Zero, sp.S.One, -sp.S.One, sp.Rational(1, 2), rounded) if not digits else (rounded,):
            if name.low <= candidate <= name.high and (candidate > 0 or not name.symbol.is_positive):
                yield candidate
