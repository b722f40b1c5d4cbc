# SPDX-License-Identifier: Apache-2.0
"""The distance of two series of floats, by which a board and its host are compared."""

from __future__ import annotations

import numpy as np
import pytest

from mehvar.runtime.board.run import ulps

TINIEST = np.float32(1e-45)


@pytest.mark.parametrize("value", [1.0, 1e-30, 3e38, -1.0, -1e-30, -3e38, 1e-45, -1e-45])
def test_floats_are_as_far_apart_as_there_are_steps_between_them(value: float) -> None:
    here, there = np.float32(value), np.float32(value)
    for apart in range(4):
        assert ulps(np.array([here, there]), np.array([there, here])).tolist() == [apart, apart]
        there = np.nextafter(there, np.float32(np.inf))


def test_zeros_are_one_float_and_so_are_those_without_a_value() -> None:
    assert ulps(np.array([0.0, np.nan, TINIEST]), np.array([-0.0, -np.nan, -TINIEST])).tolist() == [0, 0, 2]
    assert ulps(np.array([1.0]), np.array([-1.0])) == 2 * 0x3F800000
    assert ulps(np.array([1.0, 2.0]), np.array([1.0])).tolist() == [0]
