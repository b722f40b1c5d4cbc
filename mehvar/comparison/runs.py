# SPDX-License-Identifier: Apache-2.0
"""Runs of every scenario and law with both versions."""

from __future__ import annotations

import importlib.util
import math
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from mehvar.base.errors import InputError, MehvarError
from mehvar.base.manifest import read_manifest
from mehvar.runtime.compiling.compiler import require_compiler
from mehvar.runtime.model.functions import CBackend
from mehvar.runtime.model.header import check_header
from mehvar.runtime.model.model import Model
from mehvar.runtime.run.metrics import metrics
from mehvar.runtime.run.problem import Status
from mehvar.runtime.run.simulate import Run, simulate

from ..estimation.margins import Margin, draining, left_out, linear_loop, linear_margins, moving, orbit_modes, unstable
from .spectra import differentiable

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_STEPS = 1e-6
"""Relative tolerance of a metric. Two forms of a loop round differently, so runs with tolerance 1e-9 end 1e-8 apart. A
tenth of this value would report rearranged equations; ten times the value would miss changes below 1e-5."""
_STILL = 1e-12
"""Change of a state, beside its size and one unit, that counts as rest. Rounding at rest moves a state by about 1e-16 a
step, and a metric that a larger motion changes is compared."""
_VISIBLE = 1e-3
"""Relative difference of margins above which they are shown; three digits are printed."""


@dataclass(frozen=True)
class MetricChange:
    """A metric with different values in the two versions.

    Attributes
    ----------
    name, unit : str
        The metric.
    old, new : float
        Its values: infinite for a signal that does not settle, NaN for a run that ended too early.
    """

    name: str
    unit: str
    old: float
    new: float


@dataclass(frozen=True)
class RunChange:
    """A scenario under a law with a changed run.

    Attributes
    ----------
    law, scenario : str
        Law and scenario of the run.
    old, new : str
        End of each version's run in words; empty if it reached its end time.
    metrics : tuple of MetricChange
        Metrics that differ.
    count : int
        Metrics that both versions have.
    """

    law: str
    scenario: str
    old: str
    new: str
    metrics: tuple[MetricChange, ...]
    count: int

    @property
    def size(self) -> float:
        """Largest relative change of a metric; infinite if the two runs ended in different ways."""
        changes = (abs(m.new - m.old) / max(abs(m.old), abs(m.new)) for m in self.metrics)
        sizes = [size if math.isfinite(size) else math.inf for size in changes]
        return math.inf if self.old != self.new else max(sizes, default=0.0)


@dataclass(frozen=True)
class MarginChange:
    """Changed margins of a loop, input by input.

    Attributes
    ----------
    law, scenario : str
        The run; the loop is linearised at its end.
    old, new : tuple of Margin
        Margins at the inputs that the law uses; empty for an unstable loop.
    settled : bool
        False if the linear loop of a version still changes there.
    """

    law: str
    scenario: str
    old: tuple[Margin, ...]
    new: tuple[Margin, ...]
    settled: bool = True

    @property
    def title(self) -> str:
        """Law, and where the loop is linearised."""
        moment = "" if self.settled else ", a moment of a motion"
        return f"margins under {self.law} where {self.scenario} ends{moment}"


@dataclass(frozen=True)
class Overlay:
    """Both versions of the run with the largest change, for the picture; `size` has the meaning of `RunChange.size`."""

    law: str
    scenario: str
    old: Run
    new: Run
    size: float
    names: Mapping[str, str]
    """New names by old ones."""

    def picture(self, model: str) -> Figure | None:
        """Return both runs in one picture; None where matplotlib is not installed."""
        if importlib.util.find_spec("matplotlib") is None:
            return None
        from mehvar.pictures.overlay import overlay_picture
        from mehvar.pictures.style import style
        from mehvar.runtime.run.results import to_dataset

        with style(), np.errstate(all="ignore"):  # a run may go beyond all bounds
            title = f"{model}: {self.scenario} under {self.law}"
            old = to_dataset(self.old)
            old = old.rename({name: other for name, other in self.names.items() if name in old.data_vars})
            return overlay_picture(old, to_dataset(self.new), title)


@dataclass(frozen=True)
class Runs:
    """Results of every scenario under every law that both versions have.

    Attributes
    ----------
    changed : tuple of RunChange
        Runs that differ.
    same : tuple of (str, str)
        Law and scenario of runs whose metrics are equal.
    margins : tuple of MarginChange
        Loops whose margins differ.
    refused : tuple of (str, str, str)
        Law, scenario and reason of runs that both versions refuse with the same message.
    note : str
        Reason why something is missing.
    largest : float
        Largest relative difference of a metric of the runs in `same`.
    zero : tuple of str
        Parameters that are zero in every run of both versions; a term with such a factor has no effect.
    resting : tuple of (str, str)
        Law and scenario of runs in `same` in which no state moves, so that they show nothing.
    """

    changed: tuple[RunChange, ...] = ()
    same: tuple[tuple[str, str], ...] = ()
    margins: tuple[MarginChange, ...] = ()
    refused: tuple[tuple[str, str, str], ...] = ()
    note: str = ""
    largest: float = 0.0
    zero: tuple[str, ...] = ()
    resting: tuple[tuple[str, str], ...] = ()


def runs(old: Path, new: Path, names: Mapping[str, str]) -> tuple[Runs, Overlay | None]:
    """Run every scenario under every law with the compiled code of two folders.

    Parameters
    ----------
    old, new : Path
        Generated folders of one model.
    names : mapping of str to str
        New names by old ones.
    """
    try:
        before, after = _loaded(old), _loaded(new)
    except MehvarError as error:
        return Runs(note=f"laws not run: {error}"), None
    changed, same, moved, refused, resting = [], [], [], [], []
    overlay, largest, rest = None, 0.0, 0.0
    done: list[Run] = []
    cases = list(_cases(before, after, names))
    note = _noise(before, after, names) if cases else "no run compared: the versions have no law and scenario in common"
    for old_law, law, old_scenario, scenario in cases:
        first, second = _run(before, old_law, old_scenario), _run(after, law, scenario)
        change, part = _change(law, scenario, first, second, names)
        done += [run for run in (first, second) if isinstance(run, Run)]
        if isinstance(first, str) and first == second:
            refused.append((law, scenario, first))
        elif change is None:
            same.append((law, scenario))
            rest = max(rest, part)
            if not any(isinstance(run, str) or moves(run) for run in (first, second)):
                resting.append((law, scenario))
        else:
            changed.append(change)
        if isinstance(first, str) or isinstance(second, str):
            continue
        if change is not None and change.size > largest:
            overlay, largest = Overlay(law, scenario, first, second, change.size, names), change.size
        try:
            edges = _margins(before, first, names), _margins(after, second, {})
        except InputError:  # a copied folder without derivatives of its laws: the note on loops says so
            continue
        if _differ(*edges):
            sides = ((before, first, edges[0]), (after, second, edges[1]))
            still = not any(draining(model, run) or moving(model, run) for model, run, own in sides if own)
            moved.append(MarginChange(law, scenario, *edges, still))
    groups = (tuple(changed), tuple(same), tuple(moved), tuple(refused))
    return Runs(*groups, note, rest, _zero(done, names), tuple(resting)), overlay


def _noise(before: Model, after: Model, names: Mapping[str, str]) -> str:
    """Return a note if the versions draw other random numbers for a sensor, which changes runs."""
    old, new = ([names.get(q.name, q.name) for q in model.manifest.noise] for model in (before, after))
    shared = [name for name in old if name in new and old.index(name) != new.index(name)]
    if not shared:
        return ""
    return f"the order of noise changed, so that runs have other random numbers: {', '.join(shared)}"


def moves(run: Run) -> bool:
    """Return True if a state changes during a run by more than rounding."""
    return bool(np.any(np.ptp(run.x, axis=0) > _STILL * (1.0 + np.max(np.abs(run.x), axis=0))))


def _zero(runs: Sequence[Run], names: Mapping[str, str]) -> tuple[str, ...]:
    """Return the parameters that are zero in every run that has them."""
    values = [{names.get(name, name): value for name, value in run.parameters.values.items()} for run in runs]
    every = dict.fromkeys(name for own in values for name in own)
    return tuple(name for name in every if not any(own.get(name, 0.0) for own in values))


def _loaded(folder: Path) -> Model:
    manifest = read_manifest(folder)
    require_compiler()
    check_header(manifest)
    return Model(manifest, CBackend(manifest))


class _Case(NamedTuple):
    """Law and scenario of a run, by the names of either version."""

    old_law: str
    law: str
    old_scenario: str
    scenario: str


def _cases(before: Model, after: Model, names: Mapping[str, str]) -> Iterator[_Case]:
    """Yield the runs that both versions have."""
    laws, scenarios = (
        {names.get(name, name): name for name in known}
        for known in (before.manifest.controllers, before.manifest.scenarios)
    )
    for law in after.manifest.controllers:
        for scenario in after.manifest.scenarios:
            if law in laws and scenario in scenarios:
                yield _Case(laws[law], law, scenarios[scenario], scenario)


def _run(model: Model, law: str, scenario: str) -> Run | str:
    """Return a run, or the reason why it is missing."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # advice on a law's parameters is unrelated to the change
        try:
            return simulate(model, law, scenario)
        except InputError as error:
            return str(error)


def _change(
    law: str, scenario: str, old: Run | str, new: Run | str, names: Mapping[str, str]
) -> tuple[RunChange | None, float]:
    """Return the change of a run, or None, and the largest relative difference of a metric that counts as equal."""
    before, after = _metrics(old, names), _metrics(new, {})
    if not before.keys() & after.keys():
        before, after = _extremes(old, names), _extremes(new, {})
    shared = [name for name in after if name in before]
    moved = tuple(
        MetricChange(name, after[name][1], before[name][0], after[name][0])
        for name in shared
        if not equal_numbers(before[name][0], after[name][0])
    )
    pairs = [(before[name][0], after[name][0]) for name in shared]
    part = max((abs(b - a) / max(abs(a), abs(b)) for a, b in pairs if a != b and math.isfinite(b - a)), default=0.0)
    ends = _end(old), _end(new)
    return (RunChange(law, scenario, *ends, moved, len(shared)) if moved or ends[0] != ends[1] else None), part


def _metrics(run: Run | str, names: Mapping[str, str]) -> dict[str, tuple[float, str]]:
    """Return the metrics of a run with units; without metrics, the extremes and final values of its states."""
    if isinstance(run, str):
        return {}
    known = run.manifest.metrics
    found = {name: (float(value), known[name].unit) for name, value in metrics(run, run.manifest).items()}
    return found or _extremes(run, names)


def _extremes(run: Run | str, names: Mapping[str, str]) -> dict[str, tuple[float, str]]:
    """Return the extremes and final values of a run's states and of its law's memory, with units."""
    if isinstance(run, str):
        return {}
    quantities = (*run.manifest.states, *run.controller.memory)
    x = np.hstack([run.x, run.z])
    x = np.where(np.abs(x) > run.options.get("atol", 0.0), x, 0.0)  # the integration resolves no less
    states = [(k, names.get(q.name, q.name), q.unit) for k, q in enumerate(quantities)]
    reached = {f"largest |{name}|": (float(np.max(np.abs(x[:, k]))), unit) for k, name, unit in states}
    return reached | {f"last {name}": (float(x[-1, k]), unit) for k, name, unit in states}


def equal_numbers(old: float, new: float, part: float = _STEPS) -> bool:
    """Return True if numbers agree relative to the larger one; a number that is not finite equals only itself."""
    if not (math.isfinite(old) and math.isfinite(new)):
        return old == new or (math.isnan(old) and math.isnan(new))
    return abs(new - old) <= part * max(abs(old), abs(new))


def _end(run: Run | str) -> str:
    if isinstance(run, str):
        return f"refused: {run}"
    if run.status is Status.DONE:
        return ""
    return f"{'ended' if run.status.complete else 'ended early'}: {run.reason}"


def _margins(model: Model, run: Run, names: Mapping[str, str]) -> tuple[Margin, ...]:
    """Return the margins at the end of a run, linearised with the state held fixed; empty if they are undefined.

    Those of an unstable loop are NaN.
    """
    if not differentiable(model, run.controller) or run.status is not Status.DONE:
        return ()
    try:
        cut = linear_loop(model, run)
        slow = orbit_modes(model, run.x[-1])
        margins = linear_margins(cut, slow)
        if any(margin.is_endless for margin in margins) and left_out(cut, slow, margins):
            return ()
        if not margins and unstable(model, run):
            acting = (name for k, name in enumerate(cut.inputs) if np.any(cut.B[:, k]) and np.any(cut.C[k]))
            margins = tuple(Margin(name, math.nan, math.nan) for name in acting)
    except InputError:  # which the comparison of the loops reports
        return ()
    return tuple(replace(margin, input=names.get(margin.input, margin.input)) for margin in margins)


def _differ(old: tuple[Margin, ...], new: tuple[Margin, ...]) -> bool:
    one, other = ({margin.input: margin for margin in side} for side in (old, new))
    if one.keys() != other.keys():
        return True
    pairs = ((one[name], other[name]) for name in one)
    return not all(
        equal_numbers(a.gain, b.gain, _VISIBLE) and equal_numbers(a.phase, b.phase, _VISIBLE) for a, b in pairs
    )
