# SPDX-License-Identifier: Apache-2.0
"""The equations of motion with draining tanks anywhere in the hull, as machines evaluate them: O(N).

A bob on its ball joint is solved for first. With D = m l^2 + I, k = m l/D and the acceleration a_P of its pivot

    sigma' + Omega x sigma = -k a_P + w + (k a_P.s - |sigma|^2 - w.s) s,
    w = (m l Gamma r + I Gamma s - eps s')/D - 2 k l' sigma,

so it pulls at its pivot as a mass m I/D, a mass m l k along its arm, and forces without accelerations. What is left are
six equations for a = V' + Omega x V of O and Omega'.

Fuel that leaves a bob or the fixed fuel flows along a straight line, which holds none, to the gimbal and leaves there:
of w kg/s over the length Delta the momentum is w Delta, so the line pushes with -(w' Delta + 2 w dDelta/dt) at its
middle.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp

from ...system import Derivation, Expr, Group
from ..fast.linear import Factors, factorise, solve
from ..plant.equations import gimbal_position
from ..states import MOMENTS, arm_rate_quantities, direction_quantities, rate
from .gravity import Gradient
from .tanks import Fuel, Lump, Tank

AXES = "xyz"


@dataclass(frozen=True)
class _Bob:
    """A bob solved for.

    Attributes
    ----------
    matrix : sympy.Matrix
        How it resists the acceleration of its pivot, kg.
    free : sympy.Matrix
        w, 1/s^2.
    force : sympy.Matrix
        On the hull without accelerations of the pivot, N.
    couple : sympy.Matrix
        On the hull, N m.
    centripetal : sympy.Matrix
        Acceleration of the pivot without a and Omega', m/s^2.
    along : Expr
        |sigma|^2 + w.s, 1/s^2.
    ratio : Expr
        k, 1/m.
    """

    matrix: sp.Matrix
    free: sp.Matrix
    force: sp.Matrix
    couple: sp.Matrix
    centripetal: sp.Matrix
    along: Expr
    ratio: Expr


@dataclass(frozen=True)
class Craft:
    """The six equations of the hull, factorised: accelerations for any moments follow.

    Attributes
    ----------
    factors : Factors
        Of their matrix.
    loads : tuple of Expr
        Right sides without the control moments.
    tanks : tuple of Tank
        What sloshes.
    bobs : tuple
        Solved for.
    """

    factors: Factors
    loads: tuple[Expr, ...]
    tanks: tuple[Tank, ...]
    bobs: tuple[_Bob, ...]

    def accelerations(self, moments: Sequence[Expr], tag: str, d: Derivation) -> tuple[Expr, ...]:
        """Return a and Omega' for control moments, N m."""
        right = (*self.loads[:3], *(load + moment for load, moment in zip(self.loads[3:], moments, strict=True)))
        return solve(self.factors, right, tag, d)

    def arm_rates(self, unknown: Sequence[Expr]) -> tuple[Expr, ...]:
        """Return sigma' of every bob for a and Omega'."""
        linear, angular = sp.Matrix(unknown[:3]), sp.Matrix(unknown[3:])
        rates: list[Expr] = []
        for k, (tank, bob) in enumerate(zip(self.tanks, self.bobs, strict=True), 1):
            s, sigma = _symbols(k)
            pushed = bob.ratio * (linear + angular.cross(tank.pivot) + bob.centripetal)
            rates += list(bob.free - pushed + (pushed.dot(s) - bob.along) * s - rate.cross(sigma))
        return tuple(rates)


def craft(p: Group, fuel: Fuel, thrust: sp.Matrix, gravity: Gradient, d: Derivation) -> Craft:
    """Define the six equations of the hull.

    Parameters
    ----------
    p : Group
        Parameters of the plant.
    fuel : Fuel
        What the tanks hold.
    thrust : sympy.Matrix
        In body axes, N.
    gravity : Gradient
        In body axes.
    d : Derivation
        Receives the steps.
    """
    d.section("Equations of motion with draining tanks")
    bobs = [_bob(tank, k, gravity, d) for k, tank in enumerate(fuel.tanks, 1)]
    total, first, inertia = _hull(p, fuel.fixed, d)
    spin = rate.cross(inertia * rate) + fuel.fixed.inertia_rate * rate
    turned = rate.cross(rate.cross(first))
    gimbal = gimbal_position(p)
    force = thrust - turned + gravity.of(first)
    moment = gimbal.cross(thrust) - spin + gravity.turning(inertia)
    for lump, place, slip in _lumps(p, fuel):
        push = _line(lump, gimbal - place, slip, d)
        force, moment = force - push, moment - ((place + gimbal) / 2).cross(push)
    across = _skew(first)
    matrix = sp.Matrix(sp.BlockMatrix([[total * sp.eye(3), -across], [across, inertia]]))
    for tank, bob in zip(fuel.tanks, bobs, strict=True):
        lever = _skew(tank.pivot)
        swept = lever * bob.matrix
        matrix += sp.Matrix(sp.BlockMatrix([[bob.matrix, swept.T], [swept, -swept * lever]]))
        pushed = bob.force - bob.matrix * bob.centripetal
        pushed = _named(f"pulled{tank.bob.name}", pushed, f"force of bob {tank.bob.name} on the hull", "N", d)
        force, moment = force + pushed, moment + tank.pivot.cross(pushed) + bob.couple
    named = sp.zeros(6, 6)
    for i in range(6):
        for j in range(i + 1):
            if matrix[i, j] != 0:
                named[i, j] = d.define(
                    f"H{i + 1}{j + 1}",
                    matrix[i, j],
                    title="entry of the matrix of a, Omega'",
                    latex=f"H_{{{i + 1}{j + 1}}}",
                )
    loads = tuple(
        d.define(f"load{k}", entry, title="force or moment without accelerations", latex=f"b_{k}")
        for k, entry in enumerate((*force, *moment), 1)
    )
    return Craft(factorise(named, "H", d), loads, fuel.tanks, tuple(bobs))


def control_moments() -> tuple[sp.Symbol, ...]:
    """Return the symbols of the control moments."""
    return tuple(q.symbol for q in MOMENTS)


def hull_inertia(p: Group, fixed: Lump) -> tuple[Expr, sp.Matrix, sp.Matrix]:
    """Return mass, first moment and inertia about O of hull and fixed fuel."""
    total = p.m + fixed.mass
    first = sp.Matrix([-p.m * p.b - fixed.mass * p.h0, 0, 0])
    second = p.m * p.b**2 + fixed.mass * p.h0**2
    own = [j + fixed.inertia for j in (p.J_x, p.J_y, p.J_z)]
    return total, first, sp.diag(own[0], own[1] + second, own[2] + second)


def _hull(p: Group, fixed: Lump, d: Derivation) -> tuple[Expr, sp.Matrix, sp.Matrix]:
    total, first, inertia = hull_inertia(p, fixed)
    named = [
        d.define(f"J_O{k + 1}", inertia[k, k], title="inertia of hull and fixed fuel about O", unit="kg m^2")
        for k in range(3)
    ]
    return (
        d.define("m_O", total, title="mass of hull and fixed fuel", unit="kg"),
        sp.Matrix([d.define("S_O", first[0], title="first moment of hull and fixed fuel", unit="kg m"), 0, 0]),
        sp.diag(*named),
    )


def _lumps(p: Group, fuel: Fuel) -> list[tuple[Lump, sp.Matrix, sp.Matrix]]:
    """Return all fuel with its places from O and its velocities in the body."""
    rows = [(fuel.fixed, sp.Matrix([-p.h0, 0, 0]), sp.zeros(3, 1))]
    for k, tank in enumerate(fuel.tanks, 1):
        s, _ = _symbols(k)
        rows.append((tank.fuel, tank.pivot + tank.bob.length * s, tank.length_rate * s + tank.bob.length * slip_of(k)))
    return rows


def _line(lump: Lump, reach: sp.Matrix, slip: sp.Matrix, d: Derivation) -> sp.Matrix:
    """Return w' Delta + 2 w dDelta/dt of the line from a lump to the gimbal."""
    return lump.out_rate * reach + 2 * lump.out * (rate.cross(reach) - slip)


def _bob(tank: Tank, k: int, gravity: Gradient, d: Derivation) -> _Bob:
    a, (s, sigma), slip = tank.bob, _symbols(k), slip_of(k)

    def name(text: str, value: Expr, title: str, unit: str) -> sp.Symbol:
        return d.define(f"{text}_{k}", value, title=f"{title} {k}", unit=unit)

    first = name("ml", a.mass * a.length, "m l of pendulum", "kg m")
    whole = name("D_now", first * a.length + a.inertia, "inertia about its pivot of pendulum", "kg m^2")
    ratio = name("k_now", first / whole, "m l/D of pendulum", "1/m")
    place = tank.pivot + a.length * s
    own = _named(f"fall_{k}", gravity.of(place), f"gradient at bob {k}", "m/s^2", d)
    free = (first * own + a.inertia * gravity.of(s) - a.damping * slip) / whole - 2 * ratio * tank.length_rate * sigma
    free = _named(f"free_{k}", free, f"sigma' of bob {k} without its pivot", "1/s^2", d)
    along = name("inward", sigma.dot(sigma) + free.dot(s), "|sigma|^2 + w.s of bob", "1/s^2")
    swinging = name("swinging", first * ratio, "mass that swings with pendulum", "kg")
    lumped = name("staying", a.mass - swinging, "mass that stays with the pivot of pendulum", "kg")
    force = a.mass * (own - 2 * tank.length_rate * sigma - tank.length_change * s) - first * free + first * along * s
    couple = a.damping * s.cross(slip) - tank.fuel.inertia_rate * s.cross(sigma)
    matrix = lumped * sp.eye(3) + swinging * s * s.T
    return _Bob(matrix, free, force, couple, rate.cross(rate.cross(tank.pivot)), along, ratio)


def slip_of(k: int) -> sp.Matrix:
    """Return s' of bob k, in body axes."""
    s, sigma = _symbols(k)
    return sigma - rate.cross(s)


def _symbols(k: int) -> tuple[sp.Matrix, sp.Matrix]:
    """Return s and sigma of bob k."""
    s, sigma = (sp.Matrix([q.symbol for q in group(k)]) for group in (direction_quantities, arm_rate_quantities))
    return s, sigma


def _named(text: str, vector: sp.Matrix, title: str, unit: str, d: Derivation) -> sp.Matrix:
    return sp.Matrix(
        [
            d.define(f"{text}{axis}", entry, title=f"{title}, {axis}", unit=unit)
            for axis, entry in zip(AXES, vector, strict=True)
        ]
    )


def _skew(v: sp.Matrix) -> sp.Matrix:
    """Return the matrix of v x."""
    x, y, z = v
    return sp.Matrix([[0, -z, y], [z, 0, -x], [-y, x, 0]])
