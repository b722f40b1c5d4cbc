# SPDX-License-Identifier: Apache-2.0
"""Plants without laws or with other laws."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from .check.vectors import vectors
from .derivation import Definition, Derivation, Equation, used_definitions
from .system import Controller, Metric, System


def without_laws(system: System) -> System:
    """Return the plant of a system without laws and without everything that only laws use.

    Laws command the plant's own input. The inputs of a regular chart become definitions.
    """
    plant = replace(
        system,
        controllers=(),
        scenarios=tuple(replace(scenario, controllers={}, expect={}) for scenario in system.scenarios),
        metrics=tuple(_without_reports(system)),
        variants=tuple(replace(variant, loops={}) for variant in system.variants),
        coordinates=None,
        projection=() if system.coordinates else system.projection,
    )
    plant = replace(plant, steps=(*_chart(system), *plant.steps))
    return replace(plant, steps=tuple(_steps_of(plant)))


def with_laws(plant: System, name: str, laws: Iterable[Controller], derivation: Derivation) -> System:
    """Return a new system: the plant with the given laws and their derivation."""
    return replace(plant, name=name, controllers=tuple(laws), steps=tuple(derivation.steps))


def _without_reports(system: System) -> Iterable[Metric]:
    """Yield the metrics of plant variables, without those of a law's memory and reports."""
    reports = {q.name for law in system.controllers for q in law.memory}
    reports |= {output.quantity.name for law in system.controllers for output in law.outputs}
    for metric in system.metrics:
        if not reports & {part.strip() for of in metric.of for part in of.split(" - ")}:
            yield metric


def _chart(system: System) -> Iterable[Definition]:
    """Yield the meanings of a regular chart's symbols."""
    chart = system.coordinates
    if chart is None:
        return
    for group, entries in ((chart.states, chart.from_state), (chart.inputs, chart.from_input)):
        for q, entry in zip(group, entries, strict=True):
            if q.symbol != entry:
                yield Definition(q.symbol, entry, "", q.description, "Regular coordinates", q.unit, q.latex)


def _steps_of(plant: System) -> Iterable[Definition | Equation]:
    """Yield the steps that the plant's vectors use, and the shown equations in the plant's symbols."""
    entries = [entry for vector in vectors(plant) for entry in vector.entries]
    entries += [*plant.residual, *(s for condition in plant.limits for s in condition.shown)]
    needed = used_definitions(entries, plant.definitions)
    known = needed | {symbol for vector in vectors(plant) for symbol in vector.units}
    for step in plant.steps:
        kept = step.symbol in needed if isinstance(step, Definition) else step.expr.free_symbols <= known
        if kept:
            yield step
