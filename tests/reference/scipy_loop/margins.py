# SPDX-License-Identifier: Apache-2.0
"""Detection of margins that are not positive: the rules of native/step/margins.h with its numbers."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mehvar.runtime.model.functions import FloatArray

from .headers import numbers

_NUMBERS = numbers("step/margins.h")
_LIMIT_TIME, _AHEAD_PART = (_NUMBERS[name] for name in ("LIMIT_TIME", "AHEAD_PART"))

_Of = Callable[[float, FloatArray], FloatArray]


class Margins:
    """The margins of a loop, from step to step.

    Parameters
    ----------
    margins, slope : callable
        (t, q) -> values, and the rates of q.
    touches : bool
        True where margins are checked along slopes.
    fixed : bool
        True for fixed steps, which are never repeated.
    end : float
        End of the run, s.

    Attributes
    ----------
    broken : int or None
        The limit that the last step violated.
    """

    def __init__(self, margins: _Of, slope: _Of, *, touches: bool, fixed: bool, end: float) -> None:
        self._margins, self._slope, self._touches, self._fixed = margins, slope, touches, fixed
        self._tolerance, self._held = _LIMIT_TIME * end, 1.0
        self._value = np.empty(0)
        self.broken: int | None = None

    def begin(self, t: float, q: FloatArray) -> None:
        """Evaluate the margins at the start of a step."""
        self._value = self._margins(t, q)
        self.broken = _first(~(self._value > 0))

    def shorter(self, t: float, q: FloatArray, h: float, y: FloatArray) -> float | None:
        """Return the length at which to repeat the step q -> y of length h; None to keep it and move to its end."""
        end = self._margins(t + h, y)
        crossed = ~(end > 0)
        if crossed.any():
            held = self._value * self._held
            part = float(np.min((held / (held - end))[crossed]))
            past = float(np.max((end / (end - self._value))[crossed]))
            broken = _first(crossed)
        else:
            part, broken = self._touching(t, q, h, y, end)
            past = 1.0
        if broken is not None and not self._fixed and h > self._tolerance and past * h > self._tolerance:
            self._held /= 2
            return max(part * h, self._tolerance / 2)
        self._held, self._value, self.broken = 1.0, end, broken
        return None

    def _touching(self, t: float, q: FloatArray, h: float, y: FloatArray, end: FloatArray) -> tuple[float, int | None]:
        """Return the smallest part of a step where the tangent of a margin is zero and the margin rises afterwards."""
        if not self._touches:
            return 1.0, None
        ahead = self._margins(t, q + _AHEAD_PART * h * self._slope(t, q))
        parts = _AHEAD_PART * self._value / (self._value - ahead)
        falls = (parts >= 0) & (parts <= 1)
        if not falls.any():
            return 1.0, None
        falls &= self._margins(t + h, y + _AHEAD_PART * h * self._slope(t + h, y)) > end
        parts = np.where(falls, parts, np.inf)
        return float(np.min(parts)), int(np.argmin(parts)) if falls.any() else None


def _first(mask: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]) -> int | None:
    indices = np.flatnonzero(mask)
    return int(indices[0]) if indices.size else None
