# SPDX-License-Identifier: Apache-2.0
"""One axis of a satellite under thrusters with hysteresis: a Schmitt trigger, whose output is a mode."""

from pathlib import Path

import sympy as sp

from mehvar import Controller, Event, Group, Quantity, System, read_parameters, read_scenarios

HERE = Path(__file__).parent
STRUCTURE = {}
X = Group("x", (
    Quantity("angle", "rad", "attitude", r"\theta"),
    Quantity("rate", "rad/s", "rate", r"\omega"),
    Quantity("fires", "1", "mode: the thruster that fires, 1, -1 or 0 for none"),
))  # fmt: skip
U = Group("u", (Quantity("wheel", "N m", "torque of a wheel", "T_w"),))


def system():
    """Put the system together."""
    tables = read_parameters(HERE / "parameters.toml")
    scenarios, metrics = read_scenarios(HERE / "scenarios.toml")
    p, s = Group("p", tables["plant"].quantities), Group("s", tables["start"].quantities)
    none = Group("c", ())
    signal = -(X.angle + p.lead * X.rate)
    mode = X.fires
    return System(
        name="thruster",
        title="a satellite under thrusters with hysteresis",
        source="an example",
        states=X,
        inputs=U,
        parameters=p,
        scenario_parameters=s,
        rhs=(X.rate, (p.torque * mode + p.drift + U.wheel) / p.I, sp.S.Zero),
        initial=(s.angle_0, sp.S.Zero, -sp.S.One),
        controllers=(
            Controller("trigger", "the thrusters alone", none, (sp.S.Zero,)),
            Controller(
                "damped", "and a wheel that brakes, sampled", none, (-p.lead * X.rate * p.torque / 10,), period="Ts"
            ),
        ),
        scenarios=scenarios,
        metrics=metrics,
        events=(
            Event("fire_plus", signal - p.on, "rising", {mode: sp.S.One}),
            Event("rest_plus", signal - p.off, "falling", {mode: sp.Min(mode, 0)}),
            Event("fire_minus", -signal - p.on, "rising", {mode: -sp.S.One}),
            Event("rest_minus", -signal - p.off, "falling", {mode: sp.Max(mode, 0)}),
        ),
    )
