# SPDX-License-Identifier: Apache-2.0
"""Deviations of metrics from the values that scenarios expect."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from mehvar.runtime.run.metrics import AMPLITUDES, COUNTS, TIMES, Deviation, deviations_of

from .claims import Check, Claim, ClaimKind

if TYPE_CHECKING:
    from mehvar.base.manifest import Manifest, Scenario

    from .runs import Runs


def deviations(runs: Runs) -> list[Deviation]:
    """Run all scenarios and laws with expected numbers, and compare."""
    manifest = runs.model.manifest
    return [
        number
        for scenario in manifest.scenarios.values()
        for law in scenario.expect
        for number in deviations_of(manifest, scenario, law, runs.metrics(law, scenario.name))
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
