# SPDX-License-Identifier: Apache-2.0
"""Eigenvalues of the closed loops where the runs of a report end."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from mehvar.papers.runs import Runs

SHOWN = 4
"""Fills a line of the table."""


@dataclass(frozen=True)
class LoopSpectrum:
    """The eigenvalues of one loop that are nearest to instability.

    Attributes
    ----------
    scenario, law : str
        The run.
    t : float
        Where it ended and the loop was linearised, s.
    period : float or None
        Of a sampled law, s: eigenvalues of the map over a period, stable within the unit circle; else in 1/s.
    count : int
        Of all eigenvalues.
    nearest : tuple of complex
        Those with the largest modulus, or real part, one of each conjugate pair; empty where the loop has no
        derivative.
    """

    scenario: str
    law: str
    t: float
    period: float | None
    count: int
    nearest: tuple[complex, ...]


def loop_spectra(runs: Runs, loops: Iterable[tuple[str, str]]) -> list[LoopSpectrum]:
    """Linearise loops, each a scenario and a law, at the last sample of their runs."""
    return [_spectrum(runs, scenario, law) for scenario, law in loops]


def _spectrum(runs: Runs, scenario: str, law: str) -> LoopSpectrum:
    run, model = runs(law, scenario), runs.model
    values, t = run.parameters, float(run.t[-1])
    memory = {"u": run.u[-2], "z": run.z[-1]} if run.controller.memory and len(run.t) > 1 else {"u": None}
    r = model.functions["reference"](t, values.p, values.s)
    system = model.linearize(run.x[-1], p=values.p, r=r, controller=law, c=values.c, **memory)
    eigenvalues = system.eigenvalues
    upper = eigenvalues[~(eigenvalues.imag < 0)]
    period = None if system.period is None else float(system.period)
    order = np.argsort(-(upper.real if period is None else np.abs(upper)), kind="stable")
    nearest = tuple(complex(value) for value in upper[order[:SHOWN]]) if np.all(np.isfinite(upper)) else ()
    return LoopSpectrum(scenario, law, t, period, len(eigenvalues), nearest)
