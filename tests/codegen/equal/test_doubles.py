# SPDX-License-Identifier: Apache-2.0
"""Differences of doubles: those beyond rounding, and how many pairs have values."""

import numpy as np

from mehvar.codegen.equal.doubles import apart


def test_what_differs_beyond_rounding_is_apart_by_its_share():
    old = np.array([1.0, 1.0, 3.0, np.nan, np.inf, 0.0])
    new = np.array([1.0, 1.0 + 1e-15, 1.0, 1.0, 1.0, 0.0])
    sizes, both = apart(old, new)
    assert sizes[:3].tolist() == [0.0, 0.0, 0.5]
    assert sizes[5] == 0.0
    assert both == 5
