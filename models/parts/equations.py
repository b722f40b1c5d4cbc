# SPDX-License-Identifier: Apache-2.0
"""Derivation of a part's equations from its aggregates and its particle."""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from ..derivation import Expr, free_symbols, used_definitions
from ..quantities import TIME, ModelError
from .frame import ZERO, Labels
from .terms import Aggregates, Contribution, Coordinate, Load, Particle, Point, Row


def _check_degrees(of: Aggregates, speeds: Sequence[sp.Symbol], name: str) -> None:
    """Refuse energies that are not quadratic in the speeds, and momenta that are not linear in the speeds."""

    def depends(slopes: sp.Matrix) -> bool:
        return any(slope.has(*speeds) and sp.simplify(slope).has(*speeds) for slope in slopes)

    if speeds and depends(sp.hessian(of.energy, speeds)):
        raise ModelError(f"{name}.energy = {of.energy}: must be quadratic in the speeds {', '.join(map(str, speeds))}")
    for what, momentum in (("momentum", of.momentum), ("angular", of.angular)):
        if speeds and depends(momentum.jacobian(speeds)):
            raise ModelError(
                f"{name}.{what} = {tuple(momentum)}: must be linear in the speeds {', '.join(map(str, speeds))}"
            )


def contribution(
    of: Aggregates, coordinates: Sequence[Coordinate], at: Labels, particle: Particle | None = None
) -> Contribution:
    """Derive a part's contribution to the hub's equations from its aggregates, and its particle besides them."""
    frame, w = at.frame, at.frame.rate
    places = [c.place.symbol if c.place else None for c in coordinates]
    speeds = [c.speed.symbol for c in coordinates]
    refuse_terms(of, coordinates, particle, at.name)

    def by(expr: Expr, place: sp.Symbol | None) -> Expr:
        return sp.S.Zero if place is None else frame.slope(expr, place)

    def along(expr: Expr) -> Expr:
        """Differentiate along the motion with constant speeds."""
        return sp.Add(*(by(expr, q) * v for q, v in zip(places, speeds, strict=True)))

    _check_degrees(of, speeds, at.name)
    prescribed = of.prescribed or (None,) * len(speeds)
    drive = dict(pair for pair in zip(speeds, prescribed, strict=True) if pair[1] is not None)
    rows, held, swelling = [], [], ZERO
    for i, (q, v) in enumerate(zip(places, speeds, strict=True)):
        linear, angular, own = of.momentum.diff(v), of.angular.diff(v), of.energy.diff(v)
        gyro = angular.applyfunc(along) - of.angular.applyfunc(lambda e, q=q: by(e, q))
        spin = of.inertia.applyfunc(lambda e, q=q: by(e, q))
        turned = at.vector(f"JW{i + 1}_", spin * w, f"slope of the inertia by coordinate {i + 1}, times the rate")
        swelling += turned * v
        bias = (
            w.dot(gyro.applyfunc(sp.expand)) - w.dot(turned) / 2 + along(own) - by(of.energy, q) + by(of.potential, q)
        )
        forces = of.forces[i] if of.forces else sp.S.Zero
        if prescribed[i] is not None:
            held.append(Row(linear, angular, tuple(own.diff(other) for other in speeds), forces - bias))
            continue
        coupling = tuple(own.diff(other) for other in speeds if other not in drive)
        driven = sp.Add(*(own.diff(other) * value for other, value in drive.items()))
        rows.append(Row(linear, angular, coupling, forces - bias - driven))
    force, couple = -of.momentum.applyfunc(along), -of.angular.applyfunc(along) - swelling
    for speed, value in drive.items():
        force, couple = force - of.momentum.diff(speed) * value, couple - of.angular.diff(speed) * value
    load, point = Load(force, ZERO, couple), None
    if particle is not None:
        point, rows = _moving(particle, coordinates, rows, at)
    for i, (row, v) in enumerate(zip(rows, (v for v in speeds if v not in drive), strict=True)):
        if row.coupling[i] == 0:
            text = (
                f"no mass and no inertia moves with {v}: give {at.name} an inertia about its axis, or a centre off it"
            )
            raise ModelError(f"{at.name}: {text}")
    _refuse_dependent(rows, [v for v in speeds if v not in drive], at)
    return Contribution(
        of.mass, of.first, of.inertia, of.momentum, of.angular, (load,), tuple(rows), tuple(held), point=point
    )


def _refuse_dependent(rows: Sequence[Row], speeds: Sequence[sp.Symbol], at: Labels) -> None:
    """Refuse coordinates whose mass matrix is singular at any state, as of two that move the same mass alike."""
    matrix = sp.Matrix([row.coupling for row in rows])
    if matrix.is_diagonal():
        return
    definitions = at.frame.derivation.definitions
    symbols = sorted(free_symbols(matrix, definitions), key=str)
    known = {symbol: sp.sqrt(sp.prime(k + 2)).evalf(_DIGITS) / 5 for k, symbol in enumerate(symbols)}
    used = used_definitions(matrix, definitions)
    for symbol in (symbol for symbol in definitions if symbol in used):
        known[symbol] = definitions[symbol].xreplace(known).evalf(_DIGITS)
    left = matrix.xreplace(known).evalf(_DIGITS)
    for i, speed in enumerate(speeds):
        if abs(left[i, i]) <= _ZERO * abs(matrix[i, i].xreplace(known).evalf(_DIGITS)):
            among = [str(other) for k, other in enumerate(speeds[:i]) if matrix[i, k] != 0]
            raise ModelError(
                f"{at.name}: the coordinate of {speed} is determined by that of {', '.join(among)}: their mass matrix "
                "is singular at every state; leave one out, or give each a mass or an inertia of its own"
            )
        for k in range(i + 1, len(speeds)):
            left[k, :] -= left[k, i] / left[i, i] * left[i, :]


_DIGITS = 50
"""Digits at which a mass matrix is eliminated once, at one state."""
_ZERO = sp.Float(10) ** -30
"""Largest pivot, relative to its diagonal entry, that is a rounding error of these digits."""


def refuse_terms(of: Aggregates, coordinates: Sequence[Coordinate], particle: Particle | None, name: str) -> None:
    """Refuse terms of a wrong shape, and masses that move with time instead of coordinates."""
    vectors = {"first": of.first, "momentum": of.momentum, "angular": of.angular}
    if particle is not None:
        vectors["place"] = particle.place
    for what, value in vectors.items():
        if not isinstance(value, sp.MatrixBase) or value.shape != (3, 1):
            raise ModelError(f"{name}.{what} = {value}: must be a column of three, such as sympy.Matrix([x, 0, 0])")
    for what, entries in (("forces", of.forces), ("prescribed", of.prescribed)):
        if entries and len(entries) != len(coordinates):
            raise ModelError(f"{name}.{what} = {entries}: must have {len(coordinates)} entries, one per coordinate")
    for what, value in (*vectors.items(), ("mass", of.mass), ("inertia", of.inertia), ("energy", of.energy)):
        if TIME.symbol in value.free_symbols:
            raise ModelError(f"{name}.{what} = {value}: depends on time; a joint with a prescribed motion moves a mass")


def slopes_of(vector: sp.Matrix, coordinates: Sequence[Coordinate], at: Labels) -> list[sp.Matrix]:
    """Return the derivatives of a vector with respect to the coordinates."""
    places = [c.place for c in coordinates]
    return [vector.applyfunc(lambda e, q=q: at.frame.slope(e, q.symbol) if q else sp.S.Zero) for q in places]


def _moving(
    particle: Particle, coordinates: Sequence[Coordinate], rows: Sequence[Row], at: Labels
) -> tuple[Point, list[Row]]:
    """Return the point of a particle, and the rows of its part with the terms of the particle."""
    m, speeds = particle.mass, [c.speed.symbol for c in coordinates]
    r, slopes, force = _kinematics(particle, coordinates, at)
    energy = None if particle.squared is None else m * particle.squared / 2
    result = []
    for i, (row, slope, v) in enumerate(zip(rows, slopes, speeds, strict=True), 1):
        pushed = at.vector(f"g{i}_", m * slope, f"momentum of the particle per {v}")
        own = [pushed.dot(other) for other in slopes] if energy is None else [energy.diff(v, other) for other in speeds]
        coupling = tuple(a + b for a, b in zip(row.coupling, own, strict=True))
        couple = row.angular - r.cross(row.linear)
        result.append(Row(row.linear + pushed, couple, coupling, row.right - slope.dot(force)))
    return Point(r, m, -force), result


def _kinematics(
    particle: Particle, coordinates: Sequence[Coordinate], at: Labels
) -> tuple[sp.Matrix, list[sp.Matrix], sp.Matrix]:
    """Return place and slopes of a particle, and the force that moves it on a hub without acceleration.

    Entries of the place and its derivatives that are equal up to their sign share a name.
    """
    w, speeds = at.frame.rate, [c.speed.symbol for c in coordinates]
    names: dict[Expr, Expr] = {}

    def named(name: str, vector: sp.Matrix, title: str) -> sp.Matrix:
        new = at.vector(name, vector.applyfunc(lambda e: sp.S.Zero if e in names else e), title)
        for e, symbol in zip(vector, new, strict=True):
            names.setdefault(e, symbol)
            names.setdefault(-e, -symbol)
        return vector.applyfunc(names.__getitem__)

    r, slopes = named("r_", particle.place, "place of the particle"), slopes_of(particle.place, coordinates, at)
    along = [
        named(f"r{i}_", slope, f"velocity of the particle per {v}")
        for i, (slope, v) in enumerate(zip(slopes, speeds, strict=True), 1)
    ]
    twice = (at.define(f"twice{i}", 2 * v, f"twice {v}") for i, v in enumerate(speeds, 1))
    stream = w.cross(r) + sum((slope * v for slope, v in zip(along, twice, strict=True)), ZERO)
    bias = w.cross(at.vector("u_", stream, "W x r + 2 r' of the particle", "m/s"))
    curved = ZERO
    for i, (slope, v) in enumerate(zip(slopes, speeds, strict=True), 1):
        for j, (bend, other) in enumerate(zip(slopes_of(slope, coordinates[:i], at), speeds, strict=False), 1):
            product = at.define(f"v{i}{j}", (1 if i == j else 2) * v * other, f"product of {v} and {other}")
            curved += named(f"r{i}{j}_", bend, f"acceleration of the particle per {v} {other}") * product
    bias += curved.applyfunc(lambda e: sp.collect(e, r.free_symbols))
    return r, along, at.vector("F", particle.mass * bias, "force on the particle if the hub does not accelerate", "N")
