# SPDX-License-Identifier: Apache-2.0
"""Check of metrics: existing quantities, matching units, and the numbers that their kind needs."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

from mehvar.base.manifest import OF_SECONDS
from mehvar.base.units import dimension, radians

from ..quantities import ModelError
from ..system import Metric, System
from ..tables import OF_COUNTS, check_metric_numbers, check_names, place_of
from .dimensions import check_radians, placed
from .names import check_distinct, check_name


def check_metrics(system: System, folder: Path | None = None) -> None:
    """Refuse metrics with unknown quantities, wrong units or unusable numbers."""
    check_distinct([metric.name for metric in system.metrics], f"{system.origin}: metric")
    for metric in system.metrics:
        check_name(metric.name, f"{place_of(folder, 'metrics', metric.name, system.origin)}: metric")
    units = _variables(system)
    for metric in system.metrics:
        place = place_of(folder, "metrics", metric.name, system.origin)
        where = f"{place}: metric {metric.name!r} of {system.name}"
        check_metric_numbers(metric, where)
        if metric.kind == "events":
            _check_events(metric, system, where)
        else:
            _check_variables(metric, units, where)


def _check_events(metric: Metric, system: System, where: str) -> None:
    """Refuse counts of events that some law lacks, and counts with a time window."""
    check_distinct(metric.of, f"{where}: event")
    check_names(metric.of, [event.name for event in system.events], f"{where}: event")
    if not metric.of or metric.unit != "1":
        raise ModelError(
            f"{where}: of = {list(metric.of)}, unit = {metric.unit!r}: of must name an event, and unit must be '1'"
        )
    if metric.since or math.isfinite(metric.until):
        raise ModelError(f"{where}: since and until would be ignored: events are counted over the whole run")


def _variables(system: System) -> dict[str, set[str]]:
    """Return the units of the variables that runs of all laws have; laws may report one name in different units."""
    common = {q.name: {q.unit} for q in (*system.states, *system.outputs)}
    common |= {f"u_{q.name}": {q.unit} for q in system.inputs}
    reports = [
        {q.name: q.unit for q in (*law.memory, *(output.quantity for output in law.outputs))}
        for law in system.controllers
    ]
    shared = set.intersection(*(set(report) for report in reports)) if reports else set()
    return common | {name: {report[name] for report in reports} for name in shared}


def _check_variables(metric: Metric, units: Mapping[str, set[str]], where: str) -> None:
    """Refuse variables that are unknown or have different units, and a metric with another unit."""
    signals = [[name.strip() for name in of.split(" - ")] for of in metric.of]
    check_distinct(metric.of, f"{where}: variable")
    allowed = "one" if metric.kind == "final" else "one or more"
    if not signals or (metric.kind == "final" and len(signals) > 1):
        raise ModelError(f"{where}: of = {list(metric.of)}: must be {allowed}, for {metric.kind}")
    for of, names in zip(metric.of, signals, strict=True):
        check_names(names, units, f"{where}: variable")
        if len(names) > 2 or len({*names}) < len(names):
            raise ModelError(f"{where}: of = {of!r}: must be a variable or the difference of two")
    present = {unit for names in signals for name in names for unit in units[name]}
    one = sorted(present)[0]
    other = next((unit for unit in sorted(present) if dimension(unit) != dimension(one)), None)
    if other is not None:
        raise ModelError(
            f"{where}: of = {list(metric.of)}: variables with the units {one} and {other} cannot be combined"
        )
    unit = "s" if metric.kind in OF_SECONDS else "1" if metric.kind in OF_COUNTS else one
    with placed(where):
        own = dimension(metric.unit)
    check_radians(metric.unit, where)
    angle = max(map(radians, present), key=abs) if unit == one else 0
    if own != dimension(unit) or radians(metric.unit) != angle:
        raise ModelError(f"{where}: unit = {metric.unit!r}: must be {unit}, for {metric.kind} of {metric.of[0]!r}")
