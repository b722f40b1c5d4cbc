# SPDX-License-Identifier: Apache-2.0
"""When a run stops to look, record and control."""

from __future__ import annotations

import math

import numpy as np

from mehvar.errors import InputError, bad_value

from ..model.functions import FloatArray

_MULTIPLE = 1e-9  # relative tolerance of "is an integer multiple of"
_MOST_TICKS = 20_000_000
_MOST_SAMPLES = 5_000_000


def ticks_of(end: float, dt: float, hold: float | None, origin: str) -> tuple[FloatArray, int, int | None]:
    """Return the instants at which a run stops, at k dt to the last bit; ticks per recorded sample; ticks per hold."""
    tick = dt if hold is None else min(dt, hold)
    number_of_ticks = end / tick
    if number_of_ticks > _MOST_TICKS:
        raise bad_value("t_end", end, f"at most {_MOST_TICKS} times the sampling step {tick:g} s", origin)
    if end / dt > _MOST_SAMPLES:
        raise bad_value("dt_out", dt, f"at least {end / _MOST_SAMPLES:g} s, for {_MOST_SAMPLES} samples", origin)
    record_every = _ratio(dt, tick, hold, origin)
    hold_every = None if hold is None else _ratio(hold, tick, dt, origin)
    k = np.arange(math.floor(number_of_ticks * (1 + _MULTIPLE)) + 1)
    # Beyond the end a step is as good as any other, and C counts ticks in 64 bits.
    record_every = min(record_every, len(k))
    hold_every = None if hold_every is None else min(hold_every, len(k))
    ticks = (k // record_every) * dt + (k % record_every) * tick
    if end - ticks[-1] > _MULTIPLE * tick:
        ticks = np.append(ticks, end)
    else:
        ticks[-1] = end
    return ticks, record_every, hold_every


def _ratio(longer: float, tick: float, other: float | None, origin: str) -> int:
    ratio = longer / tick
    if abs(ratio - round(ratio)) > _MULTIPLE * ratio:
        pair = sorted((longer, other if other is not None else tick))
        raise InputError(
            f"hold and dt_out are {pair[0]:g} s and {pair[1]:g} s (from {origin}): "
            "one must be an integer multiple of the other"
        )
    return round(ratio)
