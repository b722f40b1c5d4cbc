# SPDX-License-Identifier: Apache-2.0
"""Location of zero crossings of guards in a step: rules and numbers of native/step/events.h, roots by SciPy."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mehvar.base.manifest import Event
from mehvar.runtime.model.functions import FloatArray

from .headers import numbers

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
    """The first crossing of a guard in a step: its part of the step, its instant, and the events there."""

    part: float
    t: float
    fires: tuple[int, ...]


class Watch:
    """The guards of a loop and their current sides.

    Parameters
    ----------
    guards : callable
        (t, q) -> values.
    events : sequence of Event
        Events of the loop.
    end : float
        End of the run, s.
    """

    def __init__(self, guards: _Guards, events: Sequence[Event], end: float) -> None:
        self._guards, self._end = guards, end
        self._direction = np.array([event.numbers[0] for event in events])
        self._forbidden = np.where([bool(event.ends) for event in events], self._direction, 0)
        self.begins = True
        self._value = self._side = np.full(len(events), np.nan)
        self._zero = self._noise = np.zeros(len(events))
        self._resting = np.zeros(len(events), bool)
        self._last, self._stalled = -np.inf, 0

    def begin(self, t: float, q: FloatArray) -> tuple[int, ...]:
        """Update the sides of guards after a change outside the flow: at the start, or with an input.

        Returns the events that end runs and that the state has already passed.
        """
        value = self._guards(t, q)
        same = value == self._value
        self._side = np.where(same, self._side, np.sign(value))
        self._resting = np.where(same, self._resting, value == 0)
        self._noise = np.where(same, self._noise, 0.0)
        self._value = value
        if self.begins:  # an event that ends runs may happen at once from zero
            self._side = np.where(value == 0, -self._forbidden, self._side)
        self.begins = False
        return _numbers(self._side * self._forbidden > 0)

    @property
    def finite(self) -> bool:
        """True where all guards were numbers at their last evaluation."""
        return bool(np.all(np.isfinite(self._value)))

    def crossing(self, t: float, h: float, within: _Within) -> Crossing | None:
        """Return the first crossing in a step and move to its end; `within` gives the coordinates at a part of it."""
        tolerance = _LOCATED * h + 2 * np.spacing(t)

        def values(part: float) -> FloatArray:
            value = self._guards(t + part * h, within(part))
            return np.where(self._resting, value / part, value) if part else value

        ahead, reaches, value = self._side, np.abs(self._value), self._value
        if self._resting.any():
            goes = self._probe(values)
            turned = self._resting & (ahead * goes < 0)
            if (turned & self._counts(ahead)).any():
                return Crossing(tolerance / h, t + tolerance, _numbers(turned & self._counts(ahead)))
            ahead = np.where(self._resting & (goes != 0), goes, ahead)
        for look in range(1, _LOOKS + 1):
            value = values(look / _LOOKS)
            reaches = np.maximum(reaches, np.abs(value))
            side = self._side_from(ahead, look / _LOOKS, value)
            rests_on = self._resting & (side == 0)
            flips = (ahead != 0) & (side != ahead) & ~rests_on
            crosses = flips & self._counts(ahead)
            if crosses.any():
                low, high = (look - 1) / _LOOKS, look / _LOOKS
                return self._first(t, h, values, crosses, ahead, low, high, reaches, tolerance / h)
            ahead = np.where(rests_on, ahead, _over(ahead, side))
        still = self._resting & (ahead == 0)
        self._noise = np.where(still, self._noise, 0.0)
        self._side, self._value, self._resting = ahead, value, still | (value == 0)
        return None

    def _side_from(self, side: FloatArray, part: float, value: FloatArray) -> FloatArray:
        """Return the sides of guards; a resting guard that is still within its noise has none."""
        still = (side == 0) & self._resting & (np.abs(value * part) <= self._noise)
        return np.where(still, 0.0, np.sign(value))

    def _probe(self, values: _Within) -> FloatArray:
        """Return the values of resting guards just after the start of the step, or later where they are undecided."""
        part, none = _PROBE, np.zeros(len(self._side))
        value = values(part)
        open_, goes = self._resting & (value != 0), self._side_from(none, part, value)
        while (open_ := open_ & (goes == 0)).any() and part * _LOOKS < 1:
            part *= 4
            goes = np.where(open_, self._side_from(none, part, values(part)), goes)
        return goes

    def _first(
        self, t: float, h: float, values: Callable[[float], FloatArray], crosses: _Mask, ahead: FloatArray,
        low: float, high: float, reaches: FloatArray, tolerance: float,
    ) -> Crossing:  # fmt: skip
        """Return the first of the crossings in a part of a step, beyond it by the tolerance at most."""
        from scipy.optimize import brentq

        roots = []
        for e in _numbers(crosses):
            begin = low if low or not self._resting[e] else _PROBE
            ends = [values(part)[e] for part in (begin, high)]
            roots.append(
                brentq(lambda s, e=e: values(s)[e], begin, high, xtol=tolerance / 4) if ends[0] * ends[1] < 0 else high
            )
        part, located = min(min(roots) + tolerance / 2, high), tolerance
        while not (crossed := crosses & (np.sign(value := values(part)) != ahead)).any():
            tolerance *= 2  # the state or the guard is too coarse; at `high` one has crossed
            part = min(min(roots) + tolerance / 2, high)
        past = min(_STEEPEST * tolerance / part, 1.0)
        now, stays = np.abs(value), ~self._resting & (np.sign(value) == ahead) & (ahead == self._side)
        touches = stays & self._counts(ahead) & (now <= past * (np.abs(self._value) - now))
        happens = crossed | touches
        still = self._resting & (ahead == 0) & (self._side_from(ahead, part, value) == 0) & ~happens
        self._zero = np.where(happens, reaches * (_RESTING + past), _RESTING * now)
        noise = np.where(happens & (tolerance > located), self._zero, 0.0)
        self._noise = np.where(still, self._noise, noise)
        self._side, self._resting = np.where(still, 0.0, _over(ahead, value)), still
        return Crossing(part, t + part * h, _numbers(happens))

    def settle(self, t: float, before: FloatArray, q: FloatArray, fires: Sequence[int]) -> tuple[int, ...]:
        """Update the sides after events at the coordinates `before`; return events that end runs and lie behind q."""
        earlier, value = self._guards(t, before), self._guards(t, q)
        happens = np.isin(np.arange(len(value)), fires)
        side = np.where(happens, 0, self._side)
        other = happens | (value != earlier)
        resting = np.abs(value) <= self._zero
        self._side = np.where(other & ~resting, np.sign(value), side)
        self._resting = np.where(other, resting, self._resting | (value == 0))
        self._value = value
        self._stalled = self._stalled + 1 if t - self._last <= _STALLED * self._end else 0
        self._last = t
        return _numbers(other & ~resting & (self._side * self._forbidden > 0))

    @property
    def stalled(self) -> bool:
        """True where events repeat without progress in time."""
        return self._stalled >= _CHATTERING

    def _counts(self, side: FloatArray) -> _Mask:
        """Return True for the guards that have an event on leaving a side."""
        counts: _Mask = np.where(self._direction == 0, side != 0, side * self._direction < 0)
        return counts


def _over(side: FloatArray, value: FloatArray) -> FloatArray:
    """Return the sides of guards after a move to a value; a zero counts as the other side."""
    return np.where((value == 0) & (side != 0), -side, np.sign(value))


def _numbers(mask: _Mask) -> tuple[int, ...]:
    return tuple(int(e) for e in np.flatnonzero(mask))
