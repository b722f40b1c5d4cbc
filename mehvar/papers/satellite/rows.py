# SPDX-License-Identifier: Apache-2.0
"""The metric table of the satellite: runs with their expected numbers, and what is measured of a run.

From 200 s to the end: error against the reference model, torque, ring; and the settling time after the last switch.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from mehvar.papers.study import AMPLITUDES, TIMES, Check, Claim, Runs, beside
from mehvar.runtime.run.problem import Status

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from mehvar.runtime.run.simulate import Run

    FloatArray = NDArray[np.float64]

AXES = ("roll", "pitch", "yaw")
LATE = 200.0
"""Start of the window, s."""
SEEDS = 16

_LAST_SWITCH, _SETTLED_DEG = 600.0, (1.0, 1.2, 0.5)
_SAMPLE = 0.5


@dataclass(frozen=True)
class Row:
    """A run of the table: its name, what distinguishes it in words, law, scenario and settings."""

    name: str
    title: str
    law: str
    scenario: str
    settings: Mapping[str, Any]


@dataclass(frozen=True)
class Measured:
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

_KNOWN = "no adaptation, "
_LIMITS = {"umax": 0.1, "hmax": 0.5}
ROWS = (
    Row("pd", "PD", "pd", "paper", {}),
    Row("pd_delay", "PD, delay", "pd", "paper", {"delay": 1}),
    Row("pd_ym", "PD that follows the reference model", "pd", "paper", {"follow_model": 1}),
    Row("pd_nowheel", "PD, external torque", "pd", "paper", {"wheels": 0}),
    Row("mrac", "adaptive", "mrac", "paper", {}),
    Row("mrac_delay", "adaptive, delay", "mrac", "paper", {"delay": 1}),
    Row("mrac_fixed", _KNOWN + "nominal plant", "mrac", "paper", {"adapt": 0}),
    Row("mrac_fixed_delay", _KNOWN + "nominal plant, delay", "mrac", "paper", {"adapt": 0, "delay": 1}),
    Row("mrac_printedB", "first guess: the printed B", "mrac", "printed", {}),
    Row("mrac_printedB_delay", "first guess: the printed B, delay", "mrac", "printed", {"delay": 1}),
    Row("mrac_60pct_delay", "first guess 0.6 b, delay", "mrac", "paper", {"guess": 0.6, "F0": 100, "delay": 1}),
    Row("mrac_nowheel", "adaptive, external torque", "mrac", "paper", {"wheels": 0}),
    Row("mrac_step0_sat", "reference model from zero, limited wheels", "mrac", "paper", {"matched": 0, **_LIMITS}),
    Row("mrac_step0_sat_delay", "the same, delay", "mrac", "paper", {"matched": 0, **_LIMITS, "delay": 1}),
    Row("mrac_f32_delay", "law in single precision, delay", "mrac", "paper", {"real": "float", "delay": 1}),
    Row(
        "mrac_noise_delay",
        "noise of 5e-5 rad, limited torque, delay",
        "mrac",
        "paper",
        {"noise": 5e-5, "umax": 0.1, "delay": 1},
    ),
    Row("literal", "law (32), first guess: the printed B", "mrac-literal", "printed", {}),
    Row("deadbeat_retain", _KNOWN + "pole 0.001", "mrac", "paper", {"rho": 0.001, "adapt": 0}),
)
# In the order of _WHAT, roll, pitch, yaw each.
_TABLE = """
pd                   16.6601 14.0237 12.9851 30.466 28.253 22.217 .00206 .00275 .00120 .00206 .00275 .00120 inf inf inf .013 .012 .009
pd_delay             17.0453 14.1634 13.2477 31.030 28.847 22.791 .00208 .00273 .00126 .00208 .00273 .00126 inf inf inf .014 .013 .009
pd_ym                20.0042 16.9025 12.0957 39.402 35.671 20.123 .00125 .00138 .00108 .00125 .00138 .00108 inf inf inf .011 .010 .009
pd_nowheel           14.8462 14.4331 11.1444 28.303 27.500 20.831 .00200 .00277 .00111 .00200 .00277 .00111 194.5 inf inf .013 .012 .010
mrac                 .0103 .0140 .0539 .085 .119 .350 .01769 .03029 .01694 .01769 .03029 .01694 58.5 58.5 0 .076 .068 .108
mrac_delay           .0368 .0382 .1165 .288 .297 .743 .01769 .03029 .01823 .01769 .03029 .01823 59 59 6 .099 .089 .114
mrac_fixed           .0103 .0140 .0545 .083 .120 .353 .01769 .03029 .01674 .01769 .03029 .01674 58.5 58.5 0 .075 .068 .107
mrac_fixed_delay     .0364 .0375 .1180 .282 .294 .750 .01769 .03029 .01789 .01769 .03029 .01789 59 59 6 .098 .089 .112
mrac_printedB        .0218 .0284 .0480 .094 .156 .385 .01778 .03223 .01606 .02119 .03309 .02754 58.5 58.5 0 .077 .069 .123
mrac_printedB_delay  .1016 .1091 .1306 1.105 .721 .748 .01623 .03471 .01772 .02339 .08507 .08801 59 59 6 .080 .097 .106
mrac_60pct_delay     .0379 .0574 .0878 .417 .533 .667 .02205 .03849 .02424 .02205 .03849 .02424 59 59 4.5 .138 .113 .160
mrac_nowheel         .0102 .0133 .0495 .083 .121 .352 .01769 .03029 .01696 .01769 .03029 .01696 58.5 58.5 0 .076 .069 .121
mrac_step0_sat       .0106 .0142 .0543 .088 .121 .353 .01762 .03038 .01690 .1 .1 .1 58.5 58.5 0 .075 .069 .108
mrac_step0_sat_delay .0373 .0385 .1175 .294 .301 .750 .01762 .03041 .01818 .08496 .1 .06741 59 59 6 .098 .090 .114
mrac_f32_delay       .0370 .0381 .1165 .287 .294 .743 .01768 .03029 .01823 .01768 .03029 .01823 59 59 6 .099 .090 .114
mrac_noise_delay     .0370 .0384 .1165 .290 .300 .748 .01760 .03050 .01838 .01760 .03050 .01838 59 59 6 .266 .242 .361
literal              .0601 .0272 .0147 .512 .267 .110 .13479 1.24229 .28425 7.20852 15.42450 6.94691 58.5 58.5 0 .988 .997 .994
deadbeat_retain      .0035 .0037 .0119 .042 .048 .103 .02479 .03087 .02516 .02479 .03087 .02516 58.5 58.5 0 .194 .138 .281
"""  # noqa: E501
EXPECTED = {
    name: Measured(*np.array(numbers, dtype=float).reshape(6, 3))
    for name, *numbers in (line.split() for line in _TABLE.strip().splitlines())
}


def measure(run: Run) -> Measured:
    """Measure a run, NaN if it did not reach its end; the last sample, where the reference switches, does not count."""
    if run.status is not Status.DONE:
        return Measured(*np.full((6, 3), math.nan))
    series = {name: column[:-1] for name, column in run.variables().items()}
    t, torque = run.t[:-1], np.abs(run.u[:-1])
    late = t >= LATE
    error = np.degrees([series[a] - series[f"ym_{a}"] for a in AXES])[:, late]
    change = np.abs(np.diff(run.u[:-1][late], axis=0))
    return Measured(
        rms=np.sqrt(np.square(error).mean(axis=1)),
        largest=np.abs(error).max(axis=1),
        torque=torque[late].max(axis=0),
        torque_ever=torque.max(axis=0),
        settling=np.array([_settling(t, np.degrees(series[f"{a}_error"]), band)
                           for a, band in zip(AXES, _SETTLED_DEG, strict=True)]),
        ring=change.mean(axis=0) / (2 * torque[late].mean(axis=0)),
    )  # fmt: skip


def _settling(t: FloatArray, error: FloatArray, band: float) -> float:
    """Return how long after the last switch the error enters its band for good, s; infinite for never."""
    after = t >= _LAST_SWITCH
    outside = np.flatnonzero(np.abs(error[after]) > band)
    if not outside.size:
        return 0.0
    following = outside[-1] + 1
    return float(t[after][following] - _LAST_SWITCH) if following < after.sum() else math.inf


def row_claims(runs: Runs) -> list[Claim]:
    """Return one claim for each row: its numbers are reproduced."""
    return [
        Claim(f"R{k}", f"Row {row.name}: {row.title} (scenario {row.scenario}).", _checks(runs, row), _WHY_NOT_RUN)
        for k, row in enumerate(ROWS, 1)
    ]


_WHY_NOT_RUN = "A law computes in single precision in generated C only, and no C compiler was found."


def _checks(runs: Runs, row: Row) -> tuple[Check, ...]:
    if row.settings.get("real") == "float" and runs.model.backend != "c":
        return (beside(Check("all numbers", "within 2 %", "not run", False)),)
    seeds = range(SEEDS if "noise" in row.settings else 1)
    found = [runs(row.law, row.scenario, seed=seed, **row.settings) for seed in seeds]
    lost = [run for run in found if run.status is not Status.DONE]
    if lost:
        return (Check("run", "reaches its end", lost[0].reason, False),)
    return _compared(EXPECTED[row.name], [measure(run) for run in found])


def _compared(expected: Measured, found: list[Measured]) -> tuple[Check, ...]:
    """Compare each number with the mean over the runs, of which there are several only where there is noise."""
    checks = []
    for field, what, unit, digits in _WHAT:
        wanted = getattr(expected, field)
        each = np.array([getattr(one, field) for one in found])
        mean, spread = each.mean(axis=0), np.ptp(each, axis=0) / 2 if len(found) > 1 else 0.0
        slack = (_SAMPLE if field == "settling" else 0.5 * 10.0**-digits) + spread
        relative = TIMES if field == "settling" else AMPLITUDES
        with np.errstate(invalid="ignore"):
            near = (mean == wanted) | (np.abs(mean - wanted) <= relative * np.abs(wanted) + slack)
        name = what if len(found) == 1 else f"{what}, mean of {len(found)} seeds"
        checks.append(Check(name, _three(wanted, unit, digits), _three(mean, unit, digits), bool(near.all())))
    return tuple(checks)


def _three(values: FloatArray, unit: str, digits: int) -> str:
    text = " / ".join(f"{v:.{digits}f}" if math.isfinite(v) else "never" for v in values)
    return f"{text} {unit}".strip()
