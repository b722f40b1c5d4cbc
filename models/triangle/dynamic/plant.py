# SPDX-License-Identifier: Apache-2.0
"""Newton's law for three masses with rod forces, thrusters, and an orbit's gravity gradient.

The length of a rod obeys l^2 = D . D. Let D'' = A be the difference of its ends' accelerations, omega its angular
rate and e its direction. Then l'' = l omega^2 + e . A. Forces normal to the rods only change the angular momentum.
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from ...derivation import vector
from ...mechanics import planar_cross
from ...system import Derivation, Expr, Group
from .bodies import ENDS
from .motion import Motion
from .states import ANOMALY, HEADING, forces, lengths, rates, thrust


@dataclass(frozen=True)
class Plant:
    """Rates of the states of the dynamic triangle.

    Attributes
    ----------
    coupling : Matrix
        Accelerations of the rods' lengths for forces of one newton in each rod.
    free : tuple of Expr
        Accelerations of the lengths without forces of rods and thrusters.
    torque : Expr
        Gravity torque about the centre of mass.
    rhs : tuple of Expr
        Rates of all states.
    """

    coupling: sp.Matrix
    free: tuple[Expr, ...]
    torque: Expr
    rhs: tuple[Expr, ...]


@dataclass(frozen=True)
class Gravity:
    """Gravity relative to the centre of mass, linear in the position: gradient (3 r r^T - 1).

    Attributes
    ----------
    gradient : Expr
        Gravitational parameter over the cube of the distance, 1/s^2.
    radial : Matrix
        r, away from the Earth, in axes along rod 3.
    rate : Expr
        Rate of the true anomaly.
    """

    gradient: Expr
    radial: sp.Matrix
    rate: Expr


def gravity(p: Group, d: Derivation) -> Gravity:
    """Return the gravity along a Kepler orbit with mean motion n and eccentricity e."""
    d.section("Gravity gradient")
    e, turn = p.eccentricity, ANOMALY.symbol - HEADING.symbol
    near = d.define(
        "nearness",
        (1 + e * sp.cos(ANOMALY.symbol)) / (1 - e**2),
        title="semi-major axis over the distance",
        latex="a/r",
        positive=True,
    )
    gradient = d.define(
        "gradient", p.mean_motion**2 * near**3, title="gravitational parameter over r^3", unit="1/s^2", latex=r"\kappa"
    )
    along = d.define("radial_x", sp.cos(turn), title="direction from the Earth, along rod 3", latex="r_x")
    across = d.define("radial_y", sp.sin(turn), title="direction from the Earth, across rod 3", latex="r_y")
    radial = sp.Matrix([along, across])
    return Gravity(gradient, radial, p.mean_motion * near**2 * sp.sqrt(1 - e**2))


def plant(motion: Motion, field: Gravity, d: Derivation) -> Plant:
    """Sum the forces along the rods and the torques about the centre of mass.

    Parameters
    ----------
    motion, field
        Positions of the masses, and gravity.
    d : Derivation
        Receives the steps.
    """
    d.section("Forces")
    coupling = _coupling(motion, d)
    title = "acceleration of rod * without forces of rods and thrusters"
    free = [_free(k, motion, field) for k in range(3)]
    free = vector("free*", free, title, "m/s^2", r"\ddot l_{*,0}", d, labels="123")
    pushed = tuple(_pushed(k, motion) for k in range(3))
    accelerations = coupling * forces + free + sp.Matrix(pushed)
    cosine, sine = sp.cos(HEADING.symbol), sp.sin(HEADING.symbol)
    fx, fy = sum(thrust[1:], thrust[0])
    torque = d.define(
        "torque", _torque(motion, field), title="torque of the gravity gradient", unit="N m", latex=r"\tau_g"
    )
    by_thrust = sp.Add(*(planar_cross(place, force) for place, force in zip(motion.places, thrust, strict=True)))
    rhs = (
        *rates,
        motion.turns[2],
        *accelerations,
        torque + by_thrust,
        field.rate,
        (cosine * fx - sine * fy) / motion.bodies.total,
        (sine * fx + cosine * fy) / motion.bodies.total,
        sp.Add(*(sp.Abs(force * speed) for force, speed in zip(forces, rates, strict=True))),
        sp.Add(*(sp.Abs(force) for pair in thrust for force in pair)),
    )
    return Plant(coupling, tuple(free), torque, rhs)


def _coupling(motion: Motion, d: Derivation) -> sp.Matrix:
    """Return E M^-1 E^T with E = dl/dX, the accelerations of all lengths per force in each rod."""
    m = motion.bodies.masses
    matrix = sp.zeros(3, 3)
    for k, (i, j) in enumerate(ENDS):
        matrix[k, k] = d.define(
            f"B{k + 1}{k + 1}", 1 / m[i] + 1 / m[j], title=f"mobility of rod {k + 1}", latex=f"B_{{{k + 1}{k + 1}}}"
        )
        entry = d.define(
            f"B{i + 1}{j + 1}",
            motion.cosines[k] / m[k],
            title=f"coupling of rods {i + 1} and {j + 1} by mass {k + 1}",
            latex=f"B_{{{i + 1}{j + 1}}}",
        )
        matrix[i, j] = matrix[j, i] = entry
    return matrix


def _free(k: int, motion: Motion, field: Gravity) -> Expr:
    """Return l'' of a rod from its rotation and the gravity gradient."""
    length = lengths[k]
    outward = motion.rods[k].dot(field.radial) / length
    return length * (motion.turns[k] ** 2 + field.gradient * (3 * outward**2 - 1))


def _pushed(k: int, motion: Motion) -> Expr:
    """Return l'' of a rod from the thrust on its ends, relative to the centre of mass."""
    i, j = ENDS[k]
    bodies, whole = motion.bodies, sum(thrust[1:], thrust[0])
    moved = [(thrust[n] - bodies.lumps[n] / bodies.total * whole) / bodies.masses[n] for n in range(3)]
    difference = (moved[j] - moved[i]).applyfunc(sp.expand)
    return motion.rods[k].dot(difference) / lengths[k]


def _torque(motion: Motion, field: Gravity) -> Expr:
    """Return the gravity torque sum X_i x f_i as a sum over rods."""
    each = (
        mass * planar_cross(rod, field.radial) * rod.dot(field.radial)
        for mass, rod in zip(motion.bodies.reduced, motion.rods, strict=True)
    )
    return 3 * field.gradient * sp.Add(*each)


def kinetic(motion: Motion, drift: tuple[Expr, Expr]) -> Expr:
    """Return the kinetic energy, a sum over rods plus that of the centre of mass."""
    about = sp.Add(
        *(
            mass * (rate**2 + (length * turn) ** 2)
            for mass, rate, length, turn in zip(motion.bodies.reduced, rates, lengths, motion.turns, strict=True)
        )
    )
    return (about + motion.bodies.total * (drift[0] ** 2 + drift[1] ** 2)) / 2


def potential(motion: Motion, field: Gravity) -> Expr:
    """Return the potential energy in the gravity gradient."""
    each = (
        mass * (3 * rod.dot(field.radial) ** 2 - length**2)
        for mass, rod, length in zip(motion.bodies.reduced, motion.rods, lengths, strict=True)
    )
    return -field.gradient * sp.Add(*each) / 2
