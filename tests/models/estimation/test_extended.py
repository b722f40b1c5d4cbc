# SPDX-License-Identifier: Apache-2.0
"""An extended Kalman filter of a pendulum against one in NumPy, against its own statistics, and what is refused."""

import numpy as np
import pytest
import sympy as sp

import mehvar
from mehvar import Diffusion, Group, Quantity, Sensor, estimated
from mehvar.base.errors import MehvarError
from mehvar.runtime.run.noise import normals

from .swing import (
    DEVIATION,
    KD,
    KP,
    MEAN,
    SIGMA,
    SIGMA_G,
    START,
    TS,
    WALK,
    E,
    P,
    U,
    X,
    Y,
    has_the_bits_on_a_board,
    is_consistent,
    is_of_the_textbook,
    moved,
    swing,
)


@pytest.fixture(scope="module")
def model():
    return mehvar.build(estimated(swing(), "pd", START))


def by_hand(run, delay=0):
    """Return estimate and covariance before each sample: slopes by complex steps, whole covariance."""

    def seen(x):
        return np.array([np.sin(x[0]), x[1]])

    def slopes(of, x):
        return np.stack([of(x + 1e-30j * e).imag / 1e-30 for e in np.eye(3)], axis=1)

    e = normals(0, 0, run.sizes["t"], 2) * [SIGMA, SIGMA_G]
    last, (x, P, R) = 0.0, (MEAN, np.diag(DEVIATION**2), np.diag([SIGMA**2, SIGMA_G**2]))
    for k, (angle, speed) in enumerate(zip(run["angle"].values, run["rate"].values, strict=True)):
        yield x, P
        H = slopes(seen, x)
        gain = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
        x = x + gain @ (np.array([np.sin(angle), speed]) + e[k] - seen(x))
        I = np.eye(3) - gain @ H  # noqa: E741
        P = I @ P @ I.T + gain @ R @ gain.T
        command = -KP * x[0] - KD * x[1]
        u, last = last if delay else command, command
        F = slopes(lambda v, u=u: moved(v, u), x)
        x, P = moved(x, u), F @ P @ F.T + np.diag([0, 0, WALK**2 * TS])


@pytest.mark.parametrize("delay", [0, 1])
def test_it_is_the_filter_of_the_textbook(model, delay):
    run = mehvar.simulate(model, "pd", t_end=10.0, initial={"drag": 0.3}, delay=delay)
    is_of_the_textbook(run, by_hand(run, delay), 1e-11, 1e-6)


def test_a_board_computes_the_same_bits(model):
    has_the_bits_on_a_board(model)


def test_noise_of_the_user_is_a_parameter():
    law = estimated(swing(), "pd", START, {"rate": 0.01}).controllers[0]
    units = {q.name: q.unit for q in law.parameters}
    assert units["rate_noise"] == "1/s^(3/2)"


def test_noise_of_the_diffusion_is_that_of_a_density():
    """The memory after a sample has the same numbers."""
    wiener = Group("w", (Quantity("W", "s^(1/2)", "wind"),))
    wind = swing(random_step=None, diffusion=Diffusion(wiener, (0, P.sigma_g * wiener.W, 0)))
    updates = []
    for system in (estimated(wind, "pd", START), estimated(swing(random_step=None), "pd", START, {"rate": P.sigma_g})):
        law = system.controllers[0]
        groups = (P, law.parameters, law.memory, U, Y)
        at = {q.symbol: sp.Float(0.3 + 0.1 * k) for group in groups for k, q in enumerate(group)}
        for symbol, expr in system.definitions.items():
            at[symbol] = sp.sympify(expr).xreplace(at)
        updates.append([float(sp.sympify(e).xreplace(at)) for e in law.update])
    np.testing.assert_allclose(*updates, rtol=1e-12)


@pytest.mark.soak
def test_errors_and_innovations_are_as_large_as_it_says(model):
    is_consistent(model, 1000)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: estimated(swing(), "lqr", START), "law 'lqr' is not known"),
        (lambda: estimated(swing(), "pd", {"angle": (0, 1)}), "must also have mean and deviation of rate, drag"),
        (lambda: estimated(swing(), "pd", START, {"speed": 1.0}), "state 'speed' is not known"),
        (lambda: estimated(swing(sensor=None), "pd", START), "estimates need a sampled law and a system with a sensor"),
        (
            lambda: estimated(swing(sensor=Sensor(E, (X.angle + E.e_s, X.rate), Y)), "pd", START),
            "measurement 'gyro' has no noise: an estimate needs it",
        ),
        (
            lambda: estimated(swing(sensor=Sensor(E, (X.angle + E.e_s, X.rate + E.e_s), Y)), "pd", START),
            "measurements sine and gyro share a noise",
        ),
        (
            lambda: estimated(swing(), "pd", START | {"rate": (0.0, -1.0)}),
            r"'rate_dev_0': default = -1 is outside its bounds",
        ),
        (
            lambda: estimated(swing(), "pd", START, {"rate": -0.1}),
            r"'rate_noise': default = -0.1 is outside its bounds",
        ),
        (lambda: estimated("swing", "pd", START), "system = 'swing': must be a System"),
        (lambda: estimated(swing(delays={"torque": "kp"}), "pd", START), "law 'pd': has inputs with delays"),
    ],
)
def test_wrong_filters_are_refused(make, words):
    with pytest.raises(MehvarError, match=words):
        mehvar.build(make())


def test_a_delay_of_two_samples_is_refused(model):
    with pytest.raises(MehvarError, match="a delay must be at most 1 sample"):
        mehvar.simulate(model, "pd", t_end=1.0, delay=2)
