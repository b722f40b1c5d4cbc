# SPDX-License-Identifier: Apache-2.0
"""Limits with known instants: a run ends at each by every method, in C, lanes and Python, also where one is touched."""

import math

import numpy as np
import pytest
import sympy as sp

import mehvar
from mehvar.models.system import Condition, Controller, Event, Group, Scenario
from mehvar.runtime import simulate
from mehvar.runtime.batch.repeat import difference, plan_of, repeat_run
from mehvar.runtime.batch.store.store import open_store
from mehvar.runtime.run.problem import Status
from tests.models.edits import POSITIVE, parameter, quantity
from tests.models.feedback import table
from tests.models.written import written

X = Group("x", (quantity("a", "m"), quantity("v", "m/s")))
U = Group("u", (quantity("push", "m/s^2"),))
P = Group("p", tuple(parameter(*row) for row in (
    ("w", "1/s", 1.0, POSITIVE), ("low", "m", -10.0), ("gap", "m^2", 1e-12), ("Ts", "s", 0.25, POSITIVE),
    ("most", "m", 1e9),
)))  # fmt: skip
S = Group("s", (parameter("a_0", "m", 1.0), parameter("v_0", "m/s", 0.0)))
ADAPTIVE = ("dopri5", "dop853", "rock4", "rodas5p")
LAWS = ("smooth", "steps")


def swinging(**fields):
    """A mass on a spring that may not come below a place, nor near the middle, where its margin only touches zero."""
    none = Group("c", ())
    own = {
        "rhs": (X.v, U.push - P.w**2 * X.a), "initial": S.symbols, "scenario_parameters": S,
        "limits": (
            Condition(X.a - P.low, "the mass is below {low} m"), Condition(X.a**2 - P.gap, "the mass is in the middle"),
        ),
        "controllers": (
            Controller("smooth", "", none, (sp.S.Zero,)), Controller("steps", "", none, (sp.S.Zero,), period="Ts"),
        ),
        "scenarios": (Scenario("plain", "plain", 10.0, 0.5, {}, {}, {}),),
    }  # fmt: skip
    return table(X, U, P, name="swing", title="a mass on a spring", **(own | fields))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return written(swinging(outputs=Group("y", (quantity("p_most", "m"),)), output=(P.most,)),
                   tmp_path_factory.mktemp("swing"))  # fmt: skip


@pytest.mark.parametrize("backend", ["c", "python"])
@pytest.mark.parametrize("method", ADAPTIVE)
@pytest.mark.parametrize("law", LAWS)
def test_a_margin_that_touches_zero_ends_the_run_there(folder, law, method, backend):
    loaded = mehvar.load(folder, backend)
    for a, v, tolerance in ((1.0, 0.0, 1e-9), (1.0, 0.0, 1e-5), (-0.7, 0.2, 1e-6), (0.3, 5.0, 1e-4)):
        run = simulate(loaded, law, a_0=a, v_0=v, method=method, rtol=tolerance, atol=tolerance)
        assert (run.status, run.violated) == (Status.LIMIT, 1)
        assert "the mass is in the middle" in run.reason
        expected = math.atan2(-a, v) % math.pi  # a cos t + v sin t = 0
        assert run.t_stop == pytest.approx(expected, abs=30 * tolerance + 1e-5)


@pytest.mark.parametrize("backend", ["c", "python"])
@pytest.mark.parametrize("law", LAWS)
def test_a_margin_that_crosses_zero_is_located(folder, law, backend):
    """Within a run, and in its first step; by secants, which take 3 to 5 trials where halves would take some 20."""
    loaded = mehvar.load(folder, backend)
    for method in ADAPTIVE:
        for a, v, expected in ((2.0, 0.0, math.pi / 3), (1.0001, -1.0, 1e-4)):
            run = simulate(loaded, law, a_0=a, v_0=v, low=1.0, method=method)
            assert (run.status, run.violated) == (Status.LIMIT, 0)
            assert run.t_stop == pytest.approx(expected, abs=2e-8)
            assert run.statistics["rejected"] <= 6


@pytest.mark.parametrize("shape", ["flat", "shallow", "cube", "steep", "jump"])
def test_the_slope_of_a_margin_beyond_zero_does_not_move_the_end(shape, tmp_path):
    """A secant does not see where a margin that is flat beyond zero has crossed it."""
    room = (X.a - P.low) / P.most
    margin = {
        "flat": sp.Max(room, 0), "shallow": sp.Piecewise((room, room > 0), (room / 10**9, True)), "cube": room**3,
        "steep": sp.Piecewise((room, room > 0), (room * 10**9, True)), "jump": sp.sign(room),
    }[shape]  # fmt: skip
    shown = Group("y", tuple(quantity(f"p_{q.name}", q.unit) for q in P))
    system = swinging(limits=(Condition(margin, "the mass is below {low} m"),), outputs=shown, output=P.symbols)
    shaped = mehvar.load(written(system, tmp_path))
    for law in LAWS:
        for method in ADAPTIVE:
            run = simulate(shaped, law, a_0=2.0, low=1.0, most=1.0, method=method, t_end=5.0)
            assert (run.status, run.violated) == (Status.LIMIT, 0)
            assert run.t_stop == pytest.approx(math.pi / 3, abs=1e-8)


@pytest.mark.parametrize("backend", ["c", "python"])
def test_a_margin_that_falls_at_a_constant_rate_is_located_at_the_first_trial(folder, backend):
    """Later, and in the first step."""
    for low, expected in ((1.0, 1.0), (1.999, 0.001)):
        run = simulate(folder, "smooth", w=1e-9, a_0=2.0, v_0=-1.0, low=low, t_end=4.0, backend=backend)
        assert run.t_stop == pytest.approx(expected, abs=1e-9)
        assert run.statistics["rejected"] == 1


def test_fixed_steps_do_not_pass_over_a_margin_that_touches_zero(folder):
    for law in LAWS:
        run = simulate(folder, law, method="rk4", step=0.1)
        assert (run.status, run.violated) == (Status.LIMIT, 1)
        assert run.t_stop == pytest.approx(math.pi / 2, abs=0.1)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.share(2)
def test_lanes_end_as_runs_alone(folder, law, tmp_path):
    mehvar.batch(folder, law, n=9, seed=1, vary={"a_0": "uniform(-1, 1)", "v_0": "uniform(-1, 1)"}, out=tmp_path / "s")
    store = open_store(tmp_path / "s")
    assert set(store.read("status")) == {int(Status.LIMIT)}
    plan = plan_of(store, folder)
    assert {difference(repeat_run(plan, store, k), plan, store, k) for k in range(9)} == {""}


def test_runs_clear_of_limits_have_the_bits_of_runs_without(folder, tmp_path):
    free = written(swinging(limits=(), outputs=Group("y", tuple(quantity(f"p_{q.name}", q.unit) for q in P)),
                            output=P.symbols), tmp_path)  # fmt: skip
    for law in LAWS:
        for method in (*ADAPTIVE, "rk4"):
            near, far = (simulate(f, law, a_0=1.0, method=method, t_end=1.4) for f in (folder, free))
            np.testing.assert_array_equal(near.x, far.x)
            assert near.statistics["steps"] == far.statistics["steps"]


def test_an_event_comes_before_a_limit_behind_it_and_moves_the_mass_beyond_one(tmp_path):
    hit = Event("hit", X.a - P.most, "falling", {X.a: 2 * (X.a - P.most)})
    system = swinging(events=(hit,), outputs=Group("y", (quantity("p_Ts", "s"),)), output=(P.Ts,))
    moved = written(system, tmp_path)
    for backend in ("c", "python"):
        run = simulate(moved, "smooth", low=-1.0, most=0.5, backend=backend)
        assert [name for _, name in run.events] == ["hit"]
        assert (run.status, run.violated) == (Status.LIMIT, 1)
        assert run.t_stop == pytest.approx(math.pi / 3, abs=1e-7)
        run = simulate(moved, "smooth", low=0.4, most=0.5, backend=backend)
        assert (run.status, run.violated) == (Status.LIMIT, 0)


@pytest.mark.parametrize("backend", ["c", "python"])
@pytest.mark.parametrize("method", ADAPTIVE)
def test_an_instant_is_as_good_in_a_run_of_milliseconds_as_in_one_of_hours(folder, method, backend):
    """The length of the run decides: a mass that swings faster is at its limit earlier."""
    loaded = mehvar.load(folder, backend)
    for rate in (2.0**-12, 1.0, 2.0**12):
        run = simulate(loaded, "smooth", w=rate, a_0=2.0, low=1.0, method=method, t_end=10 / rate, dt_out=0.5 / rate)
        assert (run.status, run.violated) == (Status.LIMIT, 0)
        assert run.t_stop * rate == pytest.approx(math.pi / 3, abs=2e-8)
