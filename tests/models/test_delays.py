# SPDX-License-Identifier: Apache-2.0
"""Inputs that act some samples after their command, each as many as the plant says, against NumPy."""

import dataclasses

import numpy as np
import pytest
import sympy as sp

import mehvar
from mehvar.base.errors import InputError
from mehvar.fmu.variables import subject
from mehvar.models.check import check
from mehvar.models.quantities import ModelError
from mehvar.models.system import Controller, Group, Scenario, System
from mehvar.runtime import load, simulate
from mehvar.runtime.batch.repeat import difference, plan_of, repeat_run
from mehvar.runtime.batch.store.store import open_store
from tests.models.edits import POSITIVE, parameter, quantity
from tests.models.feedback import WHOLE, table
from tests.models.written import written

COUNT = dataclasses.replace(WHOLE, lower=0.0)


def pipes(*without: str) -> System:
    """Two levels, each with a valve of its own and a pipe before it, or without: a' = u1, b' = u2 - a."""
    delays = {u: name for u, name in (("u1", "first"), ("u2", "second")) if name not in without}
    x = Group("x", (quantity("a", "m"), quantity("b", "m")))
    u = Group("u", (quantity("u1", "m/s"), quantity("u2", "m/s")))
    counts = (parameter("first", "1", 3.0, COUNT), parameter("second", "1", 7.0, COUNT))
    p = Group("p", (parameter("Ts", "s", 0.1, POSITIVE), parameter("leak", "1/s", 0.4),
                    *(count for count in counts if count.name in delays.values())))  # fmt: skip
    c, s = Group("c", (parameter("k", "1/s", 0.6),)), Group("s", (parameter("a_0", "m", 1.0),))
    command = (-c.k * x.a, -c.k * (x.b + x.a))
    return table(
        x, u, p, name="pipes", title="two levels", scenario_parameters=s, rhs=(u.u1, u.u2 - p.leak * x.a),
        initial=(s.a_0, sp.S.Zero), delays=delays,
        controllers=(Controller("steps", "", c, command, period="Ts"), Controller("smooth", "", c, command)),
        scenarios=(Scenario("plain", "plain", 4.0, 0.05, {}, {}, {}),),
    )  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return written(pipes(), tmp_path_factory.mktemp("pipes"))


def levels(late, delay=0):
    """States at the samples by hand."""
    x, sent, rows = np.array([1.0, 0.0]), [], []
    for k in range(41):
        rows.append(x)
        sent.append([-0.6 * x[0], -0.6 * (x[0] + x[1])])
        u = np.array([sent[k - n - delay][i] if k >= n + delay else 0.0 for i, n in enumerate(late)])
        x = x + 0.1 * np.array([u[0], u[1] - 0.4 * x[0]]) - [0, 0.4 * 0.005 * u[0]]
    return np.array(rows)


@pytest.mark.parametrize("backend", ["c", "python"])
@pytest.mark.parametrize(("late", "delay"), [((3, 7), 0), ((0, 12), 0), ((0, 0), 0), ((5, 2), 4)])
def test_inputs_act_later(folder, backend, late, delay):
    values = dict(zip(("first", "second"), late, strict=True))
    run = simulate(folder, "steps", parameters=values, delay=delay, backend=backend)
    np.testing.assert_allclose(run.x[::2], levels(late, delay), atol=1e-9)


@pytest.mark.parametrize("backend", ["c", "python"])
@pytest.mark.parametrize(("own", "late"), [("first", (4, 0)), ("second", (0, 4))])
def test_an_input_without_a_pipe_acts_at_once_beside_one_that_has(tmp_path, backend, own, late):
    alone = written(pipes(*{"first", "second"} - {own}), tmp_path)
    run = simulate(alone, "steps", parameters={own: 4}, backend=backend)
    np.testing.assert_allclose(run.x[::2], levels(late), atol=1e-9)


def test_delays_may_differ_from_lane_to_lane(folder, tmp_path):
    path, vary = tmp_path / "runs.zarr", {"first": "choice(0, 2, 9)", "k": "uniform(0.5, 0.7)"}
    runs = mehvar.batch(folder, "steps", n=24, seed=2, vary=vary, save=0.1, out=path)
    assert set(runs["first"].values.tolist()) == {0.0, 2.0, 9.0}
    store = open_store(path)
    plan = plan_of(store, folder)
    for run in range(0, 24, 5):
        assert difference(repeat_run(plan, store, run), plan, store, run) == ""


def test_what_cannot_be_run_is_refused(folder):
    for settings, allowed in (
        ({"first": 2.5}, "first = 2.5 must be a whole number"),
        ({"second": 40}, "second = 40 .*less than 40, the number of periods"),
    ):
        with pytest.raises(InputError, match=allowed):
            simulate(folder, "steps", parameters=settings)
    with pytest.raises(InputError, match=r"given, or a sampled law: .* has delayed inputs"):
        simulate(folder, "smooth")
    np.testing.assert_allclose(simulate(folder, "smooth", hold=0.1).x[::2], levels((3, 7)), atol=1e-9)
    with pytest.raises(InputError, match=r"delayed inputs .*, which a functional mock-up unit cannot have"):
        subject(load(folder), None, None)


def test_what_is_no_delay_is_refused():
    system = pipes()
    for delays, message in (
        ({"u3": "first"}, "u3"),
        ({"u1": "last"}, "last"),
        ({"u1": "Ts", "u2": "first"}, "must be a number of samples"),
    ):
        with pytest.raises(ModelError, match=message):
            check(dataclasses.replace(system, delays=delays))
    with pytest.raises(ModelError, match="delays would be ignored"):
        check(dataclasses.replace(system, controllers=system.controllers[1:]))
