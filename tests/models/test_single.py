# SPDX-License-Identifier: Apache-2.0
"""A system with one quantity in each vector, which is called as the vector is: x' = u - p x towards r."""

import math

import pytest
import sympy as sp

import mehvar
from mehvar.models.system import Controller, Group, Scenario, System
from mehvar.runtime import load
from tests.models.edits import POSITIVE, parameter, quantity
from tests.models.feedback import table
from tests.models.written import written

GAIN, POLE, END, PERIOD = 0.5, 2.0, 1.5, 0.1


def single() -> System:
    x, u, r = (Group(name, (quantity(name, unit),)) for name, unit in (("x", "m"), ("u", "m/s"), ("r", "m")))
    p, s = Group("p", (parameter("p", "1/s", POLE, POSITIVE),)), Group("s", (parameter("s", "m", 1.0),))
    c, z = Group("c", (parameter("c", "1/s", GAIN),)), Group("z", (quantity("z", "m"),))
    held = {"period": "Ts", "memory": z, "start": (sp.S.Zero,), "update": (x.x,)}
    return table(
        x, u, Group("p", (*p.quantities, parameter("Ts", "s", PERIOD, POSITIVE))), name="single", title="one of each",
        scenario_parameters=s, references=r, reference=(s.s,), outputs=Group("y", (quantity("y", "m"),)),
        output=(x.x - r.r,), rhs=(u.u - p.p * x.x,), initial=(s.s,),
        controllers=(
            Controller("smooth", "", c, (-c.c * (x.x - r.r),)),
            Controller("steps", "", c, (-c.c * (x.x - r.r),), **held),
        ),
        scenarios=(Scenario("plain", "plain", END, PERIOD, {}, {}, {}),),
    )  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return written(single(), tmp_path_factory.mktemp("single"))


@pytest.mark.parametrize("backend", ["c", "python"])
def test_vectors_of_one_element_are_vectors(folder, backend):
    run = mehvar.simulate(load(folder, backend=backend), "smooth", rtol=1e-10, atol=1e-12)
    rate = POLE + GAIN
    rest = GAIN / rate
    assert float(run["x"][-1]) == pytest.approx(rest + (1 - rest) * math.exp(-rate * END), rel=1e-9)
    assert float(run["y"][-1]) == pytest.approx(float(run["x"][-1]) - 1)
    held = mehvar.simulate(load(folder, backend=backend), "steps", rtol=1e-10, atol=1e-12)
    x, decay = 1.0, math.exp(-POLE * PERIOD)
    for _ in range(round(END / PERIOD)):
        x = decay * x + (1 - decay) / POLE * GAIN * (1 - x)
    assert float(held["x"][-1]) == pytest.approx(x, rel=1e-9)


def test_and_in_a_batch_and_alone(folder):
    model = load(folder)
    store = mehvar.batch(model, "smooth", n=3, vary={"s": "uniform(1, 2)"})
    alone = mehvar.simulate(model, "smooth", parameters={"s": float(store["s"][1])})
    assert float(store["final"].sel(state="x")[1]) == float(alone["x"][-1])
    assert model.jac_x([1.0], [0.0], model.parameters()).tolist() == [[-POLE]]
