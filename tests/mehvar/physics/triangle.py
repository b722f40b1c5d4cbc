# SPDX-License-Identifier: Apache-2.0
"""Physics of the three planar masses."""

from __future__ import annotations

import functools
from collections.abc import Callable

import numpy as np

from mehvar.physics.gates import Gate, Symmetry, balance, identity, symmetric
from mehvar.physics.machine import Array, Machine, Points
from tests.reference.cartesian_triangle import base_triangle

_LOOP = 64
"""Points on a closed path in the shape disc."""


def gates_of(subject: Machine) -> list[Gate]:
    """Return the gates of equal or general masses, with rods that follow their rates."""
    found = [
        identity("angular momentum", momentum, lambda at: at["H"] + at["disturbance"] * _inertia(at)),
        identity("rods join the masses", lambda at: at.call("lengths"), rods),
        identity("rates of rods", lambda at: at.call("length_rates"), lambda at: at.along(rods)),
        identity("outputs: rods", lambda at: at.call("outputs")[:, :6], _rods_and_rates),
        identity("rods give the shape", _shape_of_rods, shape),
        identity("placing of initial rods", lambda at: _rods_of(at, at.call("initial")), lambda at: _wanted(at, "0")),
        identity("placing of final rods", lambda at: _rods_of(at, at.call("reference")), lambda at: _wanted(at, "f")),
        identity("masses in their order", _order_of_masses, lambda at: np.ones((len(at["rho"]), 2))),
        identity("start and target attitude", _attitudes, lambda at: at.vector("theta_0", "theta_f")),
        balance("inputs are the rates", shape, lambda at: at.vector("w1", "w2", "w3")),
        balance("regular chart", lambda at: at.call("to_coordinates"), _chart_rates),
        identity("chart and back", _there_and_back, lambda at: at.values["x"]),
        symmetric(_REFLECTION if subject.system.structure["masses"] == "equal" else _EXCHANGE),
        symmetric(Symmetry("turned as a whole", shifts={"theta": 0.8})),
        identity("twice the size", lambda at: _twice(at).call("rhs")[:, 3], lambda at: _coasting(at).call("rhs")[:, 3]),
        *errors(_distance, _arrived, rods, lambda at: at["theta"][:, None], _coasting),
    ]
    if subject.system.structure["masses"] == "equal":
        found.append(identity("order of rods", _turned_rods, lambda at: np.roll(at.call("lengths"), 1, axis=1)))
    found.append(identity("attitude by the loop's area", _turn_of_a_loop, _twice_the_area))
    return found


_FLIPPED = frozenset({"phi", "theta", "w2", "H", "disturbance"})
_REFLECTION = Symmetry("reflection", _FLIPPED)
_EXCHANGE = Symmetry("reflection", _FLIPPED, {"m1": "m2", "m2": "m1"})


def errors(
    distance: Callable[[Points], Array],
    arrived: Callable[[Points], Points],
    lengths: Callable[[Points], Array],
    attitude: Callable[[Points], Array],
    coasting: Callable[[Points], Points],
) -> list[Gate]:
    """Return the errors of a run: differences in the shape disc, and the area that is still to be enclosed."""

    def direction(at: Points) -> Array:
        return at.result("outputs", "rho_error") * np.exp(1j * at.result("outputs", "phi_error"))

    def enclosed(at: Points) -> Array:
        return np.imag(np.conj(distance(at)) * at.along(distance))

    def longest(at: Points) -> Array:
        return np.abs(lengths(at) - lengths(arrived(at))).max(axis=1)

    def turned(at: Points) -> Array:
        return at.result("outputs", "theta_error")

    return [
        identity("distance to the target", direction, distance),
        balance("shifted attitude", lambda at: at.result("outputs", "theta_shifted"), enclosed, where=coasting),
        identity(
            "shifted attitude at the target",
            lambda at: arrived(at).result("outputs", "theta_shifted"),
            lambda at: turned(arrived(at)),
        ),
        identity("attitude error", turned, lambda at: attitude(at) - at["theta_ref"][:, None]),
        identity("length error", lambda at: at.result("outputs", "length_error")[:, 0], longest),
    ]


def _arrived(at: Points) -> Points:
    return at.moved(rho=at["rho_ref"], phi=at["phi_ref"], mu=at["mu_ref"])


def _distance(at: Points) -> Array:
    return (at["rho_ref"] - at["rho"] * np.exp(1j * (at["phi"] - at["phi_ref"])))[:, None]


def shape(at: Points) -> Array:
    return at.vector("rho", "phi", "mu")


def masses(at: Points) -> Array:
    equal = at.machine.system.structure["masses"] == "equal"
    return at.vector("mass", "mass", "mass") if equal else at.vector("m1", "m2", "m3")


def mass_matrix(at: Points) -> Array:
    """Return the mass matrix of the corners, shape (n, 3, 3): uniform rods summed up along themselves."""
    total = masses(at)[..., None] * np.eye(3)
    if at.machine.system.structure["rods"] == "light":
        return total
    equal = at.machine.system.structure["masses"] == "equal"
    nodes, weights = np.polynomial.legendre.leggauss(4)
    for k, (i, j) in enumerate(((1, 2), (2, 0), (0, 1)), 1):
        beam = at["rod_mass" if equal else f"rod_mass{k}"]
        for node, weight in zip(nodes, weights, strict=True):
            part = np.zeros(3)
            part[[i, j]] = (1 - node) / 2, (1 + node) / 2
            total = total + beam[:, None, None] * weight / 2 * np.outer(part, part)
    return total


def alike(at: Points) -> Array:
    """Return the masses of three points that have the kinetic energy of all bodies about their centre."""
    matrix = mass_matrix(at)
    lumps = matrix.sum(axis=2)
    about = lumps[:, :, None] * lumps[:, None, :] / lumps.sum(axis=1)[:, None, None] - matrix
    across = np.stack([about[:, 1, 2], about[:, 2, 0], about[:, 0, 1]], axis=1)
    pairs = across[:, 0] * across[:, 1] + across[:, 1] * across[:, 2] + across[:, 2] * across[:, 0]
    return np.asarray(pairs[:, None] / across)


def positions(at: Points) -> Array:
    """Return the masses' places about their centre, shape (n, 3, 2)."""
    return placed(at, *at.vector("rho", "phi", "mu", "theta").T)


def placed(at: Points, rho: Array, phi: Array, mu: Array, theta: Array) -> Array:
    """Return the places Q S x_i of a shape and an attitude, shape (n, 3, 2)."""
    base = np.stack([_base(*m) for m in alike(at)])
    z1, z2 = rho * np.cos(phi), rho * np.sin(phi)
    n = np.sqrt(1 - rho**2)
    stretch = np.sqrt(mu / 3) * np.array([[n + z1, -z2], [-z2, n - z1]])
    c, s = np.cos(theta), np.sin(theta)
    return np.einsum("ijn,jkn,nmk->nmi", np.array([[c, -s], [s, c]]), stretch, base)


@functools.cache
def _base(*masses: float) -> Array:
    return base_triangle(np.array(masses))


def momentum(at: Points) -> Array:
    """Return sum m X x X' along the motion."""
    X, V = positions(at), at.along(positions_flat).reshape(-1, 3, 2)
    return np.sum(masses(at) * (X[..., 0] * V[..., 1] - X[..., 1] * V[..., 0]), axis=1)


def positions_flat(at: Points) -> Array:
    return positions(at).reshape(-1, 6)


def rods(at: Points) -> Array:
    """Return the distances between the masses; rod k is opposite mass k."""
    return distances(positions(at))


def distances(X: Array) -> Array:
    """Return the lengths of the rods between places of shape (n, 3, 2)."""
    return np.stack([np.linalg.norm(X[:, j] - X[:, i], axis=1) for i, j in ((1, 2), (2, 0), (0, 1))], axis=1)


def _inertia(at: Points) -> Array:
    return inertia(at, positions(at))


def inertia(at: Points, X: Array) -> Array:
    """Return the moment of inertia of masses at places about their centre, shape (n, 3, 2)."""
    return np.sum(masses(at) * np.sum(X**2, axis=2), axis=1)


def _coasting(at: Points) -> Points:
    return at.moved(H=0.0, disturbance=0.0)


def _twice(at: Points) -> Points:
    return _coasting(at).moved(mu=4 * at["mu"], w3=4 * at["w3"])


def _turn_of_a_loop(at: Points) -> Array:
    """Integrate theta' once around rho = r (1 + cos(phi)/3) without momentum."""
    total = np.zeros(len(at["rho"]))
    for phi in np.arange(_LOOP) * 2 * np.pi / _LOOP:
        r = at["rho"] * (1 + np.cos(phi) / 3)
        here = _coasting(at).moved(rho=r, phi=phi, w1=-at["rho"] * np.sin(phi) / 3, w2=1.0, w3=0.0)
        total += here.call("rhs")[:, 3] * 2 * np.pi / _LOOP
    return total


def _twice_the_area(at: Points) -> Array:
    return 2 * np.pi * at["rho"] ** 2 * (1 + 1 / 18)


def _rods_and_rates(at: Points) -> Array:
    return np.hstack([rods(at), at.along(rods)])


def _shape_of_rods(at: Points) -> Array:
    own = [at.values["p"]] if len(at.machine.requests["shape"].arguments) == 4 else []
    return at.machine("shape", *rods(at).T[:, :, None], *own)


def _rods_of(at: Points, state: Array) -> Array:
    return rods(at.at(x=state))


def _wanted(at: Points, end: str) -> Array:
    return at.vector(*(f"l{k}_{end}" for k in (1, 2, 3)))


def _order_of_masses(at: Points) -> Array:
    """Return the sense in which the masses follow each other at start and target: counterclockwise is 1."""
    return np.column_stack([sense(positions(at.at(x=at.call(end)))) for end in ("initial", "reference")])


def sense(X: Array) -> Array:
    a, b = X[:, 1] - X[:, 0], X[:, 2] - X[:, 0]
    return np.sign(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])


def _attitudes(at: Points) -> Array:
    return np.column_stack([at.call("initial")[:, 3], at.call("reference")[:, 3]])


def _chart_rates(at: Points) -> Array:
    q, n = at.call("to_coordinates"), at.call("chart_inputs")
    return at.machine("chart_rhs", q, n, at.values["p"])


def _there_and_back(at: Points) -> Array:
    return at.machine("from_coordinates", at.call("to_coordinates"))


def _turned_rods(at: Points) -> Array:
    return at.moved(phi=at["phi"] + 2 * np.pi / 3).call("lengths")
