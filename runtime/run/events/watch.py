# SPDX-License-Identifier: Apache-2.0
"""Where a guard crosses zero in a step: the rules of native/step/events.h with its numbers, and the roots by SciPy."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mehvar.manifest import Event

from ...compiling.structures import numbers
from ...model.functions import FloatArray

_NUMBERS = numbers("step/events.h")
_LOCATED, _PROBE, _RESTING, _STEEPEST, _STALLED, _CHATTERING = (
    _NUMBERS[name] for name in ("LOCATED", "PROBE", "RESTING", "STEEPEST", "STALLED", "CHATTERING")
)
_LOOKS = int(_NUMBERS["LOOKS"])

_Guards = Callable[[float, FloatArray], FloatArray]
_Within = Callable[[float], FloatArray]
_Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Crossing:
    """Where a step crosses a guard: its part of the step, the instant, and which events happen there."""

    part: float
    t: float
    fires: tuple[int, ...]


class Watch:
    """The guards of a loop and the sides that they are on.

    Parameters
    ----------
    guards : callable
        (t, q) -> values.
    events : sequence of Event
        Of the loop.
    end : float
        Where the run ends, s.
    """

    def __init__(self, guards: _Guards, events: Sequence[Event], end: float) -> None:
        self._guards, self._end = guards, end
        self._direction = np.array([event.numbers[0] for event in events])
        self._value = self._side = self._zero = np.full(len(events), np.nan)
        self._resting = np.zeros(len(events), bool)
        self._last, self._stalled = -np.inf, 0

    def begin(self, t: float, q: FloatArray) -> None:
        """Take the sides of guards that changed otherwise than along the flow: at the start, or with an input."""
        value = self._guards(t, q)
        same = value == self._value
        self._side = np.where(same, self._side, np.sign(value))
        self._resting = np.where(same, self._resting, value == 0)
        self._value = value

    def crossing(self, t: float, h: float, within: _Within) -> Crossing | None:
        """Return the first crossing in a step, whose coordinates at a part of it are given; move on to its end."""
        tolerance = _LOCATED * h + 2 * np.spacing(t)

        def values(part: float) -> FloatArray:
            value = self._guards(t + part * h, within(part))
            return np.where(self._resting, value / part, value) if part else value

        ahead, reaches, value = self._side, np.abs(self._value), self._value
        if self._resting.any():
            goes = np.sign(values(_PROBE))
            turned = self._resting & (ahead * goes < 0)
            if (turned & self._counts(ahead)).any():
                return Crossing(0.0, t + tolerance, _numbers(turned & self._counts(ahead)))
            ahead = np.where(self._resting, goes, ahead)
        for look in range(1, _LOOKS + 1):
            value = values(look / _LOOKS)
            reaches = np.maximum(reaches, np.abs(value))
            flips = (ahead != 0) & (np.sign(value) != ahead)
            crosses = flips & self._counts(ahead)
            if crosses.any():
                low, high = (look - 1) / _LOOKS, look / _LOOKS
                return self._first(t, h, values, crosses, ahead, low, high, reaches, tolerance / h)
            ahead = _over(ahead, value)
        self._side, self._value, self._resting = ahead, value, value == 0
        return None

    def _first(
        self, t: float, h: float, values: Callable[[float], FloatArray], crosses: _Mask, ahead: FloatArray,
        low: float, high: float, reaches: FloatArray, tolerance: float,
    ) -> Crossing:  # fmt: skip
        """Return the first of the crossings in a part of a step, past it by the tolerance at most."""
        from scipy.optimize import brentq

        roots = {}
        for e in _numbers(crosses):
            begin = low if low or not self._resting[e] else _PROBE
            ends = [values(part)[e] for part in (begin, high)]
            roots[e] = (
                brentq(lambda s, e=e: values(s)[e], begin, high, xtol=tolerance / 4) if ends[0] * ends[1] < 0 else high
            )
        part = min(min(roots.values()) + tolerance / 2, 1.0)
        value, past = values(part), min(_STEEPEST * tolerance / part, 1.0)
        now, stays = np.abs(value), ~self._resting & (np.sign(value) == ahead) & (ahead == self._side)
        touches = stays & self._counts(ahead) & (now <= past * (np.abs(self._value) - now))
        fires = {e for e, root in roots.items() if root <= part} | set(_numbers(touches))
        happens = np.isin(np.arange(len(now)), sorted(fires))
        self._zero = np.where(happens, reaches * (_RESTING + past), _RESTING * now)
        self._side = _over(ahead, value)
        return Crossing(part, t + part * h, tuple(sorted(fires)))

    def settle(self, t: float, before: FloatArray, q: FloatArray, fires: Sequence[int]) -> bool:
        """Take the sides after events at the coordinates `before`; return whether they come without progress."""
        earlier, value = self._guards(t, before), self._guards(t, q)
        happens = np.isin(np.arange(len(value)), fires)
        side = np.where(happens, 0, self._side)
        other = happens | (value != earlier)
        resting = np.abs(value) <= np.nan_to_num(self._zero)
        self._side = np.where(other & ~resting, np.sign(value), side)
        self._resting = np.where(other, resting, value == 0)
        self._value = value
        self._stalled = self._stalled + 1 if t - self._last <= _STALLED * self._end else 0
        self._last = t
        return self._stalled >= _CHATTERING

    def _counts(self, side: FloatArray) -> _Mask:
        """Tell which guards an event is about that leave a side."""
        counts: _Mask = np.where(self._direction == 0, side != 0, side * self._direction < 0)
        return counts


def _over(side: FloatArray, value: FloatArray) -> FloatArray:
    """Return the sides of guards that have moved to a value: a zero is on the other side."""
    return np.where((value == 0) & (side != 0), -side, np.sign(value))


def _numbers(mask: _Mask) -> tuple[int, ...]:
    return tuple(int(e) for e in np.flatnonzero(mask))
