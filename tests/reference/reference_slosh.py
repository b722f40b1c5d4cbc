# SPDX-License-Identifier: Apache-2.0
"""Hand-written Newton-Euler and Kane dynamics of a spacecraft with spherical pendulums.

Bodies one by one, with vectors in body axes and unknowns a (of the tank centre O), Omega', and the pendulums' own
accelerations. Every balance is written as a residual that is linear in them and solved as one dense system. Nothing is
shared with the model: arms are placed by rotation matrices, rotors are bodies of their own, and the ball joint is a
rigid bob with three rotational freedoms and no spin.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
X, Y, Z = np.eye(3)


@dataclass(frozen=True)
class Pendulum:
    """Mass (kg), length (m), pivot ahead of O (m), moment of inertia (kg m^2) and damping (N m s/rad)."""

    m: float
    length: float
    h: float
    inertia: float
    eps: float


@dataclass(frozen=True)
class Spacecraft:
    """Hull, fixed fuel, gimbal and thrust; SI units."""

    m: float
    m0: float
    I0: float
    J: Array
    h0: float
    b: float
    d: float
    F: float
    pendulums: tuple[Pendulum, ...]


@dataclass(frozen=True)
class Motion:
    """Velocity of O and body rate in body axes, with two or three numbers a pendulum for position and rate."""

    V: Array
    W: Array
    q: Array
    qd: Array


def spacecraft(p: Sequence[float]) -> Spacecraft:
    """Read a parameter vector: m m0 I0 J_x J_y J_z h0 b d F, two gimbal limits, then m l h I eps a pendulum."""
    m, m0, I0, jx, jy, jz, h0, b, d, F = p[:10]
    rest = np.reshape(p[12:], (-1, 5))
    return Spacecraft(m, m0, I0, np.array([jx, jy, jz]), h0, b, d, F, tuple(Pendulum(*row) for row in rest))


def turn(axis: int, angle: float) -> Array:
    """Return the matrix that turns vectors about an axis."""
    i, j = (axis + 1) % 3, (axis + 2) % 3
    R = np.eye(3)
    R[i, i] = R[j, j] = np.cos(angle)
    R[j, i] = np.sin(angle)
    R[i, j] = -np.sin(angle)
    return R


def loads(craft: Spacecraft, u: Sequence[float]) -> tuple[Array, Array]:
    """Return thrust and moment about O for Mx, My, Mz, delta1, delta2."""
    *M, d1, d2 = u
    # the engine looks along x, swings by d2 about z, then by d1 about y
    thrust = turn(1, d1) @ turn(2, d2) @ (craft.F * X)
    return thrust, np.array(M) + np.cross([-(craft.b + craft.d), 0, 0], thrust)


def point_acceleration(a: Array, alpha: Array, W: Array, r: Array, v: Array, rdd: Array) -> Array:
    """Return the acceleration of a point that moves at v, rdd relative to the body."""
    return a + np.cross(alpha, r) + np.cross(W, np.cross(W, r)) + 2 * np.cross(W, v) + rdd


def hull_balance(craft: Spacecraft, x: Motion, a: Array, alpha: Array) -> tuple[Array, Array]:
    """Return rates of momentum of hull and fixed fuel, and of their angular momentum about O."""
    force, moment = np.zeros(3), np.zeros(3)
    for mass, place in ((craft.m, -craft.b), (craft.m0, -craft.h0)):
        r = place * X
        push = mass * point_acceleration(a, alpha, x.W, r, np.zeros(3), np.zeros(3))
        force, moment = force + push, moment + np.cross(r, push)
    J = np.diag(craft.J + craft.I0)
    return force, moment + J @ alpha + np.cross(x.W, J @ x.W)


def arm(bob: Pendulum, q: Array) -> tuple[Array, Array, Array]:
    """Return the two hinge axes, theta's and phi's, and the arm."""
    phi, theta = q
    # at rest the arm points along -x; phi turns it about y towards z, theta about -x
    placed = turn(0, -theta) @ turn(1, phi)
    return -X, turn(0, -theta) @ Y, placed @ (-bob.length * X)


def angle_balance(
    bob: Pendulum, geared: bool, x: Motion, q: Array, qd: Array, qdd: Array, a: Array, alpha: Array
) -> tuple[Array, Array, Array]:
    """Return force and moment about O of one pendulum, and the balances of its two angles."""
    hinge, tilt, r = arm(bob, q)
    phid, thetad = qd
    spin = thetad * hinge + phid * tilt
    spin_rate = qdd[1] * hinge + qdd[0] * tilt + np.cross(thetad * hinge, phid * tilt)
    v = np.cross(spin, r)
    rdd = np.cross(spin_rate, r) + np.cross(spin, v)
    place = bob.h * X + r
    push = bob.m * point_acceleration(a, alpha, x.W, place, v, rdd)
    if geared:
        rotors = x.W + np.array([phid, 0, thetad])
        couple = bob.inertia * (alpha + np.array([qdd[0], 0, qdd[1]]))
        total = couple + np.cross(x.W, bob.inertia * rotors)
        own = np.array([couple[0], couple[2]])
    else:
        total = bob.inertia * (alpha + np.cross(x.W, spin) + spin_rate)
        own = np.array([tilt @ total, hinge @ total])
    partial = np.array([np.cross(tilt, r) @ push, np.cross(hinge, r) @ push])
    return push, np.cross(place, push) + total, partial + own + bob.eps * qd


def ball_balance(
    bob: Pendulum, x: Motion, s: Array, sigma: Array, turning: Array, a: Array, alpha: Array
) -> tuple[Array, Array, Array]:
    """Return the same for a bob on a ball joint; `turning` is the inertial rate of change of its angular velocity."""
    omega = np.cross(s, sigma)
    arm_acceleration = np.cross(turning, s) + np.cross(omega, np.cross(omega, s))
    pivot = point_acceleration(a, alpha, x.W, bob.h * X, np.zeros(3), np.zeros(3))
    push = bob.m * (pivot + bob.length * arm_acceleration)
    couple = bob.inertia * turning
    damping = bob.eps * np.cross(s, sigma - np.cross(x.W, s))
    place = bob.h * X + bob.length * s
    return push, np.cross(place, push) + couple, np.cross(bob.length * s, push) + couple + damping


def solve_linear(residual: Callable[[Array], Array], size: int) -> Array:
    """Solve residual(z) = 0 for a residual that is linear in z."""
    at_zero = residual(np.zeros(size))
    matrix = np.column_stack([residual(column) - at_zero for column in np.eye(size)])
    return np.linalg.solve(matrix, -at_zero)


def accelerations(craft: Spacecraft, convention: str, x: Motion, u: Sequence[float]) -> tuple[Array, Array, Array]:
    """Return a of O, Omega', and phi'', theta'' or sigma' of each pendulum as rows.

    Parameters
    ----------
    craft : Spacecraft
        Parameters.
    convention : {"paper", "hinge", "ball"}
        Inertia of the bobs.
    x : Motion
        State; q, qd hold phi, theta and rates, or s and sigma, one row a pendulum.
    u : sequence of float
        Mx, My, Mz, delta1, delta2.
    """
    thrust, moment = loads(craft, u)
    width = 3 if convention == "ball" else 2

    def residual(z: Array) -> Array:
        a, alpha, own = z[:3], z[3:6], z[6:].reshape(-1, width)
        force_sum, moment_sum = hull_balance(craft, x, a, alpha)
        rows = []
        for bob, q, qd, qdd in zip(craft.pendulums, x.q, x.qd, own, strict=True):
            if convention == "ball":
                push, twist, row = ball_balance(bob, x, q, qd, qdd, a, alpha)
            else:
                push, twist, row = angle_balance(bob, convention == "paper", x, q, qd, qdd, a, alpha)
            force_sum, moment_sum = force_sum + push, moment_sum + twist
            rows.append(row)
        return np.concatenate([force_sum - thrust, moment_sum - moment, *rows])

    z = solve_linear(residual, 6 + width * len(craft.pendulums))
    own = z[6:].reshape(-1, width)
    if convention == "ball":
        own = np.array(
            [arm_rate_change(x.W, s, sigma, turning) for s, sigma, turning in zip(x.q, x.qd, own, strict=True)]
        )
    return z[:3], z[3:6], own


def arm_rate_change(W: Array, s: Array, sigma: Array, turning: Array) -> Array:
    """Return the change of sigma's components from the inertial angular acceleration of the bob."""
    omega = np.cross(s, sigma)
    inertial = np.cross(turning, s) + np.cross(omega, np.cross(omega, s))
    return inertial - np.cross(W, sigma)


def bob_motion(bob: Pendulum, q: Array, qd: Array) -> tuple[Array, Array]:
    """Return direction and inertial-rate-free velocity of a bob at angles q: s and s'."""
    hinge, tilt, r = arm(bob, q)
    return r / bob.length, np.cross(qd[1] * hinge + qd[0] * tilt, r) / bob.length
