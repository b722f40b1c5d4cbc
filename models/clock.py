# SPDX-License-Identifier: Apache-2.0
"""Time for functions without a time argument: as an additional state or reference.

A time-varying plant gets the clock as its last state, whose rate is one. Every method, backend and tool then
integrates time with the states, and no signature changes (decision 0024). If only laws use time, time becomes an
element of the reference.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import chain
from typing import Any, TypeVar

import sympy as sp

from mehvar.base.names import CLOCK as CLOCK_NAME

from .derivation import free_symbols
from .quantities import TIME, Group, Located, Quantity
from .system import Controller, Expr, Function, System, Variant

CLOCK = Quantity(CLOCK_NAME, "s", "time, as a state of the plant", "t")
"""The clock: last state of a time-varying plant, zero at the start by default."""


def with_clock(system: System) -> System:
    """Return a system whose functions receive the time; the same system if it does not use time."""
    if plant_of_time(system):
        return _in_state(system)
    loops = (entry for variant in system.variants for loop in variant.loops.values() for entry in loop)
    used = free_symbols([*loops, *(e for law in system.controllers for e in _expressions(law))], system.definitions)
    if TIME.symbol not in used or TIME in system.references.quantities:
        return system
    references = Group(system.references.name, (*system.references.quantities, TIME))
    return replace(system, references=references, reference=(*system.reference, TIME.symbol))


def plant_of_time(system: System) -> bool:
    """Return True if the plant depends on time; its functions receive no reference."""
    parts = [system.rhs, system.output, system.residual, *(variant.rhs for variant in system.variants)]
    parts += [(limit.margin,) for limit in system.limits]
    parts += [tuple(system.mass)] if system.mass is not None else []
    parts += [(event.guard, *event.reset.values()) for event in system.events]
    parts += [system.coordinates.rhs] if system.coordinates else []
    parts += [system.actuator.applied] if system.actuator else []
    parts += [system.sensor.measured] if system.sensor else []
    parts += [system.diffusion.change] if system.diffusion else []
    parts += [system.random_step.after] if system.random_step else []
    parts += [_results(function) for function in system.functions if system.states in function.arguments]
    entries = [entry for entry in chain(*parts) if isinstance(entry, sp.Basic)]
    return TIME.symbol in free_symbols(entries, system.definitions)


def _in_state(system: System) -> System:
    """Append the clock to the state and to every vector with a row per state."""
    states, last = _longer(system.states), CLOCK.symbol
    sensor = _with_entries(system.sensor, measured=last)
    chart = _with_entries(system.coordinates, rhs=sp.S.One, from_state=last, to_state=last)
    return replace(
        system,
        states=states,
        rhs=(*system.rhs, sp.S.One),
        mass=sp.diag(system.mass, 1) if system.mass is not None else None,
        initial=(*system.initial, sp.S.Zero),
        projection=(*system.projection, last) if system.projection else (),
        sensor=replace(sensor, seen=_longer(sensor.seen)) if sensor and len(sensor.seen) else sensor,
        diffusion=_with_entries(system.diffusion, change=sp.S.Zero),
        random_step=_with_entries(system.random_step, after=last),
        coordinates=replace(chart, states=_longer(chart.states)) if chart else None,
        variants=tuple(_variant(variant) for variant in system.variants),
        functions=tuple(_function(function, system.states, states) for function in system.functions),
    )


_Part = TypeVar("_Part", bound=Located)


def _with_entries(part: _Part | None, **entries: Expr) -> _Part | None:
    """Return a part of a system with one more entry in some of its vectors."""
    if part is None:
        return None
    longer: dict[str, Any] = {key: (*getattr(part, key), entry) for key, entry in entries.items()}
    return replace(part, **longer)


def _longer(group: Group) -> Group:
    return Group(group.name, (*group.quantities, CLOCK))


def _variant(variant: Variant) -> Variant:
    loops = {law: (*loop, sp.S.One) for law, loop in variant.loops.items()}
    return replace(variant, rhs=(*variant.rhs, sp.S.One), loops=loops)


def _function(function: Function, states: Group, longer: Group) -> Function:
    return replace(function, arguments=tuple(longer if group == states else group for group in function.arguments))


def _results(function: Function) -> tuple[Expr, ...]:
    return tuple(expr for _, expr in function.results)


def _expressions(law: Controller) -> tuple[Expr, ...]:
    return (*law.command, *law.start, *law.update, *law.rates, *(output.value for output in law.outputs))
