# SPDX-License-Identifier: Apache-2.0
"""The vocabulary of a ledger: what a paper prints, equation by equation, and what its symbols mean in our derivation.

A model whose paper is to be checked has a module models.MODEL.paper (or a package) with a function

    def paper(system: System) -> Paper

which `codegen.ledger` judges. It says two things and keeps them apart:

* **what is printed**, misprints included, as SymPy expressions in the paper's own symbols (`Relation.left`, `.right`);
* **what those symbols mean**, in one table of names for the whole paper (`Names`). A name is either *free* (a
  coordinate, a rate, a parameter: it may take any value within bounds) or *derived*: its meaning is an expression that
  comes from the system's derivation (`follow`), or that is derived on the spot, by differentiating, integrating,
  inserting. A meaning is never a retyped copy of what is printed: that would make the check vacuous.

A relation then holds when both sides are the same function of the free names once every meaning is put in. No verdict
is written down here; the machine computes it. What a person adds is the corrected side of a relation that is known to
be misprinted (tested too: a wrong correction is never shown), the readings of what cannot be read in one way only, and
notes.

How to write an entry
---------------------
An identity between names with meanings, here l_i^2 of a triangle and its rate, for each i (the paper prints it once)::

    names = Names()
    rho = names.free(RHO, 0, "7/10")                          # one of our quantities, and where it is tried
    v = names.free("v_1", r"v_1", -2, 2)                      # a symbol only the paper has
    h = names.derived("h", "h", follow(symbol_of_h, system.definitions, {rho_t: rho}))
    u, l = names.family("u", "u_i"), names.family("l", "l_i") # stand for a member; each case says which
    rods = [{u: rate_k, l: length_k} for ...]                 # their meanings, member by member

    printed("22", "rod rates", "equation", Relation(u, l * w3 / (2 * mu) + ..., corrected=..., cases=rods))

* Something *defined* by the paper (kind "definition") is compared as well wherever the derivation has a definition of
  its own: its verdict is "definition" when both agree, "differs" when they do not. With `given=True` nothing is
  compared: the relation is shown because it introduces a name or sets a condition.
* An *equation of motion* holds along motions only, so its two sides are not the same function. Give the derived
  residual (left minus right) as `against`; the printed left minus right is compared with it.
* A statement about a *special situation* (on the surface s = 0, on the circle) is a case that gives the names of that
  situation their meaning: ``cases=({rho_t: h},)``. A case overrides the table.
* *Inequalities* use the op "<", "<=", ">" or ">="; they are tested at random points of `domain`.
* *Integrals, derivatives and limits* are written unevaluated (``sp.Integral``, ``sp.Derivative``, ``sp.Limit``) and
  carried out after the meanings have been put in.
* *Matrices*: ``names.matrix("S", "S", meaning)`` gives a MatrixSymbol, so that ``S * S`` prints as S^2. Sides of
  different shape are a difference of their own. A 1x1 matrix counts as a number. `Cross(a, b)` is a x b.
* SymPy tidies what it is given: it turns sin(x - 2 pi/3) into -sin(x + pi/3). ``sp.UnevaluatedExpr(2 * sp.pi / 3)``
  keeps a part as printed; it is carried out before anything is compared.
* A *number* with few digits is compared within `within` (one unit of the last printed digit, say).
* *Words* that say something checkable are an entry too, with a number such as "text after (9)" and `Relation.says`.
* *Readings*: `Printed` with one `Reading` for each way to read what is printed, exactly one of them `used`. The machine
  judges each. When they disagree the entry is "illegible or ambiguous", and says which one the model follows.

`Paper` refuses a number that is missing or entered twice, and a symbol that the table of names lacks.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import sympy as sp

from models.derivation import Expr
from models.mechanics import planar_cross
from models.quantities import ModelError, Quantity

Side: TypeAlias = Expr | sp.MatrixBase | sp.MatrixExpr
"""One side of a relation: a number or a matrix."""
Case: TypeAlias = Mapping[Expr, Side]
"""Meanings that hold in one case of a relation, by name."""
Op: TypeAlias = Literal["=", "<", "<=", ">", ">="]
Kind: TypeAlias = Literal["equation", "definition", "condition", "statement", "data"]
"""equation: follows from what is said before. definition, condition, data: the author's to choose. statement: words."""


@dataclass(frozen=True)
class Name:
    """A symbol of the paper.

    Parameters
    ----------
    symbol : Symbol or MatrixSymbol
        How relations and meanings write it.
    latex : str
        How the paper prints it.
    meaning : Expr or Matrix, optional
        What the derivation says it is, as a function of other names; a free name has none.
    low, high : sympy.Rational
        Where a free name is tried.
    member : bool
        Stands for a member of a family; every relation that uses it says which, in its cases.
    text : str
        How plain text prints it; the symbol's name when empty.
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
            One of our quantities, whose symbol and LaTeX are taken, or a name that only the paper has.
        low, high : int or str
            Bounds within which it is tried, exact: 2, "7/10". A positive quantity needs low >= 0.
        latex, text : str
            How the paper prints it, as LaTeX and in plain text, where that differs from ours.
        integer : bool
            Tried with whole numbers only.

        Raises
        ------
        ModelError
            If the name has been added before or bounds are in the wrong order.
        """
        lower, upper = sp.Rational(str(low)), sp.Rational(str(high))
        if lower >= upper:
            raise ModelError(f"name {what!r} is tried between {lower} and {upper}: no room")
        if isinstance(what, Quantity):
            symbol, printed = what.symbol, latex or what.latex or str(sp.latex(what.symbol))
        else:
            assumption = {"integer": True} if integer else {"positive": True} if lower >= 0 else {"real": True}
            symbol = sp.Symbol(what, **assumption)
            printed = latex or str(sp.latex(symbol))
        return self._add(Name(symbol, printed, low=lower, high=upper, text=text))

    def derived(self, name: str, latex: str, meaning: Expr, *, positive: bool = False, text: str = "") -> sp.Symbol:
        """Add a name whose meaning comes from the derivation; `text` is how plain text prints it if not by `name`."""
        symbol = sp.Symbol(name, positive=True) if positive else sp.Symbol(name, real=True)
        return self._add(Name(symbol, latex, sp.sympify(meaning), text=text))

    def matrix(self, name: str, latex: str, meaning: sp.MatrixBase, *, text: str = "") -> sp.MatrixSymbol:
        """Add a matrix or a column whose meaning comes from the derivation."""
        return self._add(Name(sp.MatrixSymbol(name, *meaning.shape), latex, frozen(meaning), text=text))

    def family(self, name: str, latex: str, *, positive: bool = False) -> sp.Symbol:
        """Add a name that stands for a member of a family, such as l_i; the cases of a relation say for which."""
        symbol = sp.Symbol(name, positive=True) if positive else sp.Symbol(name, real=True)
        return self._add(Name(symbol, latex, member=True))

    def matrix_family(self, name: str, latex: str, rows: int, columns: int = 1) -> sp.MatrixSymbol:
        """Add a matrix or column that stands for a member of a family, such as x_i."""
        return self._add(Name(sp.MatrixSymbol(name, rows, columns), latex, member=True))

    def meaning(self, symbol: Expr) -> Side:
        """Return what a derived name means."""
        meaning = self.table[symbol].meaning
        if meaning is None:
            raise ModelError(f"name {str(symbol)!r} is free: it has no meaning of its own")
        return meaning

    def as_latex(self, side: Side) -> str:
        """Write a side as the paper prints it."""
        return str(sp.latex(side, symbol_names={symbol: name.latex for symbol, name in self.table.items()}))

    def as_text(self, side: Side) -> str:
        """Write a side in plain text, with the paper's names."""
        renamed = {symbol: _renamed(symbol, name.text) for symbol, name in self.table.items() if name.text}
        return str(sp.sstr(sp.sympify(side).xreplace(renamed)))

    def _add(self, name: Name) -> Expr:
        if any(str(name.symbol) == str(other) for other in self.table):
            raise ModelError(f"name {str(name.symbol)!r} is in the table of names twice")
        self.table[name.symbol] = name
        return name.symbol


def _renamed(symbol: Expr, text: str) -> Expr:
    if isinstance(symbol, sp.MatrixSymbol):
        return sp.MatrixSymbol(text, *symbol.shape)
    return sp.Symbol(text, **symbol.assumptions0)


@dataclass(frozen=True)
class Relation:
    """Something printed with a relation sign between two sides; a chain a = b = c is two relations.

    Parameters
    ----------
    left, right : Expr or Matrix
        The sides as printed, in the paper's symbols.
    op : str
        "=", "<", "<=", ">" or ">=".
    corrected, corrected_left : Expr or Matrix, optional
        The right side, and the left side, as they should read. Shown only if the relation fails as printed and holds
        with them.
    cases : tuple of mapping
        The relation must hold in each: meanings of family members, or of names in a special situation. They may refer
        to other names and override the table.
    domain : tuple of Expr
        Names are drawn such that each of these is positive.
    against : Expr or Matrix, optional
        Derived residual of an equation of motion, to be compared with the printed left minus right.
    given : bool
        Introduces a name or sets a condition: shown, but there is nothing to compare it with.
    within : Expr
        Allowed difference, for printed numbers; zero for everything else.
    says : str
        What is checked, in words, where the formula is not what is printed.
    """

    left: Side
    right: Side
    op: Op = "="
    corrected: Side | None = None
    corrected_left: Side | None = None
    cases: tuple[Case, ...] = ({},)
    domain: tuple[Expr, ...] = ()
    against: Side | None = None
    given: bool = False
    within: Expr = sp.S.Zero
    says: str = ""

    @property
    def sides(self) -> tuple[Side, ...]:
        """Everything that is compared."""
        given = (self.left, self.right, self.corrected, self.corrected_left, self.against)
        return tuple(side for side in given if side is not None)


@dataclass(frozen=True)
class Reading:
    """One way to read what is printed.

    Parameters
    ----------
    relations : tuple of Relation
        What it says; all must hold. Empty for words or names that nothing can be compared with.
    text : str
        What distinguishes this reading; empty when there is only one.
    used : bool
        Whether this is the one the model follows.
    why : str
        Why it is, or is not.
    """

    relations: tuple[Relation, ...] = ()
    text: str = ""
    used: bool = True
    why: str = ""


@dataclass(frozen=True)
class Printed:
    """An entry of the ledger: a numbered equation, or a row of a table or a sentence that can be checked.

    Parameters
    ----------
    number : str
        "22", or where it stands: "Table 1, row 2", "text after (9)".
    title : str
        What it is about, in a few words.
    kind : str
        equation, definition, condition, statement or data.
    readings : tuple of Reading
        As many as there are ways to read it; exactly one is `used`.
    note : str
        Said with the verdict: what a correction rests on, what was left out, slips that no formula can show.
    """

    number: str
    title: str
    kind: Kind
    readings: tuple[Reading, ...]
    note: str = ""

    def __post_init__(self) -> None:
        if sum(reading.used for reading in self.readings) != 1:
            raise ModelError(f"entry {self.number}: exactly one reading is used, not {[r.used for r in self.readings]}")


def printed(number: str, title: str, kind: Kind, *relations: Relation, note: str = "") -> Printed:
    """Return an entry that can be read in one way only, whose relations must all hold."""
    return Printed(number, title, kind, (Reading(relations),), note)


@dataclass(frozen=True)
class Paper:
    """A paper's ledger before it is judged.

    Parameters
    ----------
    title : str
        The publication.
    numbers : int
        Its equations are numbered from 1 to this.
    names : Names
        Its symbols.
    entries : tuple of Printed
        In the order of the paper.
    note : str
        Said once for all entries, such as what text was at hand.

    Raises
    ------
    ModelError
        If an equation number is missing or entered twice, or a symbol is not in the table of names.
    """

    title: str
    numbers: int
    names: Names
    entries: tuple[Printed, ...]
    note: str = ""

    def __post_init__(self) -> None:
        given = [entry.number for entry in self.entries]
        numbers = [number for number in given if number.isdecimal()]
        missing = [k for k in range(1, self.numbers + 1) if str(k) not in numbers]
        twice = sorted({number for number in given if given.count(number) > 1})
        beyond = [number for number in numbers if not 1 <= int(number) <= self.numbers]
        if missing or twice or beyond:
            raise ModelError(f"equation numbers missing {missing}, entered twice {twice}, not in the paper {beyond}")
        for name in self.names.table.values():
            if name.meaning is not None:
                self._known((name.meaning,), {}, f"the meaning of {name.symbol}", members=True)
        for entry in self.entries:
            for relation in (relation for reading in entry.readings for relation in reading.relations):
                for case in relation.cases:
                    self._known((*relation.sides, *relation.domain), case, f"entry {entry.number}", relation.given)

    def _known(self, sides: Iterable[Side], case: Case, where: str, members: bool = False) -> None:
        """Refuse a symbol that has no name; and, unless `members`, a member of a family that the case says nothing of.

        Meanings are followed: one may be about a member of a family itself.
        """
        seen: set[Expr] = set()
        waiting = [symbol for side in sides for symbol in symbols_of(side)]
        while waiting:
            symbol = waiting.pop()
            if symbol in seen:
                continue
            seen.add(symbol)
            name = self.names.table.get(symbol)
            if name is None and symbol not in case:
                raise ModelError(f"{where} uses {str(symbol)!r}, which the table of names lacks")
            meaning = case.get(symbol, name and name.meaning)
            if meaning is not None:
                waiting.extend(symbols_of(meaning))
            elif name is not None and name.member and not members:
                raise ModelError(f"{where} uses {str(symbol)!r}, a member of a family; no case says which")


class Cross(sp.MatrixExpr):  # type: ignore[misc]
    """The product a x b of two columns, written but not carried out; for the plane, its component out of it."""

    def __new__(cls, a: Side, b: Side) -> Cross:  # noqa: D102
        product: Cross = sp.Basic.__new__(cls, sp.sympify(a), sp.sympify(b))
        return product

    @property
    def shape(self) -> tuple[sp.Expr, sp.Expr]:
        """3 x 1, or 1 x 1 in the plane."""
        rows = self.args[0].shape[0]
        return (rows, sp.S.One) if rows == 3 else (sp.S.One, sp.S.One)

    def doit(self, **hints: bool) -> sp.MatrixExpr | sp.MatrixBase:
        """Carry the product out if both columns are known entry by entry."""
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
    """Return a side that can be compared and looked up."""
    return side.as_immutable() if isinstance(side, sp.MatrixBase) else sp.sympify(side)


def symbols_of(side: Side) -> set[Expr]:
    """Return the names in a side: symbols and matrix symbols, without dummies of integrals and limits."""
    return {symbol for symbol in sp.sympify(side).free_symbols if isinstance(symbol, sp.Symbol | sp.MatrixSymbol)}


def follow(expr: Expr, definitions: Mapping[sp.Symbol, Expr], cut: Case | None = None) -> Expr:
    """Write a derived expression out, its definitions followed down to the names of the paper.

    Parameters
    ----------
    expr : Expr
        Made of symbols of the derivation.
    definitions : mapping
        `system.definitions`, or those of a `Derivation` made on the spot.
    cut : mapping, optional
        Symbols that are replaced instead of followed: our quantities, by the paper's names.

    Returns
    -------
    Expr
        Free of defined symbols.
    """
    cut = cut or {}
    found = {symbol: cut[symbol] for symbol in expr.free_symbols if symbol in cut}
    for symbol in expr.free_symbols - set(found):
        if symbol in definitions:
            found[symbol] = follow(definitions[symbol], definitions, cut)
    return expr.subs(found, simultaneous=True)
