# SPDX-License-Identifier: Apache-2.0
"""Claims of the satellite's paper that fail in our reading, under other readings of its omissions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from mehvar.reproduction import Check, Checks, Expected, Readings, Runs

from .claims import carried, coefficients, offset_helps
from .survival import CLEAN, COVARIANCES, survival

if TYPE_CHECKING:
    from .coarse import Step

_SPEED = 6000 * np.pi / 30
"""Speed of a wheel at its limit, rad/s."""


def _survives(step: Step | None = None, pole: float = 0.001, **settings: Any) -> Checks:
    """Return the essential checks of claims 10 and 14, law (32) ends and does not ring, for nearly every F(0)."""

    def checks(runs: Runs, expected: Expected) -> Sequence[Check]:
        of, least, most = (
            f"of {len(COVARIANCES)} first covariances from 1 to 1e6",
            expected("survive"),
            expected("ring"),
        )
        if step is None and runs.model.backend != "c":
            return (Check(f"{of}, survives", f"≥ {least:g}", "not run: a batch needs a C compiler", False),)
        cell = survival(runs.model, step, pole, **settings)
        done, clean, calm = (int(which.sum()) for which in (cell.done, cell.clean, cell.calm(most)))
        ring = f"{calm}, largest ring {cell.ring[cell.done].max():.2g}" if done else "none"
        return (
            Check(f"{of}, survives", f"≥ {least:g}", f"{done}, {clean} of them within {CLEAN:g} deg", done >= least),
            Check(f"{of}, survives with a ring below {most:g}", f"≥ {least:g}", ring, calm >= least),
        )

    return checks


def _stepped(first: Callable[[float], float], second: Callable[[float], float], period: float = 0.5) -> Checks:
    """Return the checks that b0 and b1 are shares of Ts^2/I: `first` and `second` of the share of a sample left."""

    def checks(runs: Runs, expected: Expected) -> Sequence[Check]:
        values = runs("mrac", "paper").parameters.values
        rest = 1 - expected("cycle") / period
        gains = (period**2 / values[f"I_{i}"] for i in "xyz")
        return [c for k, gain in enumerate(gains) for c in coefficients(k, gain * first(rest), gain * second(rest))]

    return checks


def _carried(momentum: float, **settings: Any) -> Checks:
    return lambda runs, expected: carried(runs, expected, momentum, **settings)


def _helps(law: str, scenario: str, switch: str, **settings: Any) -> Checks:
    return lambda runs, expected: offset_helps(runs, law, scenario, switch, **settings)


READINGS: Readings = {
    "10": {
        "another F(0)": _survives(),
        "nominal first guess": _survives(scenario="paper"),
        "no offset in the law": _survives(compensate_d=0.0),
        "coarse simulator, explicit": _survives("explicit"),
        "coarse simulator": _survives("semi-implicit"),
        "pole 0.5": _survives(pole=0.5),
        "coarse simulator, pole 0.5": _survives("semi-implicit", pole=0.5),
    },
    "12": {
        "semi-implicit step": _stepped(lambda rest: 1.0, lambda rest: 0.0),
        "explicit step": _stepped(lambda rest: 0.0, lambda rest: 1.0),
        "Tustin": _stepped(lambda rest: 0.25, lambda rest: 0.5),
        "torque after the cycle": _stepped(lambda rest: rest**2 / 2, lambda rest: 0.5 + rest - rest**2),
        "Ts = 0.4 s": _stepped(lambda rest: 0.5, lambda rest: 0.5, 0.4),
    },
    "13": {
        "one wheel's principal inertias": _carried(1.47e-5 * _SPEED, Iw_y=1.47e-5, Iw_z=1.47e-5),
        "1e-3 for 1e-5": _carried(1.26e-3 * _SPEED, Iw_x=1.47e-3, Iw_y=1.26e-3, Iw_z=1.26e-3),
        "reference of 150 s": _carried(1.26e-5 * _SPEED, tau_m=150.0, half_period=1000.0, t_end=4000.0),
        "slow reference": _carried(1.26e-5 * _SPEED, tau_m=300.0, half_period=2000.0, t_end=8000.0),
    },
    "14": {
        "another F(0)": _survives(delay=1),
        "designed for d = 1": _survives(delay=1, design_delay=0.0, applied_regressor=0.0),
        "coarse simulator": _survives("semi-implicit", delay=1),
        "coarse simulator, explicit": _survives("explicit", delay=1),
        "pole 0.5": _survives(pole=0.5, delay=1),
        "coarse simulator, pole 0.5": _survives("semi-implicit", pole=0.5, delay=1),
    },
    "15": {
        "nominal first guess": _helps("mrac", "paper", "estimate_d", delay=1),
        "estimated and not used": _helps("mrac", "printed", "compensate_d", delay=1),
        "law (32), pole 0.5": _helps("mrac-literal", "printed", "estimate_d", delay=1, C2_pole=0.5),
    },
}
"""Functions by number of the claim and name of the reading in claims.toml."""
