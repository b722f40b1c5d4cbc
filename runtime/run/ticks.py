# SPDX-License-Identifier: Apache-2.0
"""Instants at which a run stops to check, record and control.

The k-th instant is k times a fraction, rounded once. Sums and products of doubles are inexact: 3 times 0.3 is below
0.9, so that an event at 0.9 would miss its sample.
"""

from __future__ import annotations

import functools
import math
from fractions import Fraction

import numpy as np

from mehvar.base.errors import InputError, bad_value, origin_text

from ..model.functions import FloatArray

MULTIPLE = 1e-9
"""Relative tolerance of integer multiples. It only matters for numbers with nine or more digits: sums of 1e6 doubles
and stamps of any clock are closer.
"""
_DENOMINATOR = 10**6
"""Largest denominator of a simple fraction, for microseconds and steps such as 1/3, 1/60 and 1/44100 s. Such
fractions differ by at least 1e-12, so that rounding cannot confuse them below some thousand seconds; with twice the
denominator, below half of that.
"""
_SPACINGS = 4
"""Allowed error of a double in spacings, so that 0.1 + 0.2 counts as the intended fraction. Half as many exclude
products of three; twice as many confuse no fractions below 500 s.
"""
_EXACT = 2**53  # whole numbers up to it are doubles
_FINEST = 10_000
"""Largest number of parts of a sampling step for inputs over time. Half or twice only affects grids between the two."""
_MOST_TICKS = 20_000_000
_MOST_SAMPLES = 5_000_000


@functools.lru_cache(maxsize=4096)  # for a handful of values per run, and the instants of inputs over time
def fraction(value: float) -> Fraction:
    """Return the simple fraction that rounds to a number or, without one, its decimal value."""
    simple = Fraction(value).limit_denominator(_DENOMINATOR)
    if abs(float(simple) - value) <= _SPACINGS * math.ulp(value):
        return simple
    return Fraction(repr(float(value)))


def multiples(step: Fraction, count: int) -> FloatArray:
    """Return 0, step, ..., (count - 1) step, each rounded to the nearest double."""
    over, under = step.numerator, step.denominator
    if count * over <= _EXACT and under <= _EXACT:
        return np.arange(count, dtype=np.float64) * over / under  # exact except for the division
    return np.array([k * over / under for k in range(count)])


def times_in(longer: float, shorter: float) -> int | None:
    """Return the ratio of two time spans; None if it is not a positive whole number."""
    ratio = longer / shorter
    if not 0.5 < ratio < _EXACT or abs(ratio - round(ratio)) > MULTIPLE * ratio:
        return None
    return round(ratio)


def grid(end: float, step: Fraction) -> FloatArray:
    """Return the multiples of a step from 0 to an end.

    A multiple that equals the end up to rounding becomes the end.
    """
    last = fraction(end)
    count = math.floor(last / step + Fraction(MULTIPLE))
    instants = multiples(step, count + 1)
    if count and last - count * step < MULTIPLE * step:
        instants[-1] = float(last)
    return instants


def rows_of(every: float, end: float, dt: float, origin: str) -> FloatArray:
    """Return the instants of a series with this time between rows."""
    steps = times_in(every, dt)
    if steps is None or every > end * (1 + MULTIPLE):
        allowed = f"a multiple of the sampling step {dt:g} s, at most the end time {end:g} s"
        raise bad_value("save", every, allowed, origin)
    return grid(end, fraction(dt) * steps)


def ticks_of(end: float, dt: float, hold: float | None, origin: str) -> tuple[FloatArray, int, int | None]:
    """Return the instants at which a run stops, including its end, and the ticks per recorded sample and per hold."""
    shortest = dt if hold is None else min(dt, hold)
    if end / shortest > _MOST_TICKS:
        raise bad_value("t_end", end, f"at most {_MOST_TICKS} times the sampling step {shortest:g} s", origin)
    if end / dt > _MOST_SAMPLES:
        raise bad_value("dt_out", dt, f"at least {end / _MOST_SAMPLES:g} s, for {_MOST_SAMPLES} samples", origin)
    record_every, hold_every = times_in(dt, shortest), None if hold is None else times_in(hold, shortest)
    if record_every is None or (hold is not None and hold_every is None):
        raise InputError(
            f"hold = {hold:g} s{origin_text(origin, 'hold')} and dt_out = {dt:g} s{origin_text(origin, 'dt_out')}: "
            "one must be an integer multiple of the other"
        )
    tick = fraction(dt) / record_every
    ticks, last = grid(end, tick), fraction(end)
    if len(ticks) == 1 or last - (len(ticks) - 1) * tick > MULTIPLE * tick:
        ticks = np.append(ticks, float(last))
    # Beyond the end a step is as good as any other, and C counts ticks in 64 bits.
    record_every = min(record_every, len(ticks))
    hold_every = None if hold_every is None else min(hold_every, len(ticks))
    return ticks, record_every, hold_every


def common_step(dt: float, instants: FloatArray, origin: str) -> float:
    """Return the longest span that divides the sampling step and all instants, those on its grid up to rounding.

    Raises
    ------
    InputError
        If it is too small.
    """
    step = fraction(dt)
    for instant in instants:
        if times_in(float(instant), dt):
            continue
        other = fraction(float(instant))
        shared = math.lcm(step.denominator, other.denominator)
        step = Fraction(math.gcd(int(step * shared), int(other * shared)), shared)
    if step * _FINEST < fraction(dt):
        allowed = f"multiples of a step that divides dt_out = {dt:g} s: resample them, or give a period to sample at"
        raise InputError(f"the instants of inputs{origin_text(origin, 'inputs')}: must be {allowed}")
    return float(step)
