# SPDX-License-Identifier: Apache-2.0
"""Small systems with process noise and random steps, with known distributions."""

import sympy as sp

from mehvar.models.system import Controller, Diffusion, Group, RandomStep, Scenario, System
from tests.models.edits import POSITIVE, parameter, quantity
from tests.models.feedback import table


def noisy() -> System:
    """A price, dX = m X dt + X (a dW1 + b dW2), and a speed that is braked and pushed, dV = (u - g V) dt + q dW3."""
    x, u = Group("x", (quantity("price", "1"), quantity("speed", "m/s"))), Group("u", (quantity("push", "m/s^2"),))
    p = Group("p", tuple(parameter(*row) for row in (
        ("m", "1/s", 0.5), ("a", "1/s^(1/2)", 0.6), ("b", "1/s^(1/2)", 0.4), ("g", "1/s", 1.0),
        ("q", "m/s^(3/2)", 0.7), ("Ts", "s", 0.25, POSITIVE),
    )))  # fmt: skip
    w = Group("w", tuple(quantity(name, "s^(1/2)") for name in ("W1", "W2", "W3")))
    c = Group("c", (parameter("k", "1/s", 0.5),))
    command, s = (-c.k * x.speed,), Group("s", (parameter("speed_0", "m/s", 2.0),))
    return table(
        x, u, p, name="noisy", title="a price and a speed", scenario_parameters=s,
        rhs=(p.m * x.price, u.push - p.g * x.speed), initial=(sp.S.One, s.speed_0),
        diffusion=Diffusion(w, (x.price * (p.a * w.W1 + p.b * w.W2), p.q * w.W3)),
        controllers=(Controller("brake", "", c, command), Controller("steps", "", c, command, period="Ts")),
        scenarios=(Scenario("plain", "plain", 1.0, 0.25, {}, {}, {}),),
    )  # fmt: skip


def walker() -> System:
    """A gyro whose bias changes at random at each sample, and a random gust for each sample: v' = u + gust."""
    x = Group("x", (quantity("v", "m/s"), quantity("bias", "m/s"), quantity("gust", "m/s^2")))
    u, e = Group("u", (quantity("push", "m/s^2"),)), Group("e", (quantity("e_bias", "1"), quantity("e_gust", "1")))
    p = Group("p", tuple(parameter(*row) for row in (
        ("walk", "m/s^(3/2)", 0.1), ("strength", "m/s^2", 0.5), ("Ts", "s", 0.1, POSITIVE),
    )))  # fmt: skip
    c, s = Group("c", (parameter("k", "1/s", 0.5),)), Group("s", (parameter("v_0", "m/s", 1.0),))
    command = (-c.k * (x.v + x.bias),)
    return table(
        x, u, p, name="walker", title="a walk and a gust", scenario_parameters=s,
        rhs=(u.push + x.gust, sp.S.Zero, sp.S.Zero), initial=(s.v_0, sp.S.Zero, sp.S.Zero),
        random_step=RandomStep(e, (x.v, x.bias + p.walk * sp.sqrt(p.Ts) * e.e_bias, p.strength * e.e_gust)),
        controllers=(Controller("steps", "", c, command, period="Ts"), Controller("smooth", "", c, command)),
        scenarios=(Scenario("plain", "plain", 3.0, 0.1, {}, {}, {}),),
    )  # fmt: skip
