# SPDX-License-Identifier: Apache-2.0
"""Contents of the tanks after some fuel is burnt, and the lines through which it leaves.

All tanks are filled alike: a part of the fuel that is burnt, the share, gives the sloshing mass and the length of every
pendulum by two tables. What sloshes no more and is not burnt lies with the fixed fuel. Moments of inertia go with their
masses.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import sympy as sp

from ...system import Derivation, Expr, Group, Parameter, Quantity
from ..states import Pendulum, renumbered

BURNT = Quantity("burnt", "kg", "fuel burnt since the start", "m_b")
PLACES = ("y", "z")


@dataclass(frozen=True)
class Present(Group):
    """Parameters at present: masses and arms as the burnt fuel leaves them.

    Parameters
    ----------
    values : mapping of str to Expr
        By the names of these parameters.
    """

    values: Mapping[str, Expr] = field(default_factory=dict)

    def __getattr__(self, name: str) -> object:
        values = object.__getattribute__(self, "values")
        return values[name] if name in values else super().__getattr__(name)


@dataclass(frozen=True)
class Lump:
    """Fuel in one place, and how it leaves.

    Attributes
    ----------
    mass, inertia : Expr
        Fuel and inertia, kg and kg m^2.
    out, out_rate : Expr
        Fuel that leaves it, kg/s, and its rate, kg/s^2.
    inertia_rate : Expr
        kg m^2/s.
    """

    mass: Expr
    inertia: Expr
    out: Expr
    out_rate: Expr
    inertia_rate: Expr


@dataclass(frozen=True)
class Tank:
    """A pendulum whose fuel drains.

    Attributes
    ----------
    bob : Pendulum
        What it is at present.
    pivot : sympy.Matrix
        From O, m.
    fuel : Lump
        What sloshes.
    length_rate, length_change : Expr
        l', m/s, and l'', m/s^2.
    """

    bob: Pendulum
    pivot: sp.Matrix
    fuel: Lump
    length_rate: Expr
    length_change: Expr


@dataclass(frozen=True)
class Fuel:
    """All fuel at present.

    Attributes
    ----------
    share : Expr
        Part that is burnt.
    sloshing, reach : Expr
        Sloshing mass and length of the pendulums, over those of full tanks.
    fixed : Lump
        What does not slosh.
    tanks : tuple of Tank
        What does.
    """

    share: Expr
    sloshing: Expr
    reach: Expr
    fixed: Lump
    tanks: tuple[Tank, ...]


def place_parameters(count: int, tables: Mapping[str, Group]) -> tuple[Parameter, ...]:
    """Return where the pivots stand off the axis, y and z of each pendulum."""
    places = []
    for k in range(1, count + 1):
        model = min(k, 2)
        places += [renumbered(q, model, k) for q in tables[f"place{model}"] if isinstance(q, Parameter)]
    return tuple(places)


def drained(p: Group, pendulums: Sequence[Pendulum], d: Derivation) -> Fuel:
    """Define what the tanks hold at present.

    Parameters
    ----------
    p : Group
        Parameters of the plant.
    pendulums : sequence of Pendulum
        Parameters of each with full tanks.
    d : Derivation
        Receives the steps.
    """
    d.section("Fuel")
    sloshing = sp.Add(*(a.mass for a in pendulums))
    whole = d.define("m_fuel", p.m0 + sloshing, title="all fuel at the start", unit="kg", latex="m_f")
    share = d.define("share", BURNT.symbol / whole, title="part of the fuel that is burnt", unit="1", latex=r"\beta")
    pace = d.define("share_rate", p.flow / whole, title="rate of the burnt part", unit="1/s", latex=r"\dot\beta")
    mass, arm = p.mass_part(share), p.arm_part(share)
    part, part_1, part_2 = (
        d.define(f"part{k}", value, title=title, unit="1", latex=latex)
        for k, value, title, latex in (
            (0, mass, "sloshing mass over that of the full tank", r"\mu"),
            (1, mass.diff(share), "its slope over the burnt part", r"\mu'"),
            (2, mass.diff(share, 2), "its curvature", r"\mu''"),
        )
    )
    reach, reach_1, reach_2 = (
        d.define(f"reach{k}", value, title=title, unit="1", latex=latex)
        for k, value, title, latex in (
            (0, arm, "length of the pendulums over that of the full tank", r"\lambda"),
            (1, arm.diff(share), "its slope over the burnt part", r"\lambda'"),
            (2, arm.diff(share, 2), "its curvature", r"\lambda''"),
        )
    )
    tanks = []
    for a in pendulums:
        k = a.name

        def name(text: str, value: Expr, title: str, unit: str, latex: str, k: str = k) -> sp.Symbol:
            return d.define(f"{text}{k}", value, title=f"{title} {k}", unit=unit, latex=f"{latex}_{{{k}}}")

        bob = Pendulum(
            k,
            name("mass", a.mass * part, "sloshing mass of tank", "kg", "m"),
            name("length", a.length * reach, "length of pendulum", "m", "l"),
            a.pivot,
            name("inertia", a.inertia * part, "moment of inertia of pendulum", "kg m^2", "I"),
            a.damping,
        )
        fuel = Lump(
            bob.mass,
            bob.inertia,
            name("out", -a.mass * part_1 * pace, "fuel that leaves bob", "kg/s", "w"),
            name("out_rate", -a.mass * part_2 * pace**2, "its rate, bob", "kg/s^2", r"\dot w"),
            name("inertia_rate", a.inertia * part_1 * pace, "rate of the inertia of pendulum", "kg m^2/s", r"\dot I"),
        )
        pivot = sp.Matrix([a.pivot, *(getattr(p, f"{axis}{k}") for axis in PLACES)])
        length_rate = name("length_rate", a.length * reach_1 * pace, "rate of the length of pendulum", "m/s", r"\dot l")
        change = name("length_change", a.length * reach_2 * pace**2, "l'' of pendulum", "m/s^2", r"\ddot l")
        tanks.append(Tank(bob, pivot, fuel, length_rate, change))
    rest = d.define(
        "m0_now",
        p.m0 + sloshing * (1 - part) - BURNT.symbol,
        title="fuel that does not slosh",
        unit="kg",
        latex="m_0(t)",
    )
    gyration = d.define("k0_sq", p.I0 / p.m0, title="I_0 over m_0 of the full tank", unit="m^2", latex="k_0^2")
    out = d.define(
        "out0", p.flow - sp.Add(*(t.fuel.out for t in tanks)), title="fuel that leaves what is fixed", unit="kg/s"
    )
    fixed = Lump(
        rest,
        d.define("I0_now", gyration * rest, title="moment of inertia of the fixed fuel", unit="kg m^2", latex="I_0(t)"),
        out,
        -sp.Add(*(t.fuel.out_rate for t in tanks)),
        -gyration * out,
    )
    return Fuel(share, part, reach, fixed, tuple(tanks))
