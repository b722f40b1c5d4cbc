# SPDX-License-Identifier: Apache-2.0
"""Splitting: intervals that cover known probabilities, and refusals of what proves nothing."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import chi2, norm

from mehvar.runtime.batch.evaluation.splitting import FEWEST, Score, bounds, estimate, pilot
from mehvar.runtime.batch.sampling import FloatArray


def plane(points: FloatArray) -> FloatArray:
    """Beyond a plane: one in a million."""
    return points.sum(axis=1) / np.sqrt(points.shape[1]) - norm.isf(1e-6)


def ball(points: FloatArray) -> FloatArray:
    """Outside a ball of five dimensions: one in ten million."""
    return (points**2).sum(axis=1) - chi2.isf(1e-7, 5)


def two_sides(points: FloatArray) -> FloatArray:
    """Beyond either of two planes: one in a million."""
    return np.abs(points.sum(axis=1) / np.sqrt(points.shape[1])) - norm.isf(0.5e-6)


def missed(score: Score, dimensions: int, probability: float, size: int, trials: range) -> tuple[int, int]:
    """Return how often the lower and the upper bound of 97.5 % miss a probability."""
    low = high = 0
    for trial in trials:
        rng = np.random.default_rng([20261128, trial])
        stages = pilot(score, dimensions, size, probability, rng)
        result = estimate(score, dimensions, size, stages, rng)
        if result.problem:
            continue
        least, most = bounds(result.shares, 0.975)
        low, high = low + (least > probability), high + (most < probability)
    return low, high


@pytest.mark.parametrize(("score", "dimensions", "probability"), [(plane, 10, 1e-6), (two_sides, 4, 1e-6)])
def test_bounds_hold_a_known_probability(score: Score, dimensions: int, probability: float) -> None:
    low, high = missed(score, dimensions, probability, FEWEST, range(20))
    assert low <= 2
    assert high <= 2


@pytest.mark.soak
@pytest.mark.parametrize(
    ("score", "dimensions", "probability"), [(plane, 10, 1e-6), (ball, 5, 1e-7), (two_sides, 4, 1e-6)]
)
def test_an_interval_covers_as_often_as_it_says(score: Score, dimensions: int, probability: float) -> None:
    """Of 400 intervals of 95 %, 20 miss on average; more than 28 do in one of twenty-five sequences."""
    low, high = missed(score, dimensions, probability, 500, range(400))
    assert low + high <= 28


def test_levels_end_far_below_the_share_that_matters() -> None:
    """The share beyond the last level bounds that of failures, of which there are none."""
    rng = np.random.default_rng(1)

    def bounded(points: FloatArray) -> FloatArray:
        return norm.cdf(points[:, 0]) - 1.5

    stages = pilot(bounded, 1, 500, 1e-3, rng)
    result = estimate(bounded, 1, 500, stages, rng)
    assert not result.problem
    assert stages.end < 0
    assert bounds(result.shares, 0.99)[1] < 1e-4
    assert not len(result.failed)


def test_equal_numbers_and_chains_that_stand_still_prove_nothing() -> None:
    rng = np.random.default_rng(2)
    stages = pilot(lambda points: np.where(points[:, 0] > 2, -1.0, -2.0), 1, 2000, 1e-6, rng)
    assert "same number" in stages.problem
    noise = np.random.default_rng(3)
    stages = pilot(lambda points: noise.standard_normal(len(points)) - 6, 1, 2000, 1e-6, rng)
    assert "noise may matter more" in stages.problem


def test_repetitions_that_disagree_prove_nothing() -> None:
    """A small region far off the way to the others is met by one repetition in many, here; by none, for other seeds."""
    rng = np.random.default_rng(0)

    def hidden(points: FloatArray) -> FloatArray:
        beyond, aside = points[:, 0] - 5.5, np.abs(points[:, 1] - 4.3) < 0.2
        return np.where(aside, 1.0, np.minimum(beyond, -1e-3))

    stages = pilot(hidden, 2, FEWEST, 1e-6, rng)
    result = estimate(hidden, 2, FEWEST, stages, rng)
    assert "use more runs" in result.problem
