# SPDX-License-Identifier: Apache-2.0
"""What the papers show and say, checked against the models.

A module mehvar.papers.MODEL holds `CITATION` and `READINGS` (str, tuple of str), `figures()`, `claims(runs)` and
`picture(dataset, manifest)`. Nothing outside this package names a model.
"""

from __future__ import annotations

import importlib
import importlib.util
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, Any, Protocol, cast

from runtime.manifest import Manifest, Metric, Scenario, identifier, known_models
from runtime.metrics import metrics
from runtime.model import Model
from runtime.simulate import Run, simulate

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

TIMES, AMPLITUDES, COUNTS = 0.01, 0.02, 1.0
"""Allowed deviation: of times and of amplitudes, relative; of counts, absolute."""


class Verdict(StrEnum):
    """What became of a claim."""

    HOLDS = "holds"
    NOTE = "holds with a note"
    FAILS = "does not hold"


@dataclass(frozen=True)
class Claim:
    """Something a paper says, what was expected in numbers, and what running the model gave."""

    number: str
    text: str
    expected: str
    measured: str
    verdict: Verdict
    note: str = ""


@dataclass(frozen=True)
class Comparison:
    """One metric of one run against its expected value; infinite means: does not settle within the run."""

    scenario: str
    controller: str
    metric: Metric
    expected: float
    measured: float

    @property
    def deviation(self) -> float:
        """Relative, or absolute for a count; zero where both are infinite."""
        if self.measured == self.expected:
            return 0.0
        difference = self.measured - self.expected
        return difference if self.metric.kind == "sign_changes" else difference / abs(self.expected)

    @property
    def allowed(self) -> float:
        """The largest deviation that counts as reproduced."""
        return {"settling": TIMES, "sign_changes": COUNTS}.get(self.metric.kind, AMPLITUDES)

    @property
    def holds(self) -> bool:
        """Whether the number is reproduced."""
        return abs(self.deviation) <= self.allowed


@dataclass(frozen=True)
class PaperFigure:
    """A figure by its number in the paper; `draw` makes it."""

    number: int
    title: str
    caption: str
    draw: Callable[[Runs], Figure]


class Paper(Protocol):
    """What a module of this package offers."""

    CITATION: str
    READINGS: tuple[str, ...]

    def figures(self) -> Sequence[PaperFigure]:
        """Return the paper's figures."""

    def claims(self, runs: Runs) -> Sequence[Claim]:
        """Return what became of the paper's claims."""

    def picture(self, dataset: xr.Dataset, manifest: Manifest) -> Figure:
        """Draw one run."""


class Runs:
    """Closed loops of one model, each integrated once.

    Attributes
    ----------
    compile_seconds, run_seconds : float
        Time spent so far to compile or load the code, and to integrate.
    """

    def __init__(self, model: Model) -> None:
        self.model = model
        self.compile_seconds = 0.0
        self.run_seconds = 0.0
        self._runs: dict[tuple[object, ...], Run] = {}

    def __len__(self) -> int:
        return len(self._runs)

    def __call__(
        self, controller: str, scenario: str, initial: Mapping[str, float] | None = None, **settings: Any
    ) -> Run:
        """Return a run; `settings` are options and parameters of `runtime.simulate.simulate`."""
        key = (controller, scenario, *sorted((initial or {}).items()), *sorted(settings.items()))
        if key not in self._runs:
            run = simulate(self.model, controller, scenario, initial=initial, **settings)
            self.compile_seconds += run.compile_seconds
            self.run_seconds += run.run_seconds
            self._runs[key] = run
        return self._runs[key]

    def metrics(self, controller: str, scenario: str, **settings: Any) -> dict[str, float]:
        """Return the metrics of a run by name."""
        return metrics(self(controller, scenario, **settings), self.model.manifest)


def paper_models() -> list[str]:
    """Return the known models that a paper module belongs to."""
    return [name for name in known_models() if importlib.util.find_spec(f"{__name__}.{identifier(name)}")]


def load_paper(model: str) -> Paper:
    """Import the paper module of a model."""
    return cast(Paper, importlib.import_module(f"{__name__}.{identifier(model)}"))


def compare(runs: Runs) -> list[Comparison]:
    """Run every scenario and law that expects numbers, and compare."""
    manifest = runs.model.manifest
    return [
        Comparison(scenario.name, law, manifest.metrics[name], math.inf if value is None else value, found[name])
        for scenario in manifest.scenarios.values()
        for law, expected in scenario.expect.items()
        for found in [runs.metrics(law, scenario.name)]
        for name, value in expected.items()
    ]


def table_claims(manifest: Manifest, comparisons: Sequence[Comparison]) -> list[Claim]:
    """Return one claim for each run of the comparison: its numbers are reproduced."""
    rows: dict[tuple[str, str], list[Comparison]] = {}
    for comparison in comparisons:
        rows.setdefault((comparison.scenario, comparison.controller), []).append(comparison)
    return [
        _row_claim(f"T{number}", manifest.scenarios[scenario], law, row)
        for number, ((scenario, law), row) in enumerate(rows.items(), 1)
    ]


def _row_claim(number: str, scenario: Scenario, law: str, row: Sequence[Comparison]) -> Claim:
    wrong = [c for c in row if not c.holds]
    worst = max(row, key=lambda c: abs(c.deviation) / c.allowed)
    unit = "" if worst.metric.kind == "sign_changes" else " %"
    size = worst.deviation * (100 if unit else 1)
    measured = f"{len(row) - len(wrong)} of {len(row)} within; largest deviation {size:+.2g}{unit} ({worst.metric.name})"
    return Claim(
        number=number,
        text=f"Scenario {scenario.name} with {law}: the {len(row)} numbers of the comparison are reproduced.",
        expected=f"times within {TIMES:.0%}, amplitudes within {AMPLITUDES:.0%}, sign changes within {COUNTS:g}",
        measured=measured,
        verdict=Verdict.FAILS if wrong else Verdict.HOLDS,
        note="; ".join(f"{c.metric.name}: {c.measured:.4g} instead of {c.expected:.4g}" for c in wrong),
    )
