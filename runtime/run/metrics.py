# SPDX-License-Identifier: Apache-2.0
"""Metrics: numbers that summarise a run."""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mehvar.base.errors import InputError, unknown_name
from mehvar.base.manifest import OF_SECONDS, Event, Manifest, Metric, Scenario

from ..model.functions import FloatArray
from .problem import Status
from .simulate import Run

if TYPE_CHECKING:
    import xarray

COUNT = "events"
"""Kind of metric that counts events and does not read series."""
TIMES = 0.01
"""Allowed relative deviation of a time. A sample is 0.2 to 0.9 % of the papers' settling times. Half the value fails
no claim and gives two rows a note; twice removes three notes.
"""
AMPLITUDES = 0.02
"""Allowed relative deviation of an amplitude. Printed amplitudes have two to four digits; rounding to two digits
changes them by up to 2.5 %. Half or twice changes no verdict.
"""
COUNTS = 1.0
"""Allowed deviation of a count, because a sign change at the end of a run may or may not count."""


def metrics(run: Run | xarray.Dataset, manifest: Manifest) -> dict[str, float]:
    """Return all metrics of a model by name.

    Parameters
    ----------
    run : Run or xarray.Dataset
        A run, or its dataset from `to_dataset` or `open_result`.
    manifest : Manifest
        Manifest with the definitions.

    Returns
    -------
    dict of str to float
        The settling time of a signal that does not settle is `inf`. A metric is NaN if its series contains NaN, the
        run ended before its window, or an early end leaves it undetermined (see `is_open`). Under a law from outside
        the model, metrics of law reports are omitted.

    Raises
    ------
    InputError
        If a metric is of an unknown kind or the result lacks a variable.
    """
    series = run.variables() if isinstance(run, Run) else {str(k): v.values for k, v in run.data_vars.items()}
    t = run.t if isinstance(run, Run) else run["t"].values
    law = run.controller.name if isinstance(run, Run) else run.attrs.get("controller")
    log = (
        (name for _, name in run.events)
        if isinstance(run, Run)
        else json.loads(run.attrs.get("events", '{"name": []}'))["name"]
    )
    counts = Counter(log)
    known = metrics_of(manifest, law, series)
    return {name: evaluate(metric, t, series, counts, early_end(run)) for name, metric in known.items()}


def early_end(run: Run | xarray.Dataset) -> float:
    """Return the time of an early end, s; infinity without one."""
    if isinstance(run, Run):
        return math.inf if run.status is Status.DONE else run.t_stop
    status = run.attrs.get("status", Status.DONE.text)
    return math.inf if status == Status.DONE.text else float(run.attrs["t_stop"])


def metrics_of(manifest: Manifest, law: str | None, variables: Collection[str]) -> dict[str, Metric]:
    """Return the metrics of runs under a law; for a Python law, only metrics with existing variables."""
    if law is None or law in manifest.controllers:
        return dict(manifest.metrics)
    reports = {q.name for one in manifest.controllers.values() for q in (*one.memory, *one.outputs)}
    return {
        name: metric
        for name, metric in manifest.metrics.items()
        if metric.kind == COUNT
        or not {part for of in metric.of for part in _variables(of)} & (reports - set(variables))
    }


def is_cut_short(metric: Metric, cut: float) -> bool:
    """Return True for a metric that is undetermined after an early end.

    Extremes, sums, counts and final values are determined up to the end of a run. Settling and values at later
    instants are not.
    """
    of_the_end = metric.kind in OF_SECONDS or (metric.kind == "final" and math.isfinite(metric.until))
    return of_the_end and cut < metric.until


def undetermined(metrics: Mapping[str, Metric], end: float, dt: float, cut: float = math.inf) -> dict[str, str]:
    """Return the reason for each undetermined metric: its window has no samples or is incomplete.

    Parameters
    ----------
    metrics : mapping of str to Metric
        Metrics of a run.
    end, dt : float
        End of the run and its sampling step, s.
    cut : float
        Instant at which the run ended early.
    """
    reasons = {}
    for name, metric in metrics.items():
        if metric.since > end:
            reasons[name] = f"the window begins at {metric.since:g} s, after the end of the run at {end:g} s"
        elif min(math.ceil(metric.since / dt * (1 - _ROUNDING)) * dt, end) > metric.until * (1 + _ROUNDING):
            reasons[name] = f"no sample lies in the window, {metric.since:g} s to {metric.until:g} s"
        elif is_cut_short(metric, cut):
            reasons[name] = f"the run ended at {cut:g} s, before its time"
    return {name: f"undetermined: {reason}" for name, reason in reasons.items()}


def grouped_notes(notes: Mapping[str, str]) -> list[str]:
    """Return notes about metrics, one line per reason."""
    names: dict[str, list[str]] = {}
    for name, note in notes.items():
        names.setdefault(note, []).append(name)
    return [f"{', '.join(group)}: {note}" for note, group in names.items()]


_ROUNDING = 1e-12
"""Relative rounding of instants, so that a window that ends at a sample includes it."""


def event_number(metric: Metric, name: str, events: Sequence[Event]) -> int:
    """Return the number of the event that a metric counts, or raise InputError."""
    names = [event.name for event in events]
    if name not in names:
        raise unknown_name(f"event in metric {metric.name}", name, names)
    return names.index(name)


def evaluate(
    metric: Metric,
    t: FloatArray,
    series: Mapping[str, FloatArray],
    counts: Mapping[str, int] | None = None,
    cut: float = math.inf,
) -> float:
    """Return a metric from named series, event counts, and the time of an early end."""
    if metric.kind == COUNT:
        return float(sum((counts or {}).get(name, 0) for name in metric.of))
    if metric.kind not in _KINDS:
        raise unknown_name(f"kind of metric {metric.name}", metric.kind, _KINDS)
    if not metric.of:
        raise InputError(f"metric {metric.name} names no variable")
    if is_cut_short(metric, cut):
        return math.nan
    whole = t.size > 0 and metric.since <= t[0] and t[-1] <= metric.until
    window = slice(None) if whole else (t >= metric.since) & (t <= metric.until)
    if not (isinstance(window, slice) or window.any()):
        return math.nan
    values = np.array([_signal(metric, of, series)[window] for of in metric.of])
    return float(_KINDS[metric.kind](t[window], values, metric.band))


def _variables(of: str) -> list[str]:
    return [name.strip() for name in of.split(" - ")]


def _signal(metric: Metric, of: str, series: Mapping[str, FloatArray]) -> FloatArray:
    """Return a variable or the difference of two."""
    names = _variables(of)
    for name in names:
        if name not in series:
            raise unknown_name(f"variable in metric {metric.name}", name, series)
    first, *rest = (series[name] for name in names)
    return first - rest[0] if rest else first


def _settling(t: FloatArray, values: FloatArray, band: float) -> float:
    outside = ~(np.abs(values) <= band)
    return max(_settling_of_one(t, row, out.nonzero()[0], band) for row, out in zip(values, outside, strict=True))


def _settling_of_one(t: FloatArray, row: FloatArray, outside: NDArray[np.intp], band: float) -> float:
    """Return the time at which a signal enters the band, interpolated after its last sample outside."""
    if outside.size == 0:
        return float(t[0])
    last = outside[-1]
    if last == len(t) - 1:
        return math.inf
    edge = math.copysign(band, row[last])
    part = (row[last] - edge) / (row[last] - row[last + 1])
    return float(t[last] + part * (t[last + 1] - t[last])) if math.isfinite(part) else float(t[last + 1])


def _sum(values: FloatArray) -> float:
    """Sum over time, then over rows, in the order of a batch, so that results are bit-identical."""
    rows = np.add.accumulate(values, axis=1)[:, -1:]
    return float(np.add.accumulate(rows, axis=0)[-1, 0]) if rows.size else 0.0


def _sign_changes(_t: FloatArray, values: FloatArray, band: float) -> float:
    signs = (np.sign(row[np.abs(row) > band]) for row in values)
    return float(sum(np.count_nonzero(np.diff(s)) for s in signs))


_KINDS: Mapping[str, Callable[[FloatArray, FloatArray, float], float]] = {
    "settling": _settling,
    "settling_about_end": lambda t, values, band: _settling(t, values - values[:, -1:], band),
    "max": lambda _t, values, _band: float(np.max(values)),
    "min": lambda _t, values, _band: float(np.min(values)),
    "max_abs": lambda _t, values, _band: float(np.max(np.abs(values))),
    "rms": lambda _t, values, _band: math.sqrt(_sum(values * values) / values.size),
    "travel": lambda _t, values, _band: _sum(np.abs(np.diff(values, axis=1))),
    "sign_changes": _sign_changes,
    "final": lambda _t, values, _band: float(values[0, -1]),
}


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


def deviations_of(manifest: Manifest, scenario: Scenario, law: str, measured: Mapping[str, float]) -> list[Deviation]:
    """Compare the metrics of a run with the numbers that its scenario expects for its law."""
    return [
        Deviation(scenario.name, law, manifest.metrics[name], value, measured[name])
        for name, value in scenario.expect.get(law, {}).items()
    ]
