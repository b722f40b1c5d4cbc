# SPDX-License-Identifier: Apache-2.0
"""The manifest of a system and its generated functions: all that the runtime needs to know of a model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from mehvar.base import manifest as numeric
from mehvar.base.manifest import Manifest
from mehvar.base.versions import installed
from mehvar.models.system import Condition, Controller, Event, Group, Output, Parameter, System, free_symbols

from .code.files import PrintedFunction, model_hash
from .functions.readers import Reader, readers, readers_of
from .functions.requests import reference_moves


def manifest_of(system: System, functions: Sequence[PrintedFunction], inputs: Mapping[str, str]) -> Manifest:
    """Return the manifest of a generated model.

    Parameters
    ----------
    system : System
        What was generated.
    functions : sequence of PrintedFunction
        Its functions.
    inputs : mapping of str to str
        SHA-256 of every source file it depends on.
    """
    listing = readers(system)
    manifest = Manifest(
        model=system.name,
        title=system.title,
        source=system.source,
        structure=dict(system.structure),
        hash="",
        states=_quantities(system.states),
        inputs=_quantities(system.inputs),
        references=_quantities(system.references),
        outputs=_quantities(system.outputs),
        coordinates=_quantities(system.coordinates.states) if system.coordinates else (),
        parameters=_parameters(system.parameters, listing),
        scenario_parameters=_parameters(system.scenario_parameters, listing),
        controllers={law.name: _controller(law, listing) for law in system.controllers},
        limits=_messages(system.limits),
        limits_of_state=_of_state(system),
        constraints=_messages(system.constraints),
        reference_constant=not reference_moves(system),
        choices={choice.name: choice for choice in system.choices},
        noise=_quantities(system.sensor.noise) if system.sensor else (),
        measured=_quantities(system.sensor.seen) if system.sensor else (),
        delays=dict(system.delays),
        wiener=_quantities(system.diffusion.wiener) if system.diffusion else (),
        random_step=_quantities(system.random_step.noise) if system.random_step else (),
        scenarios={scenario.name: scenario for scenario in system.scenarios},
        metrics={metric.name: metric for metric in system.metrics},
        geometry=tuple(
            numeric.Shape(shape.name, shape.kind, len(shape.points), shape.color) for shape in system.geometry
        ),
        events=_events(system.events),
        functions={f.name: _function(system.name, f) for f in functions},
        versions=installed("casadi", "sympy"),
        inputs_sha256=dict(sorted(inputs.items())),
    )
    return replace(manifest, hash=model_hash(manifest, functions))


def _of_state(system: System) -> bool:
    """Tell whether limits read no input, where continuous loops integrate the state itself."""
    used = free_symbols([limit.margin for limit in system.limits], system.definitions)
    return bool(system.limits) and system.coordinates is None and used.isdisjoint(system.inputs.symbols)


def _quantities(group: Group) -> tuple[numeric.Quantity, ...]:
    return tuple(numeric.Quantity(q.name, q.unit, q.description) for q in group)


def _parameters(group: Group, listing: Sequence[Reader], law: str = "") -> tuple[numeric.Parameter, ...]:
    names = readers_of(group, listing, law)
    return tuple(_parameter(q, names[q.name]) for q in group if isinstance(q, Parameter))


def _parameter(q: Parameter, names: tuple[str, ...]) -> numeric.Parameter:
    return numeric.Parameter(
        name=q.name,
        unit=q.unit,
        default=None if isinstance(q.default, str) else q.default,
        formula=q.default if isinstance(q.default, str) else None,
        lower=q.bounds.lower,
        upper=q.bounds.upper,
        lower_open=q.bounds.lower_open,
        upper_open=q.bounds.upper_open,
        source=q.source,
        description=q.description,
        readers=names,
    )


def _controller(law: Controller, listing: Sequence[Reader]) -> numeric.Controller:
    return numeric.Controller(
        name=law.name,
        title=law.title,
        memory=_quantities(law.memory),
        period=law.period or None,
        delay=law.delay or None,
        tolerates_loss=law.tolerates_loss,
        parameters=_parameters(law.parameters, listing, law.name),
        constraints=_messages(law.constraints),
        outputs=tuple(_output(output) for output in law.outputs),
        events=_events(law.events),
        warnings=tuple(numeric.Advice(w.message, len(w.shown)) for w in law.warnings),
    )


def _output(output: Output) -> numeric.Output:
    q = output.quantity
    return numeric.Output(q.name, q.unit, q.description, output.at_most)


def _events(events: Sequence[Event]) -> tuple[numeric.Event, ...]:
    return tuple(numeric.Event(e.name, e.direction, bool(e.reset), e.outcome, e.title) for e in events)


def _messages(conditions: Sequence[Condition]) -> tuple[str, ...]:
    return tuple(condition.message for condition in conditions)


def _function(model: str, f: PrintedFunction) -> numeric.Function:
    arguments, results = (tuple(numeric.Array(*pair) for pair in pairs) for pairs in (f.arguments, f.results))
    return numeric.Function(f.name, f.description, arguments, results, f.operations, numeric.file_of(model, f.part))
