# SPDX-License-Identifier: Apache-2.0
"""`mehvar show`: contents of a model, from its manifest."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

import typer

from mehvar.base.manifest import Manifest, Parameter, Quantity
from mehvar.base.schema import plain
from mehvar.runtime.model.catalogue import find_model
from mehvar.settings import AsJson, ModelName
from mehvar.terminal import PAGE, pages, print_entries, print_json


def command(
    model: ModelName,
    as_json: AsJson = False,
) -> None:
    """Print names, units, defaults, bounds and sources of one model."""
    manifest = find_model(model)
    if as_json:
        print_json(plain(Manifest, manifest))
        return
    with pages():
        _show(manifest)


def _show(manifest: Manifest) -> None:
    """Print structure, quantities, parameters, choices, limits, scenarios and functions of a model."""
    structure = ", ".join(f"{name}\u00a0=\u00a0{value}" for name, value in manifest.structure.items())  # kept on a line
    lines = textwrap.fill(f"structure: {structure or 'fixed'}", PAGE, subsequent_indent="  ").replace("\u00a0", " ")
    typer.echo(f"{manifest.model}: {manifest.title}\n{lines}\n")
    for title, quantities in (
        ("states x", manifest.states),
        ("inputs u", manifest.inputs),
        ("references r", manifest.references),
        ("outputs y", manifest.outputs),
    ):
        _quantities(title, quantities)
    _parameters("plant parameters p", manifest.parameters)
    for law in manifest.controllers.values():
        _parameters(f"controller {law.name}: {law.title}", law.parameters)
    _parameters("scenario parameters s", manifest.scenario_parameters)
    if manifest.choices:
        rows = [[c.name, " ".join(c.values), c.description] for c in manifest.choices.values()]
        print_entries("choices (the first value is the default)", ["name", "values", "meaning"], rows)
        typer.echo()
    if manifest.limits:
        print_entries("limits, at which a run ends", ["message"], [[message] for message in manifest.limits])
        typer.echo()
    _scenarios(manifest)
    _functions(manifest)


def _quantities(title: str, quantities: Sequence[Quantity]) -> None:
    print_entries(title, ["name", "unit", "meaning"], [[q.name, q.unit, q.description] for q in quantities])
    typer.echo()


def _parameters(title: str, parameters: Sequence[Parameter]) -> None:
    """Print a table of parameters; a formula takes the place of the default."""
    rows = [
        [
            q.name,
            q.unit,
            q.formula or f"{q.default:g}",
            q.interval,
            f"{q.description} ({q.source})" if q.source else q.description,
        ]
        for q in parameters
    ]
    print_entries(title, ["name", "unit", "default", "allowed", "meaning (source)"], rows)
    typer.echo()


def _scenarios(manifest: Manifest) -> None:
    rows = [[s.name, f"{s.duration:g} s", f"{s.step:g} s", s.title] for s in manifest.scenarios.values()]
    print_entries("scenarios", ["name", "duration", "step", "description"], rows)
    typer.echo()


def _functions(manifest: Manifest) -> None:
    """Print the public functions, without split parts, which only the integrator calls."""
    rows = [
        [
            f.name,
            str(f.operations),
            f"({', '.join(a.name for a in f.arguments)}) -> {', '.join(a.name for a in f.results)}",
        ]
        for f in manifest.functions.values()
        if not f.internal
    ]
    print_entries("functions", ["name", "operations", "arguments and results"], rows)
