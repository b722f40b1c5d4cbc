# SPDX-License-Identifier: Apache-2.0
"""A satellite under sampled attitude control, by hand: plant, reference model, estimator and laws in plain numpy.

SI units, radians. Orbit axes: x along the velocity, y opposite to the orbit normal, z to nadir; body axes are
principal; attitude by the 3-2-1 angles (roll, pitch, yaw). Polynomials in q^-1 are arrays, lowest power first.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

INERTIA = np.array([2.13, 3.04, 3.09])
SPIN = np.array([1.47e-5, 1.26e-5, 1.26e-5])
ORBIT_RATE = math.sqrt(3.986004418e14 / (6378137.0 + 600e3) ** 3)
PRINTED_B = ((0.307, 0.0586), (0.305, 0.0411), (0.302, 0.0404))
PROPORTIONAL = np.array([2.1087e-3, 3.0096e-3, 3.0591e-3])
DERIVATIVE = np.array([0.3621e-1, 0.5168e-1, 0.5253e-1])
START = np.radians([10.0, 10.0, 5.0])
STEPS = np.radians([25.0, 30.0, 0.0])


@dataclass(frozen=True)
class Plant:
    """Inertia of the body with the wheels' transverse inertia, spin inertia of the wheels, and orbit."""

    inertia: Array = field(default_factory=INERTIA.copy)
    spin: Array = field(default_factory=SPIN.copy)
    omega0: float = ORBIT_RATE
    wheels: bool = True
    umax: float = math.inf
    hmax: float = math.inf


def rotation(angles: Array) -> Array:
    """Return C, orbit axes to body axes, of the angles (roll, pitch, yaw)."""
    (sp, st, ss), (cp, ct, cs) = np.sin(angles), np.cos(angles)
    return np.array(
        [
            [ct * cs, ct * ss, -st],
            [sp * st * cs - cp * ss, sp * st * ss + cp * cs, sp * ct],
            [cp * st * cs + sp * ss, cp * st * ss - sp * cs, cp * ct],
        ]
    )


def relative_rate(plant: Plant, angles: Array, w: Array) -> Array:
    """Return Omega, the rate relative to the orbit axes, in body axes (4)."""
    return w + plant.omega0 * rotation(angles)[:, 1]


def rates(plant: Plant, x: list[float], u: list[float]) -> list[float]:
    """Return x' of x = (angles, inertial rate, wheel momentum) under the torque u."""
    phi, theta, psi, w1, w2, w3, h1, h2, h3 = x
    i1, i2, i3 = plant.inertia
    w0 = plant.omega0
    sp, cp, st, ct, ss, cs = (f(a) for a in (phi, theta, psi) for f in (math.sin, math.cos))
    p, q, r = w1 + w0 * ct * ss, w2 + w0 * (sp * st * ss + cp * cs), w3 + w0 * (cp * st * ss - sp * cs)
    n1, n2, n3 = -st, sp * ct, cp * ct
    g = 3 * w0 * w0
    j1, j2, j3 = plant.inertia + plant.spin
    l1, l2, l3 = i1 * w1 + h1, i2 * w2 + h2, i3 * w3 + h3
    turn = q * sp + r * cp
    loss = 1.0 if plant.wheels else 0.0
    return [
        p + turn * st / ct,
        q * cp - r * sp,
        turn / ct,
        (u[0] + g * (j3 - j2) * n2 * n3 - (w2 * l3 - w3 * l2)) / i1,
        (u[1] + g * (j1 - j3) * n1 * n3 - (w3 * l1 - w1 * l3)) / i2,
        (u[2] + g * (j2 - j1) * n1 * n2 - (w1 * l2 - w2 * l1)) / i3,
        -loss * u[0],
        -loss * u[1],
        -loss * u[2],
    ]


def advance(plant: Plant, x: Array, u: Array, span: float, steps: int = 5) -> Array:
    """Integrate over `span` seconds at constant torque, by Runge-Kutta 4."""
    y, v, h = x.tolist(), u.tolist(), span / steps
    for _ in range(steps):
        k1 = rates(plant, y, v)
        k2 = rates(plant, [a + h / 2 * b for a, b in zip(y, k1, strict=True)], v)
        k3 = rates(plant, [a + h / 2 * b for a, b in zip(y, k2, strict=True)], v)
        k4 = rates(plant, [a + h * b for a, b in zip(y, k3, strict=True)], v)
        y = [a + h / 6 * (b + 2 * c + 2 * d + e) for a, b, c, d, e in zip(y, k1, k2, k3, k4, strict=True)]
    return np.array(y)


def wheel_limit(plant: Plant, h: Array, wanted: Array, period: float) -> Array:
    """Return the torque that acts: limited so that no wheel passes hmax within a sample, then to umax."""
    if plant.wheels:
        wanted = np.clip(wanted, (h - plant.hmax) / period, (h + plant.hmax) / period)
    return np.clip(wanted, -plant.umax, plant.umax)


def square_wave(t: float, half_period: float = 200.0) -> Array:
    """Return the reference angles: square waves that begin positive."""
    return STEPS if math.floor(t / half_period) % 2 == 0 else -STEPS


@dataclass(frozen=True)
class Design:
    """Settings of an adaptive law, the same for each axis."""

    form: str = "retain"
    d: int = 1
    pole: float = 0.5
    adapt: bool = True
    first: float = 1.0
    factor: float = 1.0
    printed: bool = False
    forgetting: float = 0.998
    cap: float = math.inf
    dead_zone: float = 0.0
    floor: float = 0.0
    floor_ratio: float = 0.2
    matched: bool = True
    time_constant: float = 10.0
    knows_applied: bool = True


class ReferenceModel:
    """w of C1 w = D r and its past; C1 has a double pole and unit gain."""

    def __init__(self, pole: float, start: float) -> None:
        self.pole = pole
        self.past = [start] * 6

    def step(self, r: float) -> None:
        p, past = self.pole, self.past
        self.past = [2 * p * past[0] - p * p * past[1] + (1 - p) ** 2 * r, *past[:-1]]

    def filtered(self, polynomial: Array) -> float:
        """Return P(q^-1) w(k)."""
        return sum(c * w for c, w in zip(polynomial, self.past, strict=False))

    def output(self, ahead: int, keeps_zero: bool) -> float:
        """Return y_m(k + 1 - `ahead`) for `ahead` = d."""
        later = self.past[ahead - 1]
        return (later + self.past[ahead]) / 2 if keeps_zero else later


class Axis:
    """Estimator and law of one axis."""

    def __init__(self, design: Design, inertia: float, printed: tuple[float, float], period: float, y: float) -> None:
        nominal = period**2 / (2 * inertia)
        b0, b1 = printed if design.printed else (design.factor * nominal, design.factor * nominal)
        self.design = design
        self.theta = np.array([-2.0, 1.0, b0, b1, 0.0])
        self.F = design.first * np.eye(5)
        self.b_min = max(design.floor, design.floor_ratio * nominal)
        self.model = ReferenceModel(math.exp(-period / design.time_constant), y if design.matched else 0.0)
        self.y = [y, y]
        self.torque = 0.0
        self.commanded = [0.0, 0.0]
        self.u: list[float] = []
        self.samples = 0
        self.ym = y if design.matched else 0.0

    def step(self, y: float, r: float, applied: float) -> float:
        """Take the sample y(k), the reference r(k) and the torque applied since y(k-1); return u(k)."""
        d = self.design.d
        torque = applied if self.design.knows_applied else self.commanded[d - 1]
        self.u = [torque] if d == 1 else [self.commanded[0], torque]
        phi = np.array([-self.y[0], -self.y[1], torque, self.torque, 1.0])
        if self.design.adapt and self.samples >= 2:
            self._estimate(phi, y)
        self.model.step(r)
        law = self._retain if self.design.form == "retain" else self._cancel
        u = law(y)
        self.ym = self.model.output(self.design.d, self.design.form == "retain")
        self.y = [y, self.y[0]]
        self.torque = torque
        self.commanded = [u, self.commanded[0]]
        self.samples += 1
        return u

    def _estimate(self, phi: Array, y: float) -> None:
        """Recursive least squares (39)-(42) with dead zone and trace cap."""
        error = y - phi @ self.theta
        if abs(error) <= self.design.dead_zone:
            return
        forgetting = self.design.forgetting
        gain = self.F @ phi / (forgetting + phi @ self.F @ phi)
        F = (np.eye(5) - np.outer(gain, phi)) @ self.F / forgetting
        self.F = (F + F.T) / 2
        if np.trace(self.F) > self.design.cap:
            self.F *= forgetting
        self.theta = self.theta + gain * error

    def _retain(self, y: float) -> float:
        """Solve A S + q^-d B T = Ac and keep the zero of B."""
        d = self.design.d
        a1, a2, b0, b1, offset = self.theta
        lift = max(0.0, self.b_min - (b0 + b1) / 2)
        b0, b1 = b0 + lift, b1 + lift
        S, T = diophantine(np.array([1.0, a1, a2]), np.array([b0, b1]), desired(self.design.pole, d), d)
        gain = b0 + b1
        feedforward = self.model.filtered(desired(self.design.pole, d)) / gain
        return float(
            feedforward
            - T @ [y, self.y[0]]
            - sum(s * u for s, u in zip(S[1:], self.u, strict=False))
            - S.sum() / gain * offset
        )

    def _cancel(self, y: float) -> float:
        """Law (32): cancel B, with the offset term."""
        d = self.design.d
        a1, a2, b0, b1, offset = self.theta
        b0 = max(b0, self.b_min)
        c = self.design.pole
        C2 = np.array([1.0, -2 * c, c * c])
        s1 = C2[1] - a1
        if d == 1:
            S, T = np.array([1.0]), np.array([s1, C2[2] - a2])
        else:
            S, T = np.array([1.0, s1]), np.array([C2[2] - a2 - a1 * s1, -a2 * s1])
        BS = np.convolve([b0, b1], S)
        past = sum(g * u for g, u in zip(BS[1:], self.u, strict=False))
        return float((self.model.filtered(C2) - T @ [y, self.y[0]] - past - S.sum() * offset) / b0)


def desired(pole: float, d: int) -> Array:
    """Return Ac = (1 - pole q^-1)^(d+2)."""
    Ac = np.array([1.0])
    for _ in range(d + 2):
        Ac = np.convolve(Ac, [1.0, -pole])
    return Ac


def diophantine(A: Array, B: Array, Ac: Array, d: int) -> tuple[Array, Array]:
    """Solve A S + q^-d B T = Ac for S (monic, degree d) and T (degree 1)."""
    n = d + 2
    matrix = np.zeros((n + 1, n + 1))
    for k in range(d + 1):
        matrix[k : k + 3, k] = A
    for k in range(2):
        matrix[d + k : d + k + 2, d + 1 + k] = B
    solution = np.linalg.solve(matrix[1:, 1:], Ac[1:] - matrix[1:, 0])
    return np.concatenate([[1.0], solution[:d]]), solution[d:]


@dataclass(frozen=True)
class Run:
    """Samples of a run, one row each, up to the sample at which |u| > 1e4 N m was commanded (`lost`)."""

    t: Array
    x: Array
    ym: Array
    u: Array
    theta: Array
    lost: float


Measure = Callable[[int, Array], Array]


def simulate(
    design: Design | None,
    delay: int = 0,
    plant: Plant | None = None,
    samples: int = 1600,
    period: float = 0.5,
    follow_model: bool = False,
    substeps: int = 5,
    measure: Measure = lambda _k, y: y,
) -> Run:
    """Run the loop; without a design the PD law (50) acts."""
    plant = plant or Plant()
    x = np.concatenate([START, -plant.omega0 * rotation(START)[:, 1], np.zeros(3)])
    told = design or Design(d=1 + delay)
    y = measure(0, x[:3])
    axes = [Axis(told, plant.inertia[i], PRINTED_B[i], period, float(y[i])) for i in range(3)]
    queue = [np.zeros(3)] * delay
    applied = np.zeros(3)
    rows = []
    lost = math.inf
    for k in range(samples):
        y, r = measure(k, x[:3]), square_wave(k * period)
        ym = np.array([axis.ym for axis in axes])
        u = np.array([axis.step(float(y[i]), float(r[i]), float(applied[i])) for i, axis in enumerate(axes)])
        if design is None:
            goal = ym if follow_model else r
            u = PROPORTIONAL * (goal - y) - DERIVATIVE * relative_rate(plant, y, x[3:6])
        queue.append(u)
        applied = wheel_limit(plant, x[6:], queue.pop(0), period)
        rows.append((k * period, x, ym, applied, np.array([axis.theta for axis in axes])))
        if not np.abs(u).max() <= 1e4:
            lost = k * period
            break
        x = advance(plant, x, applied, period, substeps)
    t, xs, yms, us, thetas = (np.array(column) for column in zip(*rows, strict=True))
    return Run(t, xs, yms, us, thetas, lost)


def errors(run: Run) -> Array:
    """Return y - y_m in degrees, from 200 s on."""
    late = run.t >= 200
    found: Array = np.degrees(run.x[late, :3] - run.ym[late])
    return found


def rms(run: Run) -> Array:
    """Return the root mean square of the tracking errors from 200 s on, degrees."""
    found: Array = np.sqrt(np.mean(errors(run) ** 2, axis=0))
    return found


def ring(run: Run) -> Array:
    """Return mean |du| / (2 mean |u|) from 200 s on; 1 is pure alternation."""
    u = run.u[run.t >= 200]
    found: Array = np.abs(np.diff(u, axis=0)).mean(axis=0) / (2 * np.abs(u).mean(axis=0))
    return found
