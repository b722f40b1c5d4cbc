# SPDX-License-Identifier: Apache-2.0
"""Other readings of the slosh paper, and the checks of its claims under each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, TypeAlias

import numpy as np

from mehvar.reproduction import Check, Checks, Expected, Readings, Runs

from .claims import (
    LENGTHS,
    attitude_settles,
    better_law,
    gained_speed,
    lengths,
    little_more_swing,
    order_of_azimuths,
    signs_restored,
    values_fall,
)
from .positivity import positive

Settings: TypeAlias = Mapping[str, Any]

STROKES: Settings = {"eps1": 3.7, "eps2": 0.5}
"""The dampings, printed 3/7 and 0.15, read by the rule of the lengths."""
MASSES = (50.0, 5.0)
"""m_1 and m_2 of Table 1."""
DAMPING_PER_MASS: Settings = {
    f"eps{k}": eps * m for k, (eps, m) in enumerate(zip((3.57, 0.15), MASSES, strict=True), 1)
}
INERTIA_PER_MASS: Settings = {f"I{k}": i * m for k, (i, m) in enumerate(zip((10.0, 1.0), MASSES, strict=True), 1)}
LIKELY: Settings = {**INERTIA_PER_MASS, **STROKES}
"""Very likely the settings of the paper's run."""


def _attitude(weight: float, gain: float) -> dict[str, float]:
    return dict.fromkeys(("r3", "r5", "r7"), weight) | dict.fromkeys(("w3", "w4", "w5"), gain)


def _under(checks: Checks, settings: Settings) -> Checks:
    return lambda runs, expected: checks(runs.under(**settings), expected)


def _all_of(checks: Checks) -> Checks:
    """Return the checks as essential, because a reading must not need the note."""
    return lambda runs, expected: [replace(check, essential=True) for check in checks(runs, expected)]


def _settling(weight: float, gain: float) -> Checks:
    def checks(runs: Runs, expected: Expected) -> Sequence[Check]:
        return attitude_settles(runs, expected, **_attitude(weight, gain))

    return checks


def _weighted(weights: Settings) -> Checks:
    return lambda runs, expected: positive(runs, **weights)


_SLIP = "I_i per unit mass, strokes of the dampings"

READINGS: Readings = {
    "6": {_SLIP: _under(little_more_swing, LIKELY)},
    "7": {"reduced model": gained_speed},
    "8": {
        name: _under(order_of_azimuths, settings)
        for name, settings in {
            "lengths as printed": LENGTHS,
            "strokes of the dampings": STROKES,
            "dampings per unit mass": DAMPING_PER_MASS,
            "Euler angles": {"attitude": "euler"},
            "weights 10^5": _attitude(1e5, 4e5),
            "I_i per unit mass": INERTIA_PER_MASS,
            "I_i and eps_i per unit mass": {**INERTIA_PER_MASS, **DAMPING_PER_MASS},
            _SLIP: LIKELY,
            "the same, lengths as printed": {**LIKELY, **LENGTHS},
        }.items()
    },
    "9": {_SLIP: _under(_all_of(better_law), LIKELY)},
    "10": {_SLIP: _under(_all_of(values_fall), LIKELY)},
    "11": {"minus signs lost": signs_restored},
    "12": {_SLIP: _under(_all_of(lengths), LIKELY)},
    "13": {
        "w_3 of critical damping": _settling(1e-5, 2 * float(np.sqrt(1e-5 * 500.0))),
        "w_3 as printed": _settling(1e-5, 40.0),
        "w_3 ten times larger": _settling(1e-5, 4e5),
        "10^5": _settling(1e5, 4e5),
        "10^3": _settling(1e3, 4e4),
    },
    "14": {
        "the two groups swapped": _weighted({}),
        "Table 2 as printed": _weighted(dict.fromkeys(("r3", "r5", "r7"), 1e-5)),
    },
}
"""Functions by number of the claim and name of the reading in claims.toml."""
