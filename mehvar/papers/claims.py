# SPDX-License-Identifier: Apache-2.0
"""What becomes of what a paper says: claims, and the checks that decide them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import TypeAlias

from mehvar.errors import InputError

from .runs import Runs, WatchedRuns

TIMES = 0.01
"""Allowed deviation of a time, relative: a settling time is a whole number of samples, and one sample is 0.2 to 0.9 %
of the times that the papers are about. With half of this no claim fails, and two rows get a note; with twice this three
claims lose theirs."""
AMPLITUDES = 0.02
"""Allowed deviation of an amplitude, relative: expected ones are given with two to four digits, and rounding alone is
up to 2.5 % of two. No verdict changes with half or twice this."""
COUNTS = 1.0
"""Allowed deviation of a count, absolute: a sign change at the end of a run is or is not within it."""

PAPERS, OWN = "claims of the papers", "rows of our own against an independent program"


class ClaimVerdict(StrEnum):
    """Verdict on a claim."""

    HOLDS = "holds"
    NOTE = "holds with a note"
    READING = "holds under another reading"
    PRINTED = "does not hold as printed"
    REFUTED = "does not hold, as documented"
    FAILS = "does not hold"

    def of(self, count: int) -> str:
        """Return the verdict of so many claims, in words."""
        return f"{count} {self if count == 1 else self.replace('holds', 'hold').replace('does', 'do')}"


@dataclass(frozen=True)
class Check:
    """One part of a claim: what was looked at, what was expected and what running the model gave.

    The claim itself does not depend on a check that is not essential; its failure deserves a note.
    """

    what: str
    expected: str
    measured: str
    holds: bool
    essential: bool = True


@dataclass(frozen=True)
class TriedReading:
    """Another way to read what a paper prints or leaves out, and the checks of a claim under it."""

    name: str
    text: str
    checks: tuple[Check, ...]

    @property
    def holds(self) -> bool:
        """Whether the claim holds under this reading."""
        return all(check.holds for check in self.checks if check.essential)


@dataclass(frozen=True)
class Claim:
    """Something a paper says and the checks that decide it; `explanation` is about the checks that may fail.

    What a paper says and our documents refute, in the reading that the model uses, is `refuted`: it fails when its
    checks hold. A text that came damaged has other `readings`, and under one of them the claim may hold after all;
    not so one about the text as it is `printed`. A claim of our `own` is a row of numbers of an independent program.
    """

    number: str
    text: str
    checks: tuple[Check, ...]
    explanation: str = ""
    refuted: bool = False
    readings: tuple[TriedReading, ...] = ()
    printed: bool = False
    own: bool = False

    @property
    def kind(self) -> str:
        """Whose claim it is: `PAPERS` or `OWN`."""
        return OWN if self.own else PAPERS

    @property
    def verdict(self) -> ClaimVerdict:
        """Verdict on the claim."""
        failed = [check for check in self.checks if not check.holds]
        if any(check.essential for check in failed):
            if not self.refuted:
                return ClaimVerdict.FAILS
            if not any(r.holds for r in self.readings):
                return ClaimVerdict.REFUTED
            return ClaimVerdict.PRINTED if self.printed else ClaimVerdict.READING
        if self.refuted:
            return ClaimVerdict.FAILS
        return ClaimVerdict.NOTE if failed else ClaimVerdict.HOLDS

    @property
    def outcome(self) -> str:
        """What trying other readings gave, in one line; empty where none was tried."""
        if not self.readings:
            return ""
        holding = [f"{r.name}: {r.text.removesuffix('.')}" for r in self.readings if r.holds]
        many = len(self.readings)
        if not holding:
            return f"Under none of {many} other readings tried." if many > 1 else "Not under the other reading tried."
        which = f"{len(holding)} of {many} other readings tried" if many > 1 else "the other reading tried"
        if self.printed:
            return f"Holds if read otherwise ({len(holding)} of {many} tried): {'; '.join(holding)}."
        return f"Holds under {which}: {'; '.join(holding)}."

    @property
    def expected(self) -> str:
        """What was expected, in one line."""
        return "; ".join(f"{check.what}: {check.expected}" for check in self.checks)

    @property
    def measured(self) -> str:
        """What was measured, in one line."""
        return "; ".join(f"{check.what}: {check.measured}" for check in self.checks)

    @property
    def note(self) -> str:
        """The explanation where one is due, else empty."""
        return "" if self.verdict is ClaimVerdict.HOLDS else self.explanation


@dataclass(frozen=True)
class ReadingText:
    """A reading that is tried for a claim: its name and what it changes, in one sentence."""

    __pydantic_config__ = {"extra": "forbid"}  # noqa: RUF012 - read by pydantic

    name: str
    text: str


@dataclass(frozen=True)
class ClaimText:
    """A claim before it is decided: an entry of a paper's `claims.toml`, with the numbers that its checks expect."""

    __pydantic_config__ = {"extra": "forbid"}  # noqa: RUF012 - read by pydantic

    number: str
    text: str
    explanation: str = ""
    refuted: bool = False
    printed: bool = False
    expected: Mapping[str, float] = field(default_factory=dict)
    reading: tuple[ReadingText, ...] = ()

    def number_of(self, name: str) -> float:
        """Return an expected number by its name.

        Raises
        ------
        InputError
            If the entry has no such number.
        """
        if name not in self.expected:
            raise InputError(f"claim {self.number} (claims.toml) lacks the expected number {name!r}")
        return self.expected[name]


Expected: TypeAlias = Callable[[str], float]
"""The expected numbers of a claim, by name."""
Checks: TypeAlias = Callable[[Runs, Expected], Sequence[Check]]
"""Runs the model and returns the checks of a claim."""


Readings: TypeAlias = Mapping[str, Mapping[str, Checks]]
"""By the number of a claim and the name of a reading: the checks of the claim under that reading."""


def decide(
    texts: Sequence[ClaimText], checks: Mapping[str, Checks], runs: Runs, readings: Readings | None = None
) -> list[Claim]:
    """Return the claims, each with its checks, also under the readings that are tried."""
    return [_decided(text, checks[text.number], (readings or {}).get(text.number, {}), runs) for text in texts]


def _decided(text: ClaimText, checks: Checks, readings: Mapping[str, Checks], runs: Runs) -> Claim:
    tried = tuple(TriedReading(r.name, r.text, _tried(readings[r.name], text.number_of, runs)) for r in text.reading)
    results = tuple(checks(runs, text.number_of))
    return Claim(text.number, text.text, results, text.explanation, text.refuted, tried, text.printed)


def _tried(checks: Checks, expected: Expected, runs: Runs) -> tuple[Check, ...]:
    """Return the checks of a reading; where a run of it is lost, numbers of the part before are no measurements.

    Only of readings: a claim may be about a loop that is lost, and then has a check that says so.
    """
    watched = WatchedRuns(runs)
    results = tuple(checks(watched, expected))
    if not watched.lost:
        return results
    ends = Check(
        "the runs reach their ends", "all", "; ".join(dict.fromkeys(run.reason for run in watched.lost)), False
    )
    return (ends, *(replace(check, measured="not measured", holds=False) for check in results))


def tally(claims: Iterable[Claim]) -> dict[str, list[tuple[ClaimVerdict, int]]]:
    """Count the papers' claims and our own rows apart, the papers' first; verdicts that none has are left out."""
    several = list(claims)
    counts = {kind: Counter(claim.verdict for claim in several if claim.kind == kind) for kind in (PAPERS, OWN)}
    return {kind: [(verdict, of[verdict]) for verdict in ClaimVerdict if of[verdict]] for kind, of in counts.items()}


def tally_text(kind: str, counts: Sequence[tuple[ClaimVerdict, int]]) -> str:
    """Return the counts of a kind as one line."""
    return f"{sum(count for _, count in counts)} {kind}: {'; '.join(v.of(count) for v, count in counts) or 'none'}"


def about(what: str, expected: float, measured: float, unit: str = "", tolerance: float = TIMES) -> Check:
    """Return the check that a number is within a relative tolerance of the expected one."""
    holds = abs(measured - expected) <= tolerance * abs(expected)
    return Check(what, f"{expected:g} {unit}".strip(), f"{measured:.4g} {unit}".strip(), holds)


def count(what: str, expected: float, measured: float) -> Check:
    """Return the check that a count is within one of the expected one."""
    return Check(what, f"{expected:g}", f"{measured:g}", abs(measured - expected) <= COUNTS)


def below(what: str, bound: float, measured: float, unit: str = "") -> Check:
    """Return the check that a number is below a bound."""
    return Check(what, f"< {bound:g} {unit}".strip(), f"{measured:.3g} {unit}".strip(), measured < bound)


def above(what: str, bound: float, measured: float, unit: str = "") -> Check:
    """Return the check that a number is above a bound."""
    return Check(what, f"> {bound:g} {unit}".strip(), f"{measured:.3g} {unit}".strip(), measured > bound)


def beside(check: Check) -> Check:
    """Return a check that the claim does not depend on."""
    return replace(check, essential=False)
