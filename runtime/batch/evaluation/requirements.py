# SPDX-License-Identifier: Apache-2.0
"""Requirements on a batch, as in `quantile(0.997, error) < 0.02 deg`, decided with a stated confidence.

A requirement says that at least a share of all possible runs fulfils a condition. The stored runs are a sample of
these. It holds if the lower bound of the share reaches the required share, and does not hold if the upper bound is
below it; otherwise it is undecided. Each bound is wrong with a probability of at most 1 - confidence.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from mehvar.base.errors import InputError, bad_value

from ...run.options import Option
from ...run.problem import COMPLETE
from ...units import read_value
from ..blocks import IMPOSSIBLE
from ..sampling import FloatArray
from ..store.dataset import Batch
from ..store.layout import STATUS
from ..store.store import Store
from .binomial import lower_bound
from .conditions import Criterion, Number
from .statistics import Rule, column, design_of, fulfilment, notes, scalars, whole_blocks, worst

DECIDED = "decided"
"""Name of the stop rule that ends a batch as soon as all requirements are decided."""

Answer = Literal["holds", "does not hold", "undecided"]

_CONFIDENCE = Option("number", "Confidence of each bound", least=0.5, below=1.0, name="confidence")

_WORST = 3
_SHARE = r"(?P<share>[0-9.eE+-]+)"
_QUANTILE = re.compile(rf"\s*quantile\s*\(\s*{_SHARE}\s*,(?P<number>.+)\)\s*(?P<sign><=?|>=?)(?P<limit>[^<>=]+)")
_PROBABILITY = re.compile(rf"\s*probability\s*\((?P<condition>.+)\)\s*>=?\s*{_SHARE}\s*")
_USAGE = "as in 'quantile(0.997, PEAK) < 0.02 deg' or 'probability(T_x < 20) > 0.99'"


def checked_confidence(value: object, origin: str) -> float:
    """Return the confidence of a bound, 0.95 by default; refuse invalid ones."""
    return float(_CONFIDENCE.check(0.95 if value is None else value, origin))


@dataclass(frozen=True)
class Requirement:
    """A condition, and the smallest share of all runs that must fulfil it.

    Attributes
    ----------
    name, text : str
        Name and text, as given.
    share : float
        Required share, in (0, 1).
    condition : Criterion
        The condition on one run.
    number : Number or None
        Number of the quantile; None for a probability.
    largest : bool
        True if large numbers are worse.
    limit : float
        The limit of a quantile.
    units : str
        Units of the numbers that it names; empty if its text has units.
    """

    name: str
    text: str
    share: float
    condition: Criterion
    number: Number | None = None
    largest: bool = True
    limit: float = math.nan
    units: str = ""

    def badness(self, store: Batch, block: int) -> FloatArray:
        """Return a number for each run of a block, larger for worse runs; NaN for irrelevant ones."""
        if not self.number:
            return np.where(fulfilment(store, self.condition, [block]), math.nan, 1.0)
        value = self.number(lambda name: column(store, name, [block]))
        ended = np.isin(store.read(STATUS, [block]), COMPLETE)
        return np.where(ended & ~np.isnan(value), value if self.largest else -value, math.inf)


def read_requirements(
    texts: Mapping[str, str], units: Mapping[str, str], notes: Mapping[str, str], origin: str = "require"
) -> tuple[Requirement, ...]:
    """Read requirements by name.

    Parameters
    ----------
    texts : mapping of str to str
        A name to `quantile(Q, NUMBER) < LIMIT`: at least the share Q of all runs has a number below the limit; with >
        at least the share 1 - Q has one above. Or to `probability(CONDITION) > P`. The limit may have a unit.
    units, notes : mapping of str to str
        Units of the numbers of a run, and the reasons why some have none.
    origin : str
        Origin of the texts in error messages.

    Raises
    ------
    InputError
        For a text that is no requirement, a share outside (0, 1), an unknown number, or a unit of another kind.
    """
    return tuple(_read(name, text, units, notes, origin) for name, text in texts.items())


def _read(name: str, text: str, units: Mapping[str, str], notes: Mapping[str, str], origin: str) -> Requirement:
    """Return the requirement that a text states, on a quantile or on the probability of a condition."""
    if not isinstance(text, str):
        raise bad_value(name, text, f"a text {_USAGE}", origin)
    if match := _QUANTILE.fullmatch(text):
        share, number = _share(name, text, match["share"], origin), Number(match["number"].strip(), name)
        unit = number.unit(units)
        limit = read_value(match["limit"].strip(), unit, name, origin)
        if isinstance(limit, str):
            allowed = f"{_USAGE}: the limit {limit!r} is no number in {unit or 'a known unit'}"
            raise bad_value(name, text, allowed, origin)
        below = match["sign"].startswith("<")
        written = Criterion(f"{number.text} {match['sign']} {match['limit']}", name)
        condition = Criterion(f"{number.text} {match['sign']} {limit!r}", name)
        share = share if below else 1 - share
        result = Requirement(name, text, share, condition, number, below, limit, written.units(units))
    elif match := _PROBABILITY.fullmatch(text):
        written = Criterion(match["condition"].strip(), name)
        share = _share(name, text, match["share"], origin)
        result = Requirement(name, text, share, written, units=written.units(units))
    else:
        raise bad_value(name, text, _USAGE, origin)
    written.check(units, notes)
    return result


def _share(name: str, text: str, written: str, origin: str) -> float:
    try:
        share = float(written)
    except ValueError:
        share = math.nan
    if not 0 < share < 1:
        raise bad_value(name, text, f"{_USAGE}, with a share between 0 and 1", origin)
    return share


def log_evidence(successes: int, runs: int, share: float) -> float:
    """Return the logarithm of the evidence that a probability exceeds a share. It is valid at any number of runs.

    The evidence is the likelihood ratio against `share`, averaged uniformly over the larger probabilities. For a true
    probability of at most `share` it is a supermartingale that starts at 1. It therefore ever reaches 1 / a with a
    probability of at most a (Ville 1939; Robbins 1970). It decreases for shares up to the observed one, because the
    log-likelihood is concave, so that excluded shares form an interval. It is minus infinity if the larger
    probabilities underflow.
    """
    from scipy.special import betaincc, betaln, xlog1py, xlogy

    failures = runs - successes
    tail = float(betaincc(successes + 1, failures + 1, share))
    if tail == 0:
        return -math.inf
    average = float(betaln(successes + 1, failures + 1)) + math.log(tail) - math.log1p(-share)
    return average - float(xlogy(successes, share)) - float(xlog1py(failures, -share))


def sequential_bound(successes: int, runs: int, confidence: float) -> float:
    """Return the lower bound of a probability that holds at all numbers of runs at once; see `log_evidence`."""
    from scipy.optimize import brentq

    needed = -math.log1p(-confidence)
    top = min(successes / runs, 1 - 2**-53) if runs else 0.0

    def excess(share: float) -> float:
        return log_evidence(successes, runs, share) - needed

    tiny = 1e-300
    if top <= tiny or excess(tiny) < 0:
        return 0.0
    return top if excess(top) >= 0 else float(brentq(excess, tiny, top, xtol=1e-15))


@dataclass(frozen=True)
class Evidence:
    """Bounds of the share of all runs that fulfil the condition, from counted runs.

    `fulfilled` is None for a search, which does not count fulfilling runs.
    """

    runs: int
    fulfilled: int | None
    low: float
    high: float

    def answer(self, share: float) -> Answer:
        """Return the verdict of the bounds on a required share."""
        return "holds" if self.low >= share else "does not hold" if self.high < share else "undecided"

    def text(self, share: float) -> str:
        """Return the evidence in words, compared with a required share."""
        return (
            f"{self.fulfilled} of {self.runs} runs fulfil it; of all runs between {self.low:.6g} and "
            f"{self.high:.6g} do, required {share:.6g}"
        )


@dataclass(frozen=True)
class RareEvidence(Evidence):
    """Bounds of the share of runs that fail, from a search for rare failures."""

    least: float
    most: float

    def answer(self, share: float) -> Answer:
        """Return the verdict of the bounds on a required share."""
        return "holds" if self.most <= 1 - share else "does not hold" if self.least > 1 - share else "undecided"

    def text(self, share: float) -> str:
        """Return the evidence in words, compared with a required share."""
        between = f"{self.least:.3g} and {self.most:.3g}"
        return f"{self.runs} runs; of all runs between {between} fail, allowed {1 - share:.3g}"


def evidence(fulfilled: int, runs: int, confidence: float, fixed: bool) -> Evidence:
    """Return the bounds for counted runs; `fixed` is True if the number of runs was chosen in advance."""
    bound = lower_bound if fixed else sequential_bound
    return Evidence(runs, fulfilled, bound(fulfilled, runs, confidence), 1 - bound(runs - fulfilled, runs, confidence))


class DecisionRule(Rule):
    """Rule that ends a batch as soon as all requirements are decided.

    Parameters
    ----------
    requirements : sequence of Requirement
        Requirements to decide, at least one.
    confidence : float
        Confidence of each bound.
    design : str
        Design of the runs, which must be independent.

    Raises
    ------
    InputError
        Without a requirement, or for another design.
    """

    def __init__(self, requirements: Sequence[Requirement], confidence: float, design: str) -> None:
        super().__init__()
        if not requirements:
            raise bad_value("until", DECIDED, "left out without a requirement")
        if design != "random":
            raise bad_value("until", DECIDED, f"left out with a {design} design: only independent runs decide")
        self._requirements, self._open = requirements, set(range(len(requirements)))
        self._needed = -math.log1p(-confidence)

    def count(self, store: Batch, block: int) -> tuple[int, ...]:
        """Return the number of runs in a block that fulfil each requirement."""
        return tuple(int(np.count_nonzero(fulfilment(store, r.condition, [block]))) for r in self._requirements)

    def holds(self, counts: Sequence[int], runs: int) -> bool:
        """Return True if all requirements are decided by the runs so far."""
        for k in sorted(self._open):
            share, failures = self._requirements[k].share, runs - counts[k]
            if max(log_evidence(counts[k], runs, share), log_evidence(failures, runs, 1 - share)) >= self._needed:
                self._open.remove(k)
        return not self._open


@dataclass(frozen=True)
class Verdict:
    """Verdict on a requirement.

    Attributes
    ----------
    requirement : Requirement
        The requirement.
    answer : str
        "holds", "does not hold" or "undecided".
    evidence : Evidence or None
        Counts and bounds; None if the runs prove nothing.
    reason : str
        Why it is undecided, or how the bounds were computed.
    worst : tuple of (int, float)
        Runs with the worst numbers, worst first; the number is infinite for a run that ended early or lacks it. For a
        probability, the first runs that do not fulfil the condition.
    failures : mapping of str to array
        Varied values of failing runs, worst first, after a search; `mehvar.batch` takes them as `points`.
    """

    requirement: Requirement
    answer: Answer
    evidence: Evidence | None
    reason: str
    worst: tuple[tuple[int, float], ...]
    failures: Mapping[str, FloatArray] = field(default_factory=dict)


def stored_requirements(store: Store) -> tuple[dict[str, str], float]:
    """Return the requirements of a store by name, and their confidence; none if the batch had none."""
    rules = json.loads(store.attributes.get("require") or "{}")
    return rules.get("requirements", {}), checked_confidence(rules.get("confidence"), "the store")


def decide(store: Store, texts: Mapping[str, str] | None = None, confidence: float | None = None) -> list[Verdict]:
    """Decide requirements by the runs of a store.

    If all planned runs are stored, bounds are those of Clopper and Pearson. Otherwise the number of runs may depend
    on their results, and the bounds are valid for any number of runs.

    Parameters
    ----------
    store : Store
        The runs.
    texts : mapping of str to str, optional
        Requirements by name; default: those of the batch. See `read_requirements`.
    confidence : float, optional
        Confidence of each bound; default: that of the batch.

    Raises
    ------
    InputError
        If there is no requirement, one cannot be read, or nothing is stored yet.
    DamageError
        If a file of the store is missing or changed.
    """
    own, usual = stored_requirements(store)
    texts = own if texts is None else texts
    confidence = usual if confidence is None else checked_confidence(confidence, "the call")
    if not texts:
        raise InputError(f"{store.name} has no requirement: give one {_USAGE}")
    requirements = read_requirements(texts, scalars(store), notes(store), "the requirements")
    blocks, _ = whole_blocks(store)
    fixed = len(blocks) == store.blocks() and not store.attributes["until"]
    design = design_of(store.attributes)
    impossible = int(np.count_nonzero(store.read(STATUS, blocks) == IMPOSSIBLE))
    counted = f"; {impossible} runs with values that are not allowed count as not fulfilled" if impossible else ""
    return [_verdict(store, r, confidence, fixed, design, counted) for r in requirements]


def _verdict(
    store: Store, requirement: Requirement, confidence: float, fixed: bool, design: str, counted: str
) -> Verdict:
    """Return the verdict on a requirement from a store; `fixed` bounds hold only for the planned number of runs."""
    if design != "random":
        reason = f"undecided for any number of runs: runs of a {design} design are not independent"
        return Verdict(requirement, "undecided", None, reason, _worst(store, requirement, None))
    if fixed:
        successes = int(np.count_nonzero(fulfilment(store, requirement.condition, store.stored())))
        facts, how = evidence(successes, store.n, confidence, True), "for a fixed number of runs"
    else:
        facts, how = _sequential(store, requirement, confidence), "that hold for every number of runs"
    runs = _worst(store, requirement, facts.runs or None)
    return Verdict(requirement, facts.answer(requirement.share), facts, f"bounds {how}{counted}", runs)


def _worst(store: Store, requirement: Requirement, before: int | None) -> tuple[tuple[int, float], ...]:
    """Return numbers and values of the worst runs among those that count."""
    bad = worst(store, lambda block: requirement.badness(store, block), _WORST, before)
    return tuple((run, value if requirement.largest or math.isinf(value) else -value) for run, value in bad)


def _sequential(store: Store, requirement: Requirement, confidence: float) -> Evidence:
    """Return the evidence after the first decisive block or, without one, after the last block before a gap."""
    rule = DecisionRule([requirement], confidence, "random")
    for place, block in enumerate(store.stored()):
        if block != place or rule.holds_with(store, block):
            break
    return evidence(sum(rule.counts), rule.runs, confidence, False)
