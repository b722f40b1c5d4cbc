# SPDX-License-Identifier: Apache-2.0
"""Three planar point masses joined by rods of prescribed lengths, in Cartesian coordinates.

Edge ``k`` is opposite vertex ``k``: ``D_1 = X_3 - X_2``, ``D_2 = X_1 - X_3``, ``D_3 = X_2 - X_1``.
Positions (m) have shape ``(3, 2)``, vertices counter-clockwise; lengths (m) and masses (kg) ``(3,)``.
"""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.linalg import null_space

Array = NDArray[np.float64]
Signal = Callable[[float], Array]

EDGES = ((1, 2), (2, 0), (0, 1))
TOLERANCE = 1e-13


def base_triangle(masses: Sequence[float]) -> Array:
    """Return the base positions: sum m x x^T = (mean mass / 2) I, counter-clockwise, edge 3 along +x."""
    m = np.asarray(masses, dtype=float)
    x = np.sqrt(m.mean() / (2 * m))[:, None] * null_space(np.sqrt(m)[None, :])
    edge_3, edge_1 = x[1] - x[0], x[2] - x[1]
    side = edge_3 / np.linalg.norm(edge_3)
    normal = np.array([-side[1], side[0]])
    return np.column_stack([x @ side, x @ normal * np.sign(normal @ edge_1)])


def attitude(positions: Array, masses: Sequence[float]) -> Array:
    """Return theta (rad, unwrapped along the first axis) of positions of shape ``(..., 3, 2)``."""
    x = base_triangle(masses)
    edges = np.stack([positions[..., 1, :] - positions[..., 0, :], positions[..., 2, :] - positions[..., 0, :]], -1)
    A = edges @ np.linalg.inv(np.column_stack([x[1] - x[0], x[2] - x[0]]))
    theta: Array = np.arctan2(A[..., 1, 0] - A[..., 0, 1], A[..., 0, 0] + A[..., 1, 1])
    return np.unwrap(theta, axis=0) if theta.ndim else theta


def place(l1: float, l2: float, l3: float, theta: float, masses: Sequence[float]) -> Array:
    """Return positions about the mass centre of the triangle with these lengths and this attitude."""
    along = (l2**2 + l3**2 - l1**2) / (2 * l3)
    X = np.array([[0.0, 0.0], [l3, 0.0], [along, np.sqrt(l2**2 - along**2)]])
    X -= np.average(X, axis=0, weights=masses)
    turn = theta - float(attitude(X, masses))
    Q = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    turned: Array = X @ Q.T
    return turned


def rods(positions: Array) -> Array:
    """Return the lengths of positions of shape ``(..., 3, 2)``."""
    ends = [positions[..., j, :] - positions[..., i, :] for i, j in EDGES]
    return _norms(np.stack(ends, -2))


def angular_momentum(X: Array, V: Array, masses: Sequence[float]) -> float:
    """Return sum m X x V of one configuration."""
    return float(np.asarray(masses) @ (X[:, 0] * V[:, 1] - X[:, 1] * V[:, 0]))


def velocities(X: Array, length_times_rate: Array, masses: Sequence[float], momentum: float = 0.0) -> Array:
    """Return the velocities of zero linear momentum, given angular momentum and given rod rates."""
    m = np.asarray(masses, dtype=float)
    rows = np.zeros((6, 3, 2))
    rows[0, :, 0] = rows[1, :, 1] = m
    rows[2] = m[:, None] * np.column_stack([-X[:, 1], X[:, 0]])
    rows[3:] = _stretch(X)
    return np.linalg.solve(rows.reshape(6, 6), [0.0, 0.0, momentum, *length_times_rate]).reshape(3, 2)


def integrate(
    lengths: Signal,
    rates: Signal,
    masses: Sequence[float],
    start: Array,
    times: Array,
    momentum: float = 0.0,
) -> Array:
    """Return the positions ``(n, 3, 2)`` at ``times`` from the momenta and the rod rates."""

    def slope(t: float, y: Array) -> Array:
        return velocities(y.reshape(3, 2), lengths(t) * rates(t), masses, momentum).ravel()

    return _solve(slope, start.ravel(), times).T.reshape(-1, 3, 2)


def integrate_newton(
    lengths: Signal,
    rates: Signal,
    accelerations: Signal,
    masses: Sequence[float],
    start: Array,
    times: Array,
    momentum: float = 0.0,
) -> tuple[Array, Array]:
    """Return positions and velocities, each ``(n, 3, 2)``, from the rod forces.

    ``momentum`` only sets the initial velocities: rod forces are internal, so it has to be conserved.
    """
    inverse_mass = 1 / np.repeat(np.asarray(masses, dtype=float), 2)

    def slope(t: float, y: Array) -> Array:
        X, V = y.reshape(2, 3, 2)
        G = _stretch(X).reshape(3, 6)
        speed = rods(V)
        wanted = lengths(t) * accelerations(t) + rates(t) ** 2 - speed**2
        multiplier = np.linalg.solve(G * inverse_mass @ G.T, wanted)
        return np.concatenate([V.ravel(), inverse_mass * (multiplier @ G)])

    V0 = velocities(start, lengths(float(times[0])) * rates(float(times[0])), masses, momentum)
    y = _solve(slope, np.concatenate([start.ravel(), V0.ravel()]), times).T.reshape(-1, 2, 3, 2)
    return y[:, 0], y[:, 1]


def circular_loop(
    radius: float, centre: complex, masses: Sequence[float], mu: float = 3.0
) -> tuple[Signal, Signal, Signal]:
    """Return l, l' and l'' of the shape loop rho e^(i phi) = centre + radius e^(i t) at constant mu.

    The lengths are the distances between the points S x of the stretched base triangle.
    """
    x = base_triangle(masses)
    edges = np.array([x[j] - x[i] for i, j in EDGES])

    def stretches(t: float) -> list[Array]:
        zeta = centre + radius * np.exp(1j * t)
        d1, d2 = 1j * radius * np.exp(1j * t), -radius * np.exp(1j * t)
        n = np.sqrt(1 - abs(zeta) ** 2)
        n1 = -(np.conj(zeta) * d1).real / n
        n2 = -(abs(d1) ** 2 + (np.conj(zeta) * d2).real + n1**2) / n
        return [edges @ _symmetric(a, b) * np.sqrt(mu / 3) for a, b in ((n, zeta), (n1, d1), (n2, d2))]

    def lengths(t: float) -> Array:
        return _norms(stretches(t)[0])

    def rates(t: float) -> Array:
        D, D1, _ = stretches(t)
        return np.asarray(np.sum(D * D1, axis=1) / _norms(D))

    def accelerations(t: float) -> Array:
        D, D1, D2 = stretches(t)
        return np.asarray((np.sum(D1**2 + D * D2, axis=1) - rates(t) ** 2) / _norms(D))

    return lengths, rates, accelerations


def theta_after_loop(radius: float, centre: complex, masses: Sequence[float], n_laps: int = 1) -> float:
    """Return the change of theta (rad) over laps of a circle in the (rho, phi) disc."""
    lengths, rates, _ = circular_loop(radius, centre, masses)
    times = np.linspace(0, 2 * np.pi * n_laps, 64 * n_laps + 1)
    l1, l2, l3 = lengths(0.0)
    X = integrate(lengths, rates, masses, place(l1, l2, l3, 0.0, masses), times)
    theta = attitude(X, masses)
    return float(theta[-1] - theta[0])


def _norms(vectors: Array) -> Array:
    norms: Array = np.linalg.norm(vectors, axis=-1)
    return norms


def _symmetric(d: float, zeta: complex) -> Array:
    u, v = zeta.real, -zeta.imag
    return np.array([[d + u, v], [v, d - u]])


def _stretch(X: Array) -> Array:
    """Return the gradients of the half squared lengths, shape ``(3, 3, 2)``."""
    G = np.zeros((3, 3, 2))
    for k, (i, j) in enumerate(EDGES):
        G[k, j] = X[j] - X[i]
        G[k, i] = -G[k, j]
    return G


def _solve(slope: Callable[[float, Array], Array], start: Array, times: Array) -> Array:
    span = (float(times[0]), float(times[-1]))
    solution = solve_ivp(slope, span, start, "DOP853", times, rtol=TOLERANCE, atol=TOLERANCE)
    if not solution.success:
        raise ArithmeticError(solution.message)
    y: Array = solution.y
    return y
