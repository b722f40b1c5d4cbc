# SPDX-License-Identifier: Apache-2.0
"""Vocabulary of a ledger: printed equations and the derived meanings of their symbols.

The folder papers/MODEL, beside models/, has a module `ledger` (or a package) with a function

    def paper(system: System) -> Paper

which `mehvar diff --paper` checks. A ledger states two things separately:

* **the printed equations**, misprints included, as SymPy expressions in the paper's symbols (`Relation.left`,
  `.right`);
* **the meaning of the symbols**, in one table of names for the paper (`Names`). A *free* name (a coordinate, a rate, a
  parameter) can have any value within bounds. The meaning of a *derived* name is an expression from the system's
  derivation (`insert_definitions`), or one that the ledger derives by differentiation, integration or substitution.
  Do not copy a meaning from the printed formula: the comparison would be vacuous.

A relation holds if both sides are the same function of the free names after all meanings are inserted. mehvar computes
every verdict. The author adds corrections of misprinted relations (mehvar also tests these and shows no wrong
correction), the readings of ambiguous print, and notes.

How to write an entry
---------------------
An identity between names with meanings, here l_i^2 of a triangle and its rate, for each i (the paper prints it once)::

    names = Names()
    rho = names.free(RHO, 0, "7/10")                          # a quantity of the model, and its range
    v = names.free("v_1", r"v_1", -2, 2)                      # a symbol that only the paper has
    h = names.derived("h", "h", insert_definitions(symbol_of_h, system.definitions, {rho_t: rho}))
    u, l = names.family("u", "u_i"), names.family("l", "l_i") # stand for any member; each case states which
    rods = [{u: rate_k, l: length_k} for ...]                 # meanings of u and l for each member

    printed("22", "rod rates", "equation", Relation(u, l * w3 / (2 * mu) + ..., corrected=..., cases=rods))

* *Definitions* of the paper (kind "definition") are compared if the derivation has the same definition: the verdict is
  "definition" if both agree, else "differs". With `given=True` nothing is compared: the relation introduces a name or
  sets a condition.
* An *equation of motion* holds only along motions, so its sides are not the same function. Give the derived residual
  (left minus right) as `against`; the printed left minus right is compared with it.
* A statement about a *special situation* (on the surface s = 0, on the circle) is a case that gives names their
  meaning in this situation: ``cases=({rho_t: h},)``. A case overrides the table of names.
* *Inequalities* use the op "<", "<=", ">" or ">="; they are tested at random points of `domain`.
* *Integrals, derivatives and limits* are written unevaluated (``sp.Integral``, ``sp.Derivative``, ``sp.Limit``) and
  evaluated after the meanings are inserted.
* *Matrices*: ``names.matrix("S", "S", meaning)`` gives a MatrixSymbol, so that ``S * S`` prints as S^2. Sides of
  different shape differ. A 1x1 matrix counts as a number. `Cross(a, b)` is a x b.
* SymPy simplifies expressions: sin(x - 2 pi/3) becomes -sin(x + pi/3). ``sp.UnevaluatedExpr(2 * sp.pi / 3)`` keeps a
  part as printed; it is evaluated before the comparison.
* A *number* with few digits is compared within `within`, such as one unit of the last printed digit.
* A checkable *sentence* is an entry too, with a number such as "text after (9)" and `Relation.says`.
* An *erratum* states kind and cause of the error of an entry that differs or whose readings disagree. The errata of a
  paper are one table, by the numbers of the entries::

    ERRATA = {"11": Erratum(ErratumKind.SCAN, "The bar over the mean mass is lost.")}
* *Readings* are the possible interpretations of an ambiguous print; exactly one is `used`, which the model follows.
  mehvar checks each reading. If their verdicts disagree, the entry is "illegible or ambiguous"::

    printed("34", "predicted output", "equation")
    .reading("with the estimate of this sample", Relation(...), used=False, why="A circle, with (39) and (42).")
    .reading("with the estimate of the sample before", Relation(...), why="(39) and (42) need it.")

A module of a ledger is a list of entries in the order of the paper: functions that `yield` the entries, each preceded
by its definitions.

`Paper` refuses a number that is missing or entered twice, and a symbol that the table of names lacks. While writing,
check single entries: ``mehvar.ledger.check_entry(entry, names)``; `check_paper(paper, "MODEL")` checks all.
`papers/triangle/ledger/` is a complete example.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import Literal, TypeAlias

import sympy as sp

from .derivation import Expr
from .notation import Case, Cross, Name, Names, Side, frozen, insert_definitions, symbols_of
from .quantities import ModelError

__all__ = [
    "Case",
    "Cross",
    "Erratum",
    "ErratumKind",
    "Kind",
    "Name",
    "Names",
    "Op",
    "Paper",
    "Printed",
    "Reading",
    "Relation",
    "Side",
    "frozen",
    "insert_definitions",
    "printed",
    "symbols_of",
]

Op: TypeAlias = Literal["=", "<", "<=", ">", ">="]
Kind: TypeAlias = Literal["equation", "definition", "condition", "statement", "data"]
"""Kinds of entries: a derived equation; a definition, condition or datum chosen by the author; a statement in words."""


@dataclass(frozen=True)
class Relation:
    """A printed relation between two sides; a chain a = b = c gives two relations.

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
        """All sides that are compared."""
        sides = (self.left, self.right, self.corrected, self.corrected_left, self.against)
        return tuple(side for side in sides if side is not None)


class ErratumKind(StrEnum):
    """Kinds of errors in printed statements, by origin.

    scan: in the scanned copy. A dot, a bar, a bracket or an exponent is lost, similar letters are confused, or a
    right-to-left line is reversed; the surrounding formulas show the intended one. notation: in the paper's symbols:
    one letter for two things, two letters for one, an unexplained letter, an unusual convention. misprint: in
    typesetting. The authors used the right formula, as later formulas show. physics: in the derivation or in a
    number. Results that depend on it change.
    """

    SCAN = "damage of the scan"
    NOTATION = "notation"
    MISPRINT = "misprint"
    PHYSICS = "physics"


@dataclass(frozen=True)
class Erratum:
    """Reason for an error in a printed statement.

    Parameters
    ----------
    kind : Slip
        Origin of the error.
    cause : str
        Cause in one sentence.
    assumption : bool
        True if the correction is an assumption that the paper neither supports nor contradicts.

    Raises
    ------
    ModelError
        If the cause is not one sentence.
    """

    kind: ErratumKind
    cause: str
    assumption: bool = False

    def __post_init__(self) -> None:
        if len(self.cause) < 2 or not self.cause.endswith(".") or ". " in self.cause:
            raise ModelError(f"cause = {self.cause!r}: must be one sentence that ends with a full stop")


@dataclass(frozen=True)
class Reading:
    """One reading of a printed entry.

    Parameters
    ----------
    relations : tuple of Relation
        All must hold. Empty for words or names without a comparison.
    text : str
        Difference from other readings; empty for a single reading.
    used : bool
        True for the reading that the model follows.
    why : str
        Reason for this choice.
    """

    relations: tuple[Relation, ...] = ()
    text: str = ""
    used: bool = True
    why: str = ""


@dataclass(frozen=True)
class Printed:
    """An entry of the ledger: a numbered equation, a table row or a checkable sentence.

    Parameters
    ----------
    number : str
        Number or place, such as "22", "Table 1, row 2" or "text after (9)".
    title : str
        Its subject, in a few words.
    kind : str
        equation, definition, condition, statement or data.
    readings : tuple of Reading
        One for each possible reading; exactly one must be `used`.
    note : str
        Printed with the verdict: reasons for a correction, omissions, errors that no formula can show.
    """

    number: str
    title: str
    kind: Kind
    readings: tuple[Reading, ...]
    note: str = ""

    def reading(self, text: str, *relations: Relation, used: bool = True, why: str = "") -> Printed:
        """Return the entry with an additional reading; see `Reading`."""
        return replace(self, readings=(*self.readings, Reading(relations, text, used, why)))


def printed(number: str, title: str, kind: Kind, *relations: Relation, note: str = "") -> Printed:
    """Return an entry whose relations must all hold, or without relations an entry to which `reading` adds readings.

    Parameters
    ----------
    number, title : str
        Number of the equation, or its place in the paper; its subject.
    kind : str
        "equation", "definition", "condition", "statement" or "data".
    *relations : Relation
        What is printed; none where readings follow.
    note : str
        Words on the entry.
    """
    return Printed(number, title, kind, (Reading(relations),) if relations else (), note)


@dataclass(frozen=True)
class Paper:
    """Ledger of a paper, before the verdicts.

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
        Note on all entries, such as the source of the text.
    errata : mapping of str to Erratum
        Errata by the numbers of their entries.

    Raises
    ------
    ModelError
        If an equation number is missing or entered twice, a symbol is not in the table of names, or an erratum is of no
        entry.
    """

    title: str
    numbers: int
    names: Names
    entries: tuple[Printed, ...]
    note: str = ""
    errata: Mapping[str, Erratum] = field(default_factory=dict)

    def __post_init__(self) -> None:
        entered = [entry.number for entry in self.entries]
        strange = sorted(self.errata.keys() - set(entered))
        if strange:
            raise ModelError(f"errata refer to entries that do not exist: {strange}; use entry numbers of the ledger")
        numbers = [number for number in entered if number.isdecimal()]
        missing = [k for k in range(1, self.numbers + 1) if str(k) not in numbers]
        twice = sorted({number for number in entered if entered.count(number) > 1})
        beyond = [number for number in numbers if not 1 <= int(number) <= self.numbers]
        if missing or twice or beyond:
            raise ModelError(f"equation numbers: missing {missing}; entered twice {twice}; not in the paper {beyond}")
        for entry in self.entries:
            if sum(reading.used for reading in entry.readings) != 1:
                used = [reading.used for reading in entry.readings]
                raise ModelError(f"entry {entry.number}: must use exactly one reading, not {used}")
        for name in self.names.table.values():
            if name.meaning is not None:
                self._refuse_unnamed((name.meaning,), {}, f"the meaning of {name.symbol}", members=True)
        for entry in self.entries:
            for relation in (relation for reading in entry.readings for relation in reading.relations):
                for case in relation.cases:
                    self._refuse_unnamed(
                        (*relation.sides, *relation.domain), case, f"entry {entry.number}", relation.given
                    )

    def _refuse_unnamed(self, sides: Iterable[Side], case: Case, where: str, members: bool = False) -> None:
        """Refuse unknown symbols and, unless `members` is true, indexed names that the case does not define.

        The check includes meanings, which may themselves contain members of a family.
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
                raise ModelError(f"{where} uses {str(symbol)!r}, an indexed name: add a case that defines it")
