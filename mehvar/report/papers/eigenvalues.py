# SPDX-License-Identifier: Apache-2.0
"""Eigenvalues of closed loops at the end of a report's runs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mehvar.runtime.model.linear import modes

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from mehvar.reproduction.runs import Runs
    from mehvar.runtime.model.functions import FloatArray
    from mehvar.runtime.model.linear import LinearSystem
    from mehvar.runtime.run.simulate import Run

    ComplexArray = NDArray[np.complex128]

SHOWN = 4
"""Number of eigenvalues on a line of the table."""
_SAME = 0.01
"""Allowed relative change of an eigenvalue when the state changes within the run's tolerance. Smooth loops change by
1e-8; at a kink of a law eigenvalues are undefined. Half or twice changes no row.
"""


@dataclass(frozen=True)
class LoopSpectrum:
    """Eigenvalues of one loop that are nearest to instability.

    Attributes
    ----------
    scenario, law : str
        The run.
    t : float
        End of the run, at which the loop was linearised, s.
    period : float or None
        Period of a sampled law, s, whose eigenvalues are those of the map over a period; None for eigenvalues in 1/s.
    count : int
        Number of eigenvalues.
    nearest : tuple of complex
        Eigenvalues with the largest modulus or real part, one per conjugate pair. Empty if the loop has no derivative
        or the end is too close to a kink.
    """

    scenario: str
    law: str
    t: float
    period: float | None
    count: int
    nearest: tuple[complex, ...]


def loop_spectra(runs: Runs, loops: Iterable[tuple[str, str]]) -> list[LoopSpectrum]:
    """Linearise loops, given by scenario and law, at the last sample of their runs."""
    return [_spectrum(runs, scenario, law) for scenario, law in loops]


def _spectrum(runs: Runs, scenario: str, law: str) -> LoopSpectrum:
    """Return the eigenvalues nearest to instability at a run's end; none if they vary within its tolerances."""
    run, model = runs(law, scenario), runs.model
    values, t = run.parameters, float(run.t[-1])
    held = run.controller.memory and run.controller.period and len(run.t) > 1
    memory = {"u": run.u[-2] if held else None, "z": run.z[-1] if run.controller.memory else None}
    r = model.functions["reference"](t, values.p, values.s)

    def linear(x: FloatArray) -> LinearSystem:
        return model.linearize(x, p=values.p, r=r, controller=law, c=values.c, **memory)

    system = linear(run.x[-1])
    eigenvalues = system.eigenvalues
    upper = eigenvalues[~(eigenvalues.imag < 0)]
    period = None if system.period is None else float(system.period)
    order = np.argsort(-(upper.real if period is None else np.abs(upper)), kind="stable")
    nearest = upper[order[:SHOWN]]
    steady = all(_same(nearest, linear(x).A) for x in _within_tolerance(run))
    return LoopSpectrum(scenario, law, t, period, len(eigenvalues), tuple(nearest.tolist()) if steady else ())


def _within_tolerance(run: Run) -> Iterator[FloatArray]:
    """Yield the final state of a run, and states that differ from it within tolerance in one element."""
    x = run.x[-1]
    yield x
    off = np.diag(float(run.options["rtol"]) * np.abs(x) + float(run.options["atol"]))
    yield from (x + step for step in (*off, *-off))


def _same(some: ComplexArray, matrix: FloatArray) -> bool:
    """Return True if a matrix has these eigenvalues; False if one of both contains NaN."""
    if not (np.isfinite(some).all() and np.isfinite(matrix).all()):
        return False
    others, errors = modes(matrix)
    distance = np.abs(some[:, None] - others)
    return bool((distance <= _SAME * np.abs(some)[:, None] + errors).any(axis=1).all())
