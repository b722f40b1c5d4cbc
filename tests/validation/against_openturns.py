# SPDX-License-Identifier: Apache-2.0
"""Rare failures against OpenTURNS: its subset simulation and ours of the same function, and the known probability."""

from __future__ import annotations

import numpy as np
import openturns as ot
from scipy.stats import norm

from mehvar.runtime.batch.evaluation.splitting import bounds, estimate, pilot
from mehvar.runtime.batch.sampling import FloatArray
from tests.validation.table import record

DIMENSIONS, PROBABILITY, SIZE, REPEATS = 6, 1e-6, 1000, 20


def score(points: FloatArray) -> FloatArray:
    """Return the distance of points beyond a curved surface."""
    return points.sum(axis=1) + 0.1 * points[:, 0] * points[:, 1] - np.sqrt(DIMENSIONS) * norm.isf(PROBABILITY)


def theirs(seed: int) -> float:
    """Return OpenTURNS's estimate."""
    ot.RandomGenerator.SetSeed(seed)
    function = ot.PythonFunction(DIMENSIONS, 1, func_sample=lambda points: score(np.asarray(points))[:, None])
    value = ot.CompositeRandomVector(function, ot.RandomVector(ot.Normal(DIMENSIONS)))
    algorithm = ot.SubsetSampling(ot.ThresholdEvent(value, ot.Greater(), 0.0))
    algorithm.setMaximumOuterSampling(SIZE)
    algorithm.run()
    return float(algorithm.getResult().getProbabilityEstimate())


def test_subset_simulation_of_a_curved_surface() -> None:
    rng = np.random.default_rng(1)
    result = estimate(score, DIMENSIONS, SIZE, pilot(score, DIMENSIONS, SIZE, PROBABILITY, rng), rng)
    others = np.array([theirs(seed) for seed in range(REPEATS)])
    (low, high), (least, most) = bounds(result.shares, 0.995), bounds(others, 0.995)
    reason = "both intervals of 99 %, half a width each, from the scatter of 20 repetitions"
    error = np.log(result.shares.mean() / others.mean())
    bound = (np.log(high / low) + np.log(most / least)) / 2
    record("statistics: a failure of some 1e-6", "OpenTURNS", ot.__version__, error, bound, "in the logarithm", reason)
