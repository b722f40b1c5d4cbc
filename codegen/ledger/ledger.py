# SPDX-License-Identifier: Apache-2.0
"""Ledger of a paper: verdicts on its printed equations, tables and sentences, based on the derivation.

`mehvar.models.paper` defines printed statements and the meanings of their symbols. This module expands both sides of
each relation and compares them by their form (proved) or at random points with 50 digits (tested). A relation that
fails gets a simple counterexample. If the paper's module proposes a correction, the correction is tested in the same
way.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import Any

import sympy as sp

from mehvar.models.paper import Erratum, ErratumKind, Kind, Names, Paper, Printed, Reading, Relation, Side

from ..equal.verdicts import Counterexample, Verdict
from .meanings import Meanings
from .misprints import Edit, edits
from .relations import compare, residuals

_CHOSEN: tuple[Kind, ...] = ("definition", "condition", "data")


class EntryVerdict(StrEnum):
    """Verdict on a printed statement."""

    HOLDS = "holds"
    DIFFERS = "differs"
    DEFINITION = "definition"
    AMBIGUOUS = "illegible or ambiguous"
    UNDECIDED = "undecided"


@dataclass(frozen=True)
class Line:
    """A relation with its verdict, as text and LaTeX.

    Attributes
    ----------
    printed, printed_latex : str
        As printed.
    corrected, corrected_latex : str
        Corrected form; empty if the relation holds, or if no correction passed.
    verdict : EntryVerdict
        Verdict on this relation.
    how : str
        Evidence for the verdict.
    edits, edits_latex : tuple of str
        Corrections, term by term, as text, and with the formulas as LaTeX between dollar signs.
    counterexample : Counterexample or None
        A point where it fails.
    says : str
        The tested claim in words, where the formula is not the printed one.
    """

    printed: str
    printed_latex: str
    corrected: str
    corrected_latex: str
    verdict: EntryVerdict
    how: str
    edits: tuple[str, ...]
    edits_latex: tuple[str, ...]
    counterexample: Counterexample | None
    says: str


@dataclass(frozen=True)
class ReadingVerdict:
    """A reading of an entry, with its verdict."""

    text: str
    used: bool
    why: str
    verdict: EntryVerdict
    lines: tuple[Line, ...]


@dataclass(frozen=True)
class Entry:
    """Verdict on a numbered equation, table row or sentence.

    Attributes
    ----------
    number : str
        "(22)", or its place in the paper.
    title, kind : str
        Its subject; equation, definition, condition, statement or data.
    verdict : EntryVerdict
        Verdict on the entry: *illegible or ambiguous* if its readings disagree.
    readings : tuple of ReadingVerdict
        Readings, each with its own verdict.
    erratum : Erratum or None
        Kind and cause of the error; None without an error, or if the paper's module gives none.
    note : str
        Note from the paper's module.
    """

    number: str
    title: str
    kind: str
    verdict: EntryVerdict
    readings: tuple[ReadingVerdict, ...]
    erratum: Erratum | None
    note: str

    @property
    def wrong(self) -> bool:
        """True for an erratum: the entry is wrong, or its readings disagree."""
        return self.verdict in (EntryVerdict.DIFFERS, EntryVerdict.AMBIGUOUS)

    @property
    def used(self) -> ReadingVerdict:
        """The reading that the model follows."""
        return next(reading for reading in self.readings if reading.used)

    @property
    def how(self) -> str:
        """Evidence for the verdict, on one line."""
        return "; ".join(dict.fromkeys(line.how for line in self._telling()))

    @property
    def printed_latex(self) -> tuple[str, ...]:
        """The printed relations."""
        return tuple(line.printed_latex for line in self.used.lines)

    @property
    def corrected_latex(self) -> tuple[str, ...]:
        """Corrected form of the relations with corrections."""
        return tuple(line.corrected_latex for line in self.used.lines if line.corrected_latex)

    @property
    def edits(self) -> tuple[str, ...]:
        """Corrections, term by term."""
        return tuple(edit for line in self.used.lines for edit in line.edits)

    @property
    def counterexample(self) -> Counterexample | None:
        """Point at which the entry is wrong."""
        return next((line.counterexample for line in self.used.lines if line.counterexample), None)

    def _telling(self) -> Iterable[Line]:
        failing = [line for line in self.used.lines if line.verdict == self.verdict]
        return failing or self.used.lines


@dataclass(frozen=True)
class Ledger:
    """Checked entries of a paper in its order, with general remarks.

    Attributes
    ----------
    model, title : str
        Name of the model; the publication.
    entries : tuple of Entry
        In the order of the paper.
    note : str
        Remarks on the whole.
    """

    model: str
    title: str
    entries: tuple[Entry, ...]
    note: str = ""

    def counts(self) -> dict[str, int]:
        """Count the entries by verdict."""
        return {verdict.value: sum(entry.verdict is verdict for entry in self.entries) for verdict in EntryVerdict}

    def slips(self) -> dict[str, int]:
        """Count the errata by kind."""
        kinds = [entry.erratum.kind for entry in self.entries if entry.erratum and entry.wrong]
        return {kind.value: kinds.count(kind) for kind in ErratumKind}

    def __getitem__(self, number: str) -> Entry:
        """Return the entry with this number, as in "(22)"."""
        return next(entry for entry in self.entries if entry.number == number)

    def to_json(self) -> dict[str, Any]:
        """Return the ledger as plain lists, dicts and strings."""
        return {"schema": 1, "counts": self.counts(), "slips": self.slips(), **asdict(self)}


def check_paper(paper: Paper, model: str) -> Ledger:
    """Check all entries of a paper.

    Parameters
    ----------
    paper : Paper
        Printed statements and meanings of symbols.
    model : str
        Name of the model that it is about.
    """
    meanings = Meanings(paper.names)
    entries = tuple(_entry(printed, meanings, paper.errata.get(printed.number)) for printed in paper.entries)
    return Ledger(model, paper.title, entries, paper.note)


def check_entry(printed: Printed, names: Names) -> Entry:
    """Check one entry.

    Parameters
    ----------
    printed : Printed
        The entry.
    names : Names
        The table of the paper's symbols.
    """
    return _entry(printed, Meanings(names))


def _entry(printed: Printed, meanings: Meanings, erratum: Erratum | None = None) -> Entry:
    readings = tuple(_reading(reading, printed, meanings) for reading in printed.readings)
    verdicts = {reading.verdict for reading in readings}
    verdict = verdicts.pop() if len(verdicts) == 1 else EntryVerdict.AMBIGUOUS
    number = f"({printed.number})" if printed.number.isdecimal() else printed.number
    return Entry(number, printed.title, printed.kind, verdict, readings, erratum, printed.note)


def _reading(reading: Reading, printed: Printed, meanings: Meanings) -> ReadingVerdict:
    """Return the verdict on a reading: the worst of its lines; definitions, conditions and data are definitions."""
    lines = tuple(_line(relation, meanings) for relation in reading.relations)
    verdicts = {line.verdict for line in lines}
    if EntryVerdict.DIFFERS in verdicts:
        verdict = EntryVerdict.DIFFERS
    elif EntryVerdict.UNDECIDED in verdicts:
        verdict = EntryVerdict.UNDECIDED
    elif printed.kind in _CHOSEN or verdicts <= {EntryVerdict.DEFINITION}:
        verdict = EntryVerdict.DEFINITION
    else:
        verdict = EntryVerdict.HOLDS
    return ReadingVerdict(reading.text, reading.used, reading.why, verdict, lines)


def _line(relation: Relation, meanings: Meanings) -> Line:
    if relation.given:
        return _unchanged(relation, meanings, EntryVerdict.DEFINITION, "given: nothing to compare")
    verdict = compare(relation, meanings)
    if verdict.equal is None:
        return _unchanged(relation, meanings, EntryVerdict.UNDECIDED, verdict.how)
    if verdict.equal:
        return _unchanged(relation, meanings, EntryVerdict.HOLDS, verdict.how)
    return _differing(relation, meanings, verdict)


def _unchanged(relation: Relation, meanings: Meanings, standing: EntryVerdict, how: str) -> Line:
    printed = _shown(relation.left, relation.op, relation.right, meanings.names)
    return Line(*printed, "", "", standing, how, (), (), None, relation.says)


def _differing(relation: Relation, meanings: Meanings, verdict: Verdict) -> Line:
    """Return the line of a failed relation, with its correction or the wrong terms of its residual."""
    names = meanings.names
    left = relation.left if relation.corrected_left is None else relation.corrected_left
    right = relation.right if relation.corrected is None else relation.corrected
    corrected, how = ("", ""), verdict.how
    changes: tuple[Edit, ...] = ()
    retest = None if (left, right) == (relation.left, relation.right) else compare(relation, meanings, left, right)
    if retest and retest.equal:
        corrected = _shown(left, relation.op, right, names)
        how = f"{how}; the corrected form is {retest.how}"
        changes = _changes(relation, left, right)
    elif relation.against is not None:
        terms, derived = residuals(relation, meanings)
        corrected = _shown(derived, relation.op, sp.S.Zero, names)
        how = f"{how}; the derived equation is shown instead of a correction"
        changes = edits(terms, derived)
    return Line(
        *_shown(relation.left, relation.op, relation.right, names),
        *corrected,
        EntryVerdict.DIFFERS,
        how,
        tuple(dict.fromkeys(edit.spelled(names.as_text) for edit in changes)),
        tuple(dict.fromkeys(edit.spelled(lambda part: f"${names.as_latex(part)}$") for edit in changes)),
        verdict.counterexample,
        relation.says,
    )


def _changes(relation: Relation, left: Side, right: Side) -> tuple[Edit, ...]:
    """Return the edits that turn the printed relation into the corrected one."""
    if (left, right) == (relation.right, relation.left):
        return (Edit((left, " and ", right, " are exchanged"), 1),)
    return (*edits(relation.left, left), *edits(relation.right, right))


def _shown(left: Side, op: str, right: Side, names: Names) -> tuple[str, str]:
    """Write a relation as text and as LaTeX."""
    sign = {"<=": r"\le", ">=": r"\ge"}.get(op, op)
    text = f"{names.as_text(left)} {op} {names.as_text(right)}"
    return text, f"{names.as_latex(left)} {sign} {names.as_latex(right)}"
