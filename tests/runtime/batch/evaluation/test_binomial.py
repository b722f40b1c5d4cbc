# SPDX-License-Identifier: Apache-2.0
"""Bounds from counts against SciPy's."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import betaincinv
from scipy.stats import binom

from mehvar.runtime.batch.evaluation.binomial import lower_bound, probabilities, ranks
from mehvar.runtime.batch.evaluation.statistics import QUANTILES


@pytest.mark.parametrize("runs", [1, 2, 15, 16, 17, 1000, 10**6])
@pytest.mark.parametrize("confidence", [0.1, 0.5, 0.95, 1 - 1e-9])
def test_the_lower_bound_is_the_quantile_of_a_beta_distribution(runs: int, confidence: float) -> None:
    for successes in sorted({1, min(2, runs), (runs + 1) // 2, max(runs - 1, 1), runs}):
        expected = betaincinv(successes, runs - successes + 1, 1 - confidence)
        assert lower_bound(successes, runs, confidence) == pytest.approx(expected, rel=1e-12)
    assert lower_bound(0, runs, confidence) == 0


@given(n=st.integers(1, 3000) | st.sampled_from((4096, 10**6, 10**7)), q=st.sampled_from(QUANTILES))
@settings(deadline=None)
def test_a_quantile_lies_between_its_ranks_for_any_distribution(n: int, q: float) -> None:
    """The chance that fewer than `low` or at least `high` of n numbers are below it, by their count alone."""
    low, high = ranks(q, n, 0.95)
    assert 0 <= low <= np.ceil(q * n) <= high <= n + 1
    assert binom.cdf(low - 1, n, q) <= 0.025
    assert binom.sf(high - 1, n, q) <= 0.025
    assert binom.cdf(low, n, q) >= 0.025 - 1e-12
    assert high == 1 or binom.sf(high - 2, n, q) >= 0.025 - 1e-12


@pytest.mark.parametrize(("n", "p"), [(1, 0.3), (16, 0.5), (40, 1e-9), (3000, 0.999)])
def test_probabilities_are_those_of_scipy_and_no_others_count(n: int, p: float) -> None:
    first, chances = probabilities(n, p)
    np.testing.assert_allclose(chances, binom.pmf(first + np.arange(len(chances)), n, p), rtol=1e-9)
    assert binom.cdf(first - 1, n, p) + binom.sf(first + len(chances) - 1, n, p) < 1e-15
