# SPDX-License-Identifier: Apache-2.0
"""Functions to generate for a system, as SymPy expressions with the meanings of their symbols."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import sympy as sp

from mehvar.base.manifest import Part
from mehvar.base.names import CLOCK, identifier
from mehvar.models.check import formulas
from mehvar.models.geometry import shape_coordinates
from mehvar.models.system import (
    TIME,
    Condition,
    Controller,
    Event,
    Expr,
    Function,
    Group,
    Quantity,
    System,
    free_symbols,
    scalar,
)

ROLES = ("u_cmd", "e", "dw", "v", "z", "q")
"""Roles of vectors of a system's quantities."""


@dataclass(frozen=True)
class Request:
    """A function to generate.

    Attributes
    ----------
    name, description : str
        Name in C and Python, and a one-line description.
    arguments : tuple of Group
        Arguments; a group of one quantity with the same name is a scalar.
    results : tuple of (name, expressions)
        Results by name.
    scalars : bool
        True if each result is a scalar instead of a vector.
    law : Controller, optional
        Law that computes the input, if the function does not receive it.
    repeated : bool
        True if a run calls it many times with the same parameters.
    alone : bool
        True to share no subexpression with other functions, because sharing would reorder their sums.
    part : str
        The C file that contains it.
    """

    name: str
    description: str
    arguments: tuple[Group, ...]
    results: tuple[tuple[str, tuple[Expr, ...]], ...]
    scalars: bool = False
    law: Controller | None = None
    repeated: bool = False
    alone: bool = False
    part: Part = ""


def requests(system: System) -> list[Request]:
    """Return the functions of a system, right-hand side first, without Jacobians."""
    own = [_own(function) for function in system.functions]
    laws = [request for law in system.controllers for request in _law(system, law)]
    return [*_plant(system), *_scenario(system), *own, *laws, *_picture(system)]


def _picture(system: System) -> list[Request]:
    """Return the function for a picture's points, which does not change the results of a run."""
    if not system.geometry:
        return []
    arguments = (system.states, system.inputs, system.references, system.parameters)
    points = tuple(expr for *_, expr in shape_coordinates(system.geometry))
    return [Request("geometry", "points of the shapes of a picture", arguments, (("points", points),), alone=True)]


def _plant(system: System) -> list[Request]:
    """Return the functions of the plant; which ones exist depends on the features of the system."""
    x, u, r, p = system.states, system.inputs, system.references, system.parameters
    margins = _margins(system.limits)
    functions = [
        Request("rhs", "state derivative", (x, u, p), (("dx", system.rhs),), repeated=True),
        Request("outputs", "outputs of a run", (x, u, r, p), (("y", system.output),), repeated=True),
        Request("limits", "margins that stay positive along a run", (x, u, p), (("margin", margins),), repeated=True),
    ]
    functions += _events(system)
    for variant in system.variants:
        description = f"state derivative, {', '.join(variant.values)}"
        name, result = f"rhs_{suffix(system, variant.values)}", (("dx", variant.rhs),)
        functions.append(Request(name, description, (x, u, p), result, repeated=True, part="variants"))
    q = _integrated(system)
    if system.coordinates:
        functions.append(Request("to_coordinates", "regular coordinates of a state", (x,), (("q", q.symbols),)))
        functions.append(Request("from_coordinates", "state at regular coordinates", (q,), (("x", x.symbols),)))
    if system.projection:
        of_parameters = not free_symbols(system.projection, system.definitions).isdisjoint(p.symbols)
        arguments, result = (q, p) if of_parameters else (q,), (("q_next", system.projection),)
        functions.append(Request("project", "coordinates put back on their manifold", arguments, result))
    if system.mass is not None:
        diagonal, description = (("m", tuple(system.mass.diagonal())),), "one, and zero of algebraic states"
        functions.append(Request("mass_diagonal", description, (p,), diagonal))
    if system.actuator:
        commanded = Group("u_cmd", system.actuator.commanded.quantities)
        result = (("u", system.actuator.applied),)
        functions.append(Request("actuate", "input that acts", (x, commanded, p), result, repeated=True))
    if system.sensor:
        noise = Group("e", system.sensor.noise.quantities)
        own = len(system.sensor.seen)
        result = (("seen" if own else "x_seen", system.sensor.measured),)
        what = "measurement" if own else "measured state"
        functions.append(Request("measure", what, (x, noise, p), result, repeated=True))
    if system.delays:
        counts = {q.name: q.symbol for q in system.parameters}
        delays = tuple(counts[system.delays[q.name]] if q.name in system.delays else sp.S.Zero for q in u)
        functions.append(Request("input_delays", "samples after which each input acts", (p,), (("d", delays),)))
    if system.diffusion:
        wiener, result = Group("dw", system.diffusion.wiener.quantities), (("x_step", system.diffusion.change),)
        what = "change of the state by Wiener processes"
        functions.append(Request("diffuse", what, (x, wiener, p), result, repeated=True))
    if system.random_step:
        noise, result = Group("e", system.random_step.noise.quantities), (("x_after", system.random_step.after),)
        functions.append(Request("jump", "state after a random step", (x, noise, p), result, repeated=True))
    return functions


def _events(system: System) -> list[Request]:
    """Return the guards of events, and the state after an event given by its number, from 0."""
    if not system.events:
        return []
    motion = (system.states, system.inputs, system.parameters)
    guards = (("g", tuple(event.guard for event in system.events)),)
    functions = [Request("guards", "guards of the events", motion, guards, repeated=True)]
    if any(event.reset for event in system.events):
        number = Quantity("event", "1", "which event, counted from 0")
        states = tuple(_after(symbol, system.events, number.symbol) for symbol in system.states.symbols)
        description = "state after an event"
        functions.append(Request("resets", description, (*motion, scalar(number)), (("x_next", states),)))
    return functions


def _after(symbol: sp.Symbol, events: Sequence[Event], number: sp.Symbol) -> Expr:
    """Return a state after an event given by its number."""
    if not any(symbol in event.reset for event in events):
        return symbol
    values = [(event.reset.get(symbol, symbol), number < k + sp.S.Half) for k, event in enumerate(events)]
    return sp.Piecewise(*values[:-1], (values[-1][0], True))


def _scenario(system: System) -> list[Request]:
    p, s = system.parameters, system.scenario_parameters
    margins = _margins(system.constraints)
    return [
        Request("initial", "initial state of a scenario", (p, s), (("x", system.initial),)),
        Request("reference", "reference of a scenario", (scalar(TIME), p, s), (("r", system.reference),)),
        Request("constraints", "margins that stay positive for a feasible scenario", (p, s), (("margin", margins),)),
    ]


def _own(function: Function) -> Request:
    scalars = tuple((quantity.name, (expr,)) for quantity, expr in function.results)
    vector = ((function.vector, tuple(expr for _, expr in function.results)),)
    results = vector if function.vector else scalars
    return Request(function.name, function.description, function.arguments, results, not function.vector)


def _law(system: System, law: Controller) -> list[Request]:
    """Return the functions of a law: evaluation or loop, constraints, warnings, start, outputs and defaults."""
    x, r, p, c, s = system.states, system.references, system.parameters, law.parameters, system.scenario_parameters
    name, margins, derived = identifier(law.name), _margins(law.constraints), tuple(formulas(c).values())
    functions = _sampled(system, law) if law.period else _continuous(system, law)
    constraints = (("margin", margins),)
    functions.append(
        Request(f"{name}_constraints", f"margins of a feasible {law.name}", (p, c, s), constraints, law=law)
    )
    if law.warnings:
        values = tuple(value for condition in law.warnings for value in (condition.margin, *condition.shown))
        description = f"margins that a run of {law.name} should have, each with the values to show"
        functions.append(Request(f"{name}_warnings", description, (p, c, s), (("margin", values),), law=law))
    if law.start:
        description = f"memory of {law.name} before the first sample"
        functions.append(Request(f"{name}_start", description, (x, r, p, c), (("z", law.start),), law=law))
    if law.outputs:
        results = (("w", tuple(output.value for output in law.outputs)),)
        arguments = (x, r, _memory(law), p, c) if _reports_memory(system, law) else (x, r, p, c)
        functions.append(Request(f"{name}_outputs", f"reports of {law.name}", arguments, results, law=law))
    if derived:
        functions.append(Request(f"{name}_defaults", f"formula defaults of {law.name}", (c,), (("derived", derived),)))
    return functions


def _sampled(system: System, law: Controller) -> list[Request]:
    x, r, p, c = system.seen, system.references, system.parameters, law.parameters
    name, command = identifier(law.name), ("u", _commanded(system))
    if not law.memory:
        return [Request(name, law.title, (x, r, p, c), (command,), law=law, repeated=True)]
    arguments = (x, r, _applied(system, law), _memory(law), p, c)
    return [Request(name, law.title, arguments, (command, ("z_next", law.update)), law=law, repeated=True)]


def _applied(system: System, law: Controller) -> Group:
    """Return the acting inputs, under unused names if the law reads none."""
    unread = (replace(q, name=f"{q.name} applied") for q in system.inputs)
    return Group("v", law.applied.quantities or tuple(unread))


def _memory(law: Controller) -> Group:
    return Group("z", law.memory.quantities)


def _reports_memory(system: System, law: Controller) -> bool:
    """Return True if a law's reports depend on its memory; for a continuous law, also through its command."""
    definitions = system.definitions | (bindings_of_command(system, law) if not law.period else {})
    values = free_symbols([output.value for output in law.outputs], definitions)
    return not values.isdisjoint(law.memory.symbols)


def _continuous(system: System, law: Controller) -> list[Request]:
    """Return evaluation and loop of a continuous law, the guards in it, and its loop for each variant."""
    x, r, p, c = system.states, system.references, system.parameters, law.parameters
    q, rhs = _integrated(system), system.coordinates.rhs if system.coordinates else system.rhs
    name = identifier(law.name)
    command = ("u_cmd", _commanded(system))
    results = (("x", x.symbols), ("u", system.inputs.symbols), *((command,) if system.actuator else ()))
    answer: tuple[tuple[str, tuple[Expr, ...]], ...] = (("u", _commanded(system)),)
    arguments: tuple[Group, ...] = (system.seen, r, p, c)
    if law.memory:
        q, rhs = Group("q", (*q.quantities, *law.memory.quantities)), (*rhs, *law.rates)
        answer, arguments = (*answer, ("dz", law.rates)), (system.seen, r, _memory(law), p, c)
    functions = [
        Request(name, law.title, arguments, answer, law=law, repeated=True),
        Request(f"{name}_loop", f"closed loop of {law.name}", (q, r, p, c), (("dq", rhs),), law=law, repeated=True),
        Request(
            f"{name}_observe",
            f"state and input in the loop of {law.name}",
            (q, r, p, c),
            results,
            law=law,
            repeated=True,
        ),
    ]
    if guards := tuple(event.guard for event in (*system.events, *law.events)):
        description = f"guards of the events in the loop of {law.name}"
        results = (("g", guards),)
        functions.append(Request(f"{name}_guards", description, (q, r, p, c), results, law=law, repeated=True))
    for variant in system.variants:
        loop = (*variant.loops.get(law.name, variant.rhs), *law.rates)
        description = f"closed loop of {law.name}, {', '.join(variant.values)}"
        tag = f"{name}_loop_{suffix(system, variant.values)}"
        results = (("dq", loop),)
        functions.append(Request(tag, description, (q, r, p, c), results, law=law, repeated=True, part="variants"))
    return functions


def suffix(system: System, values: Iterable[str]) -> str:
    """Return the suffix of a variant's function names, which consists of its non-default values."""
    return "_".join(value for choice, value in zip(system.choices, values, strict=True) if value != choice.values[0])


def bindings(system: System, request: Request) -> dict[sp.Symbol, Expr]:
    """Return expressions for symbols that a function does not receive: another chart, the input, the reference."""
    names = {group.name for group in request.arguments}
    bound = _pairs(system.references.symbols, system.reference) if "s" in names else {}
    clock = next((q.symbol for group in request.arguments for q in group if q.name == CLOCK), None)
    bound |= {} if clock is None else {TIME.symbol: clock}
    law, coordinates = request.law, system.coordinates
    if coordinates and "q" in names:
        bound |= _pairs(system.states.symbols, coordinates.to_state)
    elif coordinates:
        bound |= _pairs(coordinates.states.symbols, coordinates.from_state)
    if coordinates and not law:
        bound |= _pairs(coordinates.inputs.symbols, coordinates.from_input)
    elif law:
        bound |= bindings_of_command(system, law)
    if law and system.sensor and system.seen is not system.states and "seen" not in names:
        bound |= _pairs(system.sensor.seen.symbols, system.sensor.measured)
        bound |= dict.fromkeys(system.sensor.noise.symbols, sp.S.Zero)
    return bound


def bindings_of_command(system: System, law: Controller) -> dict[sp.Symbol, Expr]:
    """Return the inputs that a law commands."""
    coordinates = system.coordinates
    if coordinates and not law.period:
        chart = _pairs(coordinates.inputs.symbols, law.command)
        return chart | _pairs(system.inputs.symbols, coordinates.to_input)
    acting = _pairs(system.inputs.symbols, system.actuator.applied) if system.actuator else {}
    return _pairs(_commanded(system), law.command) | acting


def parameter_arguments(system: System, request: Request) -> frozenset[int]:
    """Return the arguments that are constant along a run: parameters and a constant reference."""
    fixed = {"p", "c", "s"} | (set() if reference_moves(system) else {"r"})
    return frozenset(k for k, group in enumerate(request.arguments) if group.name in fixed)


def held_arguments(request: Request) -> frozenset[int]:
    """Return the arguments of a state derivative that are constant between samples: the input."""
    derivative = [name for name, _ in request.results] == ["dx"]
    return frozenset(k for k, group in enumerate(request.arguments) if derivative and group.name == "u")


def reference_moves(system: System) -> bool:
    """Return True if the reference depends on time."""
    return TIME.symbol in free_symbols(system.reference, system.definitions)


def _integrated(system: System) -> Group:
    """Return the integrated coordinates of continuous loops: the regular chart, else the state."""
    return Group("q", (system.coordinates.states if system.coordinates else system.states).quantities)


def _commanded(system: System) -> tuple[sp.Symbol, ...]:
    return system.actuator.commanded.symbols if system.actuator else system.inputs.symbols


def _margins(conditions: Iterable[Condition]) -> tuple[Expr, ...]:
    return tuple(condition.margin for condition in conditions)


def _pairs(symbols: Iterable[sp.Symbol], expressions: Iterable[Expr]) -> dict[sp.Symbol, Expr]:
    """Return pairs of symbols and expressions; a symbol that both charts share is paired with itself."""
    return {s: e for s, e in zip(symbols, expressions, strict=True) if s != e}
