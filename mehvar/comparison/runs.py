# SPDX-License-Identifier: Apache-2.0
"""Runs of every scenario and law with both versions."""

from __future__ import annotations

import importlib.util
import itertools
import math
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

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
from .sides import Side, Sides, shared
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
        sizes = (difference(metric.old, metric.new) for metric in self.metrics)
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
        """Return both runs in one picture; None without a visible difference, or without matplotlib."""
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
        sides = Side(_loaded(old), names), Side(_loaded(new), {})
    except MehvarError as error:
        return Runs(note=f"laws not run: {error}"), None
    laws, scenarios = shared(*(side.laws for side in sides)), shared(*(side.scenarios for side in sides))
    changed, same, refused, resting = [], [], [], []
    overlay, largest = None, 0.0
    trials: list[_Trial] = []
    margins: list[MarginChange] = []
    for law, scenario in itertools.product(laws, scenarios):
        cases = zip(sides, laws[law], scenarios[scenario], strict=True)
        first, second = (_run(side.model, own.name, case) for side, own, case in cases)
        ends = _end(first), _end(second)
        if isinstance(first, str) or isinstance(second, str):
            if isinstance(first, str) and first == second:
                refused.append((law, scenario, first))
            else:
                changed.append(RunChange(law, scenario, *ends, (), 0))
            continue
        both = _Trial(sides[0], first), _Trial(sides[1], second)
        trials += both
        metrics, count, part = _differences(*both)
        if metrics or ends[0] != ends[1]:
            changed.append(RunChange(law, scenario, *ends, metrics, count))
            if overlay is None or changed[-1].size > overlay.size:
                overlay = Overlay(law, scenario, first, second, changed[-1].size, names)
        else:
            same.append((law, scenario))
            largest = max(largest, part)
            if not (moves(first) or moves(second)):
                resting.append((law, scenario))
        margins += _margins(law, scenario, *both)
    note = "" if laws and scenarios else "no run compared: the versions have no law and scenario in common"
    groups = (tuple(changed), tuple(same), tuple(margins), tuple(refused))
    return Runs(*groups, note or _noise(sides), largest, _zero(trials), tuple(resting)), overlay


def _loaded(folder: Path) -> Model:
    manifest = read_manifest(folder)
    require_compiler()
    check_header(manifest)
    return Model(manifest, CBackend(manifest))


def _noise(sides: Sides) -> str:
    """Return a note if the versions draw other random numbers for a sensor, which changes runs."""
    old, new = ({side.name(q.name): k for k, q in enumerate(side.model.manifest.noise)} for side in sides)
    moved = [name for name in old if name in new and old[name] != new[name]]
    if not moved:
        return ""
    return f"the order of noise changed, so that runs have other random numbers: {', '.join(moved)}"


def _run(model: Model, law: str, scenario: str) -> Run | str:
    """Return a run, or the reason why it is missing."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # advice on a law's parameters is unrelated to the change
        try:
            return simulate(model, law, scenario)
        except InputError as error:
            return str(error)


def _end(run: Run | str) -> str:
    if isinstance(run, str):
        return f"refused: {run}"
    if run.status is Status.DONE:
        return ""
    return f"{'ended' if run.status.complete else 'ended early'}: {run.reason}"


def moves(run: Run) -> bool:
    """Return True if a state changes during a run by more than rounding."""
    return bool(np.any(np.ptp(run.x, axis=0) > _STILL * (1.0 + np.max(np.abs(run.x), axis=0))))


@dataclass(frozen=True)
class _Trial:
    """The run of one version."""

    side: Side
    run: Run

    def metrics(self) -> dict[str, tuple[float, str]]:
        """Return the metrics with units."""
        known = self.run.manifest.metrics
        return {name: (float(value), known[name].unit) for name, value in metrics(self.run, self.run.manifest).items()}

    def extremes(self) -> dict[str, tuple[float, str]]:
        """Return the extremes and final values of the states and of the law's memory, with units."""
        x = np.hstack([self.run.x, self.run.z])
        x = np.where(np.abs(x) > self.run.options.get("atol", 0.0), x, 0.0)  # the integration resolves no less
        quantities = (*self.run.manifest.states, *self.run.controller.memory)
        states = [(k, self.side.name(q.name), q.unit) for k, q in enumerate(quantities)]
        reached = {f"largest |{name}|": (float(np.max(np.abs(x[:, k]))), unit) for k, name, unit in states}
        return reached | {f"last {name}": (float(x[-1, k]), unit) for k, name, unit in states}

    def margins(self) -> dict[str, Margin]:
        """Return the margins at the end by input, linearised with the state held fixed; empty if they are undefined.

        Those of an unstable loop are NaN.
        """
        model, run = self.side.model, self.run
        if not differentiable(model, run.controller) or run.status is not Status.DONE:
            return {}
        try:
            cut = linear_loop(model, run)
            slow = orbit_modes(model, run.x[-1])
            margins = linear_margins(cut, slow)
            if any(margin.is_endless for margin in margins) and left_out(cut, slow, margins):
                return {}
            if not margins and unstable(model, run):
                acting = (name for k, name in enumerate(cut.inputs) if np.any(cut.B[:, k]) and np.any(cut.C[k]))
                margins = tuple(Margin(name, math.nan, math.nan) for name in acting)
        except InputError:  # which the comparison of the loops reports
            return {}
        return {(name := self.side.name(margin.input)): replace(margin, input=name) for margin in margins}

    def is_settled(self) -> bool:
        """Return False if the linear loop still changes at the end."""
        return not (draining(self.side.model, self.run) or moving(self.side.model, self.run))


def _differences(old: _Trial, new: _Trial) -> tuple[tuple[MetricChange, ...], int, float]:
    """Return the metrics that differ, the number of all, and the largest relative difference of one that is equal.

    Runs without common metrics are compared by their states.
    """
    pairs = shared(old.metrics(), new.metrics()) or shared(old.extremes(), new.extremes())
    sizes = {name: difference(before, after) for name, ((before, _), (after, _)) in pairs.items()}
    changed = [name for name, size in sizes.items() if size > _STEPS]
    changes = (MetricChange(name, pairs[name][1][1], pairs[name][0][0], pairs[name][1][0]) for name in changed)
    return tuple(changes), len(pairs), max((size for size in sizes.values() if size <= _STEPS), default=0.0)


def difference(old: float, new: float) -> float:
    """Return the difference of two numbers relative to the larger one; infinite if one alone is not finite."""
    if old == new or (math.isnan(old) and math.isnan(new)):
        return 0.0
    if not (math.isfinite(old) and math.isfinite(new)):
        return math.inf
    return abs(new - old) / max(abs(old), abs(new))


def _zero(trials: Sequence[_Trial]) -> tuple[str, ...]:
    """Return the parameters that are zero in every run that has them."""
    values = [{t.side.name(name): value for name, value in t.run.parameters.values.items()} for t in trials]
    every = dict.fromkeys(name for own in values for name in own)
    return tuple(name for name in every if not any(own.get(name, 0.0) for own in values))


def _margins(law: str, scenario: str, old: _Trial, new: _Trial) -> Iterator[MarginChange]:
    """Yield the change of a loop's margins, if they differ."""
    try:
        before, after = old.margins(), new.margins()
    except InputError:  # a copied folder without derivatives of its laws: the note on loops says so
        return
    pairs = shared(before, after).values()
    sizes = [size for a, b in pairs for size in (difference(a.gain, b.gain), difference(a.phase, b.phase))]
    if before.keys() != after.keys() or any(size > _VISIBLE for size in sizes):
        settled = all(trial.is_settled() for trial, own in ((old, before), (new, after)) if own)
        yield MarginChange(law, scenario, tuple(before.values()), tuple(after.values()), settled)
