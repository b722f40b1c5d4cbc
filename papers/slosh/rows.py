# SPDX-License-Identifier: Apache-2.0
"""The metric table of the slosh paper: reduced and full model and 3-2-1 angles, each under both laws.

Expected numbers are in expected.toml.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mehvar.reproduction import TIMES, Check, Claim, ClaimKind, Runs, not_essential, read_data

if TYPE_CHECKING:
    from mehvar.runtime import Run

LAWS = ("lyapunov-v1", "lyapunov-v2")
REDUCED: Mapping[str, Any] = {"plant": "reduced"}
FULL: Mapping[str, Any] = {}


@dataclass(frozen=True)
class TableColumn:
    """A run of the table: its description, law and settings."""

    title: str
    law: str
    settings: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class TableGroup:
    """Numbers that are shown in one line: one value for each column, by the name of a metric or an input."""

    what: str
    unit: str
    digits: int
    numbers: Mapping[str, tuple[float, ...]]


@dataclass(frozen=True)
class LoopTable:
    """The contents of expected.toml; `explanation` is about inputs that are larger between whole seconds."""

    explanation: str
    run: tuple[TableColumn, ...]
    group: tuple[TableGroup, ...]


TABLE = read_data(Path(__file__).with_name("expected.toml"), LoopTable)
_INPUTS = ("Mx", "My", "Mz", "delta1", "delta2")
_SECOND = 10
"""Samples: the table was made with the largest inputs at whole seconds, and a run has a sample each 0.1 s."""


def axial(run: Run) -> float:
    """Return the a_x of (19), F over the whole mass, m/s^2."""
    values = run.parameters.values
    return values["F"] / (values["m"] + values["m0"] + values["m1"] + values["m2"])


def measure(runs: Runs, column: TableColumn) -> dict[str, float]:
    """Return the numbers of the table: the model's metrics, in degrees where angles, and inputs at whole seconds."""
    run = runs(column.law, "paper", **column.settings)
    values = runs.metrics(column.law, "paper", **column.settings) | largest_inputs(run, _SECOND)
    return {name: _shown(values[name], group.unit) for group in TABLE.group for name in group.numbers}


def largest_inputs(run: Run, every: int) -> dict[str, float]:
    """Return the largest size of each input over samples at this spacing."""
    series = run.variables()
    return {name: float(np.nanmax(np.abs(series[f"u_{name}"][::every]))) for name in _INPUTS}


def _shown(value: float, unit: str) -> float:
    return float(np.degrees(value)) if unit == "deg" else value


def row_claims(runs: Runs) -> list[Claim]:
    """Return one claim for each column of the table: its numbers are reproduced."""
    return [
        Claim(
            f"R{k}",
            f"Metric table, {column.title}.",
            _checks(runs, column, k - 1),
            TABLE.explanation,
            kind=ClaimKind.ROW,
        )
        for k, column in enumerate(TABLE.run, 1)
    ]


def _checks(runs: Runs, column: TableColumn, place: int) -> tuple[Check, ...]:
    values = measure(runs, column)
    checks = []
    for group in TABLE.group:
        expected = [numbers[place] for numbers in group.numbers.values()]
        measured = [values[name] for name in group.numbers]
        checks.append(Check(group.what, _line(expected, group), _line(measured, group), near(measured, expected)))
    return (*checks, not_essential(_between(runs(column.law, "paper", **column.settings))))


def _between(run: Run) -> Check:
    """Return the check that no input is larger between whole seconds than at them, but for 1 %."""
    at_seconds = largest_inputs(run, _SECOND)
    excess = {name: value / at_seconds[name] - 1 for name, value in largest_inputs(run, 1).items()}
    worst = max(excess, key=lambda name: excess[name])
    text = f"{100 * excess[worst]:.2g} % ({worst})"
    return Check(
        "largest inputs every 0.1 s: excess over whole seconds", f"< {100 * TIMES:g} %", text, excess[worst] < TIMES
    )


def near(measured: list[float], expected: list[float]) -> bool:
    """Return True if numbers match the expected ones within 1 %, times and amplitudes alike, as in `captions.toml`."""
    return bool(np.all(np.abs(np.subtract(measured, expected)) <= TIMES * np.abs(expected)))


def _line(values: list[float], group: TableGroup) -> str:
    return f"{' / '.join(f'{v:.{group.digits}f}' for v in values)} {group.unit}"
