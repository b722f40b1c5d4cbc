# SPDX-License-Identifier: Apache-2.0
"""Hull, fixed fuel and bobs as separate bodies: energy and momentum summed one by one, without the derivation."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mehvar.physics.gates import dot
from mehvar.physics.machine import Array, Points


def energy(at: Points) -> Array:
    """Return the kinetic energy."""
    return np.sum([m * dot(v, v) / 2 for m, _, v in _masses(at)], axis=0) + _turning(at)


def momentum(at: Points) -> Array:
    """Return linear and angular momentum about O, in body axes."""
    linear = np.sum([m[:, None] * v for m, _, v in _masses(at)], axis=0)
    orbital = np.sum([m[:, None] * np.cross(r, v) for m, r, v in _masses(at)], axis=0)
    return np.hstack([linear, orbital + _spins(at)])


def rigid(at: Points, force: Array, moment: Array) -> Array:
    """Return the accelerations of O and of the rotation for hull and fixed fuel alone, by Newton and Euler."""
    m, m0, w = at["m"], at["m0"], _rate(at)
    first = -(m * at["b"] + m0 * at["h0"])
    second = (m * at["b"] ** 2 + m0 * at["h0"] ** 2)[:, None, None] * np.diag([0.0, 1.0, 1.0])
    inertia = second + np.einsum("ni,ij->nij", _hull(at), np.eye(3))
    lever = first[:, None] * np.array([1.0, 0.0, 0.0])
    cross = np.zeros((len(m), 3, 3))
    cross[:, 1, 2], cross[:, 2, 1] = -first, first
    whole = np.block([[(m + m0)[:, None, None] * np.eye(3), -cross], [cross, inertia]])
    known = np.hstack(
        [
            force - np.cross(w, np.cross(w, lever)),
            moment - np.cross(w, np.einsum("nij,nj->ni", inertia, w)),
        ]
    )
    return np.linalg.solve(whole, known[..., None])[..., 0]


def arm(at: Points, k: int) -> tuple[Array, Array]:
    """Return the direction of arm k and its rate relative to the hull."""
    if at.machine.system.structure["inertia"] == "ball":
        s, sigma = (at.vector(*(f"{name}{k}{axis}" for axis in "xyz")) for name in ("s", "sigma"))
        return s, sigma - np.cross(_rate(at), s)
    return direction(*(at[f"{angle}{k}{end}"] for angle in ("phi", "theta") for end in ("", "_dot")))


def direction(phi: Array, phi_dot: Array, theta: Array, theta_dot: Array) -> tuple[Array, Array]:
    """Return the direction (7) of an arm and its rate."""
    s, c, S, C = np.sin(phi), np.cos(phi), np.sin(theta), np.cos(theta)
    along_phi, along_theta = np.column_stack([s, c * S, c * C]), np.column_stack([0 * s, s * C, -s * S])
    rate = phi_dot[:, None] * along_phi + theta_dot[:, None] * along_theta
    return np.column_stack([-c, s * S, s * C]), rate


def _masses(at: Points) -> Iterator[tuple[Array, Array, Array]]:
    """Yield mass, place and velocity of each body's centre."""
    for mass, x in (("m", -at["b"]), ("m0", -at["h0"])):
        yield at[mass], *_carried(at, x[:, None] * np.array([1.0, 0.0, 0.0]), np.zeros((len(x), 3)))
    for k in _numbers(at):
        s, slip = arm(at, k)
        length = at[f"l{k}"][:, None]
        pivot = at[f"h{k}"][:, None] * np.array([1.0, 0.0, 0.0])
        yield at[f"m{k}"], *_carried(at, pivot + length * s, length * slip)


def _carried(at: Points, place: Array, relative: Array) -> tuple[Array, Array]:
    return place, at.vector("vx", "vy", "vz") + np.cross(_rate(at), place) + relative


def _turning(at: Points) -> Array:
    """Return the energy of rotation about the bodies' own centres."""
    hull = dot(_hull(at) * _rate(at), _rate(at)) / 2
    return hull + np.sum([at[f"I{k}"] * dot(_bob(at, k), _bob(at, k)) / 2 for k in _numbers(at)], axis=0)


def _spins(at: Points) -> Array:
    hull = _hull(at) * _rate(at)
    return hull + np.sum([at[f"I{k}"][:, None] * _bob(at, k) for k in _numbers(at)], axis=0)


def _bob(at: Points, k: int) -> Array:
    """Return the angular velocity of bob k that I_i multiplies, by the convention."""
    convention = at.machine.system.structure["inertia"]
    if convention == "ball":
        s, slip = arm(at, k)
        return np.cross(s, slip + np.cross(_rate(at), s))
    phi_dot, theta_dot, theta = at[f"phi{k}_dot"], at[f"theta{k}_dot"], at[f"theta{k}"]
    if convention == "paper":
        return _rate(at) + np.column_stack([phi_dot, 0 * phi_dot, theta_dot])
    turning = np.column_stack([-theta_dot, phi_dot * np.cos(theta), -phi_dot * np.sin(theta)])
    return _rate(at) + turning


def _hull(at: Points) -> Array:
    return at.vector("J_x", "J_y", "J_z") + at["I0"][:, None]


def _rate(at: Points) -> Array:
    return at.vector("wx", "wy", "wz")


def _numbers(at: Points) -> range:
    return range(1, int(at.machine.system.structure["pendulums"]) + 1)
