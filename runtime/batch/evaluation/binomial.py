# SPDX-License-Identifier: Apache-2.0
"""Bounds of a probability and of a quantile from counts of runs.

SciPy also provides them, but its import takes 1 s of processor time, more than a small batch.
"""

from __future__ import annotations

import math

import numpy as np

from ..sampling import FloatArray

_HALF_LOG_2_PI = 0.5 * math.log(2 * math.pi)
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
        p = math.exp(log_p)
        last = min(runs, successes + _reach(runs, p))
        logs = log_probabilities(successes, last, runs, p)
        total = float(logs.max() + np.log(np.exp(logs - logs.max()).sum()))
        step = (math.log1p(-confidence) - total) / (successes * math.exp(logs[0] - total))
        log_p += step
    return math.exp(log_p)


def ranks(q: float, n: int, confidence: float) -> tuple[int, int]:
    """Return the ranks among n ordered independent numbers that enclose quantile q, for any distribution.

    The count of numbers below the quantile is binomial (David and Nagaraja, Order Statistics, 2003, 7.1). Each end
    misses it with at most half of 1 - confidence. Rank 0 or n + 1 means that n is too small for that end.
    """
    tail = (1 - confidence) / 2
    first, last = max(0, int(n * q) - _reach(n, q)), min(n, int(n * q) + _reach(n, q))
    below = np.cumsum(np.exp(log_probabilities(first, last, n, q)))
    return first + int(np.searchsorted(below, tail)), first + int(np.searchsorted(below, 1 - tail)) + 1


def log_probabilities(first: int, last: int, n: int, p: float) -> FloatArray:
    """Return the logarithms of the binomial probabilities of the counts `first` to `last` (Loader 2000)."""
    k = np.arange(first, last + 1, dtype=np.float64)
    left = n - k
    inner = 0.5 * np.log(n / (2 * math.pi * np.maximum(k, 0.5) * np.maximum(left, 0.5)))
    inner += _stirling(np.full(1, float(n))) - _stirling(k) - _stirling(left)
    inner -= _deviance(k, n * p) + _deviance(left, n * (1 - p))
    return np.where(k == 0, n * math.log1p(-p), np.where(left == 0, n * math.log(p), inner))


def _reach(n: int, p: float) -> int:
    return int(_REACH * (1 + math.sqrt(n * p * (1 - p))))


def _deviance(k: FloatArray, mean: float) -> FloatArray:
    """Return k ln(k / mean) + mean - k, whose terms cancel near the mean."""
    excess = (k - mean) / mean
    result: FloatArray = mean * ((1 + excess) * np.log1p(np.maximum(excess, -1 + 2**-53)) - excess)
    return result


def _stirling(n: FloatArray) -> FloatArray:
    """Return the error of Stirling's approximation of ln(n!); zero for n = 0, which the caller replaces."""
    table = [0.0, *(math.lgamma(k + 1) - (k + 0.5) * math.log(k) + k - _HALF_LOG_2_PI for k in range(1, 16))]
    large = np.maximum(n, 15.0)
    square = large**2
    series = (1 / 12 - (1 / 360 - (1 / 1260 - (1 / 1680 - 1 / 1188 / square) / square) / square) / square) / large
    result: FloatArray = np.where(n < 16, np.array(table)[np.minimum(n, 15).astype(int)], series)
    return result
