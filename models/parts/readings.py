# SPDX-License-Identifier: Apache-2.0
"""Energy and momentum, and the powers and loads that change them; physics gates compare both."""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from ..derivation import Expr
from ..quantities import Group, Quantity
from ..system import Function
from .frame import AXES
from .motion import Motion
from .part import Craft
from .terms import Aggregates, Load, Moments

_WRENCH = (*(f"p{axis}" for axis in AXES), *(f"h{axis}" for axis in AXES))


def readings(craft: Craft, motions: Sequence[Motion], velocity: sp.Matrix | None, plane: bool) -> tuple[Function, ...]:
    """Return energy, momentum, power and loads of an assembly from its parts; their arguments are empty groups.

    Parameters
    ----------
    craft : Craft
        The assembly.
    motions : sequence of Motion
        Of its parts.
    velocity : sympy.Matrix, optional
        Velocity of O in hub axes. None if only the attitude is a state: energy and momentum are then relative to the
        centre of mass, and loads are a moment about it.
    plane : bool
        True for motion in the plane of x and y; other components are omitted.
    """
    x, u, p = (Group(name, ()) for name in "xup")
    w, loads = craft.frame.rate, craft.loads()
    aggregates = [part.total(at) for part, at in craft.parts]
    force, moment = _summed(loads)
    whole = Moments.whole(aggregates)
    v = -(w.cross(whole.first) + whole.momentum) / whole.mass if velocity is None else velocity
    power: Expr = v.dot(force) + w.dot(moment)
    for (part, at), motion in zip(craft.parts, motions, strict=True):
        load, supply = part.carried(at, v)
        loads.append(load)
        power += supply + part.power(at, motion)
    force, moment = _summed(loads)
    if velocity is None:
        force, moment = sp.zeros(3, 1), moment - (whole.first / whole.mass).cross(force)
    energy, momentum, angular = totals(aggregates, v, w)
    if velocity is None:
        momentum = sp.zeros(3, 1)
    wrenches = [[*momentum, *angular], [*force, *moment]]
    if plane:
        wrenches = [[entry if k in (0, 1, 5) else sp.S.Zero for k, entry in enumerate(wrench)] for wrench in wrenches]
    point = "the centre of mass" if velocity is None else "O"
    return (
        _scalar("energy", "J", "kinetic and potential energy", energy, (x, p)),
        _wrench(
            "momentum", ("kg m/s", "kg m^2/s"), f"momentum, and angular momentum about {point}", wrenches[0], (x, p)
        ),
        _scalar("power", "W", "power of loads, motors and dampers", power, (x, u, p)),
        _wrench("loads", ("N", "N m"), f"applied force, and moment about {point}", wrenches[1], (x, u, p)),
    )


def _summed(loads: Sequence[Load]) -> tuple[sp.Matrix, sp.Matrix]:
    """Return the force of loads, and their moment about O."""
    moment = sum((load.at.cross(load.force) + load.couple for load in loads), sp.zeros(3, 1))
    return sum((load.force for load in loads), sp.zeros(3, 1)), moment


def totals(aggregates: Sequence[Aggregates], velocity: sp.Matrix, rate: sp.Matrix) -> tuple[Expr, sp.Matrix, sp.Matrix]:
    """Return the parts' energy, momentum and angular momentum about O."""
    v, w, energy = velocity, rate, sp.S.Zero
    momentum, angular = sp.zeros(3, 1), sp.zeros(3, 1)
    for of in aggregates:
        linear, turning = of.mass * v + w.cross(of.first) + of.momentum, of.first.cross(v) + of.inertia * w + of.angular
        momentum, angular = momentum + linear, angular + turning
        energy += (v.dot(linear + of.momentum) + w.dot(turning + of.angular)) / 2 + of.energy + of.potential
    return energy, momentum, angular


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
