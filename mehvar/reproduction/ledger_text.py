# SPDX-License-Identifier: Apache-2.0
"""Checked ledgers as text: wrong printed equations in full, others by number."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from rich.text import Text

from mehvar.terminal import Line

from .ledgers import Ledger

_DIFFERS, _HOLDS, _DEFINITION = "differs", "holds", "definition"
_AMBIGUOUS, _SCAN = "illegible or ambiguous", "damage of the scan"
_STYLES = {_DIFFERS: "red", "undecided": "yellow", _AMBIGUOUS: "yellow"}
_WORDS = {_HOLDS: "hold", _DIFFERS: "differ", _DEFINITION: "definitions"}


def holds(ledger: Ledger) -> bool:
    """Return True if all printed entries hold or are definitions."""
    return not any(entry["verdict"] in _STYLES for entry in ledger["entries"])


def counted(ledger: Ledger) -> str:
    """Return the numbers of entries by verdict, as in "31 hold, 27 differ"."""
    counts = [(count, _WORDS.get(verdict, verdict)) for verdict, count in ledger["counts"].items()]
    return ", ".join(f"{count} {word}" for count, word in counts if count)


def slips(ledger: Ledger) -> str:
    """Return the numbers of errata by kind, as in "8 damage of the scan, 3 physics"."""
    return ", ".join(f"{count} {kind}" for kind, count in ledger["slips"].items() if count)


def correction(entry: dict[str, Any]) -> str:
    """Return the label of an entry's corrected form: "correct", or "assumption" without a proof."""
    return "assumption" if entry["erratum"] and entry["erratum"]["assumption"] else "correct"


def evidence_verdict(entry: dict[str, Any]) -> str:
    """Return the verdict of an entry for statements that use it; errors of the scan do not count."""
    damaged = entry["erratum"] and entry["erratum"]["kind"] == _SCAN
    return _AMBIGUOUS if damaged else str(entry["verdict"])


def lines(ledgers: Sequence[Ledger]) -> Iterator[Line]:
    """Yield the wrong printed equations of each paper, and the numbers of the others."""
    for ledger in ledgers:
        yield 0, Text.assemble((f"{ledger['model']}: ", "bold"), counted(ledger))
        yield 0, Text(ledger["title"], "dim")
        if ledger["note"]:
            yield 0, Text(ledger["note"], "dim")
        if slips(ledger):
            yield 2, Text.assemble(("errata  ", "green"), slips(ledger))
        for verdict in (_HOLDS, _DEFINITION):
            numbers = [entry["number"] for entry in ledger["entries"] if entry["verdict"] == verdict]
            if numbers:
                yield 2, Text.assemble((f"{_WORDS[verdict]}  ", "green"), ", ".join(numbers))
        for entry in ledger["entries"]:
            if entry["verdict"] in _STYLES:
                yield from _entry(entry)


def example(line: dict[str, Any]) -> str:
    """Return a counterexample on one line; empty without one."""
    point = line["counterexample"]
    if not point:
        return ""
    values = [f"{name} = {value}" for name, value in point["at"] if str(value) != "0"]
    if len(values) < len(point["at"]):
        values.append("the rest 0" if values else "all 0")
    where = f"at {', '.join(values)}: " if values else ""
    return f"{where}left side {point['left']}, right side {point['right']}"


def _entry(entry: dict[str, Any]) -> Iterator[Line]:
    """Yield the lines of an equation that the paper misprints: verdict, erratum, wrong lines of each reading, note."""
    yield (
        2,
        Text.assemble(
            (f"{entry['verdict']} ", _STYLES[entry["verdict"]]), (entry["number"], "bold"), f"  {entry['title']}"
        ),
    )
    if entry["erratum"]:
        yield 4, Text(f"{entry['erratum']['kind']}: {entry['erratum']['cause']}")
    for reading in entry["readings"]:
        if len(entry["readings"]) > 1:
            used = "the model follows this" if reading["used"] else "not used"
            yield 4, Text(f"reading {reading['text']!r}: {reading['verdict']} ({used}) {reading['why']}")
        for line in reading["lines"]:
            if line["verdict"] in _STYLES:
                yield from _relation(line, correction(entry))
    if entry["note"]:
        yield 4, Text(entry["note"], "dim")


def _relation(line: dict[str, Any], called: str) -> Iterator[Line]:
    """Yield a printed line with its correction, the edits between both, an example and the evidence."""
    yield 4, Text(f"printed  {line['printed']}", "red")
    if line["corrected"]:
        yield 4, Text(f"{called}  {line['corrected']}", "green")
    for edit in line["edits"]:
        yield 6, Text(edit)
    for text in (line["says"], example(line)):
        if text:
            yield 6, Text(text)
    yield 6, Text(line["how"], "dim")
