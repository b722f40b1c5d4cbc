# SPDX-License-Identifier: Apache-2.0
"""Manifest of a system and its generated functions, with all data that the runtime needs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from typing import Any, TypeVar, cast

from mehvar.base import manifest as numeric
from mehvar.base.manifest import Manifest, file_of
from mehvar.base.versions import installed
from mehvar.models.system import Condition, Controller, Event, Group, Parameter, System, free_symbols

from .code.files import PrintedFunction, model_hash
from .equations import VECTORS
from .equations.graph import groups
from .functions.readers import Reader, readers, readers_of
from .functions.requests import reference_moves

_T = TypeVar("_T")


def manifest_of(system: System, functions: Sequence[PrintedFunction], inputs: Mapping[str, str]) -> Manifest:
    """Return the manifest of a generated model.

    Parameters
    ----------
    system : System
        The generated system.
    functions : sequence of PrintedFunction
        Its functions.
    inputs : mapping of str to str
        SHA-256 of every source file it depends on.
    """
    listing = readers(system)
    vectors = groups(system)
    manifest = _as(
        Manifest,
        system,
        model=system.name,
        structure=dict(system.structure),
        hash="",
        **{name: tuple(vectors.get(role, ())) for name, role in VECTORS.items()},
        parameters=_parameters(system.parameters, listing),
        scenario_parameters=_parameters(system.scenario_parameters, listing),
        controllers={law.name: _controller(law, listing) for law in system.controllers},
        limits=_messages(system.limits),
        limits_of_state=_of_state(system),
        constraints=_messages(system.constraints),
        reference_constant=not reference_moves(system),
        delays=dict(system.delays),
        **{name: {part.name: part for part in getattr(system, name)} for name in ("choices", "scenarios", "metrics")},
        geometry=tuple(_as(numeric.Shape, shape, points=len(shape.points)) for shape in system.geometry),
        events=_events(system.events),
        functions={f.name: _as(numeric.Function, f, file=file_of(system.name, f.part)) for f in functions},
        versions=installed("casadi", "sympy"),
        inputs_sha256=dict(sorted(inputs.items())),
    )
    return replace(manifest, hash=model_hash(manifest, functions))


def _of_state(system: System) -> bool:
    """Return True if limits do not depend on the input and continuous loops integrate the state itself."""
    used = free_symbols([limit.margin for limit in system.limits], system.definitions)
    return bool(system.limits) and system.coordinates is None and used.isdisjoint(system.inputs.symbols)


_FORMER = {"tolerates_loss": "bears_loss"}
"""Former names of fields, for older revisions, which `diff` derives. A field without any of its names has its
default.
"""


def _as(kind: type[_T], part: object, **others: object) -> _T:
    """Convert a part of a system to a class of the manifest: fields with equal names, and the given ones."""
    names = (f.name for f in fields(cast(Any, kind)) if f.name not in others)
    known = ((name, source) for name in names for source in (name, _FORMER.get(name, "")) if hasattr(part, source))
    return kind(**{name: getattr(part, source) for name, source in known}, **others)


def _parameters(group: Group, listing: Sequence[Reader], law: str = "") -> tuple[numeric.Parameter, ...]:
    names = readers_of(group, listing, law)
    return tuple(_parameter(q, names[q.name]) for q in group if isinstance(q, Parameter))


def _parameter(q: Parameter, names: tuple[str, ...]) -> numeric.Parameter:
    value = {"formula": q.default, "default": None} if isinstance(q.default, str) else {"formula": None}
    return _as(numeric.Parameter, q, readers=names, **value, **vars(q.bounds))


def _controller(law: Controller, listing: Sequence[Reader]) -> numeric.Controller:
    """Return a law of the manifest: its quantities, messages and times instead of expressions."""
    return _as(
        numeric.Controller,
        law,
        memory=law.memory.quantities,
        period=law.period or None,
        delay=law.delay or None,
        parameters=_parameters(law.parameters, listing, law.name),
        constraints=_messages(law.constraints),
        outputs=tuple(_as(numeric.Output, o, **vars(_as(numeric.Quantity, o.quantity))) for o in law.outputs),
        events=_events(law.events),
        warnings=tuple(_as(numeric.Advice, w, shown=len(w.shown)) for w in law.warnings),
    )


def _events(events: Sequence[Event]) -> tuple[numeric.Event, ...]:
    return tuple(_as(numeric.Event, e, resets=bool(e.reset), ends=e.outcome) for e in events)


def _messages(conditions: Sequence[Condition]) -> tuple[str, ...]:
    return tuple(condition.message for condition in conditions)
