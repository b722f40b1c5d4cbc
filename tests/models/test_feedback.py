# SPDX-License-Identifier: Apache-2.0
"""Laws that see outputs, integrate states of their own or command at some samples, against calculations by hand."""

import dataclasses

import numpy as np
import pytest
import sympy as sp
from scipy.linalg import expm

import mehvar
from mehvar.base.errors import InputError
from mehvar.fmu.variables import subject
from mehvar.models.check import check
from mehvar.models.quantities import ModelError
from mehvar.models.system import Output, Sensor
from mehvar.runtime import load, simulate
from mehvar.runtime.batch.repeat import difference, plan_of, repeat_run
from mehvar.runtime.batch.store.store import open_store
from mehvar.runtime.run.noise import normals
from tests.models.edits import POSITIVE, cart, quantity, turner
from tests.models.feedback import seeker
from tests.models.written import written
from tests.reference.scipy_loop.noise import Stream, drawn

K, T, B, TOTAL, LOAD, PLACE = 4.0, 8.0, 5.0, 1.5, 0.3, 0.5


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return written(seeker(), tmp_path_factory.mktemp("seeker"))


def loop():
    """The closed loop of the lead compensator: place, speed, late, sum, and one for the load."""
    A = np.zeros((5, 5))
    A[0, 1] = A[3, 0] = 1
    A[1] = [-K - B * T, 0, B * T, -TOTAL, -LOAD]
    A[2, 0], A[2, 2] = T, -T
    return A


@pytest.mark.parametrize("backend", ["c", "python", "casadi"])
@pytest.mark.parametrize("method", ["dop853", "rk4", "rodas5p"])
@pytest.mark.share(3)
def test_a_compensator_is_integrated(folder, backend, method):
    run = simulate(folder, "lead", backend=backend, method=method, **({"step": 0.002} if method == "rk4" else {}))
    exact = np.array([expm(loop() * t) @ [PLACE, 0, PLACE, 0, 1] for t in run.t])
    np.testing.assert_allclose(run.x, exact[:, :2], atol=1e-7)
    np.testing.assert_allclose(run.z, exact[:, 2:4], atol=1e-7)
    np.testing.assert_allclose(run.w[:, 0], exact[:, 0] - exact[:, 2], atol=1e-7)
    np.testing.assert_allclose(run.w[:, 1], run.u[:, 0], atol=1e-12)
    assert {"late", "sum", "lag", "effort"} <= run.variables().keys()


def test_a_loop_with_a_compensator_is_linearised(folder):
    model = load(folder)
    system = model.linearize([0.1, 0.2], None, model.parameters(), controller="lead", c=model.law_parameters("lead"))
    assert system.states == ("place", "speed", "late", "sum")
    np.testing.assert_allclose(system.A, loop()[:4, :4], atol=1e-13)


def estimated(every, run, seed=0):
    """The estimator and its law by hand, with the noise of a run."""
    noise, dt = drawn(seed, run, Stream.MEASUREMENTS, 0, 201, 1)[:, 0], 0.02
    x, z, u, rows = np.array([PLACE, 0.0]), np.zeros(2), 0.0, []
    for k in range(201):
        old, miss = u, x[0] + 0.01 * noise[k] - z[0]
        if k % every == 0:
            u = -4 * z[0] - 3 * z[1]
        rows.append([*x, u, *z])
        z = z + np.array([dt * z[1] + 0.4 * miss, dt * old + 4 * miss])
        x = x + np.array([dt * x[1] + dt**2 / 2 * (u - LOAD), dt * (u - LOAD)])
    return np.array(rows)


@pytest.mark.parametrize("backend", ["c", "python"])
@pytest.mark.parametrize("every", [1, 5, 7])
def test_an_estimator_is_faster_than_its_law(folder, backend, every):
    run = simulate(folder, "slow", parameters={"every": every}, backend=backend, run=3)
    rows = estimated(every, 3)
    np.testing.assert_allclose(run.x, rows[:, :2], atol=1e-9)
    np.testing.assert_allclose(run.u, rows[:, 2:3], atol=1e-9)
    np.testing.assert_allclose(run.z[:, :2], rows[:, 3:], atol=1e-9)
    np.testing.assert_allclose(run.w[:, 0], rows[:, 0] - rows[:, 3], atol=1e-9)
    np.testing.assert_array_equal(run.z[:, 3], np.arange(201) % every)


def test_a_law_without_memory_may_command_at_some_samples(folder):
    u = simulate(folder, "plain").u[:, 0]
    assert np.array_equal(u[:-1:3], u[1::3][: len(u[:-1:3])])
    assert len(np.unique(u)) == 67


@pytest.mark.parametrize(("law", "vary"), [("lead", "i"), ("slow", "l1"), ("slow", "load")])
@pytest.mark.share(3)
def test_batches_and_their_repetitions(folder, tmp_path, law, vary):
    path = tmp_path / "seeker.zarr"
    mehvar.batch(folder, law, n=11, seed=5, vary={vary: "normal(0.3, 0.02)"}, save=0.02, out=path)
    store = open_store(path)
    plan = plan_of(store, folder)
    for run in (0, 7, 10):
        assert difference(repeat_run(plan, store, run), plan, store, run) == ""


def test_a_law_of_ones_own_sees_what_is_measured(folder):
    run = mehvar.simulate(folder, lambda t, x: [-x.shown], period=0.02)
    noise = normals(0, 0, 201, 1)[:, 0]
    np.testing.assert_allclose(run.u_push[:-1], -(run.place + 0.01 * noise)[:-1], atol=1e-12)


def test_what_cannot_be_run_is_refused(folder):
    for allowed, settings in (("states of its own", {"hold": 0.02}), ("whole number", {"every": 2.5})):
        with pytest.raises(InputError, match=allowed):
            simulate(folder, "slow" if "every" in settings else "lead", **settings)
    with pytest.raises(InputError, match="states of its own"):
        mehvar.batch(folder, "lead", n=2, hold=0.02)
    with pytest.raises(InputError, match="states of its own"):
        subject(load(folder), "lead", None)


def edited(law, **changes):
    laws = {one.name: one for one in seeker().controllers}
    laws[law] = dataclasses.replace(laws[law], **changes)
    return dataclasses.replace(seeker(), controllers=tuple(laws.values()))


def test_what_would_be_ignored_is_refused():
    system, x = seeker(), seeker().states
    slow, lead = system.controllers[1], system.controllers[0]
    twice = Sensor(system.sensor.noise, system.sensor.measured * 2, system.sensor.seen)
    loose = tuple(dataclasses.replace(q, bounds=POSITIVE) if q.name == "every" else q for q in slow.parameters)
    for part, message in (
        (edited("lead", rates=()), "rates of law 'lead' has 0 entries for 2 memory"),
        (edited("lead", update=(sp.S.Zero, sp.S.Zero)), "update of law 'lead' would be ignored"),
        (edited("lead", rates=(lead.rates[1], lead.rates[0])), "row 1 of 2 .late.: .* must be m/s"),
        (edited("plain", period=""), "every of law 'plain' would be ignored"),
        (edited("slow", rates=(sp.S.Zero,) * 2), "rates of law 'slow' would be ignored"),
        (edited("slow", every="once"), "every = 'once' of law 'slow' is not a parameter"),
        (edited("slow", parameters=dataclasses.replace(slow.parameters, quantities=loose)), "must be at least 1"),
        (edited("slow", command=(-x.place * slow.parameters.k,)), "is a state, which it does not receive"),
        (edited("slow", outputs=(Output(quantity("held_for", "1"), sp.S.One),)), "held_for"),
        (dataclasses.replace(system, sensor=twice), "2 entries for 1 measured quantities"),
        (dataclasses.replace(system, sensor=dataclasses.replace(
            system.sensor, seen=dataclasses.replace(system.sensor.seen, name="m"))), "must have the name 'seen'"),
    ):  # fmt: skip
        with pytest.raises(ModelError, match=message) as refusal:
            check(part)
        assert "tests/models/" in str(refusal.value)
    seen = dataclasses.replace(system.sensor, measured=turner().states.symbols[:1])
    with pytest.raises(
        ModelError,
        match=r"measured quantities under a continuous law \(inward\) cannot be combined with a regular chart",
    ):
        check(dataclasses.replace(turner(), sensor=seen))


def test_a_continuous_law_receives_no_state_that_is_measured_otherwise():
    system = cart()
    noise, exact = system.sensor.noise, system.states.symbols
    check(system)  # noise alone changes nothing for a continuous law
    for row in (2 * exact[0], exact[0] / 2 + abs(exact[0]) / 2):
        sensor = Sensor(noise, (row + system.sensor.measured[0] - exact[0], *exact[1:]))
        with pytest.raises(ModelError, match="would receive the state itself: give the measurements names"):
            check(dataclasses.replace(system, sensor=sensor))


def test_a_system_whose_laws_command_at_each_sample_stays_as_it_is():
    from mehvar.models.forms import with_samples

    system = turner()
    assert with_samples(system) is system
