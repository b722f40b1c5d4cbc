# SPDX-License-Identifier: Apache-2.0
"""Crafts with weights at the terms of one part: masses, energies, loads, rates, limits, measurements, definitions."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import sympy as sp
from sympy.logic.boolalg import Boolean

from mehvar.models.clock import with_clock
from mehvar.models.parts import (
    Accelerometer,
    Cable,
    Dipole,
    Drag,
    Eclipse,
    Engine,
    GravityGradient,
    GroundStation,
    Gyro,
    Magnetometer,
    Magnetorquer,
    Orbit,
    Part,
    Spacecraft,
    StarTracker,
    SunGravity,
    SunPressure,
    SunSensor,
    Tachometer,
    Tank,
    ThirdBody,
    Thruster,
    Wheel,
)
from mehvar.models.parts.environment.magnetism import MOST
from mehvar.models.parts.hub import Pulsed
from mehvar.models.parts.values import Parameters
from mehvar.models.system import Condition, Definition, Group, System
from mehvar.physics.machine import Ranges
from mehvar.physics.mutation import Tally, Term, Weights, run_terms, weighted
from tests.reference.reference_parts import Particles

from .compared import Compared
from .table import FUEL, HUB, PARTS, PUSH, SKEW, TURN

POOL, POOLED = 1000, "uses all weights"
"""Number of weights that are declared before it is known how many there are; more than any part has."""
METHODS = (
    "particle", "aggregates", "loads", "contribution", "rates", "power", "carried", "share", "events", "applied",
    "errors", "measured", "measures", "jumps",
)  # fmt: skip
"""Methods of parts whose terms have weights, each where a part has its own."""


MOUNTED = {"area": 0.5, "at": (0.3, 0.1, -0.2)}
PLATE = MOUNTED | {"normal": (2.0, 1.0, -2.0)}
FLYING: dict[str, Part] = {
    "gravity gradient": GravityGradient("a"),
    "dipole": Dipole("a", moment=(0.1, 0.2, 0.3)),
    "magnetorquer": Magnetorquer("a", axis=(1.0, 0.2, 0.4)),
    "drag of a sphere": Drag("a", **MOUNTED),
    "drag of a plate": Drag("a", **PLATE),
    "light on a sphere": SunPressure("a", **MOUNTED, scattered=0.3),
    "light on a plate": SunPressure("a", **PLATE, scattered=0.3),
    "third body": ThirdBody("a", mu=3.0, distance=4.0, rate=0.3, inclination=0.4, node=0.5, phase=0.6),
    "gravity of the Sun": SunGravity("a", mu=5.0, distance=7.0),
}  # fmt: skip
EARTH = {
    "mu": 2.0, "radius": 0.5, "spin": 0.3, "dipole": 1.0, "density": 0.5, "height": 0.6, "thinning": 1.0,
    "sunlight": 0.7, "ascension": 0.3, "declination": 0.2, "size": 1.5, "longitude": 0.4, "oblateness": 0.1,
    "third": -0.1, "fourth": 0.2,
}  # fmt: skip
"""An Earth so light and so near that every load is of the order of one."""
GAUSS = tuple((n, m, (-1) ** m * 4e8 / n, 3e8 / n if m else 0.0) for n in range(1, MOST + 1) for m in range(n + 1))
"""All coefficients, nT, each with an effect."""
AIR = ((0.1, 0.9), (0.2, 0.5), (0.5, 0.4), (0.9, 0.1))
ASSEMBLED = {
    "about the centre of mass": [PARTS["wheel"]],
    "by pulls": [PARTS["bob"], dataclasses.replace(PARTS["stout bob"], name="b")],
    "about O": [PARTS["modes"]],
    "by factors": [PARTS["tank with a bob"]],
    "at a point": [PARTS["pendulum by two angles"]],
}
"""Parts for each way to solve the equations of a hub."""
CHARTS = ("euler", "mrp")
LIMITED: dict[str, Part] = {
    "a thruster": Thruster("a", direction=SKEW, at=(0.1, 0.2, 0.3), limit=0.6, least=0.02),
    "a wheel": Wheel("a", axis=SKEW, inertia=0.2, torque_limit=0.4, speed_limit=0.5),
    "an engine": Engine("a", direction=SKEW, axis=(0.1, 1.0, 0.3), lag=0.2, limit=0.6, angle_limit=0.4),
    "a tank": Tank("a", **FUEL, flow=0.6, reserve=0.7),
}
NOISE = {"noise": 0.02, "walk": 0.3}
SEEING: dict[str, Sequence[Part]] = {
    "gyro": [Gyro("a", **NOISE, scale=(0.1, -0.2, 0.3), misalignment=(0.1, 0.2, -0.3))],
    "gyro that counts, late": [Gyro("a", **NOISE, step=0.1, every=3, dropout=0.5, delay=2)],
    "gyro that integrates": [Gyro("a", **NOISE, integrating=True, delay=1)],
    "accelerometer": [Accelerometer("a", **NOISE, at=(0.1, 0.2, 0.3))],
    "star tracker": [StarTracker("a", sigma=(0.1, 0.2, 0.3), blind=0.8)],
    "tachometer": [wheel := Wheel("b", axis=SKEW, inertia=0.2), Tachometer("a", of=wheel, sigma=0.1)],
}
SEEING_SKY: dict[str, Part] = {
    "star tracker in the sky": StarTracker("a", boresight=SKEW, exclusion=1.2, every=2),
    "Sun sensor": SunSensor("a", sigma=0.1),
    "magnetometer": Magnetometer("a", noise=0.1, every=2),
}
STATION = {"latitude": 0.4, "ascension": 0.3, "height": 0.1, "elevation": 0.2, "flattening": 0.1}
THIN, FIXED = ("density", "height", "thinning"), ("ascension", "declination")
SPANS = {"_fuel": (0.5, 1.0), "_angle_": (-3e-3, 3e-3)}
"""Ranges of states by a part of their names; to third order in the turn of a gyro, the error is then below 1e-12."""
PENUMBRA = 400
"""Points, of which some are in each part of the shadow."""


def around(*without: str, **fields: Any) -> Orbit:
    """Return an orbit about the light Earth, with some fields at their defaults and others given."""
    return Orbit("J4", **{name: value for name, value in EARTH.items() if name not in without} | fields)


@dataclasses.dataclass(frozen=True)
class Subject:
    """A craft, of which the terms of one part, or of all equations, are changed.

    Parameters
    ----------
    parts, orbit, motion, attitude
        Of the craft.
    part : str
        Name of the part; empty for all equations of the craft.
    points : int
        Number of points that reach all branches.
    """

    parts: Sequence[Part]
    part: str = "a"
    orbit: Orbit | None = None
    points: int = 12
    motion: str = "free"
    attitude: str = "quaternion"

    def tally(self, sample: int = 0) -> Tally:
        """Try the mutants of the part."""
        system, terms = craft(self.parts, self.part, self.orbit, self.motion, self.attitude)
        gates = Compared(Particles(self.parts, self.motion, self.orbit, attitude=self.attitude), start=not self.part)
        return run_terms(system, terms, ranges_of(system), gates, sample, self.points)


def subjects() -> dict[str, Subject]:
    """Return each part once at full size, on a hub that a force and a torque move."""
    base = (HUB, PUSH, TURN)
    ends = [dataclasses.replace(PARTS[name], name=end) for name, end in (("rod", "near"), ("tether", "far"))]
    cable = Cable("a", between=tuple(ends), length=0.9, stiffness=20.0, damping=0.3)  # type: ignore[arg-type]
    thruster = Thruster("a", direction=SKEW, at=(0.1, 0.2, 0.3))
    orbit, soft = around(), around(shadow="cone", disc=0.1)
    coil = Magnetorquer("a", axis=SKEW, limit=0.5)
    loads = [dataclasses.replace(part, name=f"load{k}") for k, part in enumerate(FLYING.values())]
    return {
        "hub": Subject(base, "hub"), "external force": Subject(base, "push"), "torquer": Subject(base, "turn"),
        "thruster": Subject((HUB, thruster)),
        **{name: Subject((*base, part)) for name, part in PARTS.items()},
        "cable": Subject((HUB, *ends, cable)),
        **{name: Subject((*base, part), orbit=orbit) for name, part in FLYING.items()},
        "orbit with all loads": Subject((*base, *loads), "orbit", orbit, PENUMBRA),
        "field of Gauss": Subject((HUB, FLYING["dipole"]), "orbit", around("dipole", harmonics=GAUSS, reference=0.8)),
        "table of the air": Subject((HUB, FLYING["drag of a sphere"]), "orbit", around(*THIN, air=AIR), 40),
        "shadow of a cone": Subject((HUB, FLYING["light on a sphere"]), "orbit", soft, PENUMBRA),
        "Sun of an epoch": Subject(
            (HUB, FLYING["light on a sphere"], dataclasses.replace(FLYING["gravity of the Sun"], name="sun")), "orbit",
            around(*FIXED, epoch=6e8, shadow="cone", disc=0.1), PENUMBRA,
        ),
        **{f"all equations, {name}": Subject((*base, *parts), "") for name, parts in ASSEMBLED.items()},
        "all equations, on an orbit": Subject((*base, FLYING["gravity gradient"]), "", orbit),
        "all equations, attitude only": Subject((*base, PARTS["wheel"]), "", motion="attitude"),
        **{f"all equations, {chart}": Subject((*base, coil), "", orbit, attitude=chart) for chart in CHARTS},
        **{f"star tracker, {chart}": Subject((HUB, StarTracker("a")), attitude=chart) for chart in CHARTS},
        **{f"limits of {name}": Subject((HUB, part), points=60) for name, part in LIMITED.items()},
        "limits of a magnetorquer": Subject((HUB, coil), orbit=orbit),
        "thruster that pulses": Subject((HUB, dataclasses.replace(thruster, limit=0.5, pulsed=True)), points=100),
        "magnetorquer that pulses": Subject((HUB, dataclasses.replace(coil, duty=0.7)), orbit=orbit, points=100),
        **{name: Subject((HUB, *parts), points=PENUMBRA) for name, parts in SEEING.items()},
        **{name: Subject((HUB, part), orbit=soft, points=PENUMBRA) for name, part in SEEING_SKY.items()},
        "eclipse": Subject((HUB, Eclipse("a")), orbit=orbit),
        "eclipse by a disc": Subject((HUB, Eclipse("a")), orbit=soft),
        "ground station": Subject((HUB, GroundStation("a", **STATION)), orbit=orbit),
    }  # fmt: skip


class _Bench:
    """Weights of a part, which are parameters of the craft while its equations are derived."""

    def __init__(self) -> None:
        self.weights, self.memos = Weights(), {}
        self.pool: list[sp.Symbol] = []

    def declare(self, parameters: Parameters) -> None:
        names = (f"weight_{k}" for k in range(POOL))
        self.pool = [parameters.add(name, 1.0, "1", "weight of a term", "(-inf, inf)") for name in names]

    def weigh(self, owner: str, value: Any) -> Any:
        """Return a result of a part's method with weights, the same for the same owner and term."""
        if isinstance(value, sp.MatrixBase):
            symmetric = value.shape[0] == value.shape[1]

            def entry(i: int, j: int) -> Any:
                pair = sorted((i, j)) if symmetric else (i, j)
                return self.weigh(f"{owner} {pair[0]}{pair[1]}", value[i, j])

            return sp.Matrix(*value.shape, entry)
        if isinstance(value, sp.Expr):
            return self.weights.weigh(owner, [value], memo=self.memos.setdefault(owner, {}))[0]
        if isinstance(value, Boolean) and value.args:
            return value.func(*(self.weigh(f"{owner} {k}", each) for k, each in enumerate(value.args)))
        if isinstance(value, tuple | list):
            return tuple(self.weigh(f"{owner} {k}", each) for k, each in enumerate(value))
        if isinstance(value, Mapping):
            return {key: self.weigh(f"{owner} {key}", each) for key, each in value.items()}
        if dataclasses.is_dataclass(value):
            given = {f.name: self.weigh(f"{owner}.{f.name}", getattr(value, f.name))
                     for f in dataclasses.fields(value) if f.init}  # fmt: skip
            return dataclasses.replace(value, **given)
        return value


def planted(part: Part, bench: _Bench) -> Part:
    """Return the part with weights at the terms of what its methods return."""
    own: Any = type(part)

    def weighed(name: str) -> Callable[..., Any]:
        def method(self: Any, at: Any, *arguments: Any) -> Any:
            return bench.weigh(name, getattr(super(kind, self), name)(at, *arguments))

        return method

    def values(self: Any, parameters: Parameters) -> Any:
        bench.declare(parameters)
        return super(kind, self).values(parameters)

    def limits(self: Any, at: Any) -> tuple[Condition, ...]:
        own = super(kind, self).limits(at)
        weighed = (
            dataclasses.replace(limit, margin=bench.weigh(f"limit {k}", limit.margin)) for k, limit in enumerate(own)
        )
        return (*weighed, Condition(sp.Add(*bench.pool), POOLED))

    names = [n for n in METHODS if getattr(own, n, None) is not getattr(Part, n, None)]
    kind: Any = type(
        own.__name__, (own,), {"values": values, "limits": limits} | {name: weighed(name) for name in names}
    )
    result: Any = object.__new__(kind)
    result.__dict__.update(vars(part))
    return result


def craft(
    parts: Sequence[Part], name: str, orbit: Orbit | None = None, motion: str = "free", attitude: str = "quaternion"
) -> tuple[System, Sequence[Term]]:
    """Derive a craft with weights at the terms of one part, which `name` states, or of all equations."""
    bench = _Bench()
    given = {part.name: planted(part, bench) if part.name == name else part for part in parts}
    for part in given.values():  # the ends of a cable are the parts that are mounted
        if hasattr(part, "between"):
            object.__setattr__(part, "between", tuple(given[end.name] for end in part.between))
    around = planted(orbit, bench) if orbit is not None and name == orbit.name else orbit
    whole = Spacecraft("craft", orbit=around, motion=motion, attitude=attitude)  # type: ignore[arg-type]
    for part in given.values():
        whole.add(part)
    if any(isinstance(part, Pulsed) and part.pulses for part in parts):
        whole.law("off", lambda law: {})
    system = whole.system()
    if not name:
        return weighted(with_clock(system))
    steps = tuple(
        dataclasses.replace(step, expr=bench.weights.weigh(step.symbol.name, [step.expr])[0])
        if isinstance(step, Definition) and step.symbol.name.startswith(f"{name}_")
        else step
        for step in system.steps
    )
    weights = set(bench.pool)
    kept = Group("p", tuple(q for q in system.parameters if q.symbol not in weights))
    functions = tuple(
        dataclasses.replace(f, arguments=tuple(kept if group.name == "p" else group for group in f.arguments))
        for f in system.functions
    )
    system = dataclasses.replace(
        system,
        steps=steps,
        parameters=kept,
        functions=functions,
        limits=tuple(limit for limit in system.limits if limit.message != POOLED),
    )
    return with_clock(system), bench.weights.terms


def ranges_of(system: System) -> Ranges:
    """Return ranges of states; parameters keep their defaults, at which the particles are."""
    drawn = [*system.states, *system.inputs]
    drawn += [q for each in (system.sensor, system.random_step) if each for q in each.noise]
    drawn += system.actuator.commanded if system.actuator else ()
    ranges = {q.name: next((v for end, v in SPANS.items() if end in q.name), (-1.0, 1.0)) for q in drawn}
    return ranges | {q.name: (float(q.default),) * 2 for q in system.parameters}
