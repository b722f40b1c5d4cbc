# SPDX-License-Identifier: Apache-2.0
"""The plant of slosh, assembled from parts beside the forms derived by hand."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np
import pytest
import sympy as sp

from mehvar.codegen.code.files import printed_functions
from mehvar.codegen.equal.equality import EqualityTest
from mehvar.codegen.equal.meaning import Meaning
from mehvar.codegen.equal.pool import Pool
from mehvar.codegen.equal.reals import PointSampler
from mehvar.codegen.functions.graphs import generate_functions
from mehvar.codegen.ledger.sides import Sides
from mehvar.models.parts import (
    Aggregates,
    Coordinate,
    Hub,
    Load,
    Part,
    Spacecraft,
    Torquer,
    point_inertia,
)
from mehvar.models.system import Quantity, System
from tests.derived import system

ROUNDING = 1e-12
"""Over the largest rate: rounding of both, some hundred operations."""


def rhs(of: System, name: str = "rhs") -> ca.Function:
    return next(f.graph for f in generate_functions(of) if f.name == name)


def operations(of: System, name: str = "rhs") -> int:
    """Return the operations of a call that depend on state or input, and those on the input alone."""
    functions = {f.name: f for f in printed_functions([f for f in generate_functions(of) if f.name == name])}
    return sum(functions[n].operations for n in (f"{name}_prepared", f"{name}_hold") if n in functions)


@dataclass(frozen=True)
class Geared(Part):
    """The paper's pendulum: a bob by two angles, and rotors geared to these."""

    number: int
    mass: sp.Expr
    length: sp.Expr
    pivot: sp.Expr
    inertia: sp.Expr
    damping: sp.Expr

    def coordinates(self):
        k = self.number
        return tuple(
            Coordinate(Quantity(f"{n}{k}_dot", "rad/s", "rate"), Quantity(f"{n}{k}", "rad", "angle"))
            for n in ("phi", "theta")
        )

    def aggregates(self, at):
        (phi, a), (theta, b) = ((c.place.symbol, c.speed.symbol) for c in self.coordinates())
        (c1, s1), (c2, s2) = at.frame.circle(phi), at.frame.circle(theta)
        rod = sp.Matrix([-c1, s1 * s2, s1 * c2])
        place = sp.Matrix([self.pivot, 0, 0]) + self.length * rod
        moving = self.length * (a * sp.Matrix([s1, c1 * s2, c1 * c2]) + b * sp.Matrix([0, s1 * c2, -s1 * s2]))
        rotors = self.inertia * sp.Matrix([a, 0, b])
        squared = self.mass * self.length**2 * (a**2 + s1**2 * b**2) + self.inertia * (a**2 + b**2)
        return Aggregates(
            self.mass, self.mass * place, point_inertia(self.mass, place) + self.inertia * sp.eye(3),
            self.mass * moving, self.mass * place.cross(moving) + rotors, squared / 2,
            forces=(-self.damping * a, -self.damping * b),
        )  # fmt: skip


@dataclass(frozen=True)
class Gimballed(Part):
    """A thrust on two gimbals."""

    force: sp.Expr
    behind: sp.Expr

    def inputs(self):
        return (Quantity("delta1", "rad", "gimbal 1"), Quantity("delta2", "rad", "gimbal 2"))

    def loads(self, at):
        d1, d2 = (q.symbol for q in self.inputs())
        force = self.force * sp.Matrix([sp.cos(d1) * sp.cos(d2), sp.sin(d2), -sp.sin(d1) * sp.cos(d2)])
        return (Load(force, sp.Matrix([-self.behind, 0, 0])),)


def slosh() -> System:
    craft, shipped = Spacecraft("slosh", attitude="euler"), {q.name: q for q in system("slosh").parameters}
    p = {n: craft.parameter(n, q.default, q.unit, q.description) for n, q in shipped.items() if not n.endswith("_max")}
    craft.add(Hub("hull", p["m"], (p["J_x"], p["J_y"], p["J_z"]), (-p["b"], 0, 0)))
    craft.add(Hub("fuel", p["m0"], (p["I0"],) * 3, (-p["h0"], 0, 0)))
    for k in (1, 2):
        craft.add(Geared(f"bob{k}", k, *(p[f"{n}{k}"] for n in ("m", "l", "h", "I", "eps"))))
    craft.add(Torquer("M"))
    craft.add(Gimballed("engine", p["F"], p["b"] + p["d"]))
    return craft.system()


def agree(assembled: System, shipped: System, renamed: dict[str, str]) -> None:
    """Compare all rates at random states, inputs and parameters; Euler angles are the chart of both."""
    f, g = rhs(assembled), rhs(shipped, "rhs_euler")
    names = [[renamed.get(q.name, q.name) for q in assembled.states], [q.name for q in shipped.states]]
    rng = np.random.default_rng(1)
    for _ in range(20):
        x = dict(zip(names[1], rng.uniform(-1.2, 1.2, len(names[1])), strict=True))
        u = rng.normal(size=5)
        p = {q.name: float(q.default) * rng.uniform(0.6, 1.6) for q in shipped.parameters}
        ours = f([x[n] for n in names[0]], u, [p[q.name] for q in assembled.parameters]).full().ravel()
        theirs = g(list(x.values()), u, list(p.values())).full().ravel()
        result, expected = dict(zip(names[0], ours, strict=True)), dict(zip(names[1], theirs, strict=True))
        assert max(abs(result[n] - expected[n]) for n in names[1]) < ROUNDING * max(map(abs, theirs))


NAMES = {"roll": "att1", "pitch": "att2", "yaw": "att3"}


@pytest.mark.soak
def test_the_plant_of_slosh_is_the_assembled_one():
    """It takes 1.71 times the operations: pendulums by angles are eliminated without what is special to a bob."""
    assembled, shipped = slosh(), system("slosh")
    agree(assembled, shipped, NAMES)
    assert operations(assembled) <= 1.75 * operations(shipped, "rhs_euler")


def meaning(pool: Pool, of: System) -> tuple[Meaning, dict[str, int]]:
    """Return the meanings of names in a system, and its rates by state."""
    sides, definitions, nodes = Sides(pool), {s.name: e for s, e in of.definitions.items()}, {}

    def target(name: str):
        if name not in definitions:
            return None
        if name not in nodes:
            nodes[name] = sides.entries(definitions[name])[0]
        return result, nodes[name]

    result = Meaning(pool, target)
    rows = zip(of.states, of.rhs, strict=True)
    return result, {q.name: sides.entries(entry)[0] for q, entry in rows}


def test_the_accelerations_of_slosh_are_the_assembled_ones_exactly():
    """As functions of states, inputs and parameters: in a finite field, where nothing rounds."""
    pool, assembled, shipped = Pool(), slosh(), system("slosh")
    (new, ours), (old, theirs) = meaning(pool, assembled), meaning(pool, shipped)
    positive = {q.name for q in shipped.parameters if q.positive}
    judge = EqualityTest(pool, positive.__contains__, PointSampler({}, frozenset()))
    names = [q.name for q in shipped.states if not q.name.startswith("att")]
    assert [judge.same_in_field((old, theirs[n]), (new, ours[n])) for n in names] == [True] * len(names)
