# SPDX-License-Identifier: Apache-2.0
"""The metric table of the satellite: runs with their expected numbers, and the measurement of a run.

From 200 s to the end: error against the reference model, torque, ring; and the settling time after the last switch.
Expected numbers are in expected.toml.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from mehvar.reproduction import AMPLITUDES, TIMES, Check, Claim, ClaimKind, Runs, not_essential, read_data
from mehvar.runtime import Status

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from mehvar.runtime import Run

    FloatArray = NDArray[np.float64]

AXES = ("roll", "pitch", "yaw")
LATE = 200.0
"""Start of the window, s: after the first half period of the reference, during which the estimator learns."""
SEEDS = 16
"""Seeds of the runs with noise; their mean has a quarter of a single run's error."""

_LAST_SWITCH = 600.0
_SETTLED_DEG = (1.0, 1.2, 0.5)
"""Bands of the settling time: 2 % of the steps of roll and pitch, 50 and 60 deg; for yaw, which has no step, a tenth
of its start.
"""
_SAMPLE = 0.5
"""Allowed deviation of a settling time, beside the relative one: the sampling period, s."""

Three: TypeAlias = tuple[float, float, float]
"""Roll, pitch, yaw."""


@dataclass(frozen=True)
class TableRow:
    """A run of the table: its name, what distinguishes it in words, law, scenario and settings; and its numbers."""

    name: str
    title: str
    law: str
    scenario: str
    rms: Three
    largest: Three
    torque: Three
    torque_ever: Three
    settling: Three
    ring: Three
    settings: Mapping[str, Any] = field(default_factory=dict)

    @property
    def expected(self) -> AxisMetrics:
        """The numbers."""
        return AxisMetrics(**{name: np.array(getattr(self, name)) for name, *_ in _WHAT})


@dataclass(frozen=True)
class AxisTable:
    """The contents of expected.toml; `explanation` is about the rows that may not be run."""

    explanation: str
    printed_b: Mapping[str, tuple[float, float]]
    row: tuple[TableRow, ...]


@dataclass(frozen=True)
class AxisMetrics:
    """Numbers of a run, one per axis: errors in deg, torques in N m, settling in s."""

    rms: FloatArray
    largest: FloatArray
    torque: FloatArray
    torque_ever: FloatArray
    settling: FloatArray
    ring: FloatArray


_WHAT = (
    ("rms", "RMS error", "deg", 4),
    ("largest", "largest error", "deg", 3),
    ("torque", "largest torque", "N m", 5),
    ("torque_ever", "largest torque of the whole run", "N m", 5),
    ("settling", "settling after the last switch", "s", 1),
    ("ring", "ring", "", 3),
)
"""Numbers of a row: description, unit, and digits after the decimal point."""

TABLE = read_data(Path(__file__).with_name("expected.toml"), AxisTable)
PRINTED_B = tuple(TABLE.printed_b[axis] for axis in AXES)
"""b0 and b1 of roll, pitch and yaw as (43)-(45) print them, rad/(N m)."""


def measure(run: Run) -> AxisMetrics:
    """Measure a run, NaN if it did not reach its end; the last sample, where the reference switches, does not count."""
    if run.status is not Status.DONE:
        return AxisMetrics(*np.full((6, 3), math.nan))
    series = {name: column[:-1] for name, column in run.variables().items()}
    t, torque = run.t[:-1], np.abs(run.u[:-1])
    late = t >= LATE
    error = np.degrees([series[a] - series[f"ym_{a}"] for a in AXES])[:, late]
    return AxisMetrics(
        rms=np.sqrt(np.square(error).mean(axis=1)),
        largest=np.abs(error).max(axis=1),
        torque=torque[late].max(axis=0),
        torque_ever=torque.max(axis=0),
        settling=np.array([_settling(t, np.degrees(series[f"{a}_error"]), band)
                           for a, band in zip(AXES, _SETTLED_DEG, strict=True)]),
        ring=ring(run.u[:-1][late]),
    )  # fmt: skip


def ring(torque: FloatArray) -> FloatArray:
    """Return the mean change of a torque, (..., samples, 3), from sample to sample over twice its mean size.

    1 is pure alternation; a torque that changes little is near 0; one that is always zero has NaN.
    """
    with np.errstate(invalid="ignore"):
        ratio: FloatArray = np.abs(np.diff(torque, axis=-2)).mean(axis=-2) / (2 * np.abs(torque).mean(axis=-2))
    return ratio


def _settling(t: FloatArray, error: FloatArray, band: float) -> float:
    """Return the time after the last step until the error stays in its band, s; infinite if it never does."""
    after = t >= _LAST_SWITCH
    outside = np.flatnonzero(np.abs(error[after]) > band)
    if not outside.size:
        return 0.0
    following = outside[-1] + 1
    return float(t[after][following] - _LAST_SWITCH) if following < after.sum() else math.inf


def row_claims(runs: Runs) -> list[Claim]:
    """Return one claim for each row: its numbers are reproduced."""
    return [
        Claim(
            f"R{k}",
            f"Row {r.name}: {r.title} (scenario {r.scenario}).",
            _checks(runs, r),
            TABLE.explanation,
            kind=ClaimKind.ROW,
        )
        for k, r in enumerate(TABLE.row, 1)
    ]


def _checks(runs: Runs, row: TableRow) -> tuple[Check, ...]:
    if row.settings.get("real") == "float" and runs.model.backend != "c":
        return (not_essential(Check("all numbers", f"within {100 * AMPLITUDES:g} %", "not run", False)),)
    seeds = range(SEEDS if "noise" in row.settings else 1)
    repeats = [runs(row.law, row.scenario, seed=seed, **row.settings) for seed in seeds]
    lost = [run for run in repeats if run.status is not Status.DONE]
    if lost:
        return (Check("run", "reaches its end", lost[0].reason, False),)
    return compare(row.expected, [measure(run) for run in repeats])


def compare(expected: AxisMetrics, repeats: list[AxisMetrics]) -> tuple[Check, ...]:
    """Compare each number with the mean over the repeats; only runs with noise are repeated.

    Besides the relative deviation, half of the last digit given and half of the range over the repeats are allowed.
    """
    checks = []
    for name, what, unit, digits in _WHAT:
        numbers = getattr(expected, name)
        each = np.array([getattr(metrics, name) for metrics in repeats])
        mean, spread = each.mean(axis=0), np.ptp(each, axis=0) / 2 if len(repeats) > 1 else 0.0
        slack = (_SAMPLE if name == "settling" else 0.5 * 10.0**-digits) + spread
        relative = TIMES if name == "settling" else AMPLITUDES
        with np.errstate(invalid="ignore"):
            near = (mean == numbers) | (np.abs(mean - numbers) <= relative * np.abs(numbers) + slack)
        title = what if len(repeats) == 1 else f"{what}, mean of {len(repeats)} seeds"
        checks.append(Check(title, _three(numbers, unit, digits), _three(mean, unit, digits), bool(near.all())))
    return tuple(checks)


def _three(values: FloatArray, unit: str, digits: int) -> str:
    text = " / ".join(f"{v:.{digits}f}" if math.isfinite(v) else "never" for v in values)
    return f"{text} {unit}".strip()
