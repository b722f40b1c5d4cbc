# SPDX-License-Identifier: Apache-2.0
"""Deviations of metrics from the values that scenarios expect."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from .claims import AMPLITUDES, COUNTS, TIMES, Check, Claim, ClaimKind

if TYPE_CHECKING:
    from mehvar.base.manifest import Manifest, Metric, Scenario

    from .runs import Runs


@dataclass(frozen=True)
class Deviation:
    """A metric of a run and its expected value; infinity means that the run does not settle."""

    scenario: str
    law: str
    metric: Metric
    expected: float
    measured: float

    @property
    def size(self) -> float:
        """Relative deviation, or absolute for a count; zero if both values are infinite."""
        if self.measured == self.expected:
            return 0.0
        difference = self.measured - self.expected
        return difference if self.metric.kind == "sign_changes" else difference / abs(self.expected)

    @property
    def allowed(self) -> float:
        """Largest deviation that counts as reproduced."""
        return {"settling": TIMES, "sign_changes": COUNTS}.get(self.metric.kind, AMPLITUDES)

    @property
    def holds(self) -> bool:
        """True if the deviation is allowed."""
        return abs(self.size) <= self.allowed


def deviations(runs: Runs) -> list[Deviation]:
    """Run all scenarios and laws with expected numbers, and compare."""
    manifest = runs.model.manifest
    return [
        number
        for scenario in manifest.scenarios.values()
        for law in scenario.expect
        for number in of_run(manifest, scenario, law, runs.metrics(law, scenario.name))
    ]


def of_run(manifest: Manifest, scenario: Scenario, law: str, measured: Mapping[str, float]) -> list[Deviation]:
    """Compare the metrics of a run with the numbers that its scenario expects for its law."""
    return [
        Deviation(scenario.name, law, manifest.metrics[name], math.inf if value is None else value, measured[name])
        for name, value in scenario.expect.get(law, {}).items()
    ]


def by_run(numbers: Sequence[Deviation]) -> list[tuple[tuple[str, str], list[Deviation]]]:
    """Return the deviations by scenario and law, in order."""
    rows: dict[tuple[str, str], list[Deviation]] = {}
    for number in numbers:
        rows.setdefault((number.scenario, number.law), []).append(number)
    return list(rows.items())


def table_claims(manifest: Manifest, numbers: Sequence[Deviation]) -> list[Claim]:
    """Return one claim per run, which states that its numbers are reproduced."""
    return [
        _run_claim(f"T{k}", manifest.scenarios[scenario], law, row)
        for k, ((scenario, law), row) in enumerate(by_run(numbers), 1)
    ]


def _run_claim(number: str, scenario: Scenario, law: str, row: Sequence[Deviation]) -> Claim:
    """Return the claim that a run has all expected numbers; its text names the largest deviation."""
    wrong = [d for d in row if not d.holds]
    worst = max(row, key=lambda d: abs(d.size) / d.allowed)
    size = f"{worst.size:+g}" if worst.metric.kind == "sign_changes" else f"{100 * worst.size:+.2g} %"
    check = Check(
        f"{len(row)} numbers",
        f"times within {100 * TIMES:g} %, amplitudes within {100 * AMPLITUDES:g} %, counts within {COUNTS:g}",
        f"{len(row) - len(wrong)} within; largest deviation {size} ({worst.metric.name})",
        not wrong,
    )
    return Claim(
        number,
        f"The numbers of scenario {scenario.name} with {law} are reproduced (table below).",
        (check,),
        "; ".join(f"{d.metric.name}: {d.measured:.4g} instead of {d.expected:.4g}" for d in wrong),
        kind=ClaimKind.ROW,
    )
