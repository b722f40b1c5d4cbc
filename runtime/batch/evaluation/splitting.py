# SPDX-License-Identifier: Apache-2.0
"""Small probabilities by multilevel splitting, also called subset simulation.

Each point of standard normal numbers has a score; scores of 0 or more are failures. Levels of the score rise so that
one point in ten survives each. Survivors spread by a Markov chain that preserves their distribution. The probability
is the product of the survivors' shares (Kahn and Harris 1951; Au and Beck, Probabilistic Engineering Mechanics 16
(2001) 263). A pilot determines levels and steps. With fixed levels each repetition is unbiased (Del Moral 2004), so
that the scatter of independent repetitions gives the error.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..sampling import FloatArray

Score = Callable[[FloatArray], FloatArray]
"""Function that scores points of shape (n, dimensions): 0 or more for failures, infinity for runs without a number."""

REPETITIONS = 20
"""Number of independent repetitions, which gives their scatter to a sixth. Half as many widen a 99 % bound by a
tenth.
"""
FEWEST = 250
"""Smallest number of points per repetition. With 250 its probability scatters by about 80 %; with fewer, bounds are
wrong too often."""
_SHARE = 0.1
"""Share of points that survive a level. Au and Beck found values from 0.1 to 0.3 equally good."""
_ACCEPTED = 0.4
"""Desired share of accepted steps; it determines the step width. Values of 0.2 and 0.6 are hardly worse."""
_BEYOND = 30.0
"""Factor by which the last level's share is below the relevant share, so that a bound decides without failures."""
_STUCK = 0.02
"""Smallest share of accepted steps; below it noise matters more than the varied values."""
_SURVIVORS = 0.5
"""Largest share of one repetition in the sum; above it other repetitions probably miss most failures."""


class Cloud(NamedTuple):
    """Points with scores and the numbers of their repetitions."""

    points: FloatArray
    scores: FloatArray
    group: NDArray[np.intp]

    def where(self, chosen: NDArray[np.bool_]) -> Cloud:
        """Return the chosen points."""
        return Cloud(self.points[chosen].copy(), self.scores[chosen].copy(), self.group[chosen])


@dataclass(frozen=True)
class Levels:
    """Rising levels with their step widths, and the reason if they do not reach failures."""

    levels: tuple[float, ...]
    widths: tuple[float, ...]
    end: float
    problem: str = ""


@dataclass(frozen=True)
class Estimate:
    """Estimate of the repetitions.

    Attributes
    ----------
    shares : array
        Estimated probability of reaching the last level, one per repetition.
    failed : array
        Failing points, worst first.
    problem : str
        Reason why the shares prove nothing, or an empty text.
    """

    shares: FloatArray
    failed: FloatArray
    problem: str = ""


def pilot(score: Score, dimensions: int, n: int, least: float, rng: np.random.Generator) -> Levels:
    """Return levels up to failures, or up to a share far below the smallest relevant one, `least`."""
    cloud = _first(score, dimensions, n, 1, rng)
    levels: list[float] = []
    widths: list[float] = []
    width, end, problem = _SHARE * 5, 0.0, ""
    while not problem and (level := _level(cloud.scores)) < 0:
        if _SHARE ** (len(levels) + 1) < least / _BEYOND:
            end = level
            break
        if level in levels or level >= cloud.scores.max():
            problem = f"many runs have the same number, {level:.6g} from the limit"
            break
        levels.append(level)
        widths.append(width)
        cloud, accepted = _spread(score, cloud.where(cloud.scores > level), n, level, width, rng)
        problem = _stuck(accepted)
        width = float(np.clip(width * np.exp(accepted - _ACCEPTED), 0.05, 1.0))
    return Levels(tuple(levels), tuple(widths), end, problem)


def most_levels(least: float) -> int:
    """Return the largest number of levels of a pilot."""
    return math.ceil(math.log(least / _BEYOND) / math.log(_SHARE)) - 1


def _level(scores: FloatArray) -> float:
    """Return the score that a given share of the runs reaches; NaN if it lies among runs without a number."""
    with np.errstate(invalid="ignore"):
        return float(np.quantile(scores, 1 - _SHARE))


def estimate(score: Score, dimensions: int, n: int, stages: Levels, rng: np.random.Generator) -> Estimate:
    """Return the probability of a failure from repetitions with n points."""
    cloud, problem = _first(score, dimensions, n, REPETITIONS, rng), ""
    shares = np.ones(REPETITIONS)
    for level, width in zip(stages.levels, stages.widths, strict=True):
        above = cloud.where(cloud.scores > level)
        shares *= np.bincount(above.group, minlength=REPETITIONS) / n
        cloud, accepted = _spread(score, above, n, level, width, rng)
        problem = problem or _stuck(accepted)
    shares *= np.bincount(cloud.group[cloud.scores >= stages.end], minlength=REPETITIONS) / n
    order = np.argsort(-cloud.scores, kind="stable")
    failed = cloud.points[order[: int(np.count_nonzero(cloud.scores >= 0))]]
    return Estimate(shares, failed, problem or _disagreement(shares))


def bounds(shares: FloatArray, confidence: float) -> tuple[float, float]:
    """Return bounds of the mean of positive estimates at given confidences.

    The estimates are nearly lognormal (Cerou and Guyader 2016). Each bound is the wider of Student's interval of the
    logarithm of the mean, which is too narrow above for few estimates, and Cox's interval of a lognormal mean.
    """
    from scipy.special import stdtrit

    n, mean = len(shares), float(shares.mean())
    quantile = float(stdtrit(n - 1, confidence))
    student = quantile * float(shares.std(ddof=1)) / np.sqrt(n) / mean
    logs = np.log(shares)
    variance = float(logs.var(ddof=1))
    centre, cox = float(logs.mean()) + variance / 2, quantile * np.sqrt(variance / n + variance**2 / (2 * (n - 1)))
    low, high = np.log(mean) - student, np.log(mean) + student
    return float(np.exp(min(low, centre - cox))), min(1.0, float(np.exp(max(high, centre + cox))))


def _first(score: Score, dimensions: int, n: int, groups: int, rng: np.random.Generator) -> Cloud:
    points = rng.standard_normal((n * groups, dimensions))
    return Cloud(points, score(points), np.repeat(np.arange(groups), n))


def _spread(
    score: Score, now: Cloud, n: int, level: float, width: float, rng: np.random.Generator
) -> tuple[Cloud, float]:
    """Return n points per group above a level, and the share of accepted steps.

    Each survivor starts a chain, all of whose states count; chain lengths within a group differ by at most one. A
    step mixes a point with a new one and is rejected at or below the level, which preserves the distribution.
    """
    lengths, states, accepted = _lengths(now.group, n, rng), [], 0
    keep = np.sqrt(1 - width**2)
    for step in range(max(lengths, default=0)):
        now, lengths = now.where(lengths > step), lengths[lengths > step]
        points = keep * now.points + width * rng.standard_normal(now.points.shape)
        scores = score(points)
        taken = scores > level
        accepted += int(np.count_nonzero(taken))
        now = Cloud(np.where(taken[:, None], points, now.points), np.where(taken, scores, now.scores), now.group)
        states.append(now)
    if not states:
        return now, 1.0
    cloud = Cloud(*(np.concatenate(parts) for parts in zip(*states, strict=True)))
    return cloud, accepted / len(cloud.group)


def _lengths(group: NDArray[np.intp], n: int, rng: np.random.Generator) -> NDArray[np.intp]:
    """Return chain lengths with the sum n per group; randomly chosen chains are longer by one."""
    lengths = np.zeros(len(group), np.intp)
    for number in np.unique(group):
        places = rng.permutation(np.flatnonzero(group == number))
        each, rest = divmod(n, len(places))
        lengths[places] = each
        lengths[places[:rest]] += 1
    return lengths


def _stuck(accepted: float) -> str:
    """Return the reason why a search makes no progress; empty if it does."""
    if accepted >= _STUCK:
        return ""
    return f"the search accepts only {accepted:.1%} of its steps: noise may matter more than the varied values"


def _disagreement(shares: FloatArray) -> str:
    """Return the reason why the repetitions contradict each other; empty if they agree."""
    missed = int(np.count_nonzero(shares == 0))
    if missed:
        return f"{missed} of {len(shares)} repetitions found no failure: use more runs"
    if shares.max() > _SURVIVORS * shares.sum():
        return "one repetition found most of the failures, so others may be missed: use more runs"
    return ""
