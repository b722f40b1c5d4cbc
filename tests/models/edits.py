# SPDX-License-Identifier: Apache-2.0
"""Small systems with all features, and random edits of their fields."""

import dataclasses
import random
from collections.abc import Iterator
from typing import Any

import numpy as np
import sympy as sp

from mehvar.models.system import (  # fmt: skip
    TIME,
    Actuator,
    Choice,
    Condition,
    Controller,
    Coordinates,
    Derivation,
    Function,
    Group,
    Interval,
    Metric,
    Output,
    Parameter,
    Quantity,
    Scenario,
    Sensor,
    System,
    Variant,
)

ANY = Interval(-np.inf, np.inf, True, True)
POSITIVE = Interval(0.0, np.inf, True, True)


def parameter(name: str, unit: str, default: float = 1.0, bounds: Interval = ANY) -> Parameter:
    return Parameter(name, unit, name, default=default, bounds=bounds, source="assumption: test")


def quantity(name: str, unit: str) -> Quantity:
    return Quantity(name, unit, name)


def cart() -> System:
    """A cart on a spring: a motor that saturates, a noisy sensor, a sampled law with memory and a continuous one."""
    x = Group("x", (quantity("place", "m"), quantity("speed", "m/s")))
    u, r = Group("u", (quantity("force", "N"),)), Group("r", (quantity("goal", "m"),))
    p = Group("p", tuple(parameter(*row) for row in (
        ("mass", "kg"), ("k", "N/m"), ("top", "N"), ("sigma", "m"), ("Ts", "s", 0.1, POSITIVE), ("fast", "m/s", 100.0),
    )))  # fmt: skip
    s = Group("s", (parameter("place_0", "m"), parameter("drift", "m/s")))
    c = Group("c", (parameter("gain", "N/m"), parameter("leak", "1")))
    c2 = Group("c", (parameter("gain", "N/m"), parameter("delay", "1", 0.0)))
    v, z = Group("v", (quantity("force_was", "N"),)), Group("z", (quantity("total", "m"), quantity("held", "N")))
    d = Derivation()
    spring = d.define("spring", -p.k * x.place, title="force of the spring", unit="N")
    rate = d.define("rate", (spring + u.force) / p.mass, title="acceleration")
    asked, hiss = quantity("asked", "N"), quantity("hiss", "1")
    sampled = Controller(
        "sum-law", "with memory", c, command=(c.gain * (r.goal - x.place + z.total),), period="Ts", applied=v, memory=z,
        start=(sp.S.Zero, c.gain * x.place), update=(c.leak * z.total + r.goal - x.place, v.force_was),
        warnings=(Condition(c.gain, "gain = {gain:g} N/m, and {0:g}", (c.leak,)),),
    )  # fmt: skip
    late = Controller("late", "one sample late", c2, (c2.gain * (r.goal - x.place),), period="Ts", delay="delay")
    smooth = Controller(
        "smooth", "continuous", Group("c", (parameter("gain", "N/m"),)), (c.gain * (r.goal - x.place),),
        constraints=(Condition(c.gain, "gain = {gain:g}"),),
        outputs=(Output(quantity("lag", "m"), r.goal - x.place),),
    )  # fmt: skip
    energy = p.mass * x.speed**2 / 2 + p.k * x.place**2 / 2
    return System(
        name="cart", title="a cart", source="test", structure={}, states=x, inputs=u, references=r,
        outputs=Group("y", (quantity("E", "J"),)), parameters=p, scenario_parameters=s, rhs=(x.speed, rate),
        output=(energy,), steps=tuple(d.steps), limits=(Condition(p.fast - x.speed, "faster than {fast:g} m/s"),),
        initial=(s.place_0, sp.S.Zero), reference=(s.drift * TIME.symbol,), constraints=(Condition(p.mass, "no mass"),),
        functions=(Function("energy", (x, p), ((quantity("E", "J"), energy),), "energy"),),
        controllers=(sampled, late, smooth), scenarios=(Scenario("plain", "plain", 1.0, 0.1, {"k": 2.0}, {}, {}),),
        metrics=(Metric("furthest", "max_abs", ("place",), unit="m", description=""),),
        actuator=Actuator(Group("u_cmd", (asked,)), (sp.Max(-p.top, sp.Min(p.top, asked.symbol)),)),
        sensor=Sensor(Group("e", (hiss,)), (x.place + p.sigma * hiss.symbol, x.speed)),
        choices=(Choice("spring", ("stiff", "none"), "with or without spring"),),
        variants=(Variant(("none",), (x.speed, u.force / p.mass), {}),),
        rates={"speed": sp.Symbol("speed_rate", real=True)},
        residual=(p.mass * sp.Symbol("speed_rate", real=True) - spring - u.force,),
    )  # fmt: skip


def turner() -> System:
    """A plane turner in polar coordinates with a regular chart, a projection and a law in the chart's inputs."""
    x = Group("x", (quantity("radius", "m"), quantity("angle", "rad")))
    u = Group("u", (quantity("out", "m/s"), quantity("round", "rad/s")))
    q, n = (
        Group("q", (quantity("a", "m"), quantity("b", "m"))),
        Group("n", (quantity("va", "m/s"), quantity("vb", "m/s"))),
    )
    p, c = Group("p", (parameter("wind", "m/s"),)), Group("c", (parameter("gain", "1/s"),))
    s, r = Group("s", (parameter("radius_0", "m"),)), Group("r", ())
    from_polar = (x.radius * sp.cos(x.angle), x.radius * sp.sin(x.angle))
    return System(
        name="turner", title="a turner", source="test", structure={}, states=x, inputs=u, references=r,
        outputs=Group("y", (quantity("height", "m"),)), parameters=p, scenario_parameters=s,
        rhs=(u.out + p.wind, u.round), output=(from_polar[1],), steps=(), limits=(), initial=(s.radius_0, sp.S.Zero),
        reference=(), constraints=(), functions=(), scenarios=(Scenario("plain", "plain", 1.0, 0.1, {}, {}, {}),),
        controllers=(Controller("inward", "to the middle", c, (-c.gain * q.a, -c.gain * q.b)),), metrics=(),
        coordinates=Coordinates(
            q, n, (n.va + p.wind * q.a / sp.sqrt(q.a**2 + q.b**2), n.vb + p.wind * q.b / sp.sqrt(q.a**2 + q.b**2)),
            from_polar,
            tuple(e.diff(x.radius) * u.out + e.diff(x.angle) * u.round for e in from_polar),
            (sp.sqrt(q.a**2 + q.b**2), sp.atan2(q.b, q.a)),
            ((q.a * n.va + q.b * n.vb) / sp.sqrt(q.a**2 + q.b**2), (q.a * n.vb - q.b * n.va) / (q.a**2 + q.b**2)),
        ),
    )  # fmt: skip


@dataclasses.dataclass(frozen=True)
class Edit:
    """An edit, its place, and the edited system."""

    path: tuple[str | int, ...]
    what: str
    system: System


def edits(base: System, generator: random.Random) -> Iterator[Edit]:
    """Yield random edits of a system, without end: of fields, rows, names, units, numbers, kinds."""
    places = list(_places(base, ()))
    while True:
        path, value = generator.choice(places)
        what, new = generator.choice(list(_changes(value, base, generator)))
        yield Edit(path, what, put(base, path, new))


def _places(value: Any, path: tuple[str | int, ...]) -> Iterator[tuple[tuple[str | int, ...], Any]]:
    """Yield every place of a value that can be edited; a system keeps the name of its folder."""
    if path and path != ("name",):
        yield path, value
    if dataclasses.is_dataclass(value):
        for field in dataclasses.fields(value):
            if field.init:
                yield from _places(getattr(value, field.name), (*path, field.name))
    elif isinstance(value, tuple) and not isinstance(value, str):
        for k, entry in enumerate(value):
            yield from _places(entry, (*path, k))


def _changes(value: Any, base: System, generator: random.Random) -> Iterator[tuple[str, Any]]:
    yield "nothing", None
    yield "a text", "text"
    yield "a number", 3
    if isinstance(value, tuple):
        yield "a list", list(value)
        yield "empty", ()
        yield "one dropped", value[:-1]
        yield "first dropped", value[1:]
        yield "reversed", value[::-1]
        yield "one twice", (*value, *value[-1:])
        yield "a zero more", (*value, sp.S.Zero)
    if isinstance(value, sp.Expr):
        for symbol in generator.sample(_symbols(base), 6):
            yield f"plus {symbol}", value + symbol
            yield f"now {symbol}", symbol
        for number in (
            sp.nan,
            sp.oo,
            sp.zoo,
            sp.I,
            sp.Float("nan"),
            0.5,
            "x + 1",
            sp.Matrix([1]),
            sp.Integer(1),
            sp.S.Zero,
        ):
            yield f"now {number}", number
        yield "of itself", value**2
    if isinstance(value, str):
        names = [q.name for group in _groups(base) for q in group] + [
            "",
            "x y",
            "double",
            "1a",
            "t",
            "Ä",
            "rhs",
            "v1",
            "np",
        ]
        for text in (
            *generator.sample(names, 4),
            value.upper(),
            "kg",
            "m/s",
            "kg^(1/2) m",
            "furlong",
            "1/(kg m)",
            "{nobody}",
        ):
            yield f"now {text!r}", text
    if isinstance(value, bool):
        yield "turned", not value
    if isinstance(value, Group):
        yield "another group", generator.choice(_groups(base))


def _groups(system: System) -> list[Group]:
    common = [
        system.states,
        system.inputs,
        system.references,
        system.outputs,
        system.parameters,
        system.scenario_parameters,
    ]
    return [*common, *(group for law in system.controllers for group in (law.parameters, law.memory, law.applied))]


def _symbols(system: System) -> list[sp.Symbol]:
    own = [symbol for group in _groups(system) for symbol in group.symbols]
    return [*own, *system.definitions, TIME.symbol, sp.Symbol("stranger"), *(sp.Symbol(s.name) for s in own[:4])]


def put(value: Any, path: tuple[str | int, ...], new: Any) -> Any:
    """Return a value with one changed place; dataclasses are constructed again, as a model would construct them."""
    if not path:
        return new
    head, *rest = path
    if isinstance(head, int):
        return (*value[:head], put(value[head], tuple(rest), new), *value[head + 1 :])
    return dataclasses.replace(value, **{head: put(getattr(value, head), tuple(rest), new)})
