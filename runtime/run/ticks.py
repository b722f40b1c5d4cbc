# SPDX-License-Identifier: Apache-2.0
"""When a run stops to look, record and control.

Instants are counted: the k-th is k times a fraction, rounded once. A sum or a product of doubles is not: 3 times 0.3 is
below 0.9, and what begins at 0.9 would miss its sample.
"""

from __future__ import annotations

import functools
import math
from fractions import Fraction

import numpy as np

from mehvar.errors import InputError, bad_value, whence

from ..model.functions import FloatArray

_MULTIPLE = 1e-9
"""Relative tolerance of "is a whole number of times", for numbers written with nine digits and more; at half or twice
of it only such numbers are taken otherwise. Decimals and simple fractions are exact multiples or far from it."""
_DENOMINATOR = 10**6
"""Of a simple fraction: microseconds, and steps such as 1/3, 1/60 and 1/44100 s. Fractions up to it are 1e-12 apart, so
that below some thousand seconds no other lies within the rounding of one; with twice as many, half so far."""
_SPACINGS = 4
"""Of the double that a fraction may be off by: sums and products of a few decimals, such as 0.1 + 0.2, are those that
were meant. Half as many lose products of three; with twice as many no fraction is mistaken below 500 s."""
_EXACT = 2**53  # whole numbers up to it are doubles
_FINEST = 10_000
"""Parts of a sampling step at most that inputs over time may ask for: instants that were measured, not chosen, have no
common step but their last digit. With half or twice as many only grids between are taken otherwise."""
_MOST_TICKS = 20_000_000
_MOST_SAMPLES = 5_000_000


@functools.lru_cache(maxsize=4096)  # of a handful a run, and of the instants of inputs over time
def fraction(value: float) -> Fraction:
    """Return the simple fraction that a number is the rounding of, or else its decimal digits."""
    simple = Fraction(value).limit_denominator(_DENOMINATOR)
    if abs(float(simple) - value) <= _SPACINGS * math.ulp(value):
        return simple
    return Fraction(repr(float(value)))


def multiples(step: Fraction, count: int) -> FloatArray:
    """Return 0, step, ..., (count - 1) step, each the double next to it."""
    over, under = step.numerator, step.denominator
    if count * over <= _EXACT and under <= _EXACT:
        return np.arange(count, dtype=np.float64) * over / under  # exact but for the division
    return np.array([k * over / under for k in range(count)])


def times_in(longer: float, shorter: float) -> int | None:
    """Return how many times one span holds another; None when that is no whole number, or none."""
    ratio = longer / shorter
    if not 0.5 < ratio < _EXACT or abs(ratio - round(ratio)) > _MULTIPLE * ratio:
        return None
    return round(ratio)


def grid(end: float, step: Fraction) -> FloatArray:
    """Return the multiples of a step from 0 up to an end; one that is the end but for rounding is it."""
    last = fraction(end)
    count = math.floor(last / step + Fraction(_MULTIPLE))
    instants = multiples(step, count + 1)
    if count and last - count * step < _MULTIPLE * step:
        instants[-1] = float(last)
    return instants


def rows_of(every: float, end: float, dt: float, origin: str) -> FloatArray:
    """Return the instants of a series with a row every so often."""
    steps = times_in(every, dt)
    if steps is None or every > end * (1 + _MULTIPLE):
        allowed = f"a multiple of the sampling step {dt:g} s, at most the end time {end:g} s"
        raise bad_value("save", every, allowed, origin)
    return grid(end, fraction(dt) * steps)


def ticks_of(end: float, dt: float, hold: float | None, origin: str) -> tuple[FloatArray, int, int | None]:
    """Return the instants at which a run stops, the end among them; ticks per recorded sample; ticks per hold."""
    shortest = dt if hold is None else min(dt, hold)
    if end / shortest > _MOST_TICKS:
        raise bad_value("t_end", end, f"at most {_MOST_TICKS} times the sampling step {shortest:g} s", origin)
    if end / dt > _MOST_SAMPLES:
        raise bad_value("dt_out", dt, f"at least {end / _MOST_SAMPLES:g} s, for {_MOST_SAMPLES} samples", origin)
    record_every, hold_every = times_in(dt, shortest), None if hold is None else times_in(hold, shortest)
    if record_every is None or (hold is not None and hold_every is None):
        raise InputError(
            f"hold = {hold:g} s{whence(origin, 'hold')} and dt_out = {dt:g} s{whence(origin, 'dt_out')}: "
            "one must be an integer multiple of the other"
        )
    tick = fraction(dt) / record_every
    ticks, last = grid(end, tick), fraction(end)
    if len(ticks) == 1 or last - (len(ticks) - 1) * tick > _MULTIPLE * tick:
        ticks = np.append(ticks, float(last))
    # Beyond the end a step is as good as any other, and C counts ticks in 64 bits.
    record_every = min(record_every, len(ticks))
    hold_every = None if hold_every is None else min(hold_every, len(ticks))
    return ticks, record_every, hold_every


def common_step(dt: float, instants: FloatArray, origin: str) -> float:
    """Return the longest span of which the sampling step and all instants are multiples.

    Raises
    ------
    InputError
        When there is none but a tiny one.
    """
    step = fraction(dt)
    for instant in instants:
        other = fraction(float(instant))
        shared = math.lcm(step.denominator, other.denominator)
        step = Fraction(math.gcd(int(step * shared), int(other * shared)), shared)
    if step * _FINEST < fraction(dt):
        allowed = f"multiples of a step that divides dt_out = {dt:g} s, or period must say how often they are looked at"
        raise InputError(f"the instants of inputs (from {origin}): must be {allowed}")
    return float(step)
