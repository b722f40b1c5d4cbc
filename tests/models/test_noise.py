# SPDX-License-Identifier: Apache-2.0
"""Process noise and random steps: their distribution, their order, and that a run repeats alone.

Seeds are fixed. A bound is four standard deviations of what is estimated: one draw in 16 000 would be beyond it.
"""

import dataclasses

import numpy as np
import pytest
import sympy as sp

import mehvar
from mehvar.base.errors import InputError
from mehvar.fmu.variables import subject
from mehvar.models.check import check
from mehvar.models.quantities import ModelError
from mehvar.models.system import Coordinates, Diffusion, Group
from mehvar.runtime import load, simulate
from mehvar.runtime.batch.repeat import difference, plan_of, repeat_run
from mehvar.runtime.batch.store.store import open_store
from mehvar.web.export import export_web
from tests.models.edits import quantity, turner
from tests.models.noisy import noisy, walker
from tests.models.written import written
from tests.reference.scipy_loop import by_scipy
from tests.reference.scipy_loop.noise import Draws, Stream

RUNS, SEED = 2000, 11


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return written(noisy(), tmp_path_factory.mktemp("noisy"))


@pytest.fixture(scope="module")
def steps(tmp_path_factory):
    return written(walker(), tmp_path_factory.mktemp("walker"))


def increments(run, count, h):
    draws = Draws(SEED, run, Stream.WIENER_PROCESSES, 3)
    return np.sqrt(h) * np.array([draws(k) for k in range(count)])


@pytest.fixture(scope="module")
def ends(folder, tmp_path_factory):
    """States at the end of many runs, by method and step."""
    kept = {}

    def of(method, h):
        if (method, h) not in kept:
            out = tmp_path_factory.mktemp("ends") / "runs.zarr"
            runs = mehvar.batch(folder, "brake", n=RUNS, seed=SEED, method=method, step=h, out=out)
            assert set(runs["status"].values.tolist()) == {0}
            kept[method, h] = runs["final"].values
        return kept[method, h]

    return of


@pytest.mark.parametrize(("method", "order"), [("euler", 0.5), ("platen", 1.0)])
@pytest.mark.share(2)
def test_strong_order(ends, method, order):
    """Of X(1) = exp(m - (a^2 + b^2)/2 + a W1 + b W2), with the increments of each run."""
    sizes = np.array([2.0**-k for k in (3, 4, 5, 6)])
    means, spreads = [], []
    for h in sizes:
        w = np.array([increments(run, round(1 / h), h).sum(axis=0) for run in range(RUNS)])
        exact = np.exp(0.5 - (0.36 + 0.16) / 2 + 0.6 * w[:, 0] + 0.4 * w[:, 1])
        error = np.abs(ends(method, h)[:, 0] - exact)
        means.append(error.mean())
        spreads.append(error.std() / np.sqrt(RUNS) / error.mean())
    centred = np.log(sizes) - np.log(sizes).mean()
    slope = centred @ np.log(means) / (centred @ centred)
    spread = np.sqrt(np.square(centred) @ np.square(spreads)) / (centred @ centred)
    assert abs(slope - order) < 4 * spread + 0.08  # the order is that of small steps: 0.08 off at these
    assert (means[-1] < 0.02) == (method == "platen")


def test_mean_and_variance_of_a_speed(ends):
    """Of V <- (1 - (g + k) h) V + q dW, from 2, and of its limit for small steps, an Ornstein-Uhlenbeck process."""
    h = 2.0**-6
    keep = (1 - 1.5 * h) ** 2
    mean, variance = 2 * keep**32, 0.49 * h * (1 - keep**64) / (1 - keep)
    speed = ends("euler", h)[:, 1]
    assert abs(speed.mean() - mean) < 4 * np.sqrt(variance / RUNS)
    assert abs(speed.var(ddof=1) / variance - 1) < 4 * np.sqrt(2 / RUNS)
    assert abs(variance - 0.49 / 3 * (1 - np.exp(-3))) < 2 * h * variance
    assert np.array_equal(speed, ends("platen", h)[:, 1])  # additive: both are of order one


@pytest.mark.parametrize("law", ["brake", "steps"])
@pytest.mark.parametrize("method", ["euler", "platen"])
@pytest.mark.share(3)
def test_a_run_repeats_alone_and_in_numpy(folder, tmp_path, law, method):
    options = {"method": method, "step": 0.01}
    vary = {"a": "uniform(0.5, 0.7)"}
    runs = mehvar.batch(folder, law, n=11, seed=SEED, vary=vary, save=0.25, **options, out=tmp_path / "runs.zarr")
    store = open_store(tmp_path / "runs.zarr")
    plan = plan_of(store, folder)
    for run in (0, 7, 10):
        assert difference(repeat_run(plan, store, run), plan, store, run) == ""
    assert len(np.unique(runs["final"].values)) == 22
    one = simulate(folder, law, seed=SEED, run=5, **options)
    with by_scipy():
        other = simulate(folder, law, seed=SEED, run=5, **options)
    np.testing.assert_allclose(one.x, other.x, rtol=1e-11)
    assert one.options["step"] == 0.01
    assert not np.allclose(one.x, simulate(folder, law, seed=SEED, run=6, **options).x)


def walked(run):
    """Bias and gust of a run by hand, and the speed under the law."""
    draws = Draws(SEED, run, Stream.RANDOM_STEPS, 2)
    x, rows = np.array([1.0, 0.0, 0.0]), []
    for k in range(31):
        if k:
            e = draws(k)
            x = np.array([x[0], x[1] + 0.1 * np.sqrt(0.1) * e[0], 0.5 * e[1]])
        rows.append(x)
        x = x + np.array([0.1 * (x[2] - 0.5 * (x[0] + x[1])), 0, 0])
    return np.array(rows)


@pytest.mark.parametrize("backend", ["c", "python"])
def test_random_steps(steps, backend):
    for run in (0, 4):
        single = simulate(steps, "steps", backend=backend, seed=SEED, run=run)
        np.testing.assert_allclose(single.x, walked(run), atol=1e-10)


def test_random_steps_in_lanes_and_of_a_law_of_ones_own(steps, tmp_path):
    mehvar.batch(steps, "steps", n=9, seed=SEED, vary={"k": "uniform(0.4, 0.6)"}, save=0.1, out=tmp_path / "a.zarr")
    store = open_store(tmp_path / "a.zarr")
    plan = plan_of(store, steps)
    for run in (0, 8):
        assert difference(repeat_run(plan, store, run), plan, store, run) == ""
    own = mehvar.simulate(steps, lambda t, x: [-0.5 * (x.v + x.bias)], period=0.1, seed=SEED, run=4)
    np.testing.assert_allclose(own.v, walked(4)[:, 0], atol=1e-10)
    held = simulate(steps, "smooth", hold=0.1, seed=SEED, run=4)
    np.testing.assert_allclose(held.x, walked(4), atol=1e-10)


def test_what_cannot_be_run_is_refused(folder, steps, tmp_path):
    for path, law, settings, allowed in (
        (folder, "brake", {}, "must be euler or platen: noisy has process noise"),
        (steps, "steps", {"method": "platen", "step": 0.1}, "walker has no process noise"),
        (steps, "smooth", {}, "given, or a sampled law: walker has random steps"),
    ):
        with pytest.raises(InputError, match=allowed):
            simulate(path, law, **settings)
        with pytest.raises(InputError, match=allowed):
            mehvar.batch(path, law, n=2, **settings)
    for path in (folder, steps):
        with pytest.raises(InputError, match=r"has (process noise|random steps) \(.*, which .* unit cannot have"):
            subject(load(path), None, None)
        with pytest.raises(InputError, match=r"has (process noise|random steps) \(.*, which a page cannot have"):
            export_web(path, tmp_path / "page")


def test_what_is_no_noise_is_refused():
    system, chart = noisy(), turner()
    noise, x, p = system.diffusion, system.states, system.parameters
    w = noise.wiener
    seconds = Group("w", (quantity("W1", "s"), *w.quantities[1:]))
    for part, message in (
        (Diffusion(w, (x.price * w.W1 * w.W2, p.q * w.W3)), "row 1 of the diffusion's .* must be linear in W1, W2, W3"),
        (
            Diffusion(w, (x.price * (p.a * w.W1 + p.b * w.W2), p.q * w.W3 + x.speed)),
            "row 2 of the diffusion's .* must be linear",
        ),
        (Diffusion(w, (x.price * (p.a * w.W1 + p.b * w.W2),)), "1 entries for 2 states"),
        (Diffusion(w, (x.price * p.a * w.W1, p.q * w.W3)), "parameter 'b'"),
        (Diffusion(w, (x.price * (p.a * w.W1 + p.b * w.W2), p.q * p.Ts * w.W3)), "must be m/s"),
        (Diffusion(seconds, (x.price * (p.a * w.W1 + p.b * w.W2), p.q * w.W3)), r"must be s\^\(1/2\)"),
    ):
        with pytest.raises(ModelError, match=message):
            check(dataclasses.replace(system, diffusion=part))
    own = Group("w", (quantity("W", "s^(1/2)"),))
    radial = Diffusion(own, (chart.states.radius * own.W, sp.S.Zero))
    assert isinstance(chart.coordinates, Coordinates)
    with pytest.raises(ModelError, match="process noise cannot be combined with a regular chart"):
        check(dataclasses.replace(chart, diffusion=radial))
    walk = walker()
    with pytest.raises(ModelError, match="no law has a period"):
        check(dataclasses.replace(walk, controllers=walk.controllers[1:]))
