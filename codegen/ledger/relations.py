# SPDX-License-Identifier: Apache-2.0
"""Whether a printed relation holds once every symbol has its derived meaning.

Relations are tested at random points with 50 digits, drawn from the bounds of the names. That finds every difference
that is not confined to a set of measure zero, a branch that was not visited, or an amount below 1e-40. What passes and
is small enough is written out; where the forms are equal, or the difference vanishes in normal form, it is proved.
"""

from __future__ import annotations

import functools
import random
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass

import mpmath
import sympy as sp

from mehvar.models.derivation import Expr
from mehvar.models.mechanics import reduce_sines
from mehvar.models.paper import Case, Name, Names, Relation, Side, frozen, symbols_of

from .precise import DIGITS, Evaluation, Value

_TOLERANCE = mpmath.mpf(10) ** -40
_VISIBLE = mpmath.mpf(10) ** -6
"""Relative difference that a counterexample shows."""
_POINTS, _BRANCHED_POINTS, _INEQUALITY_POINTS = 16, 64, 128
_DRAWS = 100
"""Attempts for each point wanted, before a domain counts as not found."""
_WRITTEN_OUT, _PROVABLE = 750, 250
"""Operations up to which sides are written out, and up to which a normal form of their difference is tried."""
_BRANCHING = (sp.Abs, sp.sign, sp.Max, sp.Min, sp.Piecewise, sp.atan2, sp.acos, sp.asin)
_UNEVALUATED = (sp.Integral, sp.Derivative, sp.Limit, sp.Sum, sp.UnevaluatedExpr)
_OPS: dict[str, Callable[[Value, Value], bool]] = {
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
        Both sides of the printed relation there, to six digits; of matrices, the first entries that differ; for an
        equation of motion, the printed left minus right and the derived residual.
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
    results = [_decide(_Test(relation, names, case, left, right)) for case in relation.cases]
    failed = [result for result in results if not result.equal]
    if failed:
        return next((result for result in failed if result.equal is False), failed[0])
    return Comparison(True, _weakest(result.how for result in results))


def residuals(relation: Relation, names: Names) -> tuple[Expr, Expr]:
    """Write the printed and the derived residual of an equation of motion out as sums of terms, in the first case.

    Even powers of sines are written by cosines, so that equal terms look equal.
    """
    test = _Test(relation, names, relation.cases[0], relation.left, relation.right)
    printed, derived = (_entries(_explicit(test.written_out(side)))[0] for side in test.sides)
    return reduce_sines(printed), reduce_sines(derived)


def _weakest(hows: Iterable[str]) -> str:
    """Sum up how several cases are known: as sure as the least sure of them."""
    found = list(dict.fromkeys(hows))
    return next((how for how in found if not how.startswith("proved")), found[0])


def _decide(test: _Test) -> Comparison:
    """Compare both sides in one case: their shapes, random points, and their forms."""
    shapes = [_shape(side) for side in test.sides]
    if shapes[0] != shapes[1]:
        return Comparison(False, f"proved: {_named(shapes[0])} cannot equal {_named(shapes[1])}")
    if any(side.has(sp.oo, -sp.oo, sp.nan, sp.zoo) for side in test.sides):
        same = test.sides[0] == test.sides[1]
        return Comparison(
            same, "proved: " + ("both are infinite" if same else f"{test.sides[0]} is not {test.sides[1]}")
        )
    found = 0
    for point, values in test.points():
        if test.differ(*values):
            return Comparison(False, f"differs with {DIGITS} digits", test.simplest(point))
        found += 1
    if found < test.wanted:
        return Comparison(None, f"only {found} of {test.wanted} points were found at which both sides exist")
    if test.op != "=":
        return Comparison(True, f"tested at {found} random points" if test.names else "compared as numbers")
    if not test.within and (proof := test.proof()):
        return Comparison(True, proof)
    if not test.names:
        return Comparison(True, f"compared as numbers, within {test.within}" if test.within else "compared as numbers")
    return Comparison(True, f"tested at {found} random points with {DIGITS} digits")


class _Test:
    """One case of a relation: both sides, what their names mean, random points."""

    def __init__(self, relation: Relation, names: Names, case: Case, left: Side, right: Side) -> None:
        derived = {symbol: name.meaning for symbol, name in names.table.items() if name.meaning is not None}
        self.case = {symbol: frozen(meaning) for symbol, meaning in case.items()}
        self.meanings: dict[Expr, Side] = derived | self.case
        self.op, self.within = relation.op, relation.within
        sides = (left, right) if relation.against is None else (left - right, relation.against)
        self.sides = tuple(self._carried_out(side) for side in sides)
        self.domain = tuple(self._carried_out(expr) for expr in relation.domain)
        reached = list(self._reached((*self.sides, *self.domain)))
        free = sorted((s for s in reached if isinstance(s, sp.Symbol) and s not in self.meanings), key=str)
        self.names: tuple[Name, ...] = tuple(names.table[symbol] for symbol in free)
        self.write = names.as_text
        used = [self.meanings[s] for s in reached if s in self.meanings]
        branched = any(side.has(*_BRANCHING) for side in (*self.sides, *used))
        self.wanted = _BRANCHED_POINTS if branched else _POINTS
        if self.op != "=":
            self.wanted = _INEQUALITY_POINTS
        if not self.names:
            self.wanted = 1

    def _carried_out(self, side: Side) -> Side:
        """Carry out integrals, derivatives and limits, which takes the meanings of what is in them."""
        side = frozen(side)
        return self.written_out(side).doit() if side.has(*_UNEVALUATED) else side

    def written_out(self, side: Side) -> Side:
        """Replace every name by its meaning, down to free names."""
        for _ in range(len(self.meanings) + 1):
            found = {s: self.meanings[s] for s in symbols_of(side) if s in self.meanings}
            if not found:
                return side
            side = side.xreplace(found)
        raise ValueError(f"the meanings of {sorted(map(str, found))} refer to each other in a circle")

    def _reached(self, sides: Iterable[Side]) -> Iterator[Expr]:
        """Follow meanings to every name that the sides depend on."""
        seen: set[Expr] = set()
        waiting = [symbol for side in sides for symbol in symbols_of(side)]
        while waiting:
            symbol = waiting.pop()
            if symbol not in seen:
                seen.add(symbol)
                yield symbol
                waiting.extend(symbols_of(self.meanings[symbol]) if symbol in self.meanings else ())

    def proof(self) -> str:
        """Say how equality is proved, or nothing: by form if it is small enough to be written out."""
        sizes = [self._size(side, {}) for side in self.sides]
        if max(sizes) > _WRITTEN_OUT:
            return ""
        left, right = (_explicit(self.written_out(side)) for side in self.sides)
        if left == right:
            return "proved: both sides are the same expression"
        if all(_vanishes(a - b) for a, b in zip(_entries(left), _entries(right), strict=True)):
            return "proved: the difference vanishes in normal form"
        return ""

    def _size(self, side: Side, known: dict[Expr, int]) -> int:
        """Count the operations of a side as it will be when written out."""
        size = _operations(side)
        for symbol in symbols_of(side):
            if symbol in self.meanings:
                if symbol not in known:
                    known[symbol] = self._size(self.meanings[symbol], known)
                size += known[symbol] * (1 if isinstance(side, sp.MatrixBase) else side.count(symbol))
        return size

    def points(self) -> Iterator[tuple[Point, tuple[list[Value], list[Value]]]]:
        """Draw points of the domain at which both sides exist, and their values; the same ones each time."""
        draw = random.Random(2024)
        found = 0
        for _ in range(self.wanted * _DRAWS):
            point = {name.symbol: _drawn(name, draw) for name in self.names}
            values = self.values(point)
            if values is not None:
                yield point, values
                found += 1
            if found == self.wanted:
                return

    def values(self, point: Point) -> tuple[list[Value], list[Value]] | None:
        """Both sides at a point, entry by entry, or None where they do not exist or the domain ends."""
        evaluation = Evaluation(self.meanings, point)
        try:
            domain = [evaluation.value(expr) for expr in self.domain]
            if not all(_is_real(value) and value > 0 for value in domain):
                return None
            left, right = (_numbers(evaluation.value(side)) for side in self.sides)
        except (ArithmeticError, TypeError, ValueError):
            return None
        return (left, right) if all(map(_is_real, (*left, *right))) else None

    def differ(self, left: list[Value], right: list[Value], visible: bool = False) -> bool:
        """Whether the relation fails for these values, and by an amount that a reader can see."""
        return any(self._apart(a, b, visible) for a, b in zip(left, right, strict=True))

    def _apart(self, left: Value, right: Value, visible: bool) -> bool:
        with mpmath.workdps(DIGITS):
            scale = abs(left) + abs(right)
            limit = _TOLERANCE * (1 + scale) + (_VISIBLE * scale if visible else 0)
            limit += mpmath.mpf(self.within.p) / self.within.q
            if self.op == "=":
                return bool(abs(left - right) > limit)
            return not _OPS[self.op](left, right) and (not visible or bool(abs(left - right) > limit))

    def simplest(self, point: Point) -> Counterexample:
        """Turn a point of failure into simple numbers, with as many zeros as the failure allows."""
        simple = dict(point)
        for name in self.names:
            for value in _candidates(simple[name.symbol], name):
                values = self.values({**simple, name.symbol: value})
                if values is not None and self.differ(*values, visible=True):
                    simple[name.symbol] = value
                    break
        values = self.values(simple)
        assert values is not None
        left, right = next(pair for pair in zip(*values, strict=True) if self._apart(*pair, visible=False))
        members = [(self.write(name), self.write(meaning)) for name, meaning in self.case.items() if not meaning.args]
        shown = [(self.write(symbol), str(value)) for symbol, value in simple.items()]
        return Counterexample((*members, *shown), mpmath.nstr(left, 6), mpmath.nstr(right, 6))


def _shape(side: Side) -> tuple[int, int]:
    return tuple(map(int, side.shape)) if isinstance(side, sp.MatrixBase | sp.MatrixExpr) else (1, 1)  # type: ignore[return-value]


@functools.lru_cache(maxsize=4096)
def _operations(side: Side) -> int:
    return int(sp.count_ops(side))


def _named(shape: tuple[int, int]) -> str:
    return "a number" if shape == (1, 1) else f"a {shape[0]} x {shape[1]} matrix"


def _explicit(side: Side) -> Side:
    """Carry out products and traces of matrices."""
    if isinstance(side, sp.MatrixExpr) or side.has(sp.MatrixExpr, sp.Trace):
        side = side.doit()
    return side.as_explicit() if isinstance(side, sp.MatrixExpr) else side


def _entries(side: Side) -> list[Expr]:
    return list(side) if isinstance(side, sp.MatrixBase) else [side]


def _numbers(value: Value) -> list[Value]:
    return list(value) if isinstance(value, mpmath.matrix) else [value]


def _is_real(value: Value) -> bool:
    return isinstance(value, mpmath.mpf | int) and bool(mpmath.isfinite(value))


def _vanishes(difference: Expr) -> bool:
    """Whether a difference is zero as a polynomial in cosines, sines and roots with their squares reduced."""
    if difference.has(*_BRANCHING) or sp.count_ops(difference) > _PROVABLE:
        return False
    numerator = sp.fraction(sp.together(sp.expand_trig(difference)))[0]
    return bool(reduce_sines(sp.expand(numerator)) == 0)


def _drawn(name: Name, draw: random.Random) -> sp.Rational:
    """Draw a value between the bounds of a name."""
    if name.symbol.is_integer:
        return sp.Integer(draw.randint(int(name.low), int(name.high)))
    return name.low + (name.high - name.low) * sp.Rational(draw.randrange(1, 10**6), 10**6)


def _candidates(value: sp.Rational, name: Name) -> Iterator[sp.Rational]:
    """Offer simple values to try in place of a drawn one, the simplest first."""
    rounded = [sp.Rational(round(value * 10**digits), 10**digits) for digits in (0, 1, 2, 3)]
    for candidate in (sp.S.Zero, sp.S.One, -sp.S.One, sp.Rational(1, 2), *rounded):
        if name.low <= candidate <= name.high and (candidate > 0 or not name.symbol.is_positive):
            yield candidate
