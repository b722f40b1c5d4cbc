# SPDX-License-Identifier: Apache-2.0
"""Gain and phase margins of a loop, cut at each input in turn."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mehvar.runtime.model.functions import FloatArray
from mehvar.runtime.model.linear import LinearSystem

_MARGINAL = 1e-6
"""Tolerance relative to the largest eigenvalue, for integrators outside the law, whose eigenvalues are zero up to
rounding (1e-8 for a double one). Ten times the tolerance hides slow instabilities; a tenth misses triple integrators.
"""
_INTEGRATOR = 1e-7
"""Tolerance for a double integrator, whose eigenvalues have errors of 1e-8."""
_POINTS = 1000
"""Number of frequencies in the grid that finds crossings, besides those of the eigenvalues, where responses are
steepest. Half or twice this number changes no margin of the three shipped models.
"""
_DECADES = 2
"""Decades of the grid below the slowest and above the fastest eigenvalue. At both ends a first-order lag is within 1 %
of its asymptote."""


_ROUNDING = 1e-6
"""Tolerance of a phase, rad, and of a logarithmic gain. Below the slowest pole, rounding of about 1e-9 moves a real
response across the axis at random; true crossings have clear values on both sides."""


@dataclass(frozen=True)
class Margin:
    """Stability margins at one input, with all other loops closed.

    Attributes
    ----------
    input : str
        The input at which the loop is opened.
    gain : float
        Gain factor nearest to one that makes the loop unstable; infinite if there is none.
    phase : float
        Loss of phase that makes the loop unstable, rad; infinite if there is none.
    """

    input: str
    gain: float
    phase: float


def margins(cut: LinearSystem) -> tuple[Margin, ...]:
    """Return the margins at each input that a law uses, or nothing if the closed loop is unstable.

    Parameters
    ----------
    cut : LinearSystem
        As `mehvar.runtime.model.linear.cut_loop` returns it.
    """
    closed = cut.A + cut.B @ cut.C
    if not (np.all(np.isfinite(closed)) and _is_stable(closed, cut.period)):
        return ()
    loops = ((name, _Loop(cut, closed, number)) for number, name in enumerate(cut.inputs))
    return tuple(Margin(name, loop.gain(), loop.phase()) for name, loop in loops if loop.acts)


def _is_stable(closed: FloatArray, period: FloatArray | None) -> bool:
    eigenvalues = np.linalg.eigvals(closed)
    if period is None:
        return bool(np.all(eigenvalues.real <= _MARGINAL * np.max(np.abs(eigenvalues))))
    return bool(np.all(np.abs(eigenvalues) <= 1 + _MARGINAL))


class _Loop:
    """Frequency response of the open loop at one input, with opposite sign.

    The closed loop is unstable if the response encircles -1.
    """

    def __init__(self, cut: LinearSystem, closed: FloatArray, number: int) -> None:
        self._b, self._c = cut.B[:, number], cut.C[number]
        self._A = closed - np.outer(self._b, self._c)
        self._period = None if cut.period is None else float(cut.period)
        self._eye = np.eye(len(closed))
        self.acts = bool(np.any(self._c) and np.any(self._b))
        self._frequencies = self._grid(closed) if self.acts else np.empty(0)
        self._values = np.array([self.at(w) for w in self._frequencies])

    def at(self, frequency: float) -> complex:
        """Return the response at an angular frequency, rad/s."""
        s = 1j * frequency if self._period is None else np.exp(1j * frequency * self._period)
        try:
            return complex(-self._c @ np.linalg.solve(s * self._eye - self._A, self._b))
        except np.linalg.LinAlgError:  # on a pole
            return complex(math.inf)

    def gain(self) -> float:
        """Return the gain factor nearest to one at which the response passes through -1."""
        crossings = [self.at(w) for w in self._crossings(lambda value: value.imag / abs(value) if value else math.inf)]
        factors = [-1 / value.real for value in (*crossings, *self._ends()) if -math.inf < value.real < 0]
        return min(factors, key=lambda factor: abs(math.log(factor)), default=math.inf)

    def _ends(self) -> Iterator[complex]:
        """Yield the response at frequencies where it is real: zero and, for a sampled loop, the Nyquist frequency."""
        ends = (0.0,) if self._period is None else (0.0, math.pi / self._period)
        poles = np.linalg.eigvals(self._A)
        for w in ends:
            place = 0.0 if self._period is None else math.cos(w * self._period)
            if np.all(np.abs(poles - place) > self._rounded(poles)):
                yield self.at(w)

    def _rounded(self, poles: NDArray[Any]) -> float:
        """Return the largest distance from an integrator at which a pole counts as one."""
        return _INTEGRATOR * (float(np.max(np.abs(poles), initial=0.0)) if self._period is None else 1.0)

    def phase(self) -> float:
        """Return the smallest angle between the response and -1 at gain one."""
        crossings = [self.at(w) for w in self._crossings(lambda value: math.log(abs(value)) if value else -math.inf)]
        return min((abs(float(np.angle(-value))) for value in crossings), default=math.inf)

    def _grid(self, closed: FloatArray) -> FloatArray:
        both = np.concatenate([np.linalg.eigvals(self._A), np.linalg.eigvals(closed)])
        with np.errstate(divide="ignore", invalid="ignore"):
            sizes = np.abs(both if self._period is None else np.log(both) / self._period)
        sizes = sizes[np.isfinite(sizes) & (sizes > _MARGINAL * np.max(sizes[np.isfinite(sizes)], initial=0.0))]
        low, high = (np.min(sizes), np.max(sizes)) if sizes.size else (1.0, 1.0)
        highest = 10**_DECADES * high if self._period is None else math.pi / self._period
        grid = np.geomspace(min(low / 10**_DECADES, highest / 2), highest, _POINTS)
        return np.unique(np.concatenate([grid, sizes[sizes < highest]]))

    def _crossings(self, what: Callable[[complex], float]) -> Iterator[float]:
        """Yield the frequencies at which a quantity of the response changes sign; ignore rounding."""
        from scipy.optimize import brentq  # takes half a second, which an unchanged model does not need

        signs = [(w, what(value)) for w, value in zip(self._frequencies, self._values, strict=True)]
        significant = [(w, sign) for w, sign in signs if math.isfinite(sign) and abs(sign) > _ROUNDING]
        for (low, a), (high, b) in itertools.pairwise(significant):
            if a * b < 0:
                yield float(brentq(lambda w: what(self.at(w)), low, high))
