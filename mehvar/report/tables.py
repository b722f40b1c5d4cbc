# SPDX-License-Identifier: Apache-2.0
"""Contents of a model as tables, for `mehvar show` and for pages."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TypeAlias

from mehvar.base.manifest import Manifest, Parameter, Quantity

NamedTable: TypeAlias = tuple[str, Sequence[str], Sequence[Sequence[str]]]
"""Title, columns and rows."""


def model_tables(manifest: Manifest) -> Iterator[NamedTable]:
    """Yield quantities, parameters, choices, limits, scenarios and public functions of a model."""
    yield _quantities("states x", manifest.states)
    yield _quantities("inputs u", manifest.inputs)
    yield _quantities("references r", manifest.references)
    yield _quantities("outputs y", manifest.outputs)
    yield _parameters("plant parameters p", manifest.parameters)
    for law in manifest.controllers.values():
        yield _parameters(f"controller {law.name}: {law.title}", law.parameters)
    yield _parameters("scenario parameters s", manifest.scenario_parameters)
    choices = [(c.name, " ".join(c.values), c.description) for c in manifest.choices.values()]
    if choices:
        yield "choices (the first value is the default)", ("name", "values", "meaning"), choices
    if manifest.limits:
        yield "limits, at which a run ends", ("message",), [(message,) for message in manifest.limits]
    scenarios = [(s.name, f"{s.duration:g} s", f"{s.step:g} s", s.title) for s in manifest.scenarios.values()]
    yield "scenarios", ("name", "duration", "step", "description"), scenarios
    functions = [
        (f.name, str(f.operations), f"({', '.join(a.name for a in f.arguments)}) -> "
         f"{', '.join(a.name for a in f.results)}")
        for f in manifest.functions.values()
        if not f.internal  # split parts, which only the integrator calls
    ]  # fmt: skip
    yield "functions", ("name", "operations", "arguments and results"), functions


def _quantities(title: str, quantities: Iterable[Quantity]) -> NamedTable:
    return title, ("name", "unit", "meaning"), [(q.name, q.unit, q.description) for q in quantities]


def _parameters(title: str, parameters: Iterable[Parameter]) -> NamedTable:
    """Return a table of parameters; a formula takes the place of the default."""
    rows = [
        (q.name, q.unit, q.formula or f"{q.default:g}", q.interval,
         f"{q.description} ({q.source})" if q.source else q.description)
        for q in parameters
    ]  # fmt: skip
    return title, ("name", "unit", "default", "allowed", "meaning (source)"), rows
