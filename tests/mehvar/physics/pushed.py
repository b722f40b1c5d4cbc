# SPDX-License-Identifier: Apache-2.0
"""Physics of the triangle moved by forces: Newton's law for its bodies in Cartesian coordinates.

Rods may have mass, and then velocities of the corners have a mass matrix.
"""

from __future__ import annotations

import numpy as np

from mehvar.physics.gates import Gate, balance, identity
from mehvar.physics.machine import Array, Machine, Points
from tests.mehvar.physics import triangle

_ENDS = ((1, 2), (2, 0), (0, 1))


def gates_of(_: Machine) -> list[Gate]:
    """Return the gates of the dynamic triangle."""
    return [
        identity("computed forces", _accelerated, _wanted),
        identity("lengths, rates and momentum are those of the masses", lambda at: at.along(_flat), _relative),
        balance("Newton's law", _velocities, _accelerations),
        balance("energy", lambda at: at.result("energy", "kinetic")[:, 0], _power),
        identity("kinetic energy", lambda at: at.result("energy", "kinetic")[:, 0], _kinetic),
        balance("Jacobi's integral on a circular orbit", _jacobi, _drives, where=_free),
        identity("Kepler's energy", _orbit, lambda at: -(at["mean_motion"] ** 2) / 2),
        identity("Kepler's momentum", _areal, lambda at: at["mean_motion"] * np.sqrt(1 - at["eccentricity"] ** 2)),
        identity("costs", lambda at: at.result("rhs", "work", "impulse"), _costs),
        identity("shape and attitude place the masses", _by_shape, lambda at: _places(at).reshape(-1, 6)),
        balance("the paper's attitude rate", lambda at: at.result("outputs", "theta"), _turning),
        identity("limits", _limited, _clipped),
        identity("start", lambda at: triangle.distances(_places(_begun(at))), lambda at: _rods(at, "0")),
        identity("state at the start", _first, _scenario),
        identity("target", _target_rods, lambda at: _rods(at, "f")),
        identity("target's attitude, masses in their order", _target_attitude, lambda at: _aligned(at["theta_f"])),
        identity("picture", _picture, lambda at: _places(at).reshape(-1, 6)),
        *triangle.errors(
            _distance,
            _at_target,
            lambda at: triangle.distances(_places(at)),
            lambda at: at.result("outputs", "theta"),
            lambda at: at.moved(H=0.0),
        ),
    ]


def _push(at: Points) -> Array:
    """Return the forces along the rods, positive where they push."""
    return at.vector("F1", "F2", "F3")


def _centred(at: Points, X: Array) -> Array:
    lumps = triangle.mass_matrix(at).sum(axis=2)
    centre = np.sum(lumps[..., None] * X, axis=1) / lumps.sum(axis=1)[:, None]
    return np.asarray(X - centre[:, None])


def _places(at: Points) -> Array:
    """Return the masses about their centre, in fixed axes, shape (n, 3, 2)."""
    l1, l2, l3 = at.vector("l1", "l2", "l3").T
    angle = np.arccos((l2**2 + l3**2 - l1**2) / (2 * l2 * l3))
    ahead, up = (np.stack([np.cos(a), np.sin(a)], axis=-1) for a in (at["psi"], at["psi"] + angle))
    X = np.stack([0 * ahead, l3[:, None] * ahead, l2[:, None] * up], axis=1)
    return _centred(at, X)


def _flat(at: Points) -> Array:
    return _places(at).reshape(-1, 6)


def _relative(at: Points) -> Array:
    """Solve rates of rods, momentum and a centre at rest for the velocities."""
    X, m = _places(at), triangle.mass_matrix(at)
    moments, lumps = m @ X, m.sum(axis=2)
    left = np.zeros((len(X), 6, 6))
    for k, (i, j) in enumerate(_ENDS):
        along = (X[:, j] - X[:, i]) / np.linalg.norm(X[:, j] - X[:, i], axis=1)[:, None]
        left[:, k, 2 * j : 2 * j + 2], left[:, k, 2 * i : 2 * i + 2] = along, -along
    for i in range(3):
        left[:, 3, 2 * i], left[:, 3, 2 * i + 1] = -moments[:, i, 1], moments[:, i, 0]
        left[:, 4, 2 * i] = left[:, 5, 2 * i + 1] = lumps[:, i]
    right = np.column_stack([at.vector("u_l1", "u_l2", "u_l3", "H"), np.zeros((len(X), 2))])
    return np.asarray(np.linalg.solve(left, right[..., None])[..., 0])


def _velocities(at: Points) -> Array:
    return _relative(at) + np.tile(at.vector("vx", "vy"), 3)


def _thrust(at: Points) -> Array:
    """Return the thrust on each mass in fixed axes, shape (n, 3, 2)."""
    own = at.vector(*(f"f{i}{axis}" for i in (1, 2, 3) for axis in "xy")).reshape(-1, 3, 2)
    c, s = np.cos(at["psi"])[:, None], np.sin(at["psi"])[:, None]
    return np.stack([c * own[..., 0] - s * own[..., 1], s * own[..., 0] + c * own[..., 1]], axis=-1)


def _accelerations(at: Points) -> Array:
    X, force, along_rods = _places(at), _thrust(at), _push(at)
    for k, (i, j) in enumerate(_ENDS):
        push = along_rods[:, k, None] * (X[:, j] - X[:, i]) / np.linalg.norm(X[:, j] - X[:, i], axis=1)[:, None]
        force[:, j] += push
        force[:, i] -= push
    return np.asarray((np.linalg.solve(triangle.mass_matrix(at), force) + _gravity(at)).reshape(-1, 6))


def _distance(at: Points) -> Array:
    """Return the distance from the Earth over the semi-major axis."""
    return np.asarray((1 - at["eccentricity"] ** 2) / (1 + at["eccentricity"] * np.cos(at["nu"])))


def _gravity(at: Points) -> Array:
    """Return the gravity gradient on each mass, to first order in the place."""
    X, r = _places(at), np.stack([np.cos(at["nu"]), np.sin(at["nu"])], axis=-1)[:, None, :]
    strength = (at["mean_motion"] ** 2 / _distance(at) ** 3)[:, None, None]
    return np.asarray(strength * (3 * r * np.sum(r * X, axis=-1, keepdims=True) - X))


def _power(at: Points) -> Array:
    V = _velocities(at).reshape(-1, 3, 2)
    weight = triangle.mass_matrix(at) @ _gravity(at)
    return np.asarray(_drives(at) + np.sum((_thrust(at) + weight) * V, axis=(1, 2)))


def _drives(at: Points) -> Array:
    """Return the power of the forces along the rods."""
    return np.asarray(np.sum(_push(at) * at.vector("u_l1", "u_l2", "u_l3"), axis=1))


def _kinetic(at: Points) -> Array:
    V = _velocities(at).reshape(-1, 3, 2)
    return np.asarray(np.sum(V * (triangle.mass_matrix(at) @ V), axis=(1, 2)) / 2)


def _free(at: Points) -> Points:
    return at.moved(eccentricity=0.0, **{q.name: 0.0 for q in at.machine.system.inputs})


def _jacobi(at: Points) -> Array:
    return np.asarray(at.result("energy", "kinetic", "potential").sum(axis=1) - at["mean_motion"] * at["H"])


def _orbit(at: Points) -> Array:
    """Return the energy of the orbit of semi-major axis one: n^2 is the gravitational parameter."""
    rate = at.along(lambda here: _distance(here)[:, None])[:, 0]
    across = _distance(at) * at.result("rhs", "nu")[:, 0]
    return np.asarray((rate**2 + across**2) / 2 - at["mean_motion"] ** 2 / _distance(at))


def _areal(at: Points) -> Array:
    return np.asarray(_distance(at) ** 2 * at.result("rhs", "nu")[:, 0])


def _costs(at: Points) -> Array:
    drives = np.abs(_push(at) * at.vector("u_l1", "u_l2", "u_l3")).sum(axis=1)
    own = at.vector(*(f"f{i}{axis}" for i in (1, 2, 3) for axis in "xy"))
    return np.column_stack([drives, np.abs(own).sum(axis=1)])


def _by_shape(at: Points) -> Array:
    return _centred(at, triangle.placed(at, *at.result("outputs", "rho", "phi", "mu", "theta").T)).reshape(-1, 6)


def _zeta(at: Points) -> Array:
    rho, phi = at.result("outputs", "rho", "phi").T
    return np.asarray(rho * np.exp(1j * phi))[:, None]


def _turning(at: Points) -> Array:
    """Return (21) with what momentum adds."""
    inertia = triangle.alike(at).mean(axis=1)[:, None] * at.result("outputs", "mu") / 3
    return np.imag(np.conj(_zeta(at)) * at.along(_zeta)) + at["H"][:, None] / inertia


def _wanted(at: Points) -> Array:
    return np.asarray(at["l1_0"][:, None] * [1.0, -2.0, 3.0])


def _accelerated(at: Points) -> Array:
    push = at.machine("forces", at.values["x"], _wanted(at), at.values["p"])
    still = {f"f{i}{axis}": 0.0 for i in (1, 2, 3) for axis in "xy"}
    there = at.moved(**{f"F{k + 1}": push[:, k] for k in range(3)}, **still)
    return there.result("rhs", "u_l1", "u_l2", "u_l3")


def _limited(at: Points) -> Array:
    return at.machine("actuate", at.values["x"], 2 * at.values["u"], at.values["p"])


def _clipped(at: Points) -> Array:
    limit = at.vector(*["F_max"] * 3, *["thrust_max"] * 6)
    return np.clip(2 * at.values["u"], -limit, limit)


def _begun(at: Points) -> Points:
    """Return the points at the start of their scenario."""
    return at.at(x=at.call("initial"))


def _rods(at: Points, end: str) -> Array:
    return at.vector(*(f"l{k}_{end}" for k in (1, 2, 3)))


def _first(at: Points) -> Array:
    first = _begun(at)
    states = ("l1", "l2", "l3", "u_l1", "u_l2", "u_l3", "H", "nu", "vx", "vy", "work", "impulse")
    return np.column_stack([first.result("outputs", "theta"), first.vector(*states)])


def _scenario(at: Points) -> Array:
    named = at.vector("theta_0", "l1_0", "l2_0", "l3_0", "u_l1_0", "u_l2_0", "u_l3_0")
    return np.column_stack([named, at["H_0"], at["nu_0"], np.zeros((len(named), 4))])


def _target_rods(at: Points) -> Array:
    rho, phi, mu, theta = at.call("reference").T
    return triangle.distances(triangle.placed(at, rho, phi, mu, theta))


def _target_attitude(at: Points) -> Array:
    rho, phi, mu, theta = at.call("reference").T
    return np.column_stack([theta, triangle.sense(triangle.placed(at, rho, phi, mu, theta))])


def _aligned(theta: Array) -> Array:
    return np.column_stack([theta, np.ones(len(theta))])


def _picture(at: Points) -> Array:
    """Return the three masses of the picture, which follow its rods of two ends each; its second axis is depth."""
    return at.call("geometry").reshape(len(at["H"]), -1, 3)[:, 6:9, ::2].reshape(-1, 6)


def _at_target(at: Points) -> Points:
    X = triangle.placed(at, *at.vector("rho_ref", "phi_ref", "mu_ref", "theta_ref").T)
    l1, l2, l3 = triangle.distances(X).T
    return at.moved(l1=l1, l2=l2, l3=l3)


def _distance(at: Points) -> Array:
    return at["rho_ref"][:, None] - _zeta(at) * np.exp(-1j * at["phi_ref"])[:, None]
