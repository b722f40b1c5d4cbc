# SPDX-License-Identifier: Apache-2.0
"""Small systems whose laws measure outputs, have states, or command at every N-th sample."""

import dataclasses

import sympy as sp

from mehvar.models.system import Controller, Group, Output, Scenario, Sensor, System
from tests.models.edits import ANY, POSITIVE, cart, parameter, quantity

WHOLE = dataclasses.replace(POSITIVE, lower=1.0, lower_open=False)


def table(x: Group, u: Group, p: Group, **fields) -> System:
    """A system with only the given fields."""
    none = Group("r", ())
    empty = dataclasses.replace(
        cart(), states=x, inputs=u, references=none, outputs=Group("y", ()), output=(), parameters=p, steps=(),
        limits=(), reference=(), constraints=(), functions=(), metrics=(), actuator=None, sensor=None, choices=(),
        variants=(), rates={}, residual=(),
    )  # fmt: skip
    return dataclasses.replace(empty, **fields)


def seeker() -> System:
    """A mass whose laws measure the position: a lead compensator, integral action, and an estimator with a law."""
    x, u = Group("x", (quantity("place", "m"), quantity("speed", "m/s"))), Group("u", (quantity("push", "m/s^2"),))
    seen, e = Group("seen", (quantity("shown", "m"),)), Group("e", (quantity("hiss", "1"),))
    rows = (("load", "m/s^2", 0.3, ANY), ("sigma", "m", 0.01, ANY), ("Ts", "s", 0.02, POSITIVE))
    p, s = Group("p", tuple(parameter(*row) for row in rows)), Group("s", (parameter("place_0", "m", 0.5),))
    c = Group("c", tuple(parameter(*row) for row in (("k", "1/s^2", 4.0), ("T", "1/s", 8.0), ("b", "1/s", 5.0))))
    z, total = Group("z", (quantity("late", "m"), quantity("sum", "m s"))), parameter("i", "1/s^3", 1.5)
    lead = Controller(
        "lead", "a lead compensator with integral action", Group("c", (*c.quantities, total)),
        (-c.k * (m := seen.shown) - c.b * c.T * (m - z.late) - total.symbol * z.sum,), memory=z,
        start=(x.place, sp.S.Zero), rates=(c.T * (m - z.late), m),
        outputs=(Output(quantity("lag", "m"), x.place - z.late), Output(quantity("effort", "m/s^2"), u.push)),
    )  # fmt: skip
    o = Group("c", tuple(parameter(*row) for row in (
        ("k", "1/s^2", 4.0), ("b", "1/s", 3.0), ("l1", "1", 0.4), ("l2", "1/s", 4.0), ("every", "1", 5.0, WHOLE),
    )))  # fmt: skip
    v, w = Group("v", (quantity("push_was", "m/s^2"),)), Group("z", (quantity("p_est", "m"), quantity("v_est", "m/s")))
    miss = m - w.p_est
    slow = Controller(
        "slow", "an estimator at each sample, a command at every fifth", o, (-o.k * w.p_est - o.b * w.v_est,),
        period="Ts", every="every", applied=v, memory=w, start=(sp.S.Zero, sp.S.Zero),
        update=(w.p_est + p.Ts * w.v_est + o.l1 * miss, w.v_est + p.Ts * v.push_was + o.l2 * miss),
        outputs=(Output(quantity("off", "m"), x.place - w.p_est),),
    )  # fmt: skip
    b = Group("c", (parameter("gain", "1/s^2", 2.0), parameter("every", "1", 3.0, WHOLE)))
    bang = Controller("plain", "no memory, every third sample", b, (-b.gain * m,), period="Ts", every="every")
    return table(
        x, u, p, name="seeker", title="a mass whose place is seen", scenario_parameters=s,
        rhs=(x.speed, u.push - p.load), initial=(s.place_0, sp.S.Zero),
        sensor=Sensor(e, (x.place + p.sigma * e.hiss,), seen),
        controllers=(lead, slow, bang), scenarios=(Scenario("plain", "plain", 4.0, 0.02, {}, {}, {}),),
    )  # fmt: skip
