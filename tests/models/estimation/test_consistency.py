# SPDX-License-Identifier: Apache-2.0
"""Errors (NEES) and innovations (NIS) of both filters of any system over 10 000 runs, as large as their covariances."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp
from scipy.linalg import expm
from scipy.stats import chi2

import mehvar
from mehvar import Diffusion, Group, Quantity, RandomStep, Sensor, estimated

from .swing import SIGMA, SIGMA_G, WALK, C, E, K, P, U, Y, swing
from .swing import START as PENDULUM

RUNS, EVERY = 10_000, 0.5
LINEAR = Group("x", (
    Quantity("angle", "rad", "angle from below"), Quantity("rate", "rad/s", "its rate"),
    Quantity("push", "rad/s^2", "slow acceleration"),
))  # fmt: skip
KICK = Group("e", (Quantity("e_p", "1", "change of the push"),))
START = {"angle": (0.5, 0.3), "rate": (0.0, 0.3), "push": (0.0, 0.2)}


WIENER = Group("w", (Quantity("W", "s^(1/2)", "wind"),))


def spring(**changes):
    """Return a linear oscillator under a push that walks."""
    x = LINEAR
    parts = {
        "name": "spring", "states": x, "steps": (), "rhs": (x.rate, -P.k / P.J * x.angle + x.push + U.torque / P.J, 0),
        "sensor": Sensor(E, (x.angle + P.sigma * E.e_s, x.rate + P.sigma_g * E.e_g), Y),
        "random_step": RandomStep(KICK, (x.angle, x.rate, x.push + P.walk / sp.sqrt(P.Ts) * KICK.e_p)),
        "controllers": (mehvar.Controller("pd", "a law", C, (-C.kp * x.angle - C.kd * x.rate,), period="Ts"),),
    }  # fmt: skip
    return swing(**(parts | changes))


@pytest.mark.parametrize("period", [0.05, 0.2])
@pytest.mark.parametrize("kind", ["extended", "sigma-point"])
def test_noise_acts_throughout_a_sample(kind, period):
    """The covariance is that of van Loan's integral of the noise."""
    wind = spring(random_step=None, diffusion=Diffusion(WIENER, (0, 0, P.walk / P.Ts * WIENER.W)))
    model = mehvar.build(estimated(wind, "pd", START, {"rate": 0.3}, kind=kind))
    options = {"method": "euler", "step": period, "dt_out": period, "t_end": 20 * period}
    run = mehvar.simulate(model, "pd", Ts=period, **options)
    A, H, R = np.array([[0, 1, 0], [-K, 0, 1], [0, 0, 0]]), np.eye(2, 3), np.diag([SIGMA**2, SIGMA_G**2])
    W = np.diag([0, 0.3**2, (WALK / period) ** 2])
    whole = expm(np.block([[-A, W], [np.zeros((3, 3)), A.T]]) * period)
    F, V = whole[3:, 3:].T, np.diag([d**2 for _, d in START.values()])
    for k in range(run.sizes["t"]):
        D, upper = np.diag([float(run[f"est_D{i}"][k]) for i in (1, 2, 3)]), np.eye(3)
        for i, j in ((1, 2), (1, 3), (2, 3)):
            upper[i - 1, j - 1] = float(run[f"est_U{i}{j}"][k])
        scale = np.sqrt(np.diag(V))
        np.testing.assert_allclose(upper @ D @ upper.T / scale / scale[:, None], V / scale / scale[:, None], atol=0.01)
        V = F @ (V - V @ H.T @ np.linalg.solve(H @ V @ H.T + R, H @ V)) @ F.T + F @ whole[:3, 3:]


def means(system, start, kind, seed):
    """Return mean NEES and NIS at each instant; the filter predicts, so that its error is before a measurement."""
    model = mehvar.build(estimated(system, "pd", start, kind=kind))
    drawn = {name: f"normal({m}, {d})" for name, (m, d) in start.items()}
    runs = mehvar.batch(model, "pd", RUNS, vary=drawn, t_end=10.0, save=EVERY, seed=seed)
    names = list(start)
    error = np.stack([runs[name].values - runs[f"{name}_est"].values for name in names], axis=-1)
    for i in range(3):  # P = U D U', solved from the last row on
        for j in range(i + 1, 3):
            error[..., 2 - j] -= runs[f"est_U{3 - j}{3 - i}"].values * error[..., 2 - i]
    nees = sum(error[..., i] ** 2 / runs[f"est_D{i + 1}"].values for i in range(3))
    return {3: nees.mean(axis=0)[1:], 2: runs["est_nis"].values.mean(axis=0)[1:]}


def outside(values, size):
    low, high = chi2.ppf([0.025, 0.975], size * RUNS) / RUNS
    return int(np.sum((values < low) | (values > high)))


@pytest.mark.soak
@pytest.mark.parametrize("kind", ["extended", "sigma-point"])
def test_in_a_linear_system_they_are_as_large_as_they_say(kind):
    """Of 20 instants at most three are outside of the 95 % bands, by chance one."""
    values = means(spring(), START, kind, 0)
    assert all(
        outside(mean, size) <= 3 and mean.mean() == pytest.approx(size, rel=0.005) for size, mean in values.items()
    )


@pytest.mark.soak
def test_in_a_pendulum_known_to_20_degrees_errors_are_larger_than_they_say():
    """4.0 and 3.1 in place of 3, while the innovations are 1 % too large: the page on estimators says so."""
    extended, points = (means(swing(), PENDULUM, kind, 0) for kind in ("extended", "sigma-point"))
    assert (extended[3].mean(), points[3].mean()) == (pytest.approx(4.0, abs=0.1), pytest.approx(3.1, abs=0.1))
    assert (extended[2].mean(), points[2].mean()) == (pytest.approx(2.03, abs=0.01), pytest.approx(2.01, abs=0.01))
