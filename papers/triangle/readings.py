# SPDX-License-Identifier: Apache-2.0
"""Claims of the triangle's paper under other readings of its damaged numbers; claims.toml describes each reading."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from mehvar.reproduction import Check, Checks, Expected, below

from .claims import ALIKE, errors_at, random_runs

if TYPE_CHECKING:
    from mehvar.reproduction import Runs

Changes = Mapping[str, Mapping[str, float]]
"""Parameters that a reading changes, by law."""


def _rods(start: Sequence[float], end: Sequence[float]) -> Changes:
    values = {f"l{k}_0": length for k, length in enumerate(start, 1)}
    values |= {f"l{k}_f": length for k, length in enumerate(end, 1)}
    return {"sliding": values, "path": values}


_CASE_A = (0.2, 0.2, 0.3)
_COMPARED: Mapping[str, Changes] = {
    "gain as printed": {"path": {"k_phi": 5.0}},
    "theta* as printed": {"sliding": {"theta_star": math.radians(4.0)}},
    "rods to 0.3, 0.4, 0.5": _rods(_CASE_A, (0.3, 0.4, 0.5)),
    "rods to 0.3, 0.5, 0.3": _rods(_CASE_A, (0.3, 0.5, 0.3)),
    "rods to 0.5, 0.3, 0.3": _rods(_CASE_A, (0.5, 0.3, 0.3)),
    "rods from 0.21, 0.21, 0.23": _rods((0.21, 0.21, 0.23), (0.23, 0.23, 0.25)),
}


def _metrics(runs: Runs, law: str, changes: Changes) -> dict[str, float]:
    return runs.metrics(law, "paper", **_longer(changes.get(law, {})))


def _longer(changes: Mapping[str, float]) -> dict[str, Any]:
    return {**changes, "t_end": 60.0}


def _times(changes: Changes) -> Checks:
    def checks(runs: Runs, expected: Expected) -> Sequence[Check]:
        sliding, path = (_metrics(runs, law, changes)["T_rho"] for law in ("sliding", "path"))
        holds = abs(path / sliding - 1) < ALIKE if math.isfinite(path) and math.isfinite(sliding) else False
        return (
            Check(
                "time after which ρ̃ < 0.02: sliding, path",
                f"within {100 * ALIKE:g} %",
                f"{sliding:.4g}, {path:.4g} s",
                holds,
            ),
        )

    return checks


def _calmer(changes: Changes) -> Checks:
    def checks(runs: Runs, expected: Expected) -> Sequence[Check]:
        sliding, path = (_metrics(runs, law, changes) for law in ("sliding", "path"))
        return [
            Check(
                f"{what}: sliding, path",
                "smaller for path",
                f"{sliding[name]:.4g}, {path[name]:.4g}",
                path[name] < sliding[name],
            )
            for what, name in (("largest rod rate, m/s", "max_rate"), ("sign changes of the rod rates", "flips"))
        ]

    return checks


def _one_smoothed(**sharp: float) -> Checks:
    def checks(runs: Runs, expected: Expected) -> Sequence[Check]:
        flips = runs.metrics("sliding", "paper", hold=0.01, t_end=30.0, **sharp)["flips"]
        most = 2 * expected("smooth")
        return (
            Check("sign changes in 30 s, held for 0.01 s", f"at most {most:g}: smooth", f"{flips:g}", flips <= most),
        )

    return checks


def _sharp_signs(runs: Runs, expected: Expected) -> Sequence[Check]:
    many = random_runs(runs, "sliding", s_min=1e-12, theta_min=1e-12, hold=0.01)
    angle, distance = np.max([errors_at(run, 35.0) for run in many], axis=0)
    return (
        below("sliding, worst of the random pairs, |θ| at 35 s", expected("sliding_angle"), angle, "rad"),
        below("sliding, worst of the random pairs, ρ̃ at 35 s", expected("sliding_distance"), distance),
    )


READINGS: Mapping[str, Mapping[str, Checks]] = {
    "1": {"signs not smoothed": _sharp_signs},
    "2": {name: _times(changes) for name, changes in _COMPARED.items()},
    "3": {name: _calmer(changes) for name, changes in _COMPARED.items()},
    "7": {
        "only sgn s is smoothed": _one_smoothed(theta_min=1e-12),
        "only sgn theta is smoothed": _one_smoothed(s_min=1e-12),
    },
}
"""Functions by number of the claim and name of the reading in claims.toml."""
