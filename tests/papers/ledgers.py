# SPDX-License-Identifier: Apache-2.0
"""Checks of the ledger of every paper."""

from __future__ import annotations

import dataclasses
import xml.etree.ElementTree as ET
from pathlib import Path

import sympy as sp

from mehvar.codegen.ledger.ledger import Entry, EntryVerdict, Ledger, check_entry
from mehvar.html import typeset_within
from mehvar.models.paper import ErratumKind, Paper
from mehvar.models.system import Definition, Equation, System
from tests.docs.formulas import MATH, faults

PAGE = Path(__file__).parents[2] / "docs" / "explanation" / "ledger.md"


def broken(system: System, *names: str) -> System:
    """Put a wrong factor into steps of the derivation, evaluated or shown, by their symbol, left side or number."""
    steps = tuple(
        dataclasses.replace(step, expr=step.expr * sp.Rational(9, 10))
        if (isinstance(step, Definition) and step.symbol.name in names)
        or (isinstance(step, Equation) and {step.left, step.number} & set(names))
        else step
        for step in system.steps
    )
    return dataclasses.replace(system, steps=steps)


def checked(paper: Paper, *numbers: str) -> dict[str, Entry]:
    """Judge a few entries of a paper, such as one against a broken system."""
    chosen = {entry.number: entry for entry in paper.entries}
    return {number: check_entry(chosen[number], paper.names) for number in numbers}


def equations(ledger: Ledger) -> list[int]:
    """Return the numbers of the numbered equations, sorted."""
    return sorted(int(entry.number[1:-1]) for entry in ledger.entries if entry.number.startswith("("))


def judged(ledger: Ledger, verdict: EntryVerdict) -> set[str]:
    """Return the numbers of the entries with a verdict."""
    return {entry.number for entry in ledger.entries if entry.verdict is verdict}


def check_ledger(ledger: Ledger, numbers: int) -> None:
    """Numbers have entries, none is undecided; each erratum, and nothing else, has a cause and changes as MathML."""
    assert equations(ledger) == list(range(1, numbers + 1))
    assert not judged(ledger, EntryVerdict.UNDECIDED)
    errata = [entry for entry in ledger.entries if entry.wrong]
    assert [entry for entry in ledger.entries if entry.erratum] == errata
    assert sum(ledger.slips().values()) == len(errata)
    lines = [line for entry in errata for reading in entry.readings for line in reading.lines]
    for edit in (edit for line in lines for edit in line.edits_latex):
        words = str(typeset_within(edit))
        formulas = MATH.findall(words)
        assert len(ET.fromstring(f"<p>{words}</p>").findall("math")) == len(formulas) == edit.count("$") / 2
        assert not [fault for formula in formulas for fault in faults(formula)], edit
    assert counted(ledger) in PAGE.read_text(encoding="utf-8"), (
        f"the table of {PAGE.name} should have {counted(ledger)}"
    )


def counted(ledger: Ledger) -> str:
    """Return the row of a paper in the table of errata."""
    slips = ledger.slips()
    assumed = sum(entry.erratum.assumption for entry in ledger.entries if entry.erratum)
    cells = [ledger.model, len(ledger.entries), *(slips[kind] for kind in ErratumKind), sum(slips.values()), assumed]
    return f"| {' | '.join(map(str, cells))} |"
