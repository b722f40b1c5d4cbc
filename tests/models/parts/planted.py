# SPDX-License-Identifier: Apache-2.0
"""Crafts of which one part has a weight at each term of its masses, energies, loads, rates and definitions."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import sympy as sp

from mehvar.models.clock import with_clock
from mehvar.models.parts import (
    Cable,
    Dipole,
    Drag,
    GravityGradient,
    Magnetorquer,
    Orbit,
    Part,
    Spacecraft,
    SunGravity,
    SunPressure,
    ThirdBody,
    Thruster,
)
from mehvar.models.parts.values import Parameters
from mehvar.models.system import Condition, Definition, Group, System
from mehvar.physics.gates import Gate, balance, identity
from mehvar.physics.machine import Machine, Points, Ranges
from mehvar.physics.mutation import Tally, Term, Weights, run_terms
from tests.reference.reference_parts import Particles

from .table import HUB, PARTS, PUSH, SKEW, TURN

POOL = 1000
"""Number of weights that are declared before it is known how many there are; more than any part has."""
PARTICLES = "accelerations of particles"
READINGS = "energy and momentum of particles"


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


@dataclasses.dataclass(frozen=True)
class Subject:
    """A craft, of which the terms of one part are changed, and the number of points that reach its branches."""

    parts: Sequence[Part]
    part: str = "a"
    orbit: Orbit | None = None
    points: int = 12

    def tally(self, sample: int = 0) -> Tally:
        """Try the mutants of the part."""
        system, terms = craft(self.parts, self.part, self.orbit)
        gates = gates_of(Particles(self.parts, orbit=self.orbit))
        return run_terms(system, terms, ranges_of(system), gates, sample, self.points)


def subjects() -> dict[str, Subject]:
    """Return each part once at full size, on a hub that a force and a torque move."""
    base = (HUB, PUSH, TURN)
    ends = [dataclasses.replace(PARTS[name], name=end) for name, end in (("rod", "near"), ("tether", "far"))]
    cable = Cable("a", between=tuple(ends), length=0.9, stiffness=20.0, damping=0.3)  # type: ignore[arg-type]
    thruster = Thruster("a", direction=SKEW, at=(0.1, 0.2, 0.3))
    orbit = Orbit("J4", **EARTH)  # type: ignore[arg-type]
    loads = [dataclasses.replace(part, name=f"load{k}") for k, part in enumerate(FLYING.values())]
    return {
        "hub": Subject(base, "hub"), "external force": Subject(base, "push"), "torquer": Subject(base, "turn"),
        "thruster": Subject((HUB, thruster)),
        **{name: Subject((*base, part)) for name, part in PARTS.items()},
        "cable": Subject((HUB, *ends, cable)),
        **{name: Subject((*base, part), orbit=orbit) for name, part in FLYING.items()},
        "orbit with all loads": Subject((*base, *loads), "orbit", orbit, 400),
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
        if isinstance(value, tuple | list):
            return tuple(self.weigh(f"{owner} {k}", each) for k, each in enumerate(value))
        if dataclasses.is_dataclass(value):
            given = {f.name: self.weigh(f"{owner}.{f.name}", getattr(value, f.name))
                     for f in dataclasses.fields(value)}  # fmt: skip
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
        return (Condition(sp.Add(*bench.pool), "uses all weights"),)

    names = ["aggregates", "loads"]
    names += [n for n in ("contribution", "rates", "power", "carried") if getattr(own, n) is not getattr(Part, n)]
    kind: Any = type(
        own.__name__, (own,), {"values": values, "limits": limits} | {name: weighed(name) for name in names}
    )
    result: Any = object.__new__(kind)
    result.__dict__.update(vars(part))
    return result


def craft(
    parts: Sequence[Part], name: str, orbit: Orbit | None = None, motion: str = "free"
) -> tuple[System, list[Term]]:
    """Derive a craft with weights at the terms of one part, which `name` states."""
    bench = _Bench()
    given = {part.name: planted(part, bench) if part.name == name else part for part in parts}
    for part in given.values():  # the ends of a cable are the parts that are mounted
        if hasattr(part, "between"):
            object.__setattr__(part, "between", tuple(given[end.name] for end in part.between))
    around = planted(orbit, bench) if orbit is not None and name == orbit.name else orbit
    whole = Spacecraft("craft", orbit=around, motion=motion)  # type: ignore[arg-type]
    for part in given.values():
        whole.add(part)
    system = whole.system()
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
    system = dataclasses.replace(system, steps=steps, parameters=kept, functions=functions, limits=())
    return with_clock(system), bench.weights.terms


def ranges_of(system: System) -> Ranges:
    """Return ranges of states; parameters keep their defaults, at which the particles are."""
    ranges = {q.name: (0.5, 1.0) if q.name.endswith("_fuel") else (-1.0, 1.0) for q in (*system.states, *system.inputs)}
    return ranges | {q.name: (float(q.default),) * 2 for q in system.parameters}


def gates_of(world: Particles) -> Callable[[Machine], list[Gate]]:
    """Return the balances of every craft, and the comparison with particles."""
    memory: dict[tuple[str, bytes], np.ndarray] = {}

    def particles(at: Points, what: str) -> np.ndarray:
        key = what, at.values["x"].tobytes()
        if key not in memory:
            system, rows = at.machine.system, []
            for k in range(len(at.values["x"])):
                x, u = (dict(zip([q.name for q in group], at.values[group.name][k], strict=False))
                        for group in (system.states, system.inputs))  # fmt: skip
                rates = world.rates(x, u) if what == "rates" else {}
                rows.append([rates[q.name] for q in system.states] if rates else world.readings(x, u))
            memory[key] = np.array(rows)
        return memory[key]

    def triple(at: Points, start: str) -> np.ndarray:
        known = {q.name for q in at.machine.system.states}
        return np.stack([at[n] if (n := f"{start}{a}") in known else 0 * at["wx"] for a in "xyz"], axis=-1)

    def supply(at: Points) -> np.ndarray:
        v, w, momentum = triple(at, "v"), triple(at, "w"), at.call("momentum")
        linear, angular = momentum[:, :3], momentum[:, 3:]
        turned = np.hstack([np.cross(w, linear), np.cross(w, angular) + np.cross(v, linear)])
        return at.call("loads") - turned

    def gates(machine: Machine) -> list[Gate]:
        return [  # the fastest first
            identity(PARTICLES, lambda at: at.call("rhs"), lambda at: particles(at, "rates")),
            identity(READINGS, lambda at: np.hstack([at.call("energy"), at.call("momentum")]),
                     lambda at: particles(at, "readings")),
            balance("momentum", lambda at: at.call("momentum"), supply),
            balance("energy", lambda at: at.call("energy"), lambda at: at.call("power")),
        ]  # fmt: skip

    return gates
