# SPDX-License-Identifier: Apache-2.0
"""Hand-written closed loop of the planar three-mass triangle of equal masses (Makarem et al.).

The shape is zeta = rho e^(i phi), the error w = rho_f - zeta e^(-i phi_f).
State: zeta, theta (rad), mu (m^2).
Integration is by classical Runge-Kutta steps; unless it is held, the law is evaluated in every stage.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import acos, atan2, copysign, cos, pi, remainder, sin, sqrt

import numpy as np
from numpy.typing import NDArray

from tests.reference import cartesian_triangle as cartesian

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
ErrorRate = Callable[[complex, float, float], complex]

EDGE_TURNS: ComplexArray = np.exp(1j * np.array([-2, 2, 0]) * pi / 3)
CASES = {
    "A": ((0.2, 0.2, 0.3), (0.3, 0.3, 0.5)),
    "B": ((0.2, 0.2, 0.3), (0.3, 0.4, 0.5)),
    "C": ((0.21, 0.21, 0.23), (0.23, 0.23, 0.25)),
}


def shape(lengths: Sequence[float]) -> tuple[complex, float]:
    """Return zeta and mu (m^2) of three lengths (m), equation (19)."""
    q1, q2, q3 = (length**2 for length in lengths)
    mu = q1 + q2 + q3
    eta = 2 * (q1 * q2 + q2 * q3 + q3 * q1) - (q1**2 + q2**2 + q3**2)
    z = complex(2 * q3 - q1 - q2, sqrt(3) * (q1 - q2)) / (2 * mu)
    return z / sqrt((1 + sqrt(3 * eta) / mu) / 2), mu


def rods(zeta: ComplexArray, mu: Array) -> Array:
    """Return the lengths (m), shape ``(n, 3)``, equation (20)."""
    n = np.sqrt(1 - np.abs(zeta) ** 2)[:, None]
    squares: Array = mu[:, None] / 3 * (1 + 2 * n * (zeta[:, None] * EDGE_TURNS).real)
    return np.sqrt(squares)


def rod_rates(zeta: ComplexArray, mu: Array, zeta_rate: ComplexArray, mu_rate: Array) -> Array:
    """Return the rod rates (m/s), shape ``(n, 3)``: the regular form of equation (22)."""
    n = np.sqrt(1 - np.abs(zeta) ** 2)[:, None]
    n_rate = -(np.conj(zeta) * zeta_rate).real[:, None] / n
    c, c_rate = (zeta[:, None] * EDGE_TURNS).real, (zeta_rate[:, None] * EDGE_TURNS).real
    squares_rate: Array = (1 + 2 * n * c) * mu_rate[:, None] / 3 + 2 * mu[:, None] / 3 * (n_rate * c + n * c_rate)
    return squares_rate / (2 * rods(zeta, mu))


@dataclass(frozen=True)
class Sliding:
    """Sliding-mode law, equations (29)-(39); a zero threshold gives the discontinuous sign."""

    k: float = 3.0
    m: float = 3.0
    theta_star: float = 4.0
    R: float = 0.65
    eta: float | None = None
    s_min: float = 0.02
    theta_min: float = 0.001

    def __call__(self, w: complex, theta: float, a: float) -> complex:
        """Return w' at the error w, the shifted attitude error theta (rad) and the target radius a."""
        distance = abs(w)
        if distance == 0 and theta == 0:
            return 0j
        turn = w / distance if distance else 1 + 0j
        root = sqrt(self.R**2 - (a * turn.imag) ** 2)
        h, g = a * turn.real + root, a * turn.imag / root
        ratio = abs(theta / self.theta_star)
        sigma = self.k * sqrt(distance / h) / (ratio + (distance / h) ** 2)
        s = distance - ratio ** (1 / self.m) * h
        angular = -sigma * ratio ** (1 - 1 / self.m) * _saturate(theta, self.theta_min)
        radial = sigma * h / self.theta_star * (g * theta - distance**2 / self.m)
        eta = self.k * self.R / self.m if self.eta is None else self.eta
        return complex(radial - eta * _saturate(s, self.s_min), distance * angular) * turn


@dataclass(frozen=True)
class Path:
    """Online path planning law, equations (40)-(51)."""

    k: float = 0.5
    R: float = 0.65
    eps: float = 0.02
    limited: bool = True

    def __call__(self, w: complex, theta: float, a: float) -> complex:
        """Return w' at the error w, the shifted attitude error theta (rad) and the target radius a."""
        distance = abs(w)
        turn = w / distance if distance >= 1e-9 else 1 + 0j
        alpha = copysign(1.0, theta)
        x = chord_angle(2 * abs(theta) / max(distance**2, 1e-300))
        if self.limited:
            x = min(x, self.tangent_angle(distance, turn, alpha, a))
        leaving = max(distance, self.eps) if cos(x) < 0 else distance
        return -self.k * complex(leaving * cos(x), distance * alpha * sin(x)) * turn

    def tangent_angle(self, distance: float, turn: complex, alpha: float, a: float) -> float:
        """Return x of the arc to the target that touches the circle rho = R from inside."""
        p = (self.R**2 - a**2) * turn + a * distance
        centre = atan2(p.imag, p.real) - alpha * acos(min(1.0, distance * self.R / abs(p)))
        return pi / 2 - alpha * remainder(centre - atan2(turn.imag, turn.real), 2 * pi)


def chord_angle(K: float) -> float:
    """Solve (x - sin x cos x) / sin^2 x = K for x in [0, pi), equation (42)."""
    if K < 0.03:
        return K * (1.5 + K**2 * (-9 / 20 + K**2 * (729 / 2800 - K**2 * 729 / 4000)))
    K = min(K, 1e12)
    r = sqrt(K)
    x = pi * r**2 * (r + 1.661023) / (r**3 + 2.225213 * r**2 + 0.566927 * r + 3.478838)
    for _ in range(3):
        F = x - sin(x) * cos(x) - K * sin(x) ** 2
        F1 = 2 * sin(x) * (sin(x) - K * cos(x))
        F2 = 2 * sin(2 * x) - 2 * K * cos(2 * x)
        x -= 2 * F * F1 / (2 * F1**2 - F * F2)
    return x


@dataclass(frozen=True)
class Run:
    """Time histories of one closed loop; ``lengths`` and ``rates`` have shape ``(n, 3)``."""

    time: Array
    zeta: ComplexArray
    theta: Array
    mu: Array
    w: ComplexArray
    shifted: Array
    lengths: Array
    rates: Array
    target: Array

    def every(self, stride: int) -> "Run":
        """Return the run on every ``stride``-th sample."""
        thin = {k: v[::stride] for k, v in vars(self).items() if k != "target"}
        return Run(**thin, target=self.target)


def simulate(
    case: str,
    law: ErrorRate,
    duration: float = 35.0,
    step: float = 0.002,
    drift: float = 0.0,
    shift_factor: float = 1.0,
    theta_0: float = 1.0,
    hold: int = 0,
) -> Run:
    """Run a law from a case's initial lengths and ``theta_0`` (rad) to its final lengths and theta = 0.

    ``drift`` (rad/s) is d of equation (53); ``shift_factor`` multiplies the last term of equation (27).
    ``hold`` > 0 keeps zeta' constant over that many steps.
    """
    initial, final = CASES[case]
    zeta_f, mu_f = shape(final)
    a, axis = abs(zeta_f), zeta_f / abs(zeta_f)
    held = 0j

    def command(zeta: complex, theta: float) -> complex:
        w = a - zeta / axis
        return -law(w, theta + shift_factor * a * w.imag, a) * axis

    def slope(zeta: complex, theta: float, mu: float) -> tuple[complex, float, float]:
        zeta_rate = held if hold else command(zeta, theta)
        return zeta_rate, (zeta.conjugate() * zeta_rate).imag + drift, _growth(mu, mu_f)

    zeta, mu = shape(initial)
    theta = theta_0
    count = round(duration / step)
    state = np.empty((count + 1, 3), complex)
    slopes = np.empty((count + 1, 3), complex)
    for i in range(count + 1):
        if hold and i % hold == 0:
            held = command(zeta, theta)
        k1 = slope(zeta, theta, mu)
        state[i], slopes[i] = (zeta, theta, mu), k1
        k2 = slope(zeta + step / 2 * k1[0], theta + step / 2 * k1[1], mu + step / 2 * k1[2])
        k3 = slope(zeta + step / 2 * k2[0], theta + step / 2 * k2[1], mu + step / 2 * k2[2])
        k4 = slope(zeta + step * k3[0], theta + step * k3[1], mu + step * k3[2])
        zeta += step / 6 * (k1[0] + 2 * k2[0] + 2 * k3[0] + k4[0])
        theta += step / 6 * (k1[1] + 2 * k2[1] + 2 * k3[1] + k4[1])
        mu += step / 6 * (k1[2] + 2 * k2[2] + 2 * k3[2] + k4[2])
    Z, T, M = state[:, 0], state[:, 1].real, state[:, 2].real
    W = a - Z / axis
    rates = rod_rates(Z, M, slopes[:, 0], slopes[:, 2].real)
    time = np.linspace(0, duration, count + 1)
    return Run(time, Z, T, M, W, T + shift_factor * a * W.imag, rods(Z, M), rates, np.array(final))


def simulate_held_rods(case: str, law: ErrorRate, duration: float, period: float = 0.01) -> Run:
    """Run a law whose rod rates are held over each period (s), on three Cartesian masses."""
    initial, final = CASES[case]
    zeta_f, mu_f = shape(final)
    a, axis = abs(zeta_f), zeta_f / abs(zeta_f)
    masses, half = (1.0, 1.0, 1.0), period / 2
    X = cartesian.place(*initial, theta=1.0, masses=masses)
    count = round(duration / period)
    zetas, errors = np.empty((2, count + 1), complex)
    thetas, mus = np.empty((2, count + 1))
    lengths, rates = np.empty((2, count + 1, 3))
    for i in range(count + 1):
        lengths[i] = cartesian.rods(X)
        zetas[i], mus[i] = shape(lengths[i])
        thetas[i], errors[i] = cartesian.attitude(X, masses), a - zetas[i] / axis
        zeta_rate = -law(errors[i], thetas[i] + a * errors[i].imag, a) * axis
        one = slice(i, i + 1)
        u = rod_rates(zetas[one], mus[one], np.array([zeta_rate]), np.array([_growth(mus[i], mu_f)]))[0]
        rates[i] = u
        k1 = cartesian.velocities(X, cartesian.rods(X) * u, masses)
        k2 = cartesian.velocities(X + half * k1, (lengths[i] + half * u) * u, masses)
        k3 = cartesian.velocities(X + half * k2, (lengths[i] + half * u) * u, masses)
        k4 = cartesian.velocities(X + period * k3, (lengths[i] + period * u) * u, masses)
        X = X + period / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    time = np.linspace(0, duration, count + 1)
    return Run(time, zetas, thetas, mus, errors, thetas + a * errors.imag, lengths, rates, np.array(final))


def metrics(run: Run) -> dict[str, float]:
    """Return the numbers of the section 5 table, and the final errors."""
    length_error = np.abs(run.lengths - run.target).max(axis=1)
    return {
        "T_theta": settling_time(run.time, np.abs(run.theta), 0.01),
        "T_rho": settling_time(run.time, np.abs(run.w), 0.02),
        "T_len": settling_time(run.time, length_error, 0.005),
        "max_u": float(np.abs(run.rates).max()),
        "travel": float(np.abs(np.diff(run.lengths, axis=0)).sum()),
        "max_rho": float(np.abs(run.zeta).max()),
        "flips": sign_changes(run.rates, 0.001),
        "min_l": float(run.lengths.min()),
        "max_l": float(run.lengths.max()),
        "final_theta": float(run.theta[-1]),
        "final_rho": float(abs(run.w[-1])),
        "final_len": float(length_error[-1]),
    }


def settling_time(time: Array, error: Array, band: float) -> float:
    """Return the first sample time from which the error stays within the band; infinite if it never does."""
    outside = np.flatnonzero(error > band)
    if outside.size == 0:
        return float(time[0])
    return float(time[outside[-1] + 1]) if outside[-1] + 1 < time.size else float("inf")


def sign_changes(signals: Array, band: float) -> int:
    """Count the sign changes of the columns, skipping the samples within the dead band."""
    count = 0
    for signal in signals.T:
        signs = np.sign(signal[np.abs(signal) > band])
        count += int(np.count_nonzero(signs[1:] != signs[:-1]))
    return count


def _growth(mu: float, mu_f: float) -> float:
    """Return mu' (m^2/s), equation (52)."""
    return max(-0.05, min(0.05, 0.5 * (mu_f - mu)))


def _saturate(value: float, width: float) -> float:
    if width == 0:
        return float(np.sign(value))
    return max(-1.0, min(1.0, value / width))
