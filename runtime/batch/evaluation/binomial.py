# SPDX-License-Identifier: Apache-2.0
"""Bounds of a probability and of a quantile from counts of runs.

SciPy also provides them, but its import takes 0.2 s of processor time, a third of a small batch.
"""

from __future__ import annotations

import math

import numpy as np

from ..sampling import FloatArray

_REACH = 12.0
"""Width of a window of counts, in standard deviations. Counts outside have a probability below 1e-20."""
_SMALL_STEP = 1e-9
"""Relative step of Newton's method below which only rounding errors remain."""


def lower_bound(successes: int, runs: int, confidence: float) -> float:
    """Return the exact lower bound of a probability for a predetermined number of runs (Clopper and Pearson 1934).

    At this bound, the observed number of successes or more has the probability 1 - confidence.
    """
    if not successes:
        return 0.0
    # ln of the tail is concave in ln p, as with every beta distribution: all steps but the first increase p
    log_p, step = math.log(successes / (runs + 1)), 1.0
    while abs(step) > _SMALL_STEP:
        first, chances = probabilities(runs, math.exp(log_p), successes)
        tail = chances[successes - first :]
        step = (math.log1p(-confidence) - math.log(tail.sum())) * tail.sum() / (successes * tail[0])
        log_p += step
    return math.exp(log_p)


def ranks(q: float, n: int, confidence: float) -> tuple[int, int]:
    """Return the ranks among n ordered independent numbers that enclose quantile q, for any distribution.

    The count of numbers below the quantile is binomial (David and Nagaraja, Order Statistics, 2003, 7.1). Each end
    misses it with at most half of 1 - confidence. Rank 0 or n + 1 means that n is too small for that end.
    """
    tail = (1 - confidence) / 2
    first, chances = probabilities(n, q)
    below = np.cumsum(chances)
    return first + int(np.searchsorted(below, tail)), first + int(np.searchsorted(below, 1 - tail)) + 1


def probabilities(n: int, p: float, count: int | None = None) -> tuple[int, FloatArray]:
    """Return the first count of a window, and the binomial probabilities of its counts.

    The window contains `count` and all counts that are not negligible, so that the ratios of neighbouring
    probabilities determine them.
    """
    reach = int(_REACH * (1 + math.sqrt(n * p * (1 - p))))
    ends = int(n * p) if count is None else count, int(n * p)
    first, last = max(0, min(ends) - reach), min(n, max(ends) + reach)
    k = np.arange(first, last)
    logs = np.cumsum(np.concatenate([[0.0], np.log((n - k) / (k + 1)) + (math.log(p) - math.log1p(-p))]))
    chances = np.exp(logs - logs.max())
    return first, chances / chances.sum()
