# SPDX-License-Identifier: Apache-2.0
"""What the papers show and say, checked against the models.

A module mehvar.papers.MODEL holds what `Paper` lists. Nothing outside this package names a model, but for the scripts
that draw its scene: mehvar/templates/report/MODEL.js.
"""

from __future__ import annotations

import importlib
import importlib.util
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import TYPE_CHECKING, Any, Protocol, cast

from mehvar.runtime.model.manifest import Manifest, Metric, Scenario, identifier, known_models
from mehvar.runtime.model.model import Model
from mehvar.runtime.run.metrics import metrics
from mehvar.runtime.run.simulate import Run, simulate

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    FloatArray = NDArray[np.float64]

TIMES, AMPLITUDES, COUNTS = 0.01, 0.02, 1.0
"""Allowed deviation: of times and of amplitudes, relative; of counts, absolute."""


class Verdict(StrEnum):
    """What became of a claim."""

    HOLDS = "holds"
    NOTE = "holds with a note"
    REFUTED = "does not hold, as documented"
    FAILS = "does not hold"


@dataclass(frozen=True)
class Check:
    """One part of a claim: what was looked at, what was expected and what running the model gave.

    The claim itself does not depend on a check that is not essential; its failure deserves a note.
    """

    what: str
    expected: str
    measured: str
    holds: bool
    essential: bool = True


@dataclass(frozen=True)
class Claim:
    """Something a paper says and the checks that decide it; `explanation` is about the checks that may fail.

    What a paper says and our documents refute is `refuted`: it fails when its checks hold.
    """

    number: str
    text: str
    checks: tuple[Check, ...]
    explanation: str = ""
    refuted: bool = False

    @property
    def verdict(self) -> Verdict:
        """What became of the claim."""
        failed = [check for check in self.checks if not check.holds]
        if any(check.essential for check in failed):
            return Verdict.REFUTED if self.refuted else Verdict.FAILS
        if self.refuted:
            return Verdict.FAILS
        return Verdict.NOTE if failed else Verdict.HOLDS

    @property
    def expected(self) -> str:
        """What was expected, in one line."""
        return "; ".join(f"{check.what}: {check.expected}" for check in self.checks)

    @property
    def measured(self) -> str:
        """What was measured, in one line."""
        return "; ".join(f"{check.what}: {check.measured}" for check in self.checks)

    @property
    def note(self) -> str:
        """The explanation where one is due, else empty."""
        return "" if self.verdict is Verdict.HOLDS else self.explanation


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
    """A figure by its number in the paper; `draw` makes it, `claims` are the numbers of those that it shows."""

    number: int
    title: str
    caption: str
    draw: Callable[[Runs], Figure]
    claims: tuple[str, ...] = ()


@dataclass(frozen=True)
class Line:
    """A series of a scene that is drawn over time: its column, its name (HTML) and a colour of the pictures."""

    column: str
    name: str
    color: str
    dash: bool = False


@dataclass(frozen=True)
class Panel:
    """Series of a scene over one axis; `scale` multiplies the columns."""

    label: str
    lines: tuple[Line, ...]
    scale: float = 1.0


@dataclass(frozen=True)
class Scene:
    """An animation: its title and caption, what moves in each run, and what is drawn over time beside it.

    Attributes
    ----------
    runs : mapping
        Titles of runs to named series; each has "t".
    constants : mapping
        What does not change: lengths, the target.
    speeds : tuple of float
        Seconds of the run per second of the reader, to choose from; the first is the default.
    """

    title: str
    caption: str
    runs: Mapping[str, Mapping[str, FloatArray]]
    constants: Mapping[str, Any]
    panels: tuple[Panel, ...]
    speeds: tuple[float, ...]


@dataclass(frozen=True)
class Study:
    """A batch for each of some laws: what is drawn at random, what counts as success, and what is shown over time.

    Attributes
    ----------
    text : str
        The question, in words.
    laws : mapping of str to str
        Laws and how they are called.
    bands : mapping of str to (str, float)
        Stored series, each with the label of its axis and a factor.
    """

    text: str
    laws: Mapping[str, str]
    runs: int
    vary: Mapping[str, str]
    success: str
    bands: Mapping[str, tuple[str, float]]
    every: float
    scenario: str | None = None
    options: Mapping[str, float | str] = field(default_factory=dict)


class Paper(Protocol):
    """What a module of this package offers."""

    CITATION: str
    READINGS: tuple[str, ...]
    STUDY: Study
    BOARD: str | None
    """The law that is run on an emulated board."""

    def figures(self) -> Sequence[PaperFigure]:
        """Return the paper's figures."""

    def claims(self, runs: Runs) -> Sequence[Claim]:
        """Return what became of the paper's claims."""

    def scene(self, runs: Runs) -> Scene:
        """Return the animation."""

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
        """Return a run; `settings` are options and parameters of `mehvar.runtime.run.simulate.simulate`."""
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
    return [name for name in known_models() if importlib.util.find_spec(f"{__package__}.{identifier(name)}")]


def load_paper(model: str) -> Paper:
    """Import the paper module of a model."""
    return cast(Paper, importlib.import_module(f"{__package__}.{identifier(model)}.study"))


def compare(runs: Runs) -> list[Comparison]:
    """Run every scenario and law that expects numbers, and compare."""
    manifest = runs.model.manifest
    return [
        Comparison(scenario.name, law, manifest.metrics[name], value, found[name])
        for scenario in manifest.scenarios.values()
        for law, expected in scenario.expect.items()
        for found in [runs.metrics(law, scenario.name)]
        for name, value in expected.items()
    ]


def table_claims(manifest: Manifest, comparisons: Sequence[Comparison]) -> list[Claim]:
    """Return one claim for each run of the comparison: its numbers are reproduced."""
    return [
        _row_claim(f"T{number}", manifest.scenarios[scenario], law, row)
        for number, ((scenario, law), row) in enumerate(by_run(comparisons), 1)
    ]


def by_run(comparisons: Sequence[Comparison]) -> list[tuple[tuple[str, str], list[Comparison]]]:
    """Return the comparisons of each scenario and law, in order."""
    rows: dict[tuple[str, str], list[Comparison]] = {}
    for comparison in comparisons:
        rows.setdefault((comparison.scenario, comparison.controller), []).append(comparison)
    return list(rows.items())


def about(what: str, expected: float, measured: float, unit: str = "", tolerance: float = TIMES) -> Check:
    """Return the check that a number is within a relative tolerance of the expected one."""
    holds = abs(measured - expected) <= tolerance * abs(expected)
    return Check(what, f"{expected:g} {unit}".strip(), f"{measured:.4g} {unit}".strip(), holds)


def count(what: str, expected: float, measured: float) -> Check:
    """Return the check that a count is within one of the expected one."""
    return Check(what, f"{expected:g}", f"{measured:g}", abs(measured - expected) <= COUNTS)


def below(what: str, bound: float, measured: float, unit: str = "") -> Check:
    """Return the check that a number is below a bound."""
    return Check(what, f"< {bound:g} {unit}".strip(), f"{measured:.3g} {unit}".strip(), measured < bound)


def beside(check: Check) -> Check:
    """Return a check that the claim does not depend on."""
    return replace(check, essential=False)


def _row_claim(number: str, scenario: Scenario, law: str, row: Sequence[Comparison]) -> Claim:
    wrong = [c for c in row if not c.holds]
    worst = max(row, key=lambda c: abs(c.deviation) / c.allowed)
    size = f"{worst.deviation:+g}" if worst.metric.kind == "sign_changes" else f"{100 * worst.deviation:+.2g} %"
    check = Check(
        f"{len(row)} numbers",
        "times within 1 %, amplitudes within 2 %, counts within one",
        f"{len(row) - len(wrong)} within; largest deviation {size} ({worst.metric.name})",
        not wrong,
    )
    return Claim(
        number,
        f"The numbers of scenario {scenario.name} with {law} are reproduced (table below).",
        (check,),
        "; ".join(f"{c.metric.name}: {c.measured:.4g} instead of {c.expected:.4g}" for c in wrong),
    )
