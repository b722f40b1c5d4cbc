# SPDX-License-Identifier: Apache-2.0
"""`method="auto"`: which runs are stiff, that they are those of `rodas5p`, and what a result says of it."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import sympy as sp

import mehvar
from mehvar.models.system import Controller, Group, Sensor, System
from mehvar.runtime import InputError, Run, load, simulate
from mehvar.runtime.batch.fill import run_batch
from mehvar.runtime.batch.plan import Campaign
from mehvar.runtime.batch.repeat import difference, plan_of, repeat_run
from mehvar.runtime.batch.store.store import open_store
from mehvar.runtime.run.results import to_dataset
from tests.models.edits import POSITIVE, parameter, quantity
from tests.models.test_clock import pushed
from tests.models.written import written
from tests.reference.scipy_loop.solvers import StiffTest

LOOSE = {"rtol": 1e-6, "atol": 1e-6}
BACKENDS = ("c", "python")


def relaxation() -> System:
    """Van der Pol's oscillator, with eigenvalues near -3 mu at its start, x = 2 m; its place is seen with noise."""
    x, e = Group("x", (quantity("x", "m"), quantity("v", "m/s"))), Group("e", (quantity("glare", "1"),))
    rows = (("w", "1/s", 1.0), ("L", "m", 1.0), ("mu", "1/s", 1.0), ("sigma", "m", 0.01), ("Ts", "s", 2.0, POSITIVE))
    p, c = Group("p", tuple(parameter(*row) for row in rows)), Group("c", (parameter("k", "1/s^2", 0.1),))
    (a,) = pushed().inputs.symbols
    pull = (-c.k * x.x,)
    return dataclasses.replace(
        pushed(), name="relaxation", states=x, parameters=p, initial=(2 * p.L, sp.S.Zero),
        rhs=(x.v, p.mu * (1 - (x.x / p.L) ** 2) * x.v - p.w**2 * x.x + a),
        sensor=Sensor(e, (x.x + p.sigma * e.glare, x.v)),
        controllers=(Controller("pull", "", c, pull), Controller("steps", "", c, pull, period="Ts")),
    )  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return written(relaxation(), tmp_path_factory.mktemp("relaxation"))


def same(run: Run, expected: Run) -> bool:
    return run.checksum == expected.checksum and run.statistics == expected.statistics


@pytest.mark.parametrize("backend", BACKENDS)
def test_an_oscillator_is_stiff_where_its_friction_is_large(folder: Path, backend: str) -> None:
    options = {"t_end": 20.0, "dt_out": 0.5, "backend": backend, **LOOSE}
    for mu, method in ((0.5, "dop853"), (200.0, "rodas5p")):
        run = simulate(folder, "pull", mu=mu, method="auto", **options)
        assert (run.method, run.options["method"]) == (method, "auto")
        assert same(run, simulate(folder, "pull", mu=mu, method=method, **options))
        assert np.isnan(run.t_stiff) == (method == "dop853")
        exact = simulate(folder, "pull", mu=mu, rtol=1e-11, atol=1e-11, t_end=20.0, dt_out=0.5)
        np.testing.assert_allclose(run.x, exact.x, atol=2e-5)


@pytest.mark.parametrize("mu", [13.5, 14.0, 14.5, 15.0])
def test_stiffness_that_passes_is_forgotten(folder: Path, mu: float) -> None:
    """On either slope some dozen steps of the oscillator are held by stability, and then many by error."""
    run = simulate(folder, "pull", mu=mu, method="auto", t_end=30.0, dt_out=30.0, **LOOSE)
    assert run.method == "dop853"


@pytest.mark.parametrize(
    ("stiff", "steps"),
    [(True, "14 + 5 - 1 +"), (False, "14 + 6 - 14 +"), (True, "15 +"), (True, "7 + 3 - 4 + 3 - 4 +")],
)
def test_so_many_steps_in_a_row_forget_stiffness(stiff: bool, steps: str) -> None:
    """The Python backend has the numbers of `native/step/stiffness.h`."""
    test, words = StiffTest(), steps.split()
    for count, sign in zip(words[::2], words[1::2], strict=True):
        for _ in range(int(count)):
            slopes = np.array([[0.0], [0.0], [6.2 if sign == "+" else 6.0]])
            step = SimpleNamespace(h_previous=1.0, K=slopes, n_stages=2, A=np.eye(2), y_old=np.zeros(1), y=np.ones(1))
            answer = test.is_stiff_after(step)
    assert answer == stiff


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(
    ("name", "law", "method"),
    [("slosh", "lyapunov-v2", "rodas5p"), ("triangle", "path", "dop853"), ("satellite", "pd", "dop853")],
)
def test_the_systems(name: str, law: str, method: str, backend: str) -> None:
    """Slosh has three eigenvalues near -80 1/s; what is stiff is so within 50 steps of its stability."""
    run = simulate(load(name, backend=backend), law, t_end=10.0, dt_out=1.0, method="auto", **LOOSE)
    assert run.method == method
    assert name != "slosh" or 15 * 6.1 / 80 < run.t_stiff < 50 * 6.4 / 70


def test_a_batch_decides_for_each_run_as_the_run_alone(folder: Path, tmp_path: Path) -> None:
    """In blocks of lanes and at their end, in any mixture; what a store has can be repeated."""
    options = {"method": "auto", "t_end": 20.0, "dt_out": 0.5, **LOOSE}
    campaign = Campaign("pull", 21, vary={"mu": "uniform(0.1, 30)"}, options=options, save_every=0.5)
    store = run_batch(folder, campaign, tmp_path / "runs.zarr", threads=2)
    stiff = np.isfinite(store.read("t_stiff", [0]))
    assert 3 < stiff.sum() < 18
    store = open_store(tmp_path / "runs.zarr")
    plan = plan_of(store, folder)
    for number in range(21):
        run = repeat_run(plan, store, number)
        assert difference(run, plan, store, number) == ""
        assert run.method == ("rodas5p" if stiff[number] else "dop853")


@pytest.mark.soak
def test_a_run_that_is_made_again_keeps_its_noise(folder: Path, tmp_path: Path) -> None:
    """Runs that are stiff are gathered from among the others: each keeps its number, which its noise depends on."""
    options = {"method": "auto", "t_end": 20.0, "dt_out": 1.0, **LOOSE}
    store = run_batch(folder, Campaign("steps", 13, vary={"mu": "uniform(0.1, 100)"}, options=options, seed=4))
    plan, stiff = plan_of(store, folder), np.isfinite(store.read("t_stiff", [0]))
    assert 3 < stiff.sum() < 12
    for number in np.flatnonzero(stiff).tolist():
        assert difference(repeat_run(plan, store, number), plan, store, number) == ""


def test_a_result_says_what_ran() -> None:
    run = mehvar.simulate("slosh", controller="lyapunov-v2", t_end=5.0, dt_out=1.0, method="auto", **LOOSE)
    assert run.attrs["method"] == "rodas5p"
    assert 1.0 < run.attrs["t_stiff"] < 5.0
    again = simulate("slosh", "lyapunov-v2", t_end=5.0, dt_out=1.0, method="auto", **LOOSE)
    (text,) = again.stiffness()
    assert f"dop853 found the run stiff at t = {again.t_stiff:.6g} s" in text
    assert "t_stiff" not in to_dataset(simulate("slosh", "lyapunov-v2", t_end=1.0)).attrs


def test_what_has_no_jacobian_is_refused_by_name() -> None:
    with pytest.raises(InputError, match=r"method = 'auto'.*must be rk4, dopri5, dop853 or rock4: slosh has no Jac"):
        simulate("slosh", "lyapunov-v2", method="auto", t_end=1.0, attitude="euler")
    with pytest.raises(InputError, match=r"method = 'auto'.*is evaluated once per sample"):
        simulate("satellite", "pd", method="auto", t_end=1.0, law=lambda x, r, v, z: (v, z))
