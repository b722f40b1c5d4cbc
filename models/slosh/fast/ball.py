# SPDX-License-Identifier: Apache-2.0
"""Efficient form for bobs on ball joints: one scalar unknown per pendulum, the arm's tension.

A pendulum pulls at its pivot P with m' a_P + T s - k eps s', m' = m I/D constant and T = m'' (s.a_P) - m l |sigma|^2.
So the accelerations without tensions follow from constant, diagonal inertias, and the tensions from a symmetric system
of their number. Beyond five pendulums the hull's five coupled unknowns are solved for instead.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp

from ...system import Derivation, Expr, Group
from ..states import Pendulum, arm_rate_quantities, direction_quantities, rate
from .hull import SIZE, Arm, Dynamics, Lump, Pull, balance, lump
from .linear import factorise, solve

LARGEST_TENSION_SYSTEM = 5
"""Largest number of pendulums whose tensions are solved for; for more, the hull's 5 x 5 equations are cheaper.

Operations of a right-hand side that depend on state or input, by tensions and by the hull: 558 and 619 for four
pendulums, 730 and 741 for five, 924 and 863 for six. Either gives the same accelerations.
"""


@dataclass(frozen=True)
class _Bob:
    """Named quantities of one pendulum.

    Attributes
    ----------
    s, sigma, slip, turning : sympy.Matrix
        s, sigma, s' and Omega x sigma.
    squared : Expr
        |sigma|^2, 1/s^2.
    across : sympy.Matrix
        s x s', 1/s.
    damping : Expr
        eps, N m s.
    loss : Expr
        k eps, kg/s.
    """

    s: sp.Matrix
    sigma: sp.Matrix
    slip: sp.Matrix
    squared: Expr
    across: sp.Matrix
    damping: Expr
    loss: Expr


def ball_dynamics(p: Group, pendulums: Sequence[Pendulum], d: Derivation) -> Dynamics:
    """Define the accelerations for bobs on ball joints.

    Parameters
    ----------
    p : Group
        Parameters of the plant.
    pendulums : sequence of Pendulum
        Parameters of each.
    d : Derivation
        Receives the steps.
    """
    hull, arms = lump(p, pendulums, False, d)
    bobs = [_bob(a, arm, k, d) for k, (a, arm) in enumerate(zip(pendulums, arms, strict=True), 1)]
    pulls = [_pull(a, arm, bob, hull, d) for a, arm, bob in zip(pendulums, arms, bobs, strict=True)]
    whole = balance(hull, pulls, d)
    factors = factorise(whole.matrix, "K", d)
    if len(pendulums) > LARGEST_TENSION_SYSTEM:
        right = [b - n for b, n in zip(hull.applied, whole.bias, strict=True)]
        unknown = solve(factors, right, "X", d)
        tensions = tuple(
            _arm_tension(a, arm, bob, hull, unknown, d) for a, arm, bob in zip(pendulums, arms, bobs, strict=True)
        )
    else:
        unknown, tensions = _by_tensions(hull, pendulums, arms, bobs, d)
    rates = [
        entry
        for a, arm, bob, tension in zip(pendulums, arms, bobs, tensions, strict=True)
        for entry in _arm_rates(a, arm, bob, hull, unknown, tension, d)
    ]
    return Dynamics(hull, whole, factors, unknown, tuple(rates))


def _arm_tension(a: Pendulum, arm: Arm, bob: _Bob, hull: Lump, unknown: Sequence[Expr], d: Derivation) -> sp.Matrix:
    """Return T s/(m l) from the hull's accelerations."""
    value = arm.ratio * _at_pivot(unknown, hull, arm).dot(bob.s) - bob.squared
    return d.define(f"Tml{a.name}", value, title=f"tension {a.name} over m l", unit="1/s^2") * bob.s


def _bob(a: Pendulum, arm: Arm, k: int, d: Derivation) -> _Bob:
    s = sp.Matrix([q.symbol for q in direction_quantities(k)])
    sigma = sp.Matrix([q.symbol for q in arm_rate_quantities(k)])
    turned = rate.cross(s)
    slip = sp.Matrix(
        [
            d.define(f"slip{k}{axis}", value, title=f"s{k}' along {axis}", unit="1/s", latex=rf"s'_{{{k}{axis}}}")
            for axis, value in zip("xyz", sigma - turned, strict=True)
        ]
    )
    squared = d.define(f"sigma_sq{k}", sigma.dot(sigma), title=f"|sigma{k}|^2", unit="1/s^2", latex=rf"|\sigma_{k}|^2")
    loss = d.define(
        f"ke{k}", arm.ratio * a.damping, title="damping force over s'", unit="kg m/s", latex=rf"k_{k}\varepsilon_{k}"
    )
    return _Bob(s, sigma, slip, squared, s.cross(slip), a.damping, loss)


def _pull(a: Pendulum, arm: Arm, bob: _Bob, hull: Lump, d: Derivation) -> Pull:
    """Return a pendulum's terms in the hull's equations, with the tension eliminated."""
    k, s, e = a.name, bob.s, arm.lever

    def name(text: str, value: Expr, title: str, unit: str) -> sp.Symbol:
        return d.define(f"{text}{k}", value, title=f"{title}, pendulum {k}", unit=unit)

    moved = [name(f"mvs{axis}", arm.moving * s[i], "swinging mass along the arm", "kg") for i, axis in enumerate("xyz")]
    square = {
        (i, j): name(f"mvs{i}{j}_", moved[j] * s[i], "swinging mass", "kg") for i in range(3) for j in range(i + 1)
    }
    shifted = {
        (i, j): name(f"emvs{i}{j}_", e * square[i, j], "its first moment", "kg m") for i in (1, 2) for j in range(i + 1)
    }
    matrix = sp.zeros(SIZE, SIZE)
    for (i, j), entry in square.items():
        matrix[i, j] = entry
    for (i, j), entry in shifted.items():
        matrix[i + 3, j] = entry
        if j > 0:
            matrix[i + 3, j + 3] = e * entry
    matrix[4, 2] = shifted[2, 1]
    tension = name(
        "rest", moved[0] * e * hull.g1 - a.mass * a.length * bob.squared, "tension at rest of the unknowns", "N"
    )
    force = [
        name(f"Fp{axis}", tension * s[i] - bob.loss * bob.slip[i], "force on the hull", "N")
        for i, axis in enumerate("xyz")
    ]
    m1, m2, m3 = bob.damping * bob.across
    return Pull(matrix, (*force, -m1, e * force[1] - m3, e * force[2] + m2))


def _by_tensions(
    hull: Lump, pendulums: Sequence[Pendulum], arms: Sequence[Arm], bobs: Sequence[_Bob], d: Derivation
) -> tuple[tuple[Expr, ...], tuple[sp.Matrix, ...]]:
    """Solve for tensions over the lump's mass; return the hull's unknowns and T s/(m l) of each arm."""
    free = _without_tension(hull, pendulums, arms, bobs, d)
    mass, (_, about_z, about_y) = hull.mass, hull.inertia
    levers = [
        (
            d.define(f"uy{a.name}", arm.lever * mass / about_z, title="mass times lever over inertia", unit="1/m"),
            d.define(f"uz{a.name}", arm.lever * mass / about_y, title="mass times lever over inertia", unit="1/m"),
        )
        for a, arm in zip(pendulums, arms, strict=True)
    ]
    size = len(bobs)
    matrix = sp.zeros(size, size)
    for i in range(size):
        for j in range(i + 1):
            matrix[i, j] = matrix[j, i] = _together(i, j, hull, pendulums, arms, bobs, levers, d)
    right = [
        d.define(
            f"along{a.name}",
            _at_pivot(free, hull, arm).dot(bob.s) - bob.squared / arm.ratio,
            title=f"acceleration along arm {a.name} without tension",
            unit="m/s^2",
            latex=f"r_{a.name}",
        )
        for a, arm, bob in zip(pendulums, arms, bobs, strict=True)
    ]
    tensions = solve(factorise(matrix, "T", d), right, "t", d)
    pulls = [_pulled(a.name, t * bob.s, d) for a, t, bob in zip(pendulums, tensions, bobs, strict=True)]
    along = [free[k] - sp.Add(*(pull[k] for pull in pulls)) for k in range(3)]
    across = [
        free[k + 3] - sp.Add(*(u[k - 1] * pull[k] for pull, u in zip(pulls, levers, strict=True))) for k in (1, 2)
    ]
    pulled = (*along, free[3], *across)
    unknown = tuple(
        d.define(f"X{k}", value, title="unknown of the hull", latex=f"X_{k}") for k, value in enumerate(pulled, 1)
    )
    ratios = [
        d.define(f"Mml{a.name}", hull.mass / (a.mass * a.length), title="mass of the lump over m l", unit="1/m")
        for a in pendulums
    ]
    return unknown, tuple(ratio * sp.Matrix(pull) for ratio, pull in zip(ratios, pulls, strict=True))


def _pulled(k: str, pull: sp.Matrix, d: Derivation) -> tuple[Expr, ...]:
    return tuple(
        d.define(f"ts{k}{axis}", entry, title=f"pull of arm {k} over the lump's mass", unit="m/s^2")
        for axis, entry in zip("xyz", pull, strict=True)
    )


def _without_tension(
    hull: Lump, pendulums: Sequence[Pendulum], arms: Sequence[Arm], bobs: Sequence[_Bob], d: Derivation
) -> tuple[Expr, ...]:
    """Return the hull's unknowns under applied loads and damping only, with constants multiplied out."""
    inertias = (*(hull.mass,) * 3, *hull.inertia)
    names = ("1", "2", "3", "4", "5", "6")

    def constant(name: str, value: Expr, title: str, unit: str) -> sp.Symbol:
        return d.define(name, value, title=title, unit=unit)

    loads = [
        constant(f"X{k}_in", load / j, "applied load over inertia", "")
        for k, load, j in zip(names, hull.applied, inertias, strict=True)
    ]
    turns = [sp.S.Zero] * 3 + [
        constant(f"gyr{k}", factor / j, "gyroscopic constant", "") * product
        for k, (factor, product), j in zip(names[3:], hull.gyration, hull.inertia, strict=True)
    ]
    drags: list[list[Expr]] = [[] for _ in names]
    for a, arm, bob in zip(pendulums, arms, bobs, strict=True):
        k, loss = a.name, arm.ratio * a.damping
        slow = constant(f"kM{k}", loss / hull.mass, "damping force over mass", "m/s")
        for axis in range(3):
            drags[axis].append(slow * bob.slip[axis])
        twist = [
            constant(f"eJ{row}{k}", a.damping / j, "damping over inertia", "1/s")
            for row, j in zip(names[3:], hull.inertia, strict=True)
        ]
        pushed = [
            constant(f"kJ{row}{k}", arm.lever * loss / hull.inertia[i], "damping force times lever over inertia", "1/s")
            for row, i in (("5", 1), ("6", 2))
        ]
        across = bob.across
        drags[3].append(twist[0] * across[0])
        drags[4] += [pushed[0] * bob.slip[1], twist[1] * across[2]]
        drags[5] += [pushed[1] * bob.slip[2], -twist[2] * across[1]]
    return tuple(
        d.define(
            f"X{k}_free",
            load - turn + sp.Add(*drag),
            title="unknown of the hull without tensions",
            latex=f"X_{{{k},0}}",
        )
        for k, load, turn, drag in zip(names, loads, turns, drags, strict=True)
    )


def _together(
    i: int,
    j: int,
    hull: Lump,
    pendulums: Sequence[Pendulum],
    arms: Sequence[Arm],
    bobs: Sequence[_Bob],
    levers: Sequence[tuple[Expr, Expr]],
    d: Derivation,
) -> Expr:
    """Return the deceleration of arm i's pivot along that arm by tension j over the lump's mass."""
    names = f"{pendulums[i].name}_{pendulums[j].name}"
    gain = [
        d.define(f"u{axis}{names}", arms[i].lever * levers[j][k], title="turning share") for k, axis in enumerate("yz")
    ]
    first, second = bobs[i].s, bobs[j].s
    if i is j:
        own = d.define(f"own{names}", hull.mass / arms[i].moving + 1, title="share of the lump and the pendulum itself")
        entry = own + gain[0] * first[1] ** 2 + gain[1] * first[2] ** 2
    else:
        whole = [
            d.define(f"w{axis}{names}", 1 + g, title="share of the lump") for axis, g in zip("yz", gain, strict=True)
        ]
        entry = first[0] * second[0] + whole[0] * first[1] * second[1] + whole[1] * first[2] * second[2]
    return d.define(f"A{names}", entry, title="tensions' matrix", latex=f"A_{{{names.replace('_', ',')}}}")


def _at_pivot(unknown: Sequence[Expr], hull: Lump, arm: Arm) -> sp.Matrix:
    """Return the acceleration of the pivot."""
    turning = (hull.g1, unknown[4], unknown[5])
    return sp.Matrix([a + arm.lever * g for a, g in zip(unknown[:3], turning, strict=True)])


def _arm_rates(
    a: Pendulum, arm: Arm, bob: _Bob, hull: Lump, unknown: Sequence[Expr], tension: sp.Matrix, d: Derivation
) -> tuple[Expr, ...]:
    """Return sigma' = T s/(m l) - k a_P - eps/D s' - Omega x sigma."""
    damping = d.define(f"eD{a.name}", a.damping / arm.total, title="damping over inertia", unit="1/s")
    pivot = _at_pivot(unknown, hull, arm)
    return tuple(tension - arm.ratio * pivot - damping * bob.slip - rate.cross(bob.sigma))
