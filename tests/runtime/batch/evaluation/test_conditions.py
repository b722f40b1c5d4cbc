# SPDX-License-Identifier: Apache-2.0
"""Conditions mean what they mean in Python, also chained ones."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mehvar.base.errors import InputError
from mehvar.runtime.batch.evaluation.conditions import Criterion

NUMBERS = st.sampled_from(("T_x", "abs(T_x)", "-T_x + 1", "0.5", "1", "2", "3"))
CHAINS = st.builds(
    lambda first, rest: " ".join((first, *(f"{op} {number}" for op, number in rest))),
    NUMBERS,
    st.lists(st.tuples(st.sampled_from(("<", "<=", ">", ">=")), NUMBERS), min_size=1, max_size=4),
)
VALUES = np.array([-2.0, 0.0, 0.5, 1.0, 2.0, 3.0, np.inf, np.nan])


@given(CHAINS, CHAINS, st.sampled_from(("{}", "not ({})", "{} and {}", "{} or not {}")))
def test_a_chain_of_comparisons_means_what_it_means_in_python(one, other, form):
    text = form.format(one, other)
    if "T_x" not in text:
        return
    expected = [bool(eval(text, {"abs": abs, "T_x": value})) for value in VALUES]
    assert Criterion(text)({"T_x": VALUES}).tolist() == expected


@pytest.mark.parametrize("text", ["(T_x < 1) < 2", "T_x < (1 < 2)", "T_x == 1 < 2", "T_x < 1 is 2", "1 < 2 < 3"])
def test_a_comparison_of_what_is_no_number_is_refused(text):
    with pytest.raises(InputError, match="must be a condition"):
        Criterion(text)


def test_numbers_that_are_compared_have_one_unit_and_words_of_a_status_have_none():
    units = {"T_x": "s", "T_y": "s", "rho": "m"}
    Criterion("T_x < T_y and status == done").check(units, {})
    with pytest.raises(InputError, match="T_x is in s, rho in m"):
        Criterion("status == done and T_x < rho").check(units, {})
