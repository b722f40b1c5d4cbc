# SPDX-License-Identifier: Apache-2.0
"""Time in a law and in a plant, continuous and sampled, against exact solutions."""

import dataclasses

import numpy as np
import pytest
import sympy as sp

import mehvar
from mehvar.models.check import check
from mehvar.models.clock import with_clock
from mehvar.models.quantities import ModelError
from mehvar.models.system import (
    TIME,
    Choice,
    Condition,
    Controller,
    Derivation,
    Function,
    Group,
    Sensor,
    System,
    Variant,
)
from mehvar.runtime import load, simulate
from mehvar.runtime.batch.repeat import difference, plan_of, repeat_run
from mehvar.runtime.batch.store.store import open_store
from tests.models.edits import POSITIVE, cart, parameter, quantity, turner
from tests.models.written import written


def pushed() -> System:
    """A speed v' = a, with a = k cos(w t)."""
    c = Group("c", (parameter("k", "m/s^2", 2.0), parameter("w", "1/s", 3.0)))
    push = (c.k * sp.cos(c.w * TIME.symbol),)
    u, p = Group("u", (quantity("a", "m/s^2"),)), Group("p", (parameter("Ts", "s", 0.1, POSITIVE),))
    return dataclasses.replace(
        cart(), name="pushed", states=Group("x", (quantity("v", "m/s"),)), inputs=u, references=Group("r", ()),
        outputs=Group("y", ()), output=(), parameters=p, scenario_parameters=Group("s", ()), rhs=(u.a,), steps=(),
        limits=(), initial=(sp.S.Zero,), reference=(), constraints=(), functions=(), metrics=(), actuator=None,
        sensor=None, choices=(), variants=(), rates={}, residual=(),
        scenarios=(dataclasses.replace(cart().scenarios[0], values={}),),
        controllers=(Controller("wave", "", c, push), Controller("steps", "", c, push, period="Ts")),
    )  # fmt: skip


def shaken() -> System:
    """A speed in a wind that turns, v' = a + k cos(w t), measured right and k t too fast, with a bound that rises."""
    x, u, t = Group("x", (quantity("v", "m"),)), Group("u", (quantity("a", "m/s"),)), TIME.symbol
    rows = (("k", "m/s", 2.0), ("w", "1/s", 3.0), ("Ts", "s", 0.1, POSITIVE), ("top", "m", 1.0))
    p, c = Group("p", tuple(parameter(*row) for row in rows)), Group("c", (parameter("gain", "1/s", 0.5),))
    seen, d = Group("seen", (quantity("exact", "m"), quantity("fast", "m"))), Derivation()
    wind = d.define("wind", p.k * sp.cos(p.w * t), title="a wind that turns")
    return dataclasses.replace(
        pushed(), name="shaken", states=x, inputs=u, parameters=p, rhs=(u.a + wind,), steps=tuple(d.steps),
        outputs=Group("y", (quantity("gust", "m/s"),)), output=(wind,),
        limits=(Condition(p.top * (2 + t / p.Ts) - x.v, "too fast"),),
        functions=(Function("wind_at", (x, p), ((quantity("W", "m/s"), wind),), "the wind"),),
        sensor=Sensor(Group("e", ()), (x.v, x.v + p.k * t), seen),
        controllers=(
            Controller("brake", "", c, (-c.gain * seen.exact,)),
            Controller("steps", "", c, (-c.gain * seen.fast,), period="Ts"),
        ),
        choices=(Choice("air", ("windy", "calm"), "with or without wind"),),
        variants=(Variant(("calm",), (u.a + wind / 2,), {}),),
    )  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return written(pushed(), tmp_path_factory.mktemp("pushed"))


@pytest.fixture(scope="module")
def windy(tmp_path_factory):
    return written(shaken(), tmp_path_factory.mktemp("shaken"))


@pytest.mark.parametrize("backend", ["c", "python"])
def test_a_law_of_time(folder, backend):
    run = simulate(folder, "wave", backend=backend)
    np.testing.assert_allclose(run.x[:, 0], 2 / 3 * np.sin(3 * run.t), atol=1e-8)
    run = simulate(folder, "steps", backend=backend)
    np.testing.assert_allclose(run.u[:-1, 0], 2 * np.cos(3 * run.t[:-1]), atol=1e-12)
    np.testing.assert_allclose(run.x[1:, 0], np.cumsum(0.1 * run.u[:-1, 0]), atol=1e-12)


def test_a_system_without_time_in_its_laws_stays_as_it_is():
    system = cart()
    assert with_clock(system) is system


def pulled(t):
    """The solution of v' = -g v + k cos(w t), v(0) = 0."""
    g, k, w = 0.5, 2.0, 3.0
    return k * (g * np.cos(w * t) + w * np.sin(w * t) - g * np.exp(-g * t)) / (g**2 + w**2)


def stepped(n):
    """The same under a law that is held for 0.1 s and sees k t too much."""
    t, v = 0.1 * np.arange(n), np.zeros(n)
    for i in range(n - 1):
        u = -0.5 * (v[i] + 2 * t[i])
        v[i + 1] = v[i] + 0.1 * u + 2 / 3 * (np.sin(3 * t[i + 1]) - np.sin(3 * t[i]))
    return v


@pytest.mark.parametrize("method", ["dop853", "dopri5", "rk4", "rock4", "rodas5p"])
@pytest.mark.parametrize("backend", ["c", "python", "casadi"])
@pytest.mark.share(2)
def test_a_plant_of_time(windy, backend, method):
    run = simulate(windy, "brake", backend=backend, method=method, **({"step": 0.01} if method == "rk4" else {}))
    np.testing.assert_allclose(run.x[:, 0], pulled(run.t), atol=1e-7)
    np.testing.assert_allclose(run.x[:, 1], run.t, atol=1e-13)
    np.testing.assert_allclose(run.y[:, 0], 2 * np.cos(3 * run.t), atol=1e-12)
    run = simulate(windy, "steps", backend=backend, method=method, **({"step": 0.01} if method == "rk4" else {}))
    np.testing.assert_allclose(run.x[:, 0], stepped(len(run.t)), atol=1e-7)


@pytest.mark.parametrize("backend", ["c", "python"])
def test_limit_and_variant_of_a_plant_of_time(windy, backend):
    calm = simulate(windy, "brake", backend=backend, air="calm")
    np.testing.assert_allclose(calm.x[:, 0], pulled(calm.t) / 2, atol=1e-7)
    above = simulate(windy, "brake", backend=backend, parameters={"top": 0.01})
    bound = 0.01 * (2 + above.t / 0.1)
    assert "too fast" in above.reason
    assert np.all(above.x[:-1, 0] < bound[:-1])
    assert pulled(above.t_stop) > 0.01 * (2 + above.t_stop / 0.1) - 1e-6


@pytest.mark.parametrize("law", ["steps", "brake"])
@pytest.mark.parametrize("method", ["dop853", "dopri5", "rock4", "rodas5p"])
@pytest.mark.share(12)
def test_a_batch_of_a_plant_of_time_has_the_bits_of_its_runs(windy, tmp_path, law, method):
    runs = mehvar.batch(windy, law, n=9, seed=1, vary={"k": "uniform(1, 3)"}, method=method, out=tmp_path / "runs.zarr")
    assert set(runs["status"].values.tolist()) == {0}
    store = open_store(tmp_path / "runs.zarr")
    plan = plan_of(store, windy)
    for number in range(9):
        assert difference(repeat_run(plan, store, number), plan, store, number) == ""


def test_tools_find_time_in_the_state(windy):
    model, at = load(windy), np.array([0.3, 0.7])
    p = model.parameters()
    assert model.state_names == ("v", "clock")
    np.testing.assert_allclose(model.rhs(at, [0.1], p), [0.1 + 2 * np.cos(2.1), 1.0], rtol=1e-15)
    np.testing.assert_allclose(model.jac_x(at, [0.1], p), [[0, -6 * np.sin(2.1)], [0, 0]], rtol=1e-14)
    np.testing.assert_allclose(model.to_casadi("rhs")(at, [0.1], p).full()[:, 0], model.rhs(at, [0.1], p), rtol=1e-15)
    np.testing.assert_allclose(model.functions["wind_at"](at, p), 2 * np.cos(2.1), rtol=1e-15)
    point = mehvar.trim(model, fix={"clock": 0.7}, free=["a"])
    np.testing.assert_allclose(point.u, [-2 * np.cos(2.1)], rtol=1e-12)
    assert point.steady == ("v",)


def test_time_in_the_rates_of_a_chart(tmp_path):
    """The turner in a wind that grows: on the axis the radius obeys r' = w t - g r."""
    system = turner()
    q, n, p, t = system.coordinates.states, system.coordinates.inputs, system.parameters, TIME.symbol
    wind, radius = p.wind * t / sp.Symbol("unit", real=True), sp.sqrt(q.a**2 + q.b**2)
    chart = dataclasses.replace(system.coordinates, rhs=(n.va + wind * q.a / radius, n.vb + wind * q.b / radius))
    rhs = (system.inputs.out + wind, system.inputs.round)
    unit = Group("p", (*p.quantities, parameter("unit", "s")))
    path = written(dataclasses.replace(system, parameters=unit, rhs=rhs, coordinates=chart), tmp_path)
    run = simulate(path, "inward")
    np.testing.assert_allclose(run.x[:, 0], 2 * np.exp(-run.t) + run.t - 1, atol=1e-7)
    np.testing.assert_allclose(run.x[:, -1], run.t, atol=1e-13)


def test_a_state_called_clock_is_refused_in_a_plant_of_time():
    system = shaken()
    clock = dataclasses.replace(
        system, states=Group("x", (*system.states.quantities, quantity("clock", "m"))),
        rhs=(*system.rhs, system.rhs[0]), initial=(*system.initial, sp.S.Zero), sensor=None,
    )  # fmt: skip
    with pytest.raises(ModelError, match=r"'clock'.*rename one of them"):
        check(clock)
