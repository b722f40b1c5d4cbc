# SPDX-License-Identifier: Apache-2.0
"""Laws of mechanics that every craft must fulfil, whatever its parts; a wrong aggregate breaks one of them."""

from __future__ import annotations

import copy
from collections.abc import Iterator, Mapping

import numpy as np
import sympy as sp

from mehvar.models.check import check
from mehvar.models.derivation import Expr
from mehvar.models.mechanics import cross_matrix
from mehvar.models.parts import Mounted, Part, Spacecraft, point_inertia
from mehvar.models.parts.equations import slopes_of
from mehvar.physics.balances import Balances, apart
from mehvar.physics.machine import Array

_POINTS = 4
"""Number of random states; a wrong term of any size breaks a law at each of them but by chance. Each state also counts
with the opposite motion, because a term may be wrong for one sign only, as friction without the sign of its speed."""
_BOOST = np.array([3.0, -2.0, 5.0])
"""A constant velocity, m/s: about that of the random states."""


def gates(craft: Spacecraft) -> dict[str, float]:
    """Return the largest error of each law at random states, relative to the size of its terms.

    Raises
    ------
    ModelError
        If the craft cannot be built.
    """
    system, rng = craft.system(), np.random.default_rng(0)
    check(system)
    reverse = copy.copy(craft)
    reverse.parts = craft.parts[::-1]
    balances, other = Balances(system), Balances(reverse.system())
    drawn = [balances.sample(rng) for _ in range(_POINTS)]
    points = [*drawn, *((balances.opposite(x), u) for x, u in drawn)]
    errors = [error for x, u in points for error in _of_craft(craft, balances, other, x, u)]
    for terms in craft.numbers(_terms, [{q.name: x[q.name] for q in system.states} for x, _ in points]):
        errors += _of_parts(craft.parts, [np.array(values) for values in terms])
    result: dict[str, float] = {}
    for law, error in errors:
        result[law] = max(error, result.get(law, 0.0))
    return result


def _of_craft(
    craft: Spacecraft, balances: Balances, other: Balances, x: Mapping[str, float], u: Mapping[str, float]
) -> Iterator[tuple[str, float]]:
    """Yield the laws of mechanics with the error of the craft in each, at a state and input."""
    rates = balances.rates(x, u)
    energy, momentum = balances.errors(x, u)
    yield "energy changes by the power of loads, motors and dampers", energy
    yield "momentum changes by the loads", momentum
    yield "the order of parts has no effect", apart(other.rates(x, u), rates)
    if len(craft.velocity) == 3:
        shift = np.cross([x[f"w{axis}"] for axis in "xyz"], _BOOST)
        faster = balances.rates({**x, **{f"v{a}": x[f"v{a}"] + more for a, more in zip("xyz", _BOOST, strict=True)}}, u)
        seen = {f"v{a}": faster[f"v{a}"] + more for a, more in zip("xyz", shift, strict=True)}
        yield "a constant velocity has no effect", apart({**faster, **seen}, rates)


def _of_parts(parts: list[Part], terms: list[Array]) -> Iterator[tuple[str, float]]:
    """Yield the laws of the aggregates of each part, from the numbers of its `_terms`."""
    matrices = [values[12:].reshape(2 * [round(len(values[12:]) ** 0.5)]) for values in terms]
    whole = sum(kinetic[:6, :6] for kinetic in matrices)
    for part, values, kinetic in zip(parts, terms, matrices, strict=True):
        name = part.name
        (mass, damping, excess), momentum, rate, first = values[:3], values[3:6], values[6:9], values[9:12]
        if len(kinetic) > 6:
            size = max(1.0, np.abs(values[3:9]).max())
            if type(part).particle is not Part.particle:
                yield f"{name}: the speed of its particle is that of its place", abs(float(excess))
            yield f"{name}: its momentum is the rate of its first moment", float(np.abs(momentum - rate).max() / size)
            yield f"{name}: its dampers take energy", float(max(0.0, damping))
        if mass == 0:  # the hub has its mass
            kinetic[:6, :6] = whole
        yield f"{name}: its kinetic energy is never negative", _below_zero(kinetic)
        if mass > 0:
            about = kinetic[3:6, 3:6] - np.array(point_inertia(mass, sp.Matrix(first / mass)), dtype=float)
            second = np.trace(about) / 2 * np.eye(3) - about
            yield f"{name}: its inertia is that of a body with its mass and first moment", _below_zero(second)


def _excess(part: Part, at: Mounted) -> Expr:
    """Return the error of the square of a particle's speed beside that of its place, relative to the latter or to 1."""
    particle = part.particle(at)
    if particle is None or particle.squared is None:
        return sp.S.Zero
    slopes = zip(slopes_of(particle.place, part.coordinates(), at), part.coordinates(), strict=True)
    velocity = sum((slope * c.speed.symbol for slope, c in slopes), sp.zeros(3, 1))
    square = velocity.dot(velocity)
    return (particle.squared - square) / sp.Max(1, square)


def _below_zero(matrix: Array) -> float:
    """Return how far the least eigenvalue of a symmetric matrix is below zero, relative to its entries."""
    return float(max(0.0, -np.linalg.eigvalsh(matrix)[0]) / max(1.0, np.abs(matrix).max()))


def _terms(part: Part, at: Mounted) -> list[Expr]:
    """Return the terms that `_of_parts` compares.

    They are mass, power of dampers, relative error of the square of a particle's speed, momentum, rate of the first
    moment, first moment, and the matrix of T.
    """
    of, coordinates = part.total(at), part.coordinates()
    speeds = [c.speed.symbol for c in coordinates]
    damping, rate = of.power, sp.zeros(3, 1)
    if of.forces and not any(of.prescribed):
        damping += sp.Matrix(of.forces).dot(sp.Matrix(speeds))
    for c in coordinates:
        if c.place is not None:
            rate += c.speed.symbol * sp.Matrix([at.frame.slope(entry, c.place.symbol) for entry in of.first])
    size, hat = len(speeds), cross_matrix(of.first)
    kinetic = sp.zeros(6 + size, 6 + size)
    kinetic[:3, :3], kinetic[:3, 3:6], kinetic[3:6, :3], kinetic[3:6, 3:6] = of.mass * sp.eye(3), -hat, hat, of.inertia
    for i, speed in enumerate(speeds, 6):
        slope = sp.Matrix([*of.momentum.diff(speed), *of.angular.diff(speed)])
        kinetic[:6, i], kinetic[i, :6] = slope, slope.T
        for j, other in enumerate(speeds, 6):
            kinetic[i, j] = of.energy.diff(speed, other)
    return [of.mass, damping, _excess(part, at), *of.momentum, *rate, *of.first, *kinetic]
