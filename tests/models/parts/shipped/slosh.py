# SPDX-License-Identifier: Apache-2.0
"""The plant of slosh from parts, with every convention of the pendulums' inertia."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable
from dataclasses import dataclass

import sympy as sp

from mehvar.models.parts import (
    Aggregates,
    Bob,
    Chain,
    Coordinate,
    Hub,
    Link,
    Load,
    Part,
    Pendulum,
    Spacecraft,
    Torquer,
    point_inertia,
)
from mehvar.models.parts.part import Mounted
from mehvar.models.system import Expr, Quantity, System

from .rederived import Pair, Side, structured


@dataclass(frozen=True)
class Geared(Part):
    """The paper's pendulum: a bob by two angles, and rotors geared to these."""

    number: int
    mass: sp.Expr
    length: sp.Expr
    pivot: sp.Expr
    inertia: sp.Expr
    damping: sp.Expr

    def coordinates(self) -> tuple[Coordinate, ...]:
        k = self.number
        return tuple(
            Coordinate(Quantity(f"{n}{k}_dot", "rad/s", "rate"), Quantity(f"{n}{k}", "rad", "angle"))
            for n in ("phi", "theta")
        )

    def aggregates(self, at: Mounted) -> Aggregates:
        (phi, a), (theta, b) = ((c.place.symbol, c.speed.symbol) for c in self.coordinates() if c.place)
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

    def inputs(self) -> tuple[Quantity, ...]:
        return (Quantity("delta1", "rad", "gimbal 1"), Quantity("delta2", "rad", "gimbal 2"))

    def loads(self, at: Mounted) -> tuple[Load, ...]:
        d1, d2 = (q.symbol for q in self.inputs())
        force = self.force * sp.Matrix([sp.cos(d1) * sp.cos(d2), sp.sin(d2), -sp.sin(d1) * sp.cos(d2)])
        return (Load(force, sp.Matrix([-self.behind, 0, 0])),)


FORK = sp.Symbol("fork", positive=True)
"""Mass, kg, and moments of inertia, kg m^2, of the fork between two hinges; zero after the derivation."""


def geared(k: int, m: Expr, length: Expr, h: Expr, i: Expr, eps: Expr) -> Part:
    return Geared(f"bob{k}", k, m, length, h, i, eps)


def hinged(k: int, m: Expr, length: Expr, h: Expr, i: Expr, eps: Expr) -> Part:
    """Return a rigid bob on two hinges: about -x by a fork, and about the turned y axis."""
    fork = Link(FORK, (FORK,) * 3, axis=(-1, 0, 0), at=(h, 0, 0), damping=eps)
    return Chain(f"bob{k}", links=(fork, Link(m, (i,) * 3, axis=(0, 1, 0), centre=(-length, 0, 0), damping=eps)))


def ball(k: int, m: Expr, length: Expr, h: Expr, i: Expr, eps: Expr) -> Part:
    return Bob(f"bob{k}", m, length, (h, 0, 0), eps, i)


def jointed(k: int, m: Expr, length: Expr, h: Expr, i: Expr, eps: Expr) -> Part:
    """Return a bob on a universal joint, whose angles are those of a chart of the ball's directions."""
    return Pendulum(f"bob{k}", m, length, (0, 1, 0), (-1, 0, 0), (h, 0, 0), 2, eps, i)


NAMES = {
    "paper": {"phi{k}": "phi{k}", "theta{k}": "theta{k}", "phi{k}_dot": "phi{k}_dot", "theta{k}_dot": "theta{k}_dot"},
    "hinge": {
        "phi{k}": "bob{k}_2_angle", "theta{k}": "bob{k}_1_angle", "phi{k}_dot": "bob{k}_2_rate",
        "theta{k}_dot": "bob{k}_1_rate",
    },
    "ball": {f"{n}{{k}}{i}": f"bob{{k}}_{m}{i}" for n, m in (("s", "e"), ("sigma", "u")) for i in "xyz"},
}  # fmt: skip
"""Shipped states of pendulum k, and those of its part."""
PENDULUMS = {"paper": geared, "hinge": hinged, "ball": ball}
ANGLES = {"att1": "roll", "att2": "pitch", "att3": "yaw"}


def assembled(shipped: System, pendulum: Callable[..., Part]) -> System:
    """Assemble hull, fixed fuel, pendulums, moments and thrust with the shipped parameters."""
    structure = shipped.structure
    craft = Spacecraft("slosh", attitude={"angles": "euler"}.get(structure["attitude"], "quaternion"))
    given = (q for q in shipped.parameters if not q.name.endswith("_max"))
    p = {q.name: craft.parameter(q.name, q.default, q.unit, q.description, str(q.bounds)) for q in given}
    if pendulum is hinged:
        craft.parameter(FORK.name, 1.0, "kg", "fork", "(0, inf)")
    craft.add(Hub("hull", p["m"], (p["J_x"], p["J_y"], p["J_z"]), (-p["b"], 0, 0)))
    craft.add(Hub("fuel", p["m0"], (p["I0"],) * 3, (-p["h0"], 0, 0)))
    for k in range(1, int(structure["pendulums"]) + 1):
        craft.add(pendulum(k, *(p[f"{n}{k}"] for n in ("m", "l", "h", "I", "eps"))))
    craft.add(Torquer("M"))
    craft.add(Gimballed("engine", p["F"], p["b"] + p["d"]))
    form, light = craft.system(), {FORK: sp.S.Zero}
    steps = tuple(dataclasses.replace(step, expr=step.expr.xreplace(light)) for step in form.definitions_in_order)
    return dataclasses.replace(form, steps=steps, rhs=tuple(e.xreplace(light) for e in form.rhs))


@functools.cache
def forms(pendulums: str, inertia: str, attitude: str) -> list[Pair]:
    """Return the shipped form beside the parts of its convention, and beside other parts where it uses these itself."""
    shipped = structured("slosh", pendulums=pendulums, inertia=inertia, attitude=attitude)
    first = turned(shipped) if attitude == "angles" else named(shipped)
    return [first, charted(shipped)] if inertia == "ball" else [first]


def named(shipped: System) -> Pair:
    """Return the pair of forms that have the same states under other names, without the attitude of small angles."""
    inertia, count = shipped.structure["inertia"], int(shipped.structure["pendulums"])
    names = {s.format(k=k): a.format(k=k) for k in range(1, count + 1) for s, a in NAMES[inertia].items()}
    names |= attitude(shipped)
    other = Side(assembled(shipped, PENDULUMS[inertia]), {a: _symbol(s) for s, a in names.items()})
    kept = [q.name for q in shipped.states if not q.name.startswith("att")]
    return Pair(Side(shipped), other, {n: (_symbol(n), _symbol(names.get(n, n))) for n in kept})


def turned(shipped: System) -> Pair:
    """Return the pair of its variant with 3-2-1 angles, as a system of its own."""
    (variant,) = (v for v in shipped.variants if v.values == ("full", "euler"))
    euler = dataclasses.replace(shipped, rhs=variant.rhs, variants=(), choices=())
    pair = named(euler)
    return dataclasses.replace(
        pair, readings={**pair.readings, **{s: (_symbol(s), _symbol(a)) for s, a in ANGLES.items()}}
    )


def attitude(shipped: System) -> dict[str, str]:
    """Return the names of the angles of the attitude by those of the shipped system."""
    return ANGLES if shipped.structure["attitude"] == "angles" else {}


def charted(shipped: System) -> Pair:
    """Return the pair of bobs on ball joints and pendulums on universal joints, in the angles of the latter."""
    count, rate = int(shipped.structure["pendulums"]), sp.Matrix([_symbol(f"w{i}") for i in "xyz"])
    at = {}
    for k in range(1, count + 1):
        (a, b), speeds = ([_symbol(f"bob{k}_{n}{j}") for j in "12"] for n in ("angle", "rate"))
        rod = sp.Matrix([-sp.cos(a) * sp.cos(b), -sp.sin(b), sp.sin(a) * sp.cos(b)])
        turning = rod.jacobian([a, b]) * sp.Matrix(speeds) + rate.cross(rod)
        at |= {f"{n}{k}{i}": e for n, v in (("s", rod), ("sigma", turning)) for i, e in zip("xyz", v, strict=True)}
    other = Side(assembled(shipped, jointed), {a: _symbol(s) for s, a in attitude(shipped).items()})
    kept = (q.name for q in shipped.states if not q.name.startswith("att"))
    return Pair(Side(shipped, at), other, {n: (_symbol(n), at.get(n, _symbol(n))) for n in kept})


def _symbol(name: str) -> sp.Symbol:
    return sp.Symbol(name, real=True)
