# SPDX-License-Identifier: Apache-2.0
"""The metric table of the slosh paper: reduced and full model and 3-2-1 angles, each under both laws."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from mehvar.papers.study import TIMES, Check, Claim, Runs, beside

if TYPE_CHECKING:
    from mehvar.runtime.run.simulate import Run

LAWS = ("lyapunov-v1", "lyapunov-v2")
REDUCED: Mapping[str, Any] = {"plant": "reduced"}
FULL: Mapping[str, Any] = {}


@dataclass(frozen=True)
class Row:
    """A run of the table: what distinguishes it in words, law and settings."""

    title: str
    law: str
    settings: Mapping[str, Any]


ROWS = tuple(
    Row(f"{title}, V{law[-1]}", law, settings)
    for title, settings in (
        ("reduced model", REDUCED),
        ("full model", FULL),
        ("full model with 3-2-1 angles", {"attitude": "euler"}),
    )
    for law in LAWS
)
_GROUPS = (
    ("settling of v_y, v_z and attitude", ("t_vy", "t_vz", "t_att"), "s", ".1f"),
    ("settling of phi_1, phi_2", ("t_phi1", "t_phi2"), "s", ".1f"),
    ("settling of theta_1, theta_2", ("t_theta1", "t_theta2"), "s", ".1f"),
    ("lowest v_y, v_z", ("min_vy", "min_vz"), "m/s", ".1f"),
    ("v_x at the end", ("vx_end",), "m/s", ".0f"),
    ("path of phi_1, phi_2 in 20 s", ("travel_phi1", "travel_phi2"), "deg", ".1f"),
    ("theta_1 at the end", ("theta1_end",), "deg", ".1f"),
    ("largest lateral part of the thrust", ("max_lateral",), "F", ".3f"),
    ("largest |delta_1|, |delta_2| at whole seconds", ("delta1", "delta2"), "deg", ".1f"),
    ("largest |Mx|, |My|, |Mz| at whole seconds", ("Mx", "My", "Mz"), "N m", ".0f"),
)
_INPUTS = ("Mx", "My", "Mz", "delta1", "delta2")
# One column for each of ROWS.
_TABLE = """
t_vy         552.3   559.5   551.3   558.9   554.6   562.3
t_vz         589.3   595.5   588.4   595.0   568.9   574.8
t_att        162.2   162.1   162.1   162.0   163.5   163.5
t_phi1       660.1   666.6   659.1   666.0   659.1   666.0
t_phi2       660.0   666.5   659.0   665.9   659.1   666.0
t_theta1      19.3    33.4    31.2    33.4    47.2    35.0
t_theta2      54.0    52.2    53.4    51.5    54.4    52.2
min_vy      -114.1  -112.3  -114.3  -112.2  -117.0  -114.9
min_vz       -52.1   -50.2   -52.2   -50.1   -45.9   -43.9
travel_phi1   36.7    84.0    36.7    77.6    36.7    77.7
travel_phi2   86.2   175.9    80.7   166.3    80.8   166.4
theta1_end    65.8    66.1    65.8    66.1    69.5    69.8
vx_end      4618    4618    4571    4573    4571    4573
max_lateral    0.618   0.607   0.618   0.606   0.618   0.606
delta1        24.4    17.3    21.9    17.3    21.9    15.2
delta2        34.2    33.6    34.2    33.6    35.2    34.5
Mx            81      81      81      81      81      81
My           964     603     876     602     876     527
Mz          1369    1350    1370    1348    1403    1380
"""
EXPECTED: Mapping[str, tuple[float, ...]] = {
    name: tuple(map(float, numbers)) for name, *numbers in (line.split() for line in _TABLE.strip().splitlines())
}


def axial(run: Run) -> float:
    """Return the a_x of (19), F over the whole mass, m/s^2."""
    values = run.parameters.values
    return values["F"] / (values["m"] + values["m0"] + values["m1"] + values["m2"])


def measure(runs: Runs, row: Row) -> dict[str, float]:
    """Return the numbers of the table: the model's metrics, in degrees where angles, and inputs at whole seconds."""
    found = runs.metrics(row.law, "paper", **row.settings)
    found |= _largest(runs(row.law, "paper", **row.settings), 10)
    return {name: _degrees(name, found[name]) for name in EXPECTED}


def _largest(run: Run, every: int) -> dict[str, float]:
    """Return the largest size of each input among every so many samples."""
    series = run.variables()
    return {name: float(np.nanmax(np.abs(series[f"u_{name}"][::every]))) for name in _INPUTS}


def _degrees(name: str, value: float) -> float:
    unit = next(unit for _, names, unit, _ in _GROUPS if name in names)
    return float(np.degrees(value)) if unit == "deg" else value


def row_claims(runs: Runs) -> list[Claim]:
    """Return one claim for each column of the table: its numbers are reproduced."""
    return [
        Claim(f"R{k}", f"Metric table, {row.title}.", _checks(runs, row, k - 1), _PEAKS)
        for k, row in enumerate(ROWS, 1)
    ]


_PEAKS = (
    "The largest inputs of the table are those at whole seconds. Under V1 delta_1 and My peak in the first second: "
    "with samples each 0.1 s their largest values are up to 1.7 % larger."
)


def _checks(runs: Runs, row: Row, column: int) -> tuple[Check, ...]:
    found = measure(runs, row)
    checks = []
    for what, names, unit, form in _GROUPS:
        wanted = [EXPECTED[name][column] for name in names]
        measured = [found[name] for name in names]
        checks.append(Check(what, _line(wanted, form, unit), _line(measured, form, unit), _near(measured, wanted)))
    return (*checks, beside(_between(runs(row.law, "paper", **row.settings))))


def _between(run: Run) -> Check:
    """Return the check that no input is larger between whole seconds than at them, but for 1 %."""
    at_seconds = _largest(run, 10)
    excess = {name: value / at_seconds[name] - 1 for name, value in _largest(run, 1).items()}
    worst = max(excess, key=lambda name: excess[name])
    text = f"{100 * excess[worst]:.2g} % ({worst})"
    return Check("the same every 0.1 s: largest excess", "< 1 %", text, excess[worst] < TIMES)


def _near(measured: list[float], wanted: list[float]) -> bool:
    return bool(np.all(np.abs(np.subtract(measured, wanted)) <= TIMES * np.abs(wanted)))


def _line(values: list[float], form: str, unit: str) -> str:
    return f"{' / '.join(f'{v:{form}}' for v in values)} {unit}"
