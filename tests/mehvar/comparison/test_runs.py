# SPDX-License-Identifier: Apache-2.0
"""Numbers of two versions' runs: an infinite one, as of a loop that never settles, equals only itself."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mehvar.comparison.runs import MetricChange, RunChange, equal_numbers


@given(st.floats(), st.floats(), st.sampled_from([1e-9, 1e-3, 0.5]))
def test_numbers_of_which_one_is_not_finite_are_equal_only_if_both_are_the_same(old, new, part):
    same = equal_numbers(old, new, part)
    assert same == equal_numbers(new, old, part)
    assert equal_numbers(old, old, part)
    if not (math.isfinite(old) and math.isfinite(new)):
        assert same == (old == new or (math.isnan(old) and math.isnan(new)))


@pytest.mark.parametrize(("old", "new"), [(2.65, math.inf), (math.inf, 2.65), (math.inf, -math.inf), (math.nan, 1.0)])
def test_a_run_that_no_longer_settles_has_an_infinite_change(old, new):
    assert RunChange("law", "scenario", "", "", (MetricChange("T", "s", old, new),), 1).size == math.inf
