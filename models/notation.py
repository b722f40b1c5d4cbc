# SPDX-License-Identifier: Apache-2.0
"""Symbols of a paper with their derived meanings and their spelling; see `mehvar.models.paper`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

import sympy as sp
from sympy.printing.str import StrPrinter

from .derivation import Expr
from .mechanics import planar_cross
from .quantities import ModelError, Quantity

Side: TypeAlias = Expr | sp.MatrixBase | sp.MatrixExpr
"""A side of a relation: a number or a matrix."""
Case: TypeAlias = Mapping[Expr, Side]
"""Meanings of names in one case of a relation."""


@dataclass(frozen=True)
class Name:
    """A symbol of the paper.

    Parameters
    ----------
    symbol : Symbol or MatrixSymbol
        Its symbol in relations and meanings.
    latex : str
        LaTeX as in the paper.
    meaning : Expr or Matrix, optional
        Its derived value as a function of other names; a free name has none.
    low, high : sympy.Rational
        Bounds of test values of a free name.
    member : bool
        True for a member of a family; each relation states in its cases which member.
    text : str
        Spelling in plain text; the symbol's name if empty.
    """

    symbol: Expr
    latex: str
    meaning: Side | None = None
    low: sp.Rational = -sp.S.One
    high: sp.Rational = sp.S.One
    member: bool = False
    text: str = ""


class Names:
    """The table of a paper's symbols, in the order they are introduced."""

    def __init__(self) -> None:
        self.table: dict[Expr, Name] = {}

    def free(
        self,
        what: Quantity | str,
        low: float | str = -1,
        high: float | str = 1,
        *,
        latex: str = "",
        text: str = "",
        integer: bool = False,
    ) -> sp.Symbol:
        """Add a name that may take any value.

        Parameters
        ----------
        what : Quantity or str
            A quantity of the model, which gives symbol and LaTeX, or a name that only the paper has.
        low, high : int or str
            Exact bounds of its test values, such as 2 or "7/10". A positive quantity needs low >= 0.
        latex, text : str
            Spelling in the paper, as LaTeX and plain text, if it differs from the model's.
        integer : bool
            True to test with integers only.

        Raises
        ------
        ModelError
            If the name has been added before or bounds are in the wrong order.
        """
        lower, upper = sp.Rational(str(low)), sp.Rational(str(high))
        if lower >= upper:
            raise ModelError(f"name {what!r} has the bounds {lower} and {upper}: the first must be below the second")
        if isinstance(what, Quantity):
            symbol, printed = what.symbol, latex or what.latex or str(sp.latex(what.symbol))
        else:
            assumption = {"integer": True} if integer else {"positive": True} if lower >= 0 else {"real": True}
            symbol = sp.Symbol(what, **assumption)
            printed = latex or str(sp.latex(symbol))
        return self._add(Name(symbol, printed, low=lower, high=upper, text=text))

    def derived(self, name: str, latex: str, meaning: Expr, *, positive: bool = False, text: str = "") -> sp.Symbol:
        """Add a name with a derived meaning; `text` is its spelling in plain text, by default `name`."""
        symbol = sp.Symbol(name, positive=True) if positive else sp.Symbol(name, real=True)
        return self._add(Name(symbol, latex, sp.sympify(meaning), text=text))

    def matrix(self, name: str, latex: str, meaning: sp.MatrixBase, *, text: str = "") -> sp.MatrixSymbol:
        """Add a matrix or column with a derived meaning."""
        return self._add(Name(sp.MatrixSymbol(name, *meaning.shape), latex, frozen(meaning), text=text))

    def family(self, name: str, latex: str, *, positive: bool = False, text: str = "") -> sp.Symbol:
        """Add an indexed name such as l_i; each case of a relation gives it a meaning."""
        symbol = sp.Symbol(name, positive=True) if positive else sp.Symbol(name, real=True)
        return self._add(Name(symbol, latex, member=True, text=text))

    def matrix_family(self, name: str, latex: str, rows: int, columns: int = 1) -> sp.MatrixSymbol:
        """Add an indexed matrix or column such as x_i; each case of a relation gives it a meaning."""
        return self._add(Name(sp.MatrixSymbol(name, rows, columns), latex, member=True))

    def meaning(self, symbol: Expr) -> Side:
        """Return the meaning of a derived name."""
        meaning = self.table[symbol].meaning
        if meaning is None:
            raise ModelError(f"name {str(symbol)!r} is not defined: define it, or correct the name")
        return meaning

    def as_latex(self, side: Side) -> str:
        """Return one side of an equation as LaTeX, in the paper's notation."""
        names = {symbol: name.latex for symbol, name in self.table.items()}
        return str(sp.latex(_printable(side), symbol_names=names))

    def as_text(self, side: Side) -> str:
        """Return one side of an equation as plain text, in the paper's notation."""
        renamed = {symbol: _renamed(symbol, name.text) for symbol, name in self.table.items() if name.text}
        return str(_OneLine().doprint(_printable(sp.sympify(side).xreplace(renamed))))

    def _add(self, name: Name) -> Expr:
        if any(str(name.symbol) == str(other) for other in self.table):
            raise ModelError(f"name {str(name.symbol)!r} occurs twice in the table of names")
        self.table[name.symbol] = name
        return name.symbol


class _OneLine(StrPrinter):  # type: ignore[misc]
    """Printer of matrices on one line, as [a, b; c, d]."""

    def _print_MatrixBase(self, matrix: sp.MatrixBase) -> str:  # noqa: N802 - SymPy calls it by this name
        return "[" + "; ".join(", ".join(map(self._print, row)) for row in matrix.tolist()) + "]"


class _PrintedInverse(sp.MatrixExpr):  # type: ignore[misc]
    """An inverse that is printed but never computed."""

    shape = property(lambda self: self.args[0].shape)

    def _print(self, printer: Any) -> str:
        return str(printer._print(sp.Inverse(self.args[0])))

    _latex = _sympystr = _print


def _printable(side: Side) -> Side:
    """Return a side in which inverses of known matrices stay unevaluated; SymPy would compute them to find signs."""
    if not isinstance(side, sp.Basic):
        return side
    return side.replace(sp.Inverse, lambda matrix, *_: _PrintedInverse(matrix))


def _renamed(symbol: Expr, text: str) -> Expr:
    if isinstance(symbol, sp.MatrixSymbol):
        return sp.MatrixSymbol(text, *symbol.shape)
    return sp.Symbol(text, **symbol.assumptions0)


class Cross(sp.MatrixExpr):  # type: ignore[misc]
    """Unevaluated cross product of two columns; for plane vectors, its out-of-plane component.

    Parameters
    ----------
    a, b : Matrix
        Columns of three entries, or of two.
    """

    def __new__(cls, a: Side, b: Side) -> Cross:  # noqa: D102
        product: Cross = sp.Basic.__new__(cls, sp.sympify(a), sp.sympify(b))
        return product

    @property
    def shape(self) -> tuple[sp.Expr, sp.Expr]:
        """Shape of the product: 3 x 1, or 1 x 1 in the plane."""
        rows = self.args[0].shape[0]
        return (rows, sp.S.One) if rows == 3 else (sp.S.One, sp.S.One)

    def doit(self, **hints: bool) -> sp.MatrixExpr | sp.MatrixBase:
        """Evaluate the product if all entries of both columns are known."""
        a, b = (arg.doit(**hints) for arg in self.args)
        if not (isinstance(a, sp.MatrixBase) and isinstance(b, sp.MatrixBase)):
            return Cross(a, b)
        if self.shape[0] == 3:
            return a.cross(b).as_immutable()
        return sp.ImmutableMatrix([[planar_cross(a, b)]])

    def _entry(self, i: int, j: int, **_: object) -> sp.Expr:
        a, b = self.args
        if self.shape[0] == 1:
            return planar_cross(a, b)
        return a[(i + 1) % 3, 0] * b[(i + 2) % 3, 0] - a[(i + 2) % 3, 0] * b[(i + 1) % 3, 0]

    def _written(self, printer: Any, sign: str) -> str:
        sides = (printer._print(arg) for arg in self.args)
        wrapped = (
            side if isinstance(arg, sp.MatrixSymbol) else f"({side})"
            for side, arg in zip(sides, self.args, strict=True)
        )
        return sign.join(wrapped)

    def _latex(self, printer: Any) -> str:
        return self._written(printer, r" \times ")

    def _sympystr(self, printer: Any) -> str:
        return self._written(printer, " x ")


def frozen(side: Side) -> Side:
    """Return a side as an immutable value.

    Parameters
    ----------
    side : Expr or Matrix
        A number or a matrix.
    """
    return side.as_immutable() if isinstance(side, sp.MatrixBase) else sp.sympify(side)


def symbols_of(side: Side) -> set[Expr]:
    """Return the symbols and matrix symbols of a side, except bound variables of integrals and limits."""
    return {symbol for symbol in sp.sympify(side).free_symbols if isinstance(symbol, sp.Symbol | sp.MatrixSymbol)}


def insert_definitions(expr: Expr, definitions: Mapping[sp.Symbol, Expr], cut: Case | None = None) -> Expr:
    """Replace definitions in a derived expression until only names of the paper remain.

    Parameters
    ----------
    expr : Expr
        In symbols of the derivation.
    definitions : mapping
        `system.definitions`, or those of a `Derivation` made on the spot.
    cut : mapping, optional
        Symbols of the model and the paper's names that replace them.

    Returns
    -------
    Expr
        Without defined symbols.
    """
    cut = cut or {}
    meanings = {symbol: cut[symbol] for symbol in expr.free_symbols if symbol in cut}
    for symbol in expr.free_symbols - set(meanings):
        if symbol in definitions:
            meanings[symbol] = insert_definitions(definitions[symbol], definitions, cut)
    return expr.subs(meanings, simultaneous=True)
