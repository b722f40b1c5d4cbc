# SPDX-License-Identifier: Apache-2.0
"""A system made in Python has a generated folder of its own, whatever it declares differently."""

from dataclasses import replace

import numpy as np
import pytest

from mehvar import Controller, Group, Metric, Parameter, Quantity, Scenario, Sensor, System, batch, build, diff
from mehvar.base.errors import InputError
from mehvar.codegen.build import built_folder
from mehvar.settings import required_law

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


LATE = {"parameters": Group("p", (*P.quantities, Parameter("lag", "1", "samples", default=2.0, bounds="[0, 9]")))}
SCALED = Sensor(Group("e", ()), (3 * X.angle, 3 * X.rate))
EVERY = Group("c", (*C.quantities, Parameter("often", "1", "samples", default=5.0, bounds="[1, 9]")))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"delays": {"torque": "lag"}, **LATE}, "the input torque is delayed by lag samples"),
        (law(parameters=EVERY, every="often"), "pd commands only at some samples"),
        ({"sensor": SCALED}, "has measurements without names"),
    ],
    ids=("delay", "every", "sensor"),
)
def test_margins_that_would_leave_something_out_are_not_computed(changes, words):
    """A loop that was linear without it had the margins of another one."""
    with pytest.raises(InputError, match=words):
        build(made(**changes)).linearize([0.0, 0.0], None, controller="pd")
    heavier = Group("p", (replace(P.quantities[0], default=3.0), *changes.get("parameters", P).quantities[1:]))
    text = str(diff(made(**changes), made(**{**changes, "parameters": heavier})))
    assert "loops and margins not compared: pd: " in text
    assert words in text
    assert " deg" not in text


def test_noise_and_a_command_at_each_sample_leave_a_loop_linear():
    plain = build(made()).linearize([0.1, 0.0], None, controller="pd")
    noise = Group("e", (Quantity("e_a", "1", "error"),))
    noisy = build(made(sensor=Sensor(noise, (X.angle + 0.1 * noise.e_a, X.rate))))
    np.testing.assert_array_equal(noisy.linearize([0.1, 0.0], None, controller="pd").A, plain.A)
    always = Group("c", (*C.quantities, replace(EVERY.quantities[2], default=1.0)))
    each = build(made(**law(parameters=always, every="often")))
    loop = each.linearize([0.1, 0.0], None, controller="pd")
    assert sorted(np.abs(loop.eigenvalues))[-2:] == pytest.approx(sorted(np.abs(plain.eigenvalues)))


def test_a_run_of_a_batch_is_repeated_in_the_session_that_built_its_model():
    runs = batch(build(made()), "pd", n=4, vary={"J": "uniform(1, 3)"})
    assert float(runs.mehvar.again(2)["peak"]) == float(runs["peak"][2])


def test_a_run_of_a_model_without_a_law_names_the_way():
    with pytest.raises(InputError, match="made has no law: mehvar simulate takes --input"):
        required_law(build(made(controllers=(), parameters=Group("p", P.quantities[:1]))).manifest, None)


def test_an_open_loop_is_no_law_by_the_name_none():
    manifest = build(made(controllers=(), parameters=Group("p", P.quantities[:1]))).manifest
    with pytest.raises(InputError, match="unknown controller 'none' of made: mehvar simulate takes --input"):
        manifest.controller("none")
