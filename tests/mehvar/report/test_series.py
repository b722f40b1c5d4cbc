# SPDX-License-Identifier: Apache-2.0
import base64

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from mehvar.report.series import encode, thin, track


def floats(encoded):
    return np.frombuffer(base64.b64decode(encoded), "<f4")


@settings(max_examples=60, deadline=None)
@given(hnp.arrays(np.float64, st.tuples(st.integers(2, 80), st.integers(1, 3)), elements=st.floats(-1e3, 1e3)))
def test_what_is_left_out_lies_on_the_lines_between_what_is_kept(columns):
    t = np.cumsum(np.linspace(1.0, 2.0, len(columns)))
    kept = thin(t, columns, 0.01)
    assert {0, len(t) - 1} <= set(kept.tolist())
    for column in columns.T:
        off = np.abs(np.interp(t, t[kept], column[kept]) - column)
        assert off.max() <= 0.01 * np.ptp(column) + 1e-9


def test_a_straight_line_needs_two_samples_and_a_gap_is_kept():
    t = np.arange(9.0)
    assert thin(t, 3 * t).tolist() == [0, 8]
    gap = np.where(t == 4, np.nan, t)
    assert {3, 4, 5} <= set(thin(t, gap).tolist())


def test_a_track_holds_every_column_at_the_same_instants():
    t = np.linspace(0, 1, 500)
    found = track(t, {"a": np.sin(9 * t), "b": t})
    kept = floats(found["t"])
    assert 10 < len(kept) < 200
    assert np.allclose(np.sin(9 * kept), floats(found["columns"]["a"]), atol=1e-6)
    assert np.allclose(kept, floats(found["columns"]["b"]))


def test_numbers_are_encoded_as_32_bit_floats():
    assert floats(encode([1.0, -2.5])).tolist() == [1.0, -2.5]
