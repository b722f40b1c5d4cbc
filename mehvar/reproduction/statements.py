# SPDX-License-Identifier: Apache-2.0
"""Statements of a paper, sentence by sentence, with verdicts, from its `statements.toml`.

A file holds the paper's counts of equations, tables and figures. It has a statement for every sentence of abstract and
conclusions, every table, every figure, and every other checkable sentence. A long sentence may have several entries,
and an entry may join several short sentences; entries are counted::

    [printed]
    equations = 53
    tables = 1
    figures = 11

    [[statement]]
    place = "conclusions 2"         # "abstract 1", "table 1", "figure 4", "section 5"; "beyond the paper" is ours
    text = "Sliding control chatters near the surface."
    claims = ["5"]                  # numbers of claims.toml and of the metric table (R1, ...)
    equations = ["(32)"]            # entries of the ledger, by its own numbers: "(32)", "text before (12)"
    figures = [4]                   # where it is shown
    remark = ""                     # needed where nothing can be judged: why, or where future work is done

A statement gets the worst verdict of its evidence. Without evidence it is not judged, and its remark gives the reason.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum

from mehvar.base.errors import InputError

from .claims import Claim, ClaimVerdict

BEYOND = "beyond the paper"
"""Place of a statement that is our own."""


class StatementVerdict(StrEnum):
    """Verdict on a sentence, best first."""

    HOLDS = "holds"
    VARIANT = "holds for a variant"
    PART = "holds in part"
    READING = "holds under another reading"
    MISPRINT = "rests on a formula that is misprinted"
    PRINTED = "does not hold as printed"
    REFUTED = "does not hold"
    OPEN = "undecided"
    BACKGROUND = "not judged"


_CLAIMS = {
    ClaimVerdict.HOLDS: StatementVerdict.HOLDS,
    ClaimVerdict.VARIANT: StatementVerdict.VARIANT,
    ClaimVerdict.PART: StatementVerdict.PART,
    ClaimVerdict.READING: StatementVerdict.READING,
    ClaimVerdict.OPEN: StatementVerdict.OPEN,
    ClaimVerdict.PRINTED: StatementVerdict.PRINTED,
    ClaimVerdict.REFUTED: StatementVerdict.REFUTED,
    ClaimVerdict.FAILS: StatementVerdict.REFUTED,
}
_EQUATIONS = {
    "holds": StatementVerdict.HOLDS,
    "definition": StatementVerdict.HOLDS,
    "illegible or ambiguous": StatementVerdict.READING,
    "differs": StatementVerdict.MISPRINT,
    "undecided": StatementVerdict.OPEN,
}


@dataclass(frozen=True)
class PrintedCounts:
    """Numbers of the equations, tables and figures that a paper prints."""

    equations: int
    tables: int
    figures: int


@dataclass(frozen=True)
class StatementText:
    """A sentence of a paper with its evidence: claims, equations of the ledger, figures."""

    place: str
    text: str
    claims: tuple[str, ...] = ()
    equations: tuple[str, ...] = ()
    figures: tuple[int, ...] = ()
    remark: str = ""


@dataclass(frozen=True)
class Statements:
    """A paper's `statements.toml`."""

    printed: PrintedCounts
    statement: tuple[StatementText, ...] = ()


@dataclass(frozen=True)
class Statement:
    """A sentence and its verdict."""

    text: StatementText
    verdict: StatementVerdict


@dataclass(frozen=True)
class Coverage:
    """Numbers of items of one kind that a paper prints, that are judged, and that the report shows.

    Attributes
    ----------
    printed : int or None
        None for entries on parts of the text, because the paper's sentences are not counted.
    """

    kind: str
    printed: int | None
    judged: int
    shown: int


def statement_verdicts(
    statements: Statements, claims: Sequence[Claim], equations: Mapping[str, str]
) -> list[Statement]:
    """Return every statement with its verdict.

    Parameters
    ----------
    statements : Statements
        The paper's statements.
    claims : sequence of Claim
        The decided claims.
    equations : mapping of str to str
        The verdicts of the ledger by the number of the entry.

    Raises
    ------
    InputError
        If a statement names an unknown claim or equation, or has neither evidence nor a remark.
    """
    by_number = {claim.number: claim.verdict for claim in claims}
    return [Statement(text, _verdict(text, by_number, equations)) for text in statements.statement]


def _verdict(text: StatementText, claims: Mapping[str, ClaimVerdict], equations: Mapping[str, str]) -> StatementVerdict:
    """Return the worst verdict of the claims and equations of a statement; "background" if a remark explains it."""
    _known(text, "claim", text.claims, claims)
    _known(text, "equation", text.equations, equations)
    parts = [_CLAIMS[claims[number]] for number in text.claims]
    parts += [_EQUATIONS[equations[number]] for number in text.equations]
    if parts:
        return max(parts, key=list(StatementVerdict).index)
    if text.figures or text.remark:
        return StatementVerdict.BACKGROUND
    raise InputError(f"statements.toml: {text.place}: must name a claim or a figure, or have a remark with the reason")


def _known(text: StatementText, kind: str, numbers: Iterable[str], allowed: Mapping[str, object]) -> None:
    for number in numbers:
        if number not in allowed:
            raise InputError(f"statements.toml: {text.place}: {kind} {number!r} does not exist: {', '.join(allowed)}")


def coverage(
    statements: Statements, judgements: Sequence[Statement], equations: Mapping[str, str], figures: Iterable[int]
) -> list[Coverage]:
    """Count the items that are printed, judged and shown.

    The errata show an equation that fails, the model's equations one that holds. The list of statements shows tables
    and entries on the text.
    """
    printed, drawn = statements.printed, set(figures)
    numbered = [equations[f"({k})"] for k in range(1, printed.equations + 1) if f"({k})" in equations]
    of_figures = range(1, printed.figures + 1)
    judged = [s for s in judgements if s.verdict is not StatementVerdict.BACKGROUND]

    def count(kind: str, items: Iterable[Statement]) -> int:
        return sum(item.text.place.startswith(kind) for item in items)

    rows = [
        Coverage("equations", printed.equations, sum(verdict != "undecided" for verdict in numbered), len(numbered)),
        Coverage("tables", printed.tables, count("table ", judged), count("table ", judgements)),
        Coverage("figures", printed.figures, count("figure ", judged), sum(k in drawn for k in of_figures)),
    ]
    for kind, title in (("abstract", "abstract"), ("conclusions", "conclusions"), ("section", "sections")):
        entries = count(kind, judgements)
        rows.append(Coverage(f"entries on the {title}", None, count(kind, judged), entries))
    return rows
