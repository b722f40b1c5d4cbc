# SPDX-License-Identifier: Apache-2.0
"""The triangle as a part of a craft in a plane, whose hub is mass 1 with axes along rod 3."""

from __future__ import annotations

import dataclasses
import functools
import itertools
from collections.abc import Iterable
from dataclasses import dataclass

import sympy as sp

from mehvar.models.derivation import Definition
from mehvar.models.mechanics import frame_turn
from mehvar.models.parts import Aggregates, Coordinate, Load, Part, Spacecraft
from mehvar.models.parts.part import Mounted
from mehvar.models.system import Expr, Quantity, System

from .rederived import Pair, Side, bare, structured

ENDS = ((1, 2), (2, 0), (0, 1))
"""Masses at the ends of each rod, counted from zero."""
_PLACE = sp.Symbol("s")
_ENDS = sp.Matrix([1 - _PLACE, _PLACE])
SPREAD = (_ENDS * _ENDS.T).applyfunc(lambda e: sp.integrate(e, (_PLACE, 0, 1)))
"""Products of places (1 - s) X_i + s X_j on a uniform rod that stretches evenly, integrated over its mass."""

LENGTHS = sp.symbols("l1:4", positive=True)
RATES = sp.symbols("u_l1:4", real=True)
PLACES = sp.Symbol("along", real=True), sp.Symbol("across", positive=True), LENGTHS[2]
"""Place of mass 3, and of mass 2 on the first axis."""
SPEEDS = *sp.symbols("along_speed across_speed", real=True), RATES[2]
HUB = sp.symbols("hub_x hub_y", real=True)
"""Velocity of mass 1 in the axes of rod 3."""
DRIFT = sp.symbols("vx vy", real=True)
PSI, NU, TURN, THETA, MOMENTUM = sp.symbols("psi nu wz theta H", real=True)
PUSH = sp.symbols("F1:4", real=True)
THRUST = [sp.Matrix([*sp.symbols(f"f{k}x f{k}y", real=True), 0]) for k in (1, 2, 3)]


def corners() -> list[sp.Matrix]:
    """Return the places of the masses."""
    along, across, side = PLACES
    return [sp.zeros(3, 1), sp.Matrix([side, 0, 0]), sp.Matrix([along, across, 0])]


def lengths() -> list[Expr]:
    """Return the lengths of the rods."""
    places = corners()
    return [sp.sqrt((places[j] - places[i]).dot(places[j] - places[i])) for i, j in ENDS]


def rate(of: Expr, by: Iterable[Expr] = PLACES, speeds: Iterable[Expr] = SPEEDS) -> Expr:
    """Return the derivative of a function of places along the motion in the axes of rod 3."""
    return sp.Add(*(of.diff(q) * speed for q, speed in zip(by, speeds, strict=True)))


def moved(place: sp.Matrix) -> sp.Matrix:
    """Return the velocity of a place in the axes of rod 3."""
    return place.applyfunc(rate)


@dataclass(frozen=True)
class Triangle(Part):
    """Three masses on rods that push.

    Parameters
    ----------
    masses, rods : three numbers
        kg; zero for a light rod.
    mean_motion, eccentricity : number
        Of the orbit, whose gravity gradient acts.
    """

    masses: tuple[Expr, ...]
    rods: tuple[Expr, ...]
    mean_motion: Expr
    eccentricity: Expr

    def inputs(self) -> tuple[Quantity, ...]:
        thrust = (Quantity(f"f{k}{axis}", "N", "thrust") for k in (1, 2, 3) for axis in "xy")
        return (*(Quantity(f"F{k}", "N", "push") for k in (1, 2, 3)), *thrust, Quantity("nu", "rad", "anomaly"))

    def coordinates(self) -> tuple[Coordinate, ...]:
        return tuple(
            Coordinate(Quantity(v.name, "m/s", "speed"), Quantity(q.name, "m", "place", positive=bool(q.is_positive)))
            for q, v in zip(PLACES, SPEEDS, strict=True)
        )

    @functools.cached_property
    def matrix(self) -> sp.Matrix:
        """The masses' matrix: sums over all bodies of products of places are sums over products of corners."""
        result = sp.diag(*self.masses)
        for rod, ends in zip(self.rods, ENDS, strict=True):
            for i, j in itertools.product(range(2), repeat=2):
                result[ends[i], ends[j]] += rod * SPREAD[i, j]
        return result

    @functools.cached_property
    def centre(self) -> sp.Matrix:
        """The centre of mass."""
        shares = self.matrix * sp.ones(3, 1)
        return summed(zip(shares, corners(), strict=True)) / sum(shares)

    def forces(self) -> list[sp.Matrix]:
        """Return the force on each corner: thrust, and gravity that is linear about the centre of mass."""
        e, up = self.eccentricity, sp.Matrix([sp.cos(NU - THETA), sp.sin(NU - THETA), 0])
        pull = self.mean_motion**2 * ((1 + e * sp.cos(NU)) / (1 - e**2)) ** 3
        arms = [corner - self.centre for corner in corners()]
        fields = [pull * (3 * up * up.dot(arm) - arm) for arm in arms]
        matrix = self.matrix
        return [THRUST[k] + summed(zip(matrix[k, :], fields, strict=True)) for k in range(3)]

    def aggregates(self, at: Mounted) -> Aggregates:
        matrix, places = self.matrix, corners()
        shares, speeds = list(matrix * sp.ones(3, 1)), [moved(place) for place in places]
        pairs = [(matrix[i, j], i, j) for i in range(3) for j in range(3)]
        inertia = sp.Add(*(m * places[i].dot(places[j]) for m, i, j in pairs)) * sp.eye(3)
        inertia -= sum((m * places[i] * places[j].T for m, i, j in pairs), sp.zeros(3, 3))
        pushed = list(zip(self.forces(), places, strict=True))
        return Aggregates(
            sp.Add(*shares), summed(zip(shares, places, strict=True)), inertia,
            summed(zip(shares, speeds, strict=True)), summed((m, places[i].cross(speeds[j])) for m, i, j in pairs),
            sp.Add(*(m * speeds[i].dot(speeds[j]) for m, i, j in pairs)) / 2,
            forces=tuple(
                sp.Add(*(force.dot(place.diff(q)) for force, place in pushed))
                + sp.Add(*(push * length.diff(q) for push, length in zip(PUSH, lengths(), strict=True)))
                for q in PLACES
            ),
        )  # fmt: skip

    def loads(self, at: Mounted) -> tuple[Load, ...]:
        return tuple(map(Load, self.forces(), corners()))

    def momentum(self, turn: Expr) -> Expr:
        """Return the angular momentum about the centre of mass, of axes that turn at a rate."""
        arms = [corner - self.centre for corner in corners()]
        speeds = [moved(arm) + turn * sp.Matrix([0, 0, 1]).cross(arm) for arm in arms]
        return sp.Add(*(m * arms[k // 3].cross(speeds[k % 3])[2] for k, m in enumerate(self.matrix)))


def summed(terms: Iterable[tuple[Expr, sp.Matrix]]) -> sp.Matrix:
    """Return the sum of vectors with factors."""
    return sum((factor * vector for factor, vector in terms), sp.zeros(3, 1))


@functools.cache
def forms(masses: str, rods: str) -> Pair:
    """Return a dynamic structure beside its form from parts."""
    shipped = bare(structured("triangle", masses=masses, model="dynamic", rods=rods))
    return pair(shipped, assembled(shipped))


def part(shipped: System) -> Triangle:
    p = {q.name: q.symbol for q in shipped.parameters}
    masses, rods = (
        tuple(p.get(f"{name}{k}", p.get(equal, sp.S.Zero)) for k in (1, 2, 3))
        for name, equal in (("m", "mass"), ("rod_mass", "rod_mass"))
    )
    return Triangle("triangle", masses, rods, p.get("mean_motion", sp.S.Zero), p.get("eccentricity", sp.S.Zero))


def assembled(shipped: System) -> System:
    craft = Spacecraft("triangle", motion="plane")
    triangle = part(shipped)
    numbers = sp.Tuple(*triangle.masses, *triangle.rods, triangle.mean_motion, triangle.eccentricity)
    for q in (q for q in shipped.parameters if q.symbol in numbers.free_symbols):
        craft.parameter(q.name, q.default, q.unit, q.description, str(q.bounds))
    craft.add(triangle)
    return craft.system()


def pair(shipped: System, form: System) -> Pair:
    """Return the pair in the assembled states, of which lengths, momentum and drift are functions."""
    of, axis = part(shipped), sp.Matrix([0, 0, 1])
    drift = turned(THETA) * (sp.Matrix([*HUB, 0]) + TURN * axis.cross(of.centre) + moved(of.centre))
    old = (*LENGTHS, *RATES, MOMENTUM, *DRIFT, PSI)
    new = (*lengths(), *map(rate, lengths()), of.momentum(TURN), *drift[:2], THETA)
    hub = dict(zip(HUB, DRIFT, strict=True))
    readings = {s.name: (s, e.xreplace(hub)) for s, e in zip(old, new, strict=True)}
    at = {s.name: e.xreplace({THETA: PSI}) for s, e in zip(old, new, strict=True) if s not in (*PLACES, *SPEEDS, PSI)}
    names = {"theta": PSI} | {s.name: e for e, s in hub.items()}
    return Pair(Side(shipped, at), Side(form, names), readings)


def turned(angle: Expr) -> sp.Matrix:
    return frame_turn(2, angle).T


def kinematic(shipped: System) -> tuple[System, Expr]:
    """Return the kinematic system with its shape in the paper's chart, and the momentum of the moving masses.

    The masses have the rods' lengths (20) and rates (22), and rod 3 turns with the attitude (21), without the paper's
    drift, and with its direction from the attitude.
    """
    rho, phi, *_ = shipped.states.symbols
    zeta, rates = (sp.Matrix(sp.symbols(f"zeta1{end} zeta2{end}", real=True)) for end in ("", "_rate"))
    polar = sp.Matrix([rho * sp.cos(phi), rho * sp.sin(phi)])
    speeds = polar.jacobian([rho, phi]) * sp.Matrix(shipped.inputs.symbols[:2])
    placed = zip((*zeta, *rates), (*polar, *speeds), strict=True)
    tilt = sp.atan2(-zeta[1], sp.sqrt(1 - zeta.dot(zeta)) + zeta[0])
    drift = next(q.symbol for q in shipped.parameters if q.name == "disturbance")
    turning = shipped.rhs[3] - drift + sp.Add(*(tilt.diff(z) * v for z, v in zip(zeta, rates, strict=True)))
    named = {s.name: s for s in shipped.definitions}
    l1, l2, l3 = own = [named[f"length{k}"] for k in (1, 2, 3)]
    along = (l2**2 + l3**2 - l1**2) / (2 * l3)
    places = along, sp.sqrt(l2**2 - along**2), l3
    changes = [rate(place, own, [named[f"rod_rate{k}"] for k in (1, 2, 3)]) for place in places]
    moving = dict(zip((*PLACES, *SPEEDS), (*places, *changes), strict=True))
    steps = [Definition(s, e, "", "", "", "1", s.name) for s, e in placed]
    return dataclasses.replace(shipped, steps=(*steps, *shipped.steps)), part(shipped).momentum(turning).xreplace(
        moving
    )
