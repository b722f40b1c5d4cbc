# SPDX-License-Identifier: Apache-2.0
"""Guards with known roots: each is found once, in its direction, by every method, in C, lanes and Python."""

import dataclasses
import math

import numpy as np
import pytest
import sympy as sp

import mehvar
from mehvar.base.errors import InputError
from mehvar.models.check import check
from mehvar.models.quantities import ModelError
from mehvar.models.system import TIME, Controller, Derivation, Event, Group, Metric, System, surfaces
from mehvar.runtime import simulate
from mehvar.runtime.batch.repeat import difference, plan_of, repeat_run
from mehvar.runtime.batch.store.store import open_store
from mehvar.runtime.run.problem import Status
from mehvar.web.export import export_web
from tests.models.edits import POSITIVE, cart, parameter, quantity
from tests.models.written import written

METHODS = ("rk4", "dopri5", "dop853", "rock4", "rodas5p")
COUNTERS = ("ups", "downs", "both", "order")


def turning() -> System:
    """An angle that turns steadily and a wave on it, with events that count in states of rate zero."""
    x = Group("x", (quantity("angle", "rad"), *(quantity(name, "1") for name in COUNTERS)))
    u = Group("u", (quantity("push", "1/s"),))
    rows = (
        ("w", "1/s", 1.0, POSITIVE),
        ("a", "1", 3.0),
        ("b", "1", 0.5),
        ("top", "1", 1e9),
        ("Ts", "s", 0.5, POSITIVE),
    )
    p, c = Group("p", tuple(parameter(*row) for row in rows)), Group("c", ())
    wave = sp.sin(p.a * x.angle + p.b)
    return dataclasses.replace(
        cart(), name="turning", states=x, inputs=u, references=Group("r", ()), outputs=Group("y", ()), output=(),
        parameters=p, scenario_parameters=Group("s", ()), rhs=(p.w + u.push, *[sp.S.Zero] * 4), steps=(), limits=(),
        initial=(sp.S.Zero,) * 5, reference=(), constraints=(), functions=(), actuator=None, sensor=None, choices=(),
        variants=(), rates={}, residual=(),
        metrics=(Metric("ups_seen", "events", ("up",), unit="1", description="crossings upwards"),),
        scenarios=(dataclasses.replace(cart().scenarios[0], values={}, duration=10.0, step=1.0),),
        controllers=(
            Controller("free", "", c, (sp.S.Zero,)),
            Controller("steps", "", c, (sp.S.Zero * p.Ts,), period="Ts"),
        ),
        events=(
            Event("up", wave, "rising", {x.ups: x.ups + 1}),
            Event("down", wave, "falling", {x.downs: x.downs + 1}),
            Event("any", 2 * wave, "either", {x.both: x.both + 1}),
            Event("first", sp.cos(TIME.symbol / p.Ts), "rising", {x.order: 2 * x.order + 1}),
            Event("second", sp.cos(TIME.symbol / p.Ts), "rising", {x.order: 3 * x.order}),
            Event("full", x.angle - p.top, "rising", ends=True),
        ),
    )  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return written(turning(), tmp_path_factory.mktemp("turning"))


def roots(a, b, w, end=10.0):
    """Roots of sin(a w t + b) after the start, and whether it rises there."""
    first, last = math.ceil(b / math.pi), math.floor((a * w * end + b) / math.pi)
    times = [((k * math.pi - b) / (a * w), k % 2 == 0) for k in range(first, last + 1)]
    return [(t, rises) for t, rises in times if 0 < t < end]


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("backend", ["c", "python"])
@pytest.mark.parametrize("law", ["free", "steps"])
@pytest.mark.share(12)
def test_roots_are_found_once_and_in_their_direction(folder, backend, law, method):
    """Steps of half a second at most see what is a quarter of that apart."""
    rng = np.random.default_rng(7)
    for _ in range(8):
        a, b, w = rng.uniform(1, 12), rng.uniform(-3, 3), rng.uniform(0.5, 1.5)
        values = {"a": a, "b": b, "w": w}
        run = simulate(folder, law, backend=backend, method=method, parameters=values, dt_out=0.125)
        expected = roots(a, b, w)
        for name, wanted in (
            ("up", [t for t, rises in expected if rises]),
            ("down", [t for t, rises in expected if not rises]),
            ("any", [t for t, _ in expected]),
        ):
            times = [t for t, event in run.events if event == name]
            assert len(times) == len(wanted), (name, values)
            np.testing.assert_allclose(times, wanted, atol=3e-11)
        counts = [sum(event == name for _, event in run.events) for name in ("up", "down", "any")]
        assert list(run.x[-1, 1:4]) == counts


@pytest.mark.parametrize("backend", ["c", "python"])
def test_events_at_one_instant_happen_in_the_order_of_the_system(folder, backend):
    run = simulate(folder, "free", backend=backend, t_end=2.5)
    first = [(t, event) for t, event in run.events if event in ("first", "second")]
    assert [event for _, event in first] == ["first", "second"]
    assert abs(first[0][0] - 0.75 * math.pi) < 1e-11
    assert first[0][0] == first[1][0]
    assert run.x[-1, 4] == 3 * (2 * 0 + 1)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("backend", ["c", "python"])
def test_a_run_ends_where_an_event_says(folder, backend, method):
    run = simulate(folder, "free", backend=backend, method=method, parameters={"top": 4.3})
    assert run.status is Status.EVENT
    assert run.reason == "the event full ends the run at t = 4.3 s"
    assert abs(run.t_stop - 4.3) < 1e-11
    assert run.t[-1] == run.t_stop
    assert run.t[-2] == 4.0
    assert run.x[-1, 0] == pytest.approx(4.3, abs=1e-10)


@pytest.mark.parametrize("backend", ["c", "python"])
def test_a_guard_that_starts_at_zero_does_not_happen_for_that(folder, backend):
    for b, name in ((0.0, "up"), (math.pi / 2, "down")):
        start = 0.0 if b == 0 else -0.0
        run = simulate(
            folder, "free", backend=backend, parameters={"a": 1.0, "b": b}, initial={"angle": start}, t_end=1.0
        )
        assert name not in [event for _, event in run.events]


@pytest.mark.parametrize("law", ["free", "steps"])
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.share(12)
def test_a_batch_has_the_bits_of_its_runs(folder, tmp_path, law, method):
    vary = {"a": "uniform(1, 12)", "b": "uniform(-3, 3)", "w": "uniform(0.5, 1.5)", "top": "uniform(3, 20)"}
    runs = mehvar.batch(folder, law, n=11, seed=3, vary=vary, method=method, dt_out=0.125, out=tmp_path / "runs.zarr")
    store = open_store(tmp_path / "runs.zarr")
    plan = plan_of(store, folder)
    for number in range(11):
        text = difference(repeat_run(plan, store, number), plan, store, number)
        assert not text or (method == "rk4" and "in error" in text)  # of rk4 only batches estimate the error
    assert runs["ups_seen"].values.max() > 10
    assert set(runs["status"].values.tolist()) == {Status.DONE, Status.EVENT}


def chatters() -> System:
    """Two modes that hand over to each other: the motion would have to slide."""
    system = turning()
    x = Group("x", (quantity("angle", "rad"), quantity("mode", "1")))
    p = Group("p", (parameter("w", "1/s", 1.0, POSITIVE), parameter("Ts", "s", 0.5, POSITIVE)))
    return dataclasses.replace(
        system, name="chatters", states=x, parameters=p, metrics=(),
        rhs=(p.w * x.mode + system.inputs.push, sp.S.Zero), initial=(-sp.S.One, sp.S.One),
        events=(
            Event("over", x.angle, "rising", {x.mode: -sp.S.One}),
            Event("under", x.angle, "falling", {x.mode: sp.S.One}),
        ),
    )  # fmt: skip


@pytest.mark.parametrize("backend", ["c", "python"])
@pytest.mark.parametrize("method", METHODS)
def test_modes_that_hand_over_to_each_other_end_the_run(tmp_path, backend, method):
    run = simulate(written(chatters(), tmp_path), "free", backend=backend, method=method)
    assert run.status is Status.CHATTERING
    assert run.reason.endswith("at t = 1 s")


def test_a_result_keeps_its_events(folder, tmp_path):
    run = mehvar.simulate(folder, "free")
    mehvar.save(run, tmp_path / "run.nc")
    again = mehvar.open_result(tmp_path / "run.nc")
    assert again.attrs["events"] == run.attrs["events"]
    assert '"up"' in run.attrs["events"]


def test_surfaces_are_the_kinks_of_an_expression():
    d, x = Derivation(), sp.Symbol("x", real=True)
    inner = d.define("inner", sp.Max(x, -1, x**2))
    kinks = surfaces("k", [sp.Abs(x - 2), sp.Piecewise((inner, x < 5), (0, True)), sp.Min(2 - x, 0)], d)
    expected = (x - 2, x - 5, x - x**2)  # -1 is never the largest
    assert {sp.srepr(abs(event.guard)) for event in kinks} == {sp.srepr(abs(guard)) for guard in expected}
    assert [event.name for event in kinks] == ["k_1", "k_2", "k_3"]
    assert not any(event.reset for event in kinks)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"direction": "up"}, r"direction = 'up': must be either, rising or falling"),
        ({"reset": {sp.Symbol("other"): sp.S.One}}, "must be the symbol of a state"),
        ({"name": "two words"}, "letters, digits and underscores"),
        ({"name": "down"}, "is defined twice"),
        ({"guard": sp.S.One}, "does not depend on any symbol"),
        ({"guard": sp.Symbol("other")}, "'other' belongs to no group"),
    ],
)
def test_what_is_refused(change, message):
    system = turning()
    event = dataclasses.replace(system.events[0], **change)
    with pytest.raises(ModelError, match=message):
        check(dataclasses.replace(system, events=(event, *system.events[1:])))


def test_a_unit_of_a_reset_is_checked():
    system = turning()
    event = dataclasses.replace(system.events[0], reset={system.states.ups: system.parameters.Ts})
    with pytest.raises(ModelError, match=r"reset of event 'up'.* has the unit s: must be 1"):
        check(dataclasses.replace(system, events=(event, *system.events[1:])))


def test_a_sampled_law_has_no_surfaces():
    system = turning()
    law = dataclasses.replace(system.controllers[1], events=(Event("kink", system.states.angle),))
    with pytest.raises(ModelError, match="a sampled law switches only at its samples"):
        check(dataclasses.replace(system, controllers=(law,)))


def test_a_page_refuses_events_by_name(folder, tmp_path):
    with pytest.raises(InputError, match=r"turning has events \(up, down, .*, which a page cannot have"):
        export_web(folder, tmp_path / "page")
