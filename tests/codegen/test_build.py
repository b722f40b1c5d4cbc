# SPDX-License-Identifier: Apache-2.0
"""A system made in Python has a generated folder of its own, whatever it declares differently."""

from dataclasses import replace

import pytest

from mehvar import Controller, Group, Metric, Parameter, Quantity, Scenario, System
from mehvar.codegen.build import built_folder

X = Group("x", (Quantity("angle", "rad", "angle"), Quantity("rate", "rad/s", "its rate")))
U = Group("u", (Quantity("torque", "N m", "torque"),))
P = Group(
    "p",
    (Parameter("J", "kg m^2", "inertia", default=2.0), Parameter("Ts", "s", "period", default=0.2, bounds="(0, inf)")),
)
C = Group(
    "c", (Parameter("kp", "N m", "gain", default=1.0, bounds="(0, inf)"), Parameter("kd", "N m s", "gain", default=1.0))
)
LAW = Controller("pd", "a law", C, (-C.kp * X.angle - C.kd * X.rate,), period="Ts")
GO = Scenario("go", "a run", 2.0, 0.2)
PEAK = Metric("peak", "max_abs", ("rate",), "rad/s", "largest rate")


def made(**changes):
    parts = {
        "states": X, "inputs": U, "parameters": P, "rhs": (X.rate, U.torque / P.J), "initial": (1, 0),
        "controllers": (LAW,), "scenarios": (GO,), "metrics": (PEAK,),
    }  # fmt: skip
    return System(name="made", **(parts | changes))


def law(**changes):
    return {"controllers": (replace(LAW, **changes),)}


def gain(**changes):
    return law(parameters=Group("c", (replace(C.quantities[0], **changes), C.quantities[1])))


@pytest.mark.parametrize(
    "changes",
    [
        gain(default=1.5), gain(description="another"), law(title="another"),
        law(command=(-2 * C.kp * X.angle - C.kd * X.rate,)),
        law(memory=Group("z", (Quantity("kept", "rad", "kept"),)), start=(0,), update=(X.angle,)),
        {"scenarios": (replace(GO, duration=3.0),)}, {"metrics": (replace(PEAK, since=1.0),)}, {"initial": (2, 0)},
        {"parameters": Group("p", (replace(P.quantities[0], default=3.0), P.quantities[1]))}, {"title": "another"},
    ],
)  # fmt: skip
def test_a_declaration_that_differs_is_another_model(changes, monkeypatch):
    """The folder's name in the cache differs; nothing is generated."""
    places = []
    monkeypatch.setattr("mehvar.base.cache.entry", lambda _kind, name, _fill: places.append(name))
    built_folder(made())
    built_folder(made(**changes))
    assert places[0] != places[1]
