# SPDX-License-Identifier: Apache-2.0
"""Claims of papers, and the checks behind their verdicts."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import TypeAlias

from mehvar.base.errors import InputError
from mehvar.runtime.run.metrics import COUNTS, TIMES

from .runs import Runs, WatchedRuns

_SHOWN = 1e-4
"""Smallest tolerance that a check's expected value names: below it all printed digits agree."""
_LISTED = 3
"""Largest number of failed checks that a summary lists."""


class ClaimKind(StrEnum):
    """Origins of claims, which are counted apart."""

    PAPER = "claims of the papers"
    FINDING = "findings of our own"
    ROW = "rows of our own against an independent program"

    @property
    def one(self) -> str:
        """Noun for one of them."""
        return self.split()[0].removesuffix("s")

    def of(self, count: int) -> str:
        """Return a number of claims of this kind as text."""
        return f"{count} {self if count != 1 else self.replace(f'{self.one}s', self.one, 1)}"


class ClaimVerdict(StrEnum):
    """Kinds of verdict on a claim."""

    HOLDS = "holds"
    VARIANT = "holds for a variant"
    PART = "holds in part"
    READING = "holds under another reading"
    OPEN = "undecided"
    PRINTED = "does not hold as printed"
    REFUTED = "does not hold, as documented"
    FAILS = "does not hold"

    def of(self, count: int) -> str:
        """Return a number of claims with this verdict as text."""
        return f"{count} {self if count == 1 else self.replace('holds', 'hold').replace('does', 'do')}"


@dataclass(frozen=True)
class Check:
    """Part of a claim: an expected value and the run's value.

    Attributes
    ----------
    what : str
        The quantity.
    expected, measured : str
        Both values, in words.
    holds : bool
        True if they agree.
    essential : bool
        False for a check whose failure leaves a claim that holds in part.
    """

    what: str
    expected: str
    measured: str
    holds: bool
    essential: bool = True

    @property
    def failure(self) -> str:
        """The quantity with its measured and its expected value."""
        return f"{self.what}: {self.measured}, expected {self.expected}"


@dataclass(frozen=True)
class TriedReading:
    """Alternative reading of an ambiguous or damaged part of a paper, with the checks of a claim under it."""

    name: str
    text: str
    checks: tuple[Check, ...]

    @property
    def holds(self) -> bool:
        """True if the claim holds under this reading."""
        return all(check.holds for check in self.checks if check.essential)


@dataclass(frozen=True)
class Claim:
    """A statement of a paper with its checks; `explanation` comments on checks that may fail.

    Attributes
    ----------
    number, text, explanation : str
        Number in `claims.toml`, the statement, and a comment on its weak points.
    checks : tuple of Check
        Checks that decide it.
    refuted : bool
        True if the documentation refutes the claim, so that it fails when its checks hold.
    readings : tuple of TriedReading
        Alternative readings of damaged text, under one of which the claim may hold.
    printed : bool
        True for a claim about the text as printed, to which alternative readings do not apply.
    kind : ClaimKind
        Origin of the claim.
    variant : str
        What runs instead of what the paper printed, such as a law of our own; empty for what it printed.
    """

    number: str
    text: str
    checks: tuple[Check, ...]
    explanation: str = ""
    refuted: bool = False
    readings: tuple[TriedReading, ...] = ()
    printed: bool = False
    kind: ClaimKind = ClaimKind.PAPER
    variant: str = ""

    @property
    def title(self) -> str:
        """Noun of its kind and number, as in "claim 7"."""
        return f"{self.kind.one} {self.number}"

    @property
    def failed(self) -> list[Check]:
        """Checks that fail."""
        return [check for check in self.checks if not check.holds]

    @property
    def verdict(self) -> ClaimVerdict:
        """Verdict that follows from the checks; a claim with a failed check never simply holds."""
        failed = self.failed
        if any(check.essential for check in failed):
            if not self.refuted:
                return ClaimVerdict.FAILS
            if not any(r.holds for r in self.readings):
                return ClaimVerdict.REFUTED
            return ClaimVerdict.PRINTED if self.printed else ClaimVerdict.READING
        if self.refuted:
            return ClaimVerdict.FAILS
        if not failed:
            return ClaimVerdict.VARIANT if self.variant else ClaimVerdict.HOLDS
        return ClaimVerdict.OPEN if len(failed) == len(self.checks) else ClaimVerdict.PART

    @property
    def summary(self) -> str:
        """Number of checks that hold, names if they are few, the failed ones with both values, and the variant."""
        return f"{self._checked} Run with a variant: {self.variant}." if self.variant else self._checked

    @property
    def _checked(self) -> str:
        """Return the summary without the variant."""
        failed, many = self.failed, len(self.checks)
        if not failed:
            return "The check holds." if many == 1 else f"All {many} checks hold."
        listed = [check.failure for check in failed[:_LISTED]]
        more = [f"and {len(failed) - _LISTED} more"] if len(failed) > _LISTED else []
        named = [check.what for check in self.checks if check.holds]
        which = f": {'; '.join(named)}" if 0 < len(named) < _LISTED else ""
        start = "The check does not hold" if many == 1 else f"{len(named)} of {many} checks hold{which}. Not"
        return f"{start}: {'; '.join([*listed, *more])}."

    @property
    def outcome(self) -> str:
        """Results under other readings, on one line; empty without other readings."""
        if not self.readings:
            return ""
        holding = [f"{r.name}: {r.text.removesuffix('.')}" for r in self.readings if r.holds]
        many = len(self.readings)
        if not holding:
            return "Does not hold under " + (
                f"any of {many} other readings." if many > 1 else "the other reading tried."
            )
        which = f"{len(holding)} of {many} other readings" if many > 1 else "the other reading tried"
        if self.printed:
            return f"Holds under another reading ({len(holding)} of {many} tried): {'; '.join(holding)}."
        return f"Holds under {which}: {'; '.join(holding)}."

    @property
    def expected(self) -> str:
        """Expected values, on one line."""
        return "; ".join(f"{check.what}: {check.expected}" for check in self.checks)

    @property
    def measured(self) -> str:
        """Measured values, on one line."""
        return "; ".join(f"{check.what}: {check.measured}" for check in self.checks)

    @property
    def note(self) -> str:
        """The explanation if some check fails, else an empty text."""
        return self.explanation if self.failed else ""


@dataclass(frozen=True)
class ReadingText:
    """Name of an alternative reading for a claim, and one sentence about its change."""

    name: str
    text: str


@dataclass(frozen=True)
class ClaimText:
    """Entry of a paper's `claims.toml`: the text of a claim, and the expected numbers of its checks.

    `own` marks a finding that the paper does not state; `variant` says what runs instead of what the paper printed.
    """

    number: str
    text: str
    explanation: str = ""
    refuted: bool = False
    printed: bool = False
    own: bool = False
    variant: str = ""
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


Numbers: TypeAlias = "float | Collection[float]"
"""A number, or those of several axes or runs."""
Expected: TypeAlias = Callable[[str], float]
"""Expected numbers of a claim by name."""
Checks: TypeAlias = Callable[[Runs, Expected], Sequence[Check]]
"""Function that runs the model and returns the checks of a claim."""


Readings: TypeAlias = Mapping[str, Mapping[str, Checks]]
"""Checks under other readings, by claim number and reading name."""


def decide(
    texts: Sequence[ClaimText], checks: Mapping[str, Checks], runs: Runs, readings: Readings | None = None
) -> list[Claim]:
    """Return the claims with their checks and verdicts, including those for alternative readings."""
    return [_decided(text, checks[text.number], (readings or {}).get(text.number, {}), runs) for text in texts]


def _decided(text: ClaimText, checks: Checks, readings: Mapping[str, Checks], runs: Runs) -> Claim:
    tried = tuple(TriedReading(r.name, r.text, _tried(readings[r.name], text.number_of, runs)) for r in text.reading)
    results = tuple(checks(runs, text.number_of))
    kind = ClaimKind.FINDING if text.own else ClaimKind.PAPER
    return Claim(
        text.number, text.text, results, text.explanation, text.refuted, tried, text.printed, kind, text.variant
    )


def _tried(checks: Checks, expected: Expected, runs: Runs) -> tuple[Check, ...]:
    """Return the checks under a reading, in which numbers of a diverging run count as missing.

    This applies only to readings; a claim about a diverging loop has a check for it.
    """
    watched = WatchedRuns(runs)
    results = tuple(checks(watched, expected))
    if not watched.lost:
        return results
    ends = Check(
        "the runs reach their ends", "all", "; ".join(dict.fromkeys(run.reason for run in watched.lost)), False
    )
    return (ends, *(replace(check, measured="not measured", holds=False) for check in results))


def tally(claims: Iterable[Claim]) -> dict[ClaimKind, list[tuple[ClaimVerdict, int]]]:
    """Count the claims of each kind by verdict; verdicts without claims are omitted."""
    several = list(claims)
    counts = {kind: Counter(claim.verdict for claim in several if claim.kind is kind) for kind in ClaimKind}
    return {kind: [(verdict, of[verdict]) for verdict in ClaimVerdict if of[verdict]] for kind, of in counts.items()}


def tally_text(kind: ClaimKind, counts: Sequence[tuple[ClaimVerdict, int]]) -> str:
    """Return the counts of one kind on one line."""
    return f"{kind.of(sum(count for _, count in counts))}: {'; '.join(v.of(count) for v, count in counts) or 'none'}"


def about(what: str, expected: float, measured: float, unit: str = "", tolerance: float = TIMES) -> Check:
    """Return a check that a number is within a relative tolerance of the expected one.

    Parameters
    ----------
    what : str
        The quantity.
    expected, measured : float
        Both numbers.
    unit : str
        Of both.
    tolerance : float
        Allowed relative deviation.
    """
    holds = abs(measured - expected) <= tolerance * abs(expected)
    value = f"{expected:g} {unit}".strip()
    margin = f" ± {100 * tolerance:g} %" if tolerance >= _SHOWN else ""
    return Check(what, f"{value}{margin}", f"{measured:.4g} {unit}".strip(), holds)


def count(what: str, expected: float, measured: float) -> Check:
    """Return a check that a count differs by at most one from the expected one.

    Parameters
    ----------
    what : str
        Counted quantity.
    expected, measured : float
        Both counts.
    """
    return Check(what, f"{expected:g} ± {COUNTS:g}", f"{measured:g}", abs(measured - expected) <= COUNTS)


def below(what: str, bound: float, measured: Numbers, unit: str = "") -> Check:
    """Return a check that a number, or each of several, is below a bound.

    Parameters
    ----------
    what : str
        The quantity.
    bound : float
        The bound.
    measured : float or collection of float
        The numbers.
    unit : str
        Of all.
    """
    holds = all(value < bound for value in _several(measured))
    return Check(what, f"< {bound:g} {unit}".strip(), in_words(measured, unit), holds)


def above(what: str, bound: float, measured: Numbers, unit: str = "") -> Check:
    """Return a check that a number, or each of several, is above a bound; see `below`.

    Parameters
    ----------
    what, bound, measured, unit
        As of `below`.
    """
    holds = all(value > bound for value in _several(measured))
    return Check(what, f"> {bound:g} {unit}".strip(), in_words(measured, unit), holds)


def in_words(measured: Numbers, unit: str = "") -> str:
    """Return a number, or several between strokes, with a unit.

    Parameters
    ----------
    measured : float or collection of float
        The numbers.
    unit : str
        Of all.
    """
    return f"{' / '.join(f'{value:.3g}' for value in _several(measured))} {unit}".strip()


def _several(measured: Numbers) -> Collection[float]:
    return measured if isinstance(measured, Collection) else (measured,)


def not_essential(check: Check) -> Check:
    """Return a check that does not decide its claim.

    Parameters
    ----------
    check : Check
        The check.
    """
    return replace(check, essential=False)
