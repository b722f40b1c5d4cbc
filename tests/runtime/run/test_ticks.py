# SPDX-License-Identifier: Apache-2.0
"""Instants of runs against rational arithmetic."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from mehvar.base.errors import InputError
from mehvar.runtime.run.ticks import fraction, rows_of, ticks_of, times_in

DECIMALS = st.builds(lambda digits, places: Fraction(digits, 10**places), st.integers(1, 10**5), st.integers(0, 6))
PARTS = st.builds(Fraction, st.integers(1, 20), st.integers(1, 3000))
SPANS = DECIMALS | PARTS


@given(SPANS)
def test_a_span_is_read_as_the_fraction_that_was_written(span: Fraction) -> None:
    assert fraction(float(span)) == span


@given(DECIMALS, st.integers(1, 30), st.integers(1, 30))
def test_a_sum_of_doubles_is_read_as_what_was_meant(step: Fraction, a: int, b: int) -> None:
    assume(a * step < 500)
    assert fraction(a * float(step)) == a * step
    assert fraction(float(a * step) + float(b * step)) == (a + b) * step


@given(SPANS, st.integers(1, 2000), st.fractions(0, 1, max_denominator=100))
@settings(deadline=None)
def test_samples_are_multiples_rounded_once(dt: Fraction, count: int, part: Fraction) -> None:
    end = (count + part) * dt
    assume(end < 1000)
    ticks, record_every, hold_every = ticks_of(float(end), float(dt), None, "the test")
    whole = math.floor(end / dt)
    expected = [float(k * dt) for k in range(whole + 1)] + ([float(end)] if whole * dt < end else [])
    assert ticks.tolist() == expected
    assert (record_every, hold_every) == (1, None)


@given(DECIMALS, st.integers(1, 50), st.integers(1, 60), st.booleans())
@settings(deadline=None)
def test_a_law_is_sampled_at_multiples_of_its_period(tick: Fraction, times: int, count: int, holds: bool) -> None:
    """With the longer and the shorter period, each instant of both is a tick, by its number."""
    assume(times * count * tick < 1000)
    dt, hold = (tick, times * tick) if holds else (times * tick, tick)
    end = count * times * tick
    ticks, record_every, hold_every = ticks_of(float(end), float(dt), float(hold), "the test")
    assert ticks[::record_every].tolist() == [float(k * dt) for k in range(math.floor(end / dt) + 1)]
    assert hold_every is not None
    assert ticks[::hold_every].tolist() == [float(k * hold) for k in range(math.floor(end / hold) + 1)]


@given(DECIMALS, st.integers(1, 20), st.integers(1, 200))
@settings(deadline=None)
def test_rows_of_a_series_are_samples(dt: Fraction, times: int, count: int) -> None:
    end = count * dt
    assume(end < 1000)
    assume(times <= count)
    rows = rows_of(float(times * dt), float(end), float(dt), "the test")
    ticks, *_ = ticks_of(float(end), float(dt), None, "the test")
    assert rows.tolist() == ticks[::times].tolist()


def test_numbers_that_are_no_fractions_are_counted_too() -> None:
    ticks, *_ = ticks_of(math.pi, math.pi / 10, None, "the test")
    assert ticks.tolist() == pytest.approx([k * math.pi / 10 for k in range(11)], rel=1e-15)
    assert ticks[-1] == math.pi
    long, *_ = ticks_of(1e4, 0.0123456789123, None, "the test")
    assert long[-2] == float((len(long) - 2) * Fraction("0.0123456789123"))


@pytest.mark.parametrize(("dt", "hold"), [(0.1, 0.25), (0.3, 0.7), (1e300, 0.5), (1.0, 1e-20)])
def test_spans_that_do_not_fit_are_refused(dt: float, hold: float) -> None:
    with pytest.raises(InputError, match=r"must be an integer multiple|at most"):
        ticks_of(10.0, dt, hold, "the test")
    assert times_in(dt, hold) is None or times_in(dt, hold) == round(dt / hold)


@pytest.mark.parametrize(
    ("end", "dt", "hold", "message"),
    [
        (20_000_001.0, 20_000_001.0, 1.0, "t_end = 20000001.0 .*at most 20000000 times the sampling step 1 s"),
        (5_000_001.0, 1.0, None, "dt_out = 1.0 .*at least 1 s, for 5000000 samples"),
    ],
)
def test_one_tick_or_sample_too_many_is_refused(end: float, dt: float, hold: float | None, message: str) -> None:
    with pytest.raises(InputError, match=message):
        ticks_of(end, dt, hold, "the test")


def test_a_span_is_not_repeated_less_than_once() -> None:
    assert times_in(0.1, 0.3) is None
    with pytest.raises(InputError, match=r"save = 0\.1 .*: must be a multiple"):
        rows_of(0.1, 1.0, 0.3, "the test")
    assert np.array_equal(rows_of(0.6, 0.95, 0.3, "the test"), [0.0, 0.6])
