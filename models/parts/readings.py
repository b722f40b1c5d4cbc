# SPDX-License-Identifier: Apache-2.0
"""Functions of an assembly that its gates compare: energy and momentum, and what changes them."""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from ..derivation import Expr
from ..quantities import Group, Quantity
from ..system import Function
from .frame import AXES
from .part import Aggregates, Mounted, Part

_WRENCH = (*(f"p{axis}" for axis in AXES), *(f"h{axis}" for axis in AXES))


def readings(
    parts: Sequence[Part], mounted: Sequence[Mounted], velocity: sp.Matrix, groups: Sequence[Group]
) -> tuple[Function, ...]:
    """Return energy, momentum, power and loads of an assembly, from the aggregates and loads of its parts.

    Parameters
    ----------
    parts, mounted : sequence of Part and of Mounted
        The parts in their assembly.
    velocity : sympy.Matrix
        Of O in the axes of the hub.
    groups : sequence of Group
        States, inputs and parameters.
    """
    x, u, p = groups
    v, w = velocity, mounted[0].frame.rate
    energy: Expr = sp.S.Zero
    power: Expr = sp.S.Zero
    momentum, angular, force, moment = (sp.zeros(3, 1) for _ in range(4))
    for part, at in zip(parts, mounted, strict=True):
        of = part.aggregates(at)
        linear, turning = of.mass * v + w.cross(of.first) + of.momentum, of.first.cross(v) + of.inertia * w + of.angular
        momentum, angular = momentum + linear, angular + turning
        energy += (v.dot(linear + of.momentum) + w.dot(turning + of.angular)) / 2 + of.energy + of.potential
        power += _internal(part, of)
        for load in part.loads(at):
            force, moment = force + load.force, moment + load.at.cross(load.force) + load.couple
    power += v.dot(force) + w.dot(moment)
    return (
        _scalar("energy", "J", "kinetic and potential energy", energy, (x, p)),
        _wrench(
            "momentum", ("kg m/s", "kg m^2/s"), "momentum, and angular momentum about O", (*momentum, *angular), (x, p)
        ),
        _scalar("power", "W", "power of loads, motors and dampers", power, (x, u, p)),
        _wrench("loads", ("N", "N m"), "applied force, and moment about O", (*force, *moment), (x, u, p)),
    )


def _internal(part: Part, of: Aggregates) -> Expr:
    """Return the power of a part's motors and dampers."""
    speeds = [c.speed.symbol for c in part.coordinates()]
    return of.power + sp.Add(*(f * s for f, s in zip(of.forces, speeds, strict=bool(of.forces))))


def _scalar(name: str, unit: str, title: str, value: Expr, arguments: tuple[Group, ...]) -> Function:
    return Function(name, arguments, ((Quantity(name, unit, title), value),), title)


def _wrench(
    name: str, units: tuple[str, str], title: str, values: Sequence[Expr], arguments: tuple[Group, ...]
) -> Function:
    results = tuple(
        (Quantity(f"{name}_{label}", units[k // 3], f"{title}, {label}"), value)
        for k, (label, value) in enumerate(zip(_WRENCH, values, strict=True))
    )
    return Function(name, arguments, results, title, vector=name)
