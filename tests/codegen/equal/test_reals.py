# SPDX-License-Identifier: Apache-2.0
"""Points at which expressions are compared: inside the bounds of their names, and everywhere there."""

from fractions import Fraction

import pytest

from mehvar.codegen.equal.sampler import PointSampler

NUMBERS = range(200)


@pytest.mark.parametrize(
    ("low", "high"), [(2, 5), (-5, -2), (-1, 3), (0, Fraction(1, 1000)), (10**6, 10**6 + 1), (3, None), (None, -3)]
)
@pytest.mark.parametrize("default", [None, 4])
def test_values_are_within_bounds_and_reach_all_of_them(low, high, default):
    bounds = tuple(None if bound is None else Fraction(bound) for bound in (low, high))
    middle = None if default is None or low is None or high is None else (bounds[0] + bounds[1]) / 2
    sampler = PointSampler({"a": (*bounds, middle)}, frozenset())
    values = [sampler.value("a", number) for number in NUMBERS]
    assert all((low is None or v >= low) and (high is None or v <= high) for v in values)
    assert values == [sampler.value("a", number) for number in NUMBERS]
    if low is not None and high is not None:
        parts = [(v - bounds[0]) / (bounds[1] - bounds[0]) for v in values]
        assert {0, Fraction(1, 2), 1} <= set(parts)
        assert {int(10 * part) for part in parts} == set(range(11))
    offered = [*sampler.extremes("a"), *sampler.simple("a", values[0])]
    assert all((low is None or v >= low) and (high is None or v <= high) for v in offered)


def test_values_without_bounds_have_many_sizes_and_both_signs():
    sampler = PointSampler({"a": (None, None, None)}, frozenset())
    values = [sampler.value("a", number) for number in NUMBERS]
    assert min(map(abs, values)) < Fraction(1, 10**3) < 10**3 < max(map(abs, values))
    assert min(values) < 0 < max(values)


def test_angles_are_within_half_a_turn_and_values_near_a_default():
    sampler = PointSampler({"a": (None, None, None), "k": (None, None, Fraction(8))}, frozenset("a"))
    assert all(-3 <= sampler.value("a", number) <= 3 for number in NUMBERS)
    near = [sampler.value("k", number) for number in NUMBERS if number % 2]
    assert all(4 <= value <= 16 for value in near)
    assert min(near) < 8 < max(near)
