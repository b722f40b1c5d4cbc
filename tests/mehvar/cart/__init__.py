# SPDX-License-Identifier: Apache-2.0
"""A cart on a spring: the smallest model with all features that a comparison uses. Tests copy and edit it."""

from pathlib import Path

import sympy as sp

from mehvar.models.system import Controller, Derivation, Group, Quantity, System
from mehvar.models.tables import read_parameters, read_scenarios

STRUCTURE: dict[str, tuple[str, ...]] = {}
X = Quantity("x", "m", "position")
V = Quantity("v", "m/s", "speed")
FORCE = Quantity("F", "N", "force")


def system() -> System:
    tables = read_parameters(Path(__file__).parent / "parameters.toml")
    scenarios, metrics = read_scenarios(Path(__file__).parent / "scenarios.toml")
    p, c = Group("p", tables["plant"].quantities), Group("c", tables["hold"].quantities)
    x, v = X.symbol, V.symbol
    d = Derivation()
    d.section("Motion")
    spring = d.define("spring", -p.k * x - p.d * v, "(1)", "force of the spring", "N", "F_s")
    rate = d.define("v_dot", (spring + FORCE.symbol) / p.mass, "(2)", "acceleration", "m/s^2", r"\dot v")
    return System(
        name="cart",
        title="a cart on a spring",
        source="none",
        structure={},
        states=Group("x", (X, V)),
        inputs=Group("u", (FORCE,)),
        references=Group("r", ()),
        outputs=Group("y", ()),
        parameters=p,
        scenario_parameters=Group("s", tables["scenario"].quantities),
        rhs=(v, rate),
        output=(),
        steps=tuple(d.steps),
        limits=(),
        initial=(tables["scenario"].x_0, sp.Integer(0)),
        reference=(),
        constraints=(),
        functions=(),
        controllers=(Controller("hold", "proportional", c, (-c.gain * x,)),),
        scenarios=scenarios,
        metrics=metrics,
    )
