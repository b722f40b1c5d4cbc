# SPDX-License-Identifier: Apache-2.0
"""A pendulum whose damping walks, with noisy measurements; its law is written for the state."""

import numpy as np
import pytest
import sympy as sp
from scipy.stats import chi2

import mehvar
from mehvar import Controller, Derivation, Group, Parameter, Quantity, RandomStep, Scenario, Sensor, System
from mehvar.runtime.board.run import BoardRequest, run_on_board

J, K, SIGMA, SIGMA_G, WALK, TS, KP, KD = 1.0, 4.0, 0.02, 0.1, 0.003, 0.05, 1.0, 0.5
MEAN, DEVIATION = np.array([0.8, 0.0, 0.2]), np.array([0.3, 0.3, 0.2])

X = Group("x", (
    Quantity("angle", "rad", "angle from below"), Quantity("rate", "rad/s", "its rate"),
    Quantity("drag", "1/s", "damping over the inertia"),
))  # fmt: skip
U = Group("u", (Quantity("torque", "N m", "torque of the motor"),))
E = Group("e", (Quantity("e_s", "1", "error of the sine"), Quantity("e_g", "1", "error of the rate")))
KICK = Group("e", (Quantity("e_d", "1", "change of the damping"),))
Y = Group("seen", (Quantity("sine", "1", "measured sine"), Quantity("gyro", "rad/s", "measured rate")))
P = Group("p", (
    Parameter("J", "kg m^2", "inertia", default=J, bounds="(0, inf)"),
    Parameter("k", "N m", "weight times arm", default=K, bounds="(0, inf)"),
    Parameter("sigma", "1", "deviation of the sine", default=SIGMA, bounds="(0, inf)"),
    Parameter("sigma_g", "rad/s", "deviation of the rate", default=SIGMA_G, bounds="(0, inf)"),
    Parameter("walk", "1/s^(3/2)", "random walk of the damping", default=WALK, bounds="[0, inf)"),
    Parameter("Ts", "s", "period", default=TS, bounds="(0, inf)"),
))  # fmt: skip
S = Group("s", (Parameter("angle_0", "rad", "angle at the start", default=1.0),))
C = Group("c", (Parameter("kp", "N m", "gain", default=KP), Parameter("kd", "N m s", "gain of the rate", default=KD)))
START = {name: (float(m), float(d)) for name, m, d in zip(("angle", "rate", "drag"), MEAN, DEVIATION, strict=True)}


def swing(**changes):
    """A pendulum whose damping walks; the law is written for the state."""
    d = Derivation()
    pull = d.define("pull", -P.k / P.J * sp.sin(X.angle) - X.drag * X.rate, title="acceleration without torque")
    wanted = d.define("wanted", -C.kp * X.angle - C.kd * X.rate, title="torque of the law")
    parts = {
        "name": "swing", "states": X, "inputs": U, "parameters": P, "scenario_parameters": S, "steps": tuple(d.steps),
        "rhs": (X.rate, pull + U.torque / P.J, 0), "initial": (S.angle_0, 0, 0),
        "sensor": Sensor(E, (sp.sin(X.angle) + P.sigma * E.e_s, X.rate + P.sigma_g * E.e_g), Y),
        "random_step": RandomStep(KICK, (X.angle, X.rate, X.drag + P.walk * sp.sqrt(P.Ts) * KICK.e_d)),
        "controllers": (Controller("pd", "a law of the state", C, (wanted,), period="Ts"),),
        "scenarios": (Scenario("swing", "a swing", 10.0, 0.05),),
    }  # fmt: skip
    return System(**(parts | changes))


def is_of_the_textbook(run, by_hand, atol, rtol):
    """Compare estimates and their squared errors with those of a filter in NumPy."""
    for k, (x, V) in enumerate(by_hand):
        ours = np.array([run[f"{name}_est"].values[k] for name in START])
        np.testing.assert_allclose(ours, x, rtol=0, atol=atol)
        error = np.array([run[name].values[k] for name in START]) - x
        assert float(run["est_nees"].values[k]) == pytest.approx(error @ np.linalg.solve(V, error), rel=rtol)


def is_consistent(model, n):
    """Draw starts as the filter believes; means of n runs within 99.9 % bands, for it is no linear system."""
    drawn = {name: f"normal({m}, {d})" for name, (m, d) in START.items()}
    runs = mehvar.batch(model, "pd", n, vary=drawn, t_end=10.0, save=1.0)
    low, high = chi2.ppf([0.0005, 0.9995], 2 * n) / n
    assert all(low < mean < high for mean in runs["est_nis"].values.mean(axis=0)[2:])


def has_the_bits_on_a_board(model):
    """Compare the law on a board with the law in this process."""
    outcome = run_on_board(model, BoardRequest("pd", "sil", samples=100))
    assert (outcome.max_ulp, outcome.x.ulp) == (0, 0)


def moved(x, u):
    """Return a state after a period by the classical Runge-Kutta method; x may be complex."""

    def rate(x):
        return np.array([x[1], -K / J * np.sin(x[0]) - x[2] * x[1] + u / J, 0 * x[0]])

    a = rate(x)
    b = rate(x + TS / 2 * a)
    c = rate(x + TS / 2 * b)
    return x + TS / 6 * (a + 2 * b + 2 * c + rate(x + TS * c))
