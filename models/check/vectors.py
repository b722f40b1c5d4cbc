# SPDX-License-Identifier: Apache-2.0
"""The vectors of expressions of a system: rows, units and arguments."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import sympy as sp

from mehvar.base.errors import suggestion

from ..derivation import free_symbols
from ..events import Event
from ..forms import mass_rows
from ..geometry import shape_coordinates
from ..quantities import TIME, Group, Located, ModelError, Quantity
from ..system import Condition, Controller, Coordinates, Expr, Function, System, Variant


@dataclass(frozen=True)
class Vector:
    """A vector of expressions of a system.

    Attributes
    ----------
    what : str
        Its name in messages, such as "rhs" or "command of law 'balance'".
    entries : tuple of Expr
        One expression per row.
    rows : tuple of Quantity
        The quantity of each row; margins have none.
    receives : tuple of Group
        The groups that it may depend on.
    origin : str
        File and line.
    of_time : bool
        True if it may depend on time.
    rate : bool
        True if each row is the rate of its quantity.
    group : str
        Name of the rows together, such as "states".
    margin : bool
        True if only the signs of the entries matter.
    in_numbers : bool
        True if its units are not checked.
    in_balance : bool
        True if the check of another vector covers the units of its rows.
    more : mapping of Symbol to str
        Further symbols that it receives, with their units.
    """

    what: str
    entries: tuple[Expr, ...]
    rows: tuple[Quantity, ...]
    receives: tuple[Group, ...]
    origin: str
    of_time: bool = False
    rate: bool = False
    group: str = ""
    margin: bool = False
    in_numbers: bool = False
    in_balance: bool = False
    more: Mapping[sp.Symbol, str] = field(default_factory=dict)

    @cached_property
    def units(self) -> dict[sp.Symbol, str]:
        """Units of its possible arguments, by symbol."""
        time = {TIME.symbol: TIME.unit} if self.of_time else {}
        return time | {q.symbol: q.unit for group in self.receives for q in group} | dict(self.more)

    def row(self, index: int) -> str:
        """Return the name of an entry for messages."""
        where = f"{self.origin}: {self.what}, row {index + 1} of {len(self.entries)}"
        return f"{where} ({self.rows[index].name})" if index < len(self.rows) else where


def vectors(system: System) -> list[Vector]:
    """Return all vectors of a system."""
    result = [*_plant(system), *_scenario(system), *_hardware(system)]
    for variant in system.variants:
        result += _variant(system, variant)
    for function in system.functions:
        result.append(_function(system, function))
    for law in system.controllers:
        result += _law(system, law)
    return result


def system_groups(system: System) -> list[tuple[str, Group]]:
    """Return the groups whose symbols may occur in any expression, with their names in messages."""
    return [(kind, group) for kind, group, _ in located_groups(system)]


def located_groups(system: System) -> list[tuple[str, Group, Located]]:
    """Return these groups with the part of the system that declares each."""
    rows: tuple[tuple[str, Located | None, str], ...] = (
        ("state", system, "states"),
        ("input", system, "inputs"),
        ("reference", system, "references"),
        ("parameter", system, "parameters"),
        ("scenario parameter", system, "scenario_parameters"),
        ("coordinate", system.coordinates, "states"),
        ("input of the chart", system.coordinates, "inputs"),
        ("commanded input", system.actuator, "commanded"),
        ("noise", system.sensor, "noise"),
        ("measured quantity", system.sensor, "seen"),
        ("Wiener process", system.diffusion, "wiener"),
        ("noise of the random step", system.random_step, "noise"),
    )
    return [(kind, getattr(part, name), part) for kind, part, name in rows if part is not None]


def law_groups(law: Controller) -> list[tuple[str, Group]]:
    """Return the groups of a law."""
    kinds = (("parameter", law.parameters), ("memory", law.memory), ("applied input", law.applied))
    return [(f"{kind} of law {law.name!r}", group) for kind, group in kinds]


def _plant(system: System) -> Iterator[Vector]:
    """Yield rates, balance, outputs, limits, events, geometry and residual of the plant."""
    motion = (*_motion(system), system.parameters)
    yield Vector(
        "rhs", system.rhs, system.states.quantities, motion, system.origin,
        of_time=True, rate=system.mass is None, group="states", in_balance=system.mass is not None,
    )  # fmt: skip
    if system.mass is not None:
        yield _balance(system, motion)
    yield Vector(
        "output", system.output, system.outputs.quantities, (*motion, system.references), system.origin,
        of_time=True, group="outputs",
    )  # fmt: skip
    yield from _conditions("limits", system.limits, motion, of_time=True)
    for event in system.events:
        yield _guard(event, f"event {event.name!r}", motion)
        if event.reset:
            rows = tuple(q for q in system.states if q.symbol in event.reset)
            entries = tuple(event.reset[q.symbol] for q in rows)
            yield Vector(
                f"reset of event {event.name!r}", entries, rows, motion, event.origin, of_time=True, group="states"
            )
    if system.geometry:
        yield _geometry(system, (*motion, system.references))
    if system.residual or system.rates:
        yield Vector("residual", system.residual, (), motion, system.origin, of_time=True, more=_rates(system))


def _balance(system: System, receives: tuple[Group, ...]) -> Vector:
    """Return mass x' - rhs row by row, to check that all terms of a row have the same unit."""
    rates = [sp.Dummy(f"rate of {q.name}", real=True) for q in system.states]
    units = {rate: f"{q.unit}/s" for rate, q in zip(rates, system.states, strict=True)}
    left = tuple(row - entry for row, entry in zip(mass_rows(system, rates), system.rhs, strict=False))
    return Vector("mass", left, (), receives, system.origin, of_time=True, more=units)


def _geometry(system: System, receives: tuple[Group, ...]) -> Vector:
    _, names, entries = zip(*shape_coordinates(system.geometry), strict=True)
    rows = tuple(Quantity(name, "m", "coordinate of a shape") for name in names)
    return Vector("geometry", entries, rows, receives, system.origin, in_numbers=True)


def _rates(system: System) -> dict[sp.Symbol, str]:
    """Return the units of the rate symbols in the residual."""
    units = {q.name: f"{q.unit}/s" for q in system.states}
    unknown = next((name for name in system.rates if name not in units), None)
    if unknown:
        raise ModelError(f"{system.origin}: rates: {unknown!r} is not a state{suggestion(unknown, units)}")
    return {symbol: units[name] for name, symbol in system.rates.items()}


def _scenario(system: System) -> Iterator[Vector]:
    p, s, r = system.parameters, system.scenario_parameters, system.references
    known_at_start = (p, s) if _moves(system) else (p, s, r)
    yield Vector("initial", system.initial, system.states.quantities, known_at_start, system.origin, group="states")
    yield Vector("reference", system.reference, r.quantities, (p, s), system.origin, of_time=True, group="references")
    yield from _conditions("constraints", system.constraints, known_at_start)


def _hardware(system: System) -> Iterator[Vector]:
    """Yield the vectors of chart, actuator, sensor, noise and projection."""
    x, u, p = system.states, system.inputs, system.parameters
    if system.coordinates:
        yield from _chart(system, system.coordinates)
    if system.actuator:
        yield _alike("commanded of the actuator", system.actuator.commanded, u, system.actuator.origin)
    measured = "measured quantities" if system.sensor and len(system.sensor.seen) else "states"
    rows: tuple[tuple[Located | None, str, str, Group, str, str], ...] = (
        (system.actuator, "applied", "commanded", u, "actuator", "inputs"),
        (system.sensor, "measured", "noise", system.seen, "sensor", measured),
        (system.diffusion, "change", "wiener", x, "diffusion", "states"),
        (system.random_step, "after", "noise", x, "random step", "states"),
    )
    for part, name, noise, of, what, group in rows:
        if part is not None:
            receives = (x, getattr(part, noise), p)
            where = f"{name} of the {what}"
            yield Vector(where, getattr(part, name), of.quantities, receives, part.origin, True, group=group)
    if system.projection:
        q = system.coordinates.states if system.coordinates else x
        yield Vector(
            "projection", system.projection, q.quantities, (q, p), system.origin,
            group="coordinates" if system.coordinates else "states",
        )  # fmt: skip


def _chart(system: System, chart: Coordinates) -> Iterator[Vector]:
    """Yield the chart's rates, and its conversions of state and input in both directions."""
    x, u, p = system.states, system.inputs, system.parameters
    q, n = chart.states, chart.inputs
    for name, entries, rows, receives, group in (
        ("rhs", chart.rhs, q, (q, n, x, u, p), "states of the chart"),
        ("from_state", chart.from_state, q, (x,), "states of the chart"),
        ("from_input", chart.from_input, n, (x, u, q, p), "inputs of the chart"),
        ("to_state", chart.to_state, x, (q,), "states"),
        ("to_input", chart.to_input, u, (q, n, x, p), "inputs"),
    ):
        where = f"{name} of the coordinates"
        moving = name == "rhs"
        yield Vector(where, entries, rows.quantities, receives, chart.origin, moving, moving, group)


def _variant(system: System, variant: Variant) -> Iterator[Vector]:
    """Yield the rates of a variant, and the loops of continuous laws with these rates."""
    name = f"variant {', '.join(variant.values)!r}"
    motion = (*_motion(system), system.parameters)
    yield Vector(
        f"rhs of {name}", variant.rhs, system.states.quantities, motion, variant.origin,
        of_time=True, rate=True, group="states",
    )  # fmt: skip
    chart = system.coordinates
    rows = chart.states if chart else system.states
    for law in system.controllers:
        if not law.period and (law.name in variant.loops or chart):
            loop = variant.loops.get(law.name, variant.rhs)
            yield Vector(
                f"loop of law {law.name!r} in {name}", loop, rows.quantities,
                (*motion, system.references, law.parameters), variant.origin, True, True, "integrated coordinates",
            )  # fmt: skip


def _function(system: System, function: Function) -> Vector:
    """Return the results of a function, which may use the chart's coordinates of its state and input."""
    received = {q.symbol for group in function.arguments for q in group}
    chart, more = system.coordinates, dict[sp.Symbol, str]()
    if chart:  # the chart's coordinates for the state and input of the function
        pairs = (*zip(chart.states, chart.from_state, strict=False), *zip(chart.inputs, chart.from_input, strict=False))
        for quantity, value in pairs:
            if free_symbols([value], system.definitions) <= received | more.keys():
                more[quantity.symbol] = quantity.unit
    return Vector(
        f"results of function {function.name!r}",
        tuple(expr for _, expr in function.results),
        tuple(quantity for quantity, _ in function.results),
        function.arguments,
        function.origin,
        of_time=system.states in function.arguments,
        more={symbol: unit for symbol, unit in more.items() if symbol not in received},
    )


def _law(system: System, law: Controller) -> Iterator[Vector]:
    """Yield the vectors of a law; each may use only what is known when the loop evaluates it."""
    x, r, p, s, c = system.states, system.references, system.parameters, system.scenario_parameters, law.parameters
    chart = (system.coordinates.states,) if system.coordinates else ()
    state = (x, r, p, c, *chart)
    seen = (*(state if system.seen is x else (system.seen, r, p, c)), law.memory, law.applied)
    where = f"of law {law.name!r}"

    def vector(what: str, entries: Sequence[Expr], rows: Group, receives: tuple[Group, ...], group: str) -> Vector:
        return Vector(
            f"{what} {where}", tuple(entries), rows.quantities, receives, law.origin,
            of_time=True, group=group, in_numbers=law.in_numbers,
        )  # fmt: skip

    commanded = system.actuator.commanded if system.actuator else system.inputs
    rows = system.coordinates.inputs if system.coordinates and not law.period else commanded
    result = (commanded, system.inputs, *((system.coordinates.inputs,) if system.coordinates else ()))
    yield vector("command", law.command, rows, seen, "inputs of the chart" if rows is not commanded else "inputs")
    yield vector("start", law.start, law.memory, state, "memory")
    if law.period:
        yield vector("update", law.update, law.memory, (*seen, *result), "memory")
    elif law.memory:
        yield Vector(
            f"rates {where}", law.rates, law.memory.quantities, (*seen, *result), law.origin,
            of_time=True, rate=True, group="memory", in_numbers=law.in_numbers,
        )  # fmt: skip
    if law.applied:
        yield _alike(f"applied {where}", law.applied, system.inputs, law.origin)
    reported = Group("w", tuple(output.quantity for output in law.outputs))
    receives = (*state, law.memory) if law.memory and law.period else (*state, law.memory, *result)
    yield vector("outputs", [output.value for output in law.outputs], reported, receives, "outputs")
    for event in law.events:
        yield _guard(event, f"event {event.name!r} {where}", (*state, *result))
    known_at_start = (p, c, s) if _moves(system) else (p, c, s, r)
    yield from _conditions(f"constraints {where}", law.constraints, known_at_start)
    yield from _conditions(f"warnings {where}", law.warnings, known_at_start)


def _guard(event: Event, what: str, receives: tuple[Group, ...]) -> Vector:
    return Vector(f"guard of {what}", (event.guard,), (), receives, event.origin, of_time=True, margin=True)


def _alike(what: str, group: Group, inputs: Group, origin: str) -> Vector:
    """Check that a group has one symbol for each input that it represents, in the same unit."""
    return Vector(what, group.symbols, inputs.quantities, (group,), origin, group="inputs")


def _conditions(
    where: str, conditions: Sequence[Condition], receives: tuple[Group, ...], of_time: bool = False
) -> Iterator[Vector]:
    for k, condition in enumerate(conditions):
        yield Vector(
            f"margin {k + 1} of {where}", (condition.margin,), (), receives, condition.origin, of_time, margin=True
        )
        if condition.shown:
            yield Vector(f"shown {k + 1} of {where}", condition.shown, (), receives, condition.origin)


def _motion(system: System) -> tuple[Group, ...]:
    chart = system.coordinates
    return (system.states, system.inputs, *((chart.states, chart.inputs) if chart else ()))


def _moves(system: System) -> bool:
    return TIME.symbol in free_symbols(system.reference, system.definitions)
