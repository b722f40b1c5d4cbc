# SPDX-License-Identifier: Apache-2.0
"""Crossings are found however coarse the state or the guard is there, and a run that one ends is sampled at its end."""

import numpy as np
import pytest
import sympy as sp

import mehvar
from mehvar.models.system import Controller, Event, Group, Metric, Scenario
from mehvar.runtime import simulate
from mehvar.runtime.batch.evaluation.statistics import summarise
from mehvar.runtime.batch.repeat import difference, plan_of, repeat_run
from mehvar.runtime.batch.store.store import open_store
from mehvar.runtime.run.metrics import metrics
from mehvar.runtime.run.problem import Status
from tests.models.edits import POSITIVE, parameter, quantity
from tests.models.feedback import WHOLE, table
from tests.models.written import written
from tests.reference.scipy_loop import by_scipy

METHODS = ("rk4", "dopri5", "dop853", "rock4", "rodas5p")
X = Group("x", (quantity("place", "m"), quantity("passed", "1")))
U = Group("u", (quantity("push", "m/s"),))
P = Group("p", tuple(parameter(*row) for row in (
    ("w", "m/s", 1.0), ("goal", "m", 1.1), ("far", "m", 2.0, POSITIVE), ("Ts", "s", 0.1, POSITIVE),
)))  # fmt: skip
NONE, S = Group("c", ()), Group("s", (parameter("place_0", "m", 0.0),))


GUARDS = {"near": X.place - P.goal, "afar": (X.place + P.far) ** 2 - (P.goal + P.far) ** 2}
"""Afar there are many places between two values of the guard."""


def runner(guard):
    """A place that moves at a rate, and a goal."""
    controllers = (Controller("free", "", NONE, (sp.S.Zero,)), Controller("steps", "", NONE, (0 * P.Ts,), period="Ts"))
    return table(
        X, U, P, name="runner", title="a place that moves",
        outputs=Group("y", (quantity("away", "m"),)), output=(X.place + P.far,),
        rhs=(P.w + U.push, sp.S.Zero),
        events=(Event("up", guard, "rising", {X.passed: X.passed + 1}),),
        initial=(S.place_0, sp.S.Zero), scenario_parameters=S, controllers=controllers,
        scenarios=(Scenario("plain", "", 1.0, 0.1, {}, {}, {}),),
    )  # fmt: skip


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    return {name: written(runner(guard), tmp_path_factory.mktemp(name)) for name, guard in GUARDS.items()}


def draw(rng):
    """A start, a rate, the instant of the crossing, and how far away one guard counts from."""
    sign, start = rng.choice((-1, 1)), 10.0 ** rng.uniform(-3, 9) * rng.integers(0, 2)
    rate, t = 10.0 ** rng.uniform(-6, 6), 10.0 ** rng.uniform(-3, -0.05)
    return float(sign * start), rate, t, float(2 * start + rate + 10.0 ** rng.uniform(0, 9))


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("backend", ["c", "python"])
@pytest.mark.parametrize("law", ["free", "steps"])
@pytest.mark.parametrize("guard", GUARDS)
@pytest.mark.share(11)
def test_a_crossing_is_found_however_coarse_the_state_is(folders, guard, backend, law, method):
    """The instant is off by what some spacings of the largest number in the guard are in time."""
    rng = np.random.default_rng(11)
    for _ in range(60 if backend == "c" else 12):
        start, rate, t, far = draw(rng)
        values = {"w": rate, "goal": start + rate * t, "place_0": start, "far": far}
        coarse = 64 * np.spacing(far if guard == "afar" else max(abs(start), abs(start + rate * t))) / rate
        run = simulate(folders[guard], law, backend=backend, method=method, parameters=values)
        assert run.status.name == "DONE", values
        assert len(run.events) == run.x[-1, 1] <= 1, values
        if coarse < 0.05:
            assert abs(run.events[0][0] - t) <= coarse + 1e-11, values


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("law", ["free", "steps"])
@pytest.mark.parametrize("guard", GUARDS)
@pytest.mark.share(24)
def test_coarse_crossings_in_a_batch_have_the_bits_of_runs_alone(folders, tmp_path, guard, law, method):
    vary = {"place_0": "uniform(900, 999.5)", "w": "uniform(100, 2000)", "far": "uniform(1e4, 1e9)"}
    mehvar.batch(folders[guard], law, n=11, seed=4, vary=vary, goal=1000.0, method=method, out=tmp_path / "runs.zarr")
    store = open_store(tmp_path / "runs.zarr")
    plan = plan_of(store, folders[guard])
    assert set(store.read("status").tolist()) == {Status.DONE}
    assert store.read("final")[:, 1].sum() > 0
    for number in range(11):
        text = difference(repeat_run(plan, store, number), plan, store, number)
        assert not text or (method == "rk4" and "in error" in text), number


KINDS = {
    "last": "final", "least": "min", "most": "max", "size": "max_abs", "mean": "rms", "way": "travel",
    "calm": "settling", "rest": "settling_about_end", "turns": "sign_changes",
}  # fmt: skip
UNITS = {"settling": "s", "settling_about_end": "s", "sign_changes": "1"}
THROW = Group("x", (quantity("height", "m"), quantity("speed", "m/s")))
FORCE = Group("u", (quantity("push", "m/s^2"),))
GROUND = Group("p", tuple(parameter(*row) for row in (("g", "m/s^2", 9.81), ("Ts", "s", 0.1, POSITIVE))))
BRAKE = Group("c", (parameter("k", "1/s", 0.7),))
LATE = Group("c", (*BRAKE.quantities, parameter("every", "1", 3.0, WHOLE)))
Z = Group("z", (quantity("calls", "1"),))


def throw():
    """A ball that is let go, and a run that ends where it meets the ground."""
    metrics = tuple(
        Metric(
            f"{name}_{i}",
            kind,
            ("speed",),
            band=2.5 * (kind in UNITS),
            unit=UNITS.get(kind, "m/s"),
            since=since,
            description=name,
        )
        for name, kind in KINDS.items()
        for i, since in enumerate((0.0, 0.25))
    )
    return table(
        THROW, FORCE, GROUND, name="throw", title="a ball",
        scenario_parameters=Group("s", (parameter("h_0", "m", 1.0),)),
        rhs=(THROW.speed, FORCE.push - GROUND.g), initial=(sp.Symbol("h_0", real=True), sp.S.Zero),
        outputs=Group("y", (quantity("energy", "m^2/s^2"),)), output=(GROUND.g * THROW.height + THROW.speed**2 / 2,),
        events=(Event("impact", THROW.height, "falling", ends=True),), metrics=metrics,
        scenarios=(Scenario("plain", "", 2.0, 0.1, {}, {}, {}),),
        controllers=(
            Controller("free", "", BRAKE, (-BRAKE.k * THROW.speed,)),
            Controller("steps", "", LATE, (-LATE.k * THROW.speed,), period="Ts", every="every", memory=Z,
                       start=(sp.S.Zero,), update=(Z.calls + 1,)),
        ),
    )  # fmt: skip


@pytest.fixture(scope="module")
def ground(tmp_path_factory):
    return written(throw(), tmp_path_factory.mktemp("throw"))


@pytest.mark.parametrize("backend", ["c", "python"])
@pytest.mark.parametrize("method", METHODS)
def test_an_end_by_an_event_is_a_sample(ground, backend, method):
    run = simulate(ground, "free", backend=backend, method=method, parameters={"k": 0.0})
    assert run.status.complete
    assert run.t[-1] == run.t_stop == pytest.approx(np.sqrt(2 / 9.81), abs=1e-9)
    np.testing.assert_allclose(run.t[:-1], np.arange(5) / 10)
    assert metrics(run, run.manifest)["last_0"] == pytest.approx(-np.sqrt(2 * 9.81), abs=1e-7)


@pytest.mark.parametrize(("law", "settings"), [
    ("free", {}), ("free", {"hold": 0.1, "delay": 1}), ("free", {"dt_out": 0.03, "hold": 0.06}),
    ("steps", {}), ("steps", {"delay": 1}), ("steps", {"Ts": 0.06, "dt_out": 0.03}),
])  # fmt: skip
def test_backends_sample_the_same_end(ground, law, settings):
    runs = [simulate(ground, law, rtol=1e-12, atol=1e-12, **settings)]
    with by_scipy():
        runs.append(simulate(ground, law, rtol=1e-12, atol=1e-12, **settings))
    for name in ("t", "x", "u", "u_cmd", "y", "z"):
        np.testing.assert_allclose(getattr(runs[0], name), getattr(runs[1], name), atol=1e-8, err_msg=name)
    values = [metrics(run, run.manifest) for run in runs]
    assert values[0] == pytest.approx(values[1], abs=1e-7, nan_ok=True)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(("law", "settings"), [("free", {}), ("steps", {}), ("steps", {"dt_out": 0.05, "delay": 2})])
@pytest.mark.share(8)
def test_ends_in_a_batch_have_the_bits_of_runs_alone(ground, tmp_path, law, settings, method):
    """All kinds of metrics, some of windows that only the last sample is in or that no sample is in."""
    where = tmp_path / "throws.zarr"
    runs = mehvar.batch(
        ground, law, n=13, seed=2, vary={"h_0": "uniform(0.001, 30)", "k": "uniform(0, 2)"}, method=method, out=where,
        save=0.1, success="final(height) < 0.001", **settings,
    )  # fmt: skip
    assert set(runs["status"].values.tolist()) == {Status.DONE, Status.EVENT}
    store = open_store(where)
    plan = plan_of(store, ground)
    for number in range(13):
        text = difference(repeat_run(plan, store, number), plan, store, number)
        assert not text or (method == "rk4" and "in error" in text), number
    ended = runs["status"].values == Status.EVENT
    assert np.array_equal(runs["final"].sel(state="speed").values, runs["last_0"].values)
    assert summarise(store).successes == ended.sum()
    assert summarise(store, "final(speed) < 0").successes == 13
