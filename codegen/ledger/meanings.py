# SPDX-License-Identifier: Apache-2.0
"""Meanings of a paper's names as nodes of a pool, and test points of its free names."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction

import sympy as sp

from mehvar.models.derivation import Expr
from mehvar.models.paper import Case, Names, Side, frozen, symbols_of

from ..equal import field
from ..equal.equality import EqualityTest
from ..equal.meaning import Expression, Meaning
from ..equal.pool import Pool
from ..equal.sampler import PointSampler
from .sides import Sides

_STEPS = 10**6
"""Number of grid points between two bounds. Grid values keep the numbers of counterexamples short and the values of
names distinct.
"""


class PaperSampler(PointSampler):
    """Sampler of values strictly between the bounds of names, at which formulas are often undefined.

    Parameters
    ----------
    names : Names
        Table of the paper's names.
    """

    def __init__(self, names: Names) -> None:
        self._table = {str(symbol): name for symbol, name in names.table.items()}
        self._ranges = {
            name: (_fraction(n.low), _fraction(n.high) - _fraction(n.low), n.symbol.is_integer)
            for name, n in self._table.items()
        }
        super().__init__({}, frozenset())

    def value(self, name: str, number: int) -> Fraction:
        """Return one coordinate of a point."""
        low, width, integer = self._ranges[name]
        draw = field.hashed("value", number, name)
        if integer:
            return low + draw % (width + 1)
        return low + width * Fraction(1 + draw % (_STEPS - 1), _STEPS)

    def simple(self, name: str, value: Fraction) -> Iterator[Fraction]:
        """Yield simple values to try in place of a drawn one, simplest first."""
        entry = self._table[name]
        rounded = [Fraction(round(value * 10**digits), 10**digits) for digits in (0, 1, 2, 3)]
        for candidate in (Fraction(0), Fraction(1), Fraction(-1), Fraction(1, 2), *rounded):
            if entry.low <= candidate <= entry.high and (candidate > 0 or not entry.symbol.is_positive):
                yield candidate


class Meanings:
    """Names of a paper in one pool, evaluated at the same points for every relation.

    Parameters
    ----------
    names : Names
        Table of the paper's names.
    """

    def __init__(self, names: Names) -> None:
        self.names = names
        self.pool = Pool()
        self.symbols = {str(symbol): symbol for symbol in names.table}
        self.sides = Sides(self.pool)
        self.equality = EqualityTest(self.pool, lambda name: bool(self.symbols[name].is_positive), PaperSampler(names))
        self._reached: dict[Expr, frozenset[Expr]] = {}
        self.table = InCase(self, {})
        self._cases = {frozenset[tuple[Expr, Side]](): self.table}

    def case(self, case: Case) -> InCase:
        """Return the meanings of names in a case, where they override the table's."""
        overrides = {symbol: frozen(meaning) for symbol, meaning in case.items()}
        return self._cases.setdefault(frozenset(overrides.items()), InCase(self, overrides))

    def reached(self, symbol: Expr) -> frozenset[Expr]:
        """Return all names that a name of the table depends on, itself included."""
        if symbol not in self._reached:
            meaning = self.table.of.get(symbol)
            below = symbols_of(meaning) if meaning is not None else ()
            self._reached[symbol] = frozenset((symbol,)).union(*map(self.reached, below))
        return self._reached[symbol]


class InCase:
    """Meanings of names in one case of a relation.

    Attributes
    ----------
    overrides, of : mapping
        The case's meanings, and their combination with the table's.
    """

    def __init__(self, meanings: Meanings, overrides: Mapping[Expr, Side]) -> None:
        table = {s: name.meaning for s, name in meanings.names.table.items() if name.meaning is not None}
        self._all = meanings
        self.overrides = overrides
        self.of: dict[Expr, Side] = table | dict(overrides)
        self._symbols = meanings.symbols | {str(symbol): symbol for symbol in overrides}
        self._matrices = {s: meaning for s, meaning in self.of.items() if isinstance(s, sp.MatrixSymbol)}
        self._nodes: dict[str, int] = {}
        self._meaning = Meaning(meanings.pool, self._target)

    def expressions(self, side: Side) -> list[Expression]:
        """Return the entries of a side as expressions for comparison; a number has one entry."""
        return [(self._meaning, node) for node in self._all.sides.entries(self._without_matrices(side))]

    def symbol(self, name: str) -> Expr:
        """Return the symbol with a name."""
        return self._symbols[name]

    def written_out(self, side: Side) -> Side:
        """Replace all names by their meanings until only free names remain."""
        return self._replaced(side, self.of)

    def _without_matrices(self, side: Side) -> Side:
        return self._replaced(side, self._matrices) if self._matrices else side

    @staticmethod
    def _replaced(side: Side, meanings: Mapping[Expr, Side]) -> Side:
        for _ in range(len(meanings) + 1):
            here = {symbol: meanings[symbol] for symbol in symbols_of(side) if symbol in meanings}
            if not here:
                return side
            side = side.xreplace(here)
        raise ValueError(f"the meanings of {sorted(map(str, here))} are circular")

    def _target(self, name: str) -> Expression | None:
        """Return the meaning of a name in this case, by default that of the table."""
        symbol = self._symbols[name]
        if symbol not in self.of:
            return None
        table = self._all.table
        if self is not table and self._all.reached(symbol).isdisjoint(self.overrides):
            return table._target(name)
        if name not in self._nodes:
            (self._nodes[name],) = self._all.sides.entries(self._without_matrices(self.of[symbol]))
        return self._meaning, self._nodes[name]


def _fraction(value: sp.Rational) -> Fraction:
    return Fraction(int(value.p), int(value.q))
