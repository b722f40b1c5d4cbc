# SPDX-License-Identifier: Apache-2.0
"""A batch: run i is the same bits alone and in company, impossible runs are marked, what is stored stays."""

from __future__ import annotations

import errno
import hashlib
import resource
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
import pytest

from mehvar import runtime
from mehvar.base.errors import InputError
from mehvar.base.manifest import with_digest
from mehvar.runtime.batch import fill
from mehvar.runtime.batch.blocks import IMPOSSIBLE, Blocks
from mehvar.runtime.batch.evaluation.statistics import fulfilment, success_condition
from mehvar.runtime.batch.fill import REFUSALS, ImpossibleRunError, OutOfMemoryError, run_batch
from mehvar.runtime.batch.plan import Campaign, Plan
from mehvar.runtime.batch.repeat import difference, is_model_of, plan_of, repeat_run
from mehvar.runtime.batch.store import store as store_module
from mehvar.runtime.batch.store.layout import STATUS
from mehvar.runtime.batch.store.store import Store, StoreError, open_store
from mehvar.runtime.run.options import Option
from tests.runtime.batch.forgery import contents

TRIANGLE = Campaign(
    "path",
    n=60,
    seed=5,
    vary={"l1_0": "normal(0.2, 0.01)", "k_phi": "uniform(0.3, 0.7)", "theta": "normal(1, 0.1)"},
    options={"t_end": 0.5},
    save_every=0.25,
)
SATELLITE = Campaign("mrac", n=10, scenario="flight", seed=2, vary={"I_x": "normal(4, 0.05)"}, options={"t_end": 20.0})


@pytest.mark.parametrize(("row", "most"), [(fill._THREADS, 1024), (fill._RUNS_PER_BLOCK, 65536)])
def test_threads_and_runs_per_block_have_a_most(row: Option, most: int) -> None:
    for value in (1, most):
        assert row.check(value, "here") == value
    for value in (0, most + 1):
        with pytest.raises(InputError, match=f"^{row.name} = {value} "):
            row.check(value, "here")


@pytest.fixture(scope="module")
def triangle() -> runtime.Model:
    return runtime.load("triangle", "c")


@pytest.fixture(scope="module")
def whole(triangle: runtime.Model) -> Store:
    return run_batch(triangle, TRIANGLE)


def same(one: Store, other: Store) -> bool:
    names = one.variables()
    return names == other.variables() and all(
        np.array_equal(one.read(name), other.read(name), equal_nan=names[name].dtype == "float64") for name in names
    )


@pytest.mark.parametrize(("chunk", "threads"), [(1, 1), (7, 2), (32, 3), (60, 1)])
@pytest.mark.share(2)
def test_pieces_and_threads_change_no_bit(triangle: runtime.Model, whole: Store, chunk: int, threads: int) -> None:
    campaign = replace(TRIANGLE, n=60 if chunk > 1 else 9)
    store = run_batch(triangle, campaign, chunk=chunk, threads=threads)
    for name in store.variables():
        assert np.array_equal(store.read(name), whole.read(name)[: store.n], equal_nan=store.n > 0 and name != STATUS)


def test_a_store_says_where_its_model_is_by_a_shipped_name_or_by_folder(whole: Store, pendulum: runtime.Model) -> None:
    own = run_batch(pendulum, Campaign("pd", n=1, options={"t_end": 0.05}))
    assert whole.attributes["model_source"] == "triangle"
    assert own.attributes["model_source"] == str(pendulum.manifest.folder.absolute())


def test_blocks_may_be_computed_at_the_same_time(triangle: runtime.Model, whole: Store) -> None:
    """As the threads of a cluster's worker do."""
    blocks = Blocks(Plan(triangle, TRIANGLE), threads=1)
    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(lambda first: blocks.compute(first, 10), range(0, 60, 10)))
    for name in ("final", "minimum", "travel", STATUS):
        assert np.array_equal(np.concatenate([values[name] for values in found if values]), whole.read(name)), name


VARY = {"theta_0": "normal(1, 0.1)", "rho": "uniform(0.1, 0.3)", "k_phi": "uniform(2, 3)"}
HELD = {"t_end": 2.0, "hold": 0.05, "delay": 1}
SLOSH = {"phi1": "uniform(-0.2, 0.2)"}
ALONE = [
    *(
        (("triangle", Campaign(law, n=12, seed=1, vary=VARY, options=HELD)), k)
        for law in ("path", "sliding")
        for k in (0, 3, 11)
    ),
    *((("slosh", Campaign(law, n=3, vary=SLOSH, options={"t_end": 2.0})), 2) for law in ("lyapunov-v1", "lyapunov-v2")),
    *((("satellite", SATELLITE), k) for k in (0, 9)),
]
"""Batches whose law is sampled, reports what a store does not keep, or has noise; and a run."""


@pytest.mark.parametrize(("batch", "number"), ALONE)
@pytest.mark.share(3)
def test_a_run_alone_is_the_same_bits(batch: tuple[str, Campaign], number: int) -> None:
    store = run_batch(*batch)
    plan = plan_of(store)
    assert difference(repeat_run(plan, store, number), plan, store, number) == ""


def test_the_noise_of_each_run_is_its_own() -> None:
    quiet = run_batch("satellite", replace(SATELLITE, vary={}))
    assert len(np.unique(quiet.read("final")[:, 0])) == quiet.n


def test_a_difference_is_told(tmp_path: Path, triangle: runtime.Model) -> None:
    store = run_batch(triangle, TRIANGLE, tmp_path / "runs.zarr")
    plan = Plan(triangle, replace(TRIANGLE, seed=6))
    text = str(difference(repeat_run(plan, store, 3), plan, store, 3))
    for name in ("minimum", "k_phi", "initial_theta", "theta", "error"):
        assert f" {name} by up to" in text, name
    assert "seed" in text


def test_formulas_follow_what_they_are_made_of(triangle: runtime.Model) -> None:
    """eta_rho of the sliding law is k_phi R / m unless set."""
    vary = {"k_phi": "uniform(2, 4)", "R": "uniform(0.6, 0.7)"}
    plan = Plan(triangle, Campaign("sliding", n=50, vary=vary))
    draw = plan.draw(0, 50)
    place = {q.name: i for i, q in enumerate(plan.law.parameters)}
    k, radius, m, eta = (draw.c[:, place[name]] for name in ("k_phi", "R", "m", "eta_rho"))
    assert np.allclose(eta, k * radius / m, rtol=1e-15)
    fixed = Plan(triangle, Campaign("sliding", n=50, vary=vary, parameters={"eta_rho": 1.25}))
    assert (fixed.draw(0, 50).c[:, place["eta_rho"]] == 1.25).all()


IMPOSSIBLE_VARY = {"R": "uniform(0.5, 0.75)", "l1_0": "normal(0.25, 0.1)", "rho": "uniform(0, 0.8)"}


def test_impossible_runs_are_marked_and_explained(triangle: runtime.Model) -> None:
    """Vectorised checks and those of a single run agree on which runs are possible."""
    campaign = Campaign("path", n=200, vary=IMPOSSIBLE_VARY, options={"t_end": 0.1})
    store, plan = run_batch(triangle, campaign), Plan(triangle, campaign)
    impossible = store.read(STATUS) == IMPOSSIBLE
    assert 20 < impossible.sum() < 180
    for run in range(200):
        parameters, initial = plan.settings(run)
        try:
            runtime.simulate(triangle, "path", None, parameters, initial, t_end=0.1)
            refused = False
        except InputError:
            refused = True
        assert refused == impossible[run] == bool(plan.refusal(run)), run
    assert np.isnan(store.read("final")[impossible]).all()
    assert np.isfinite(store.read("final")[~impossible]).all()
    assert np.isfinite(store.read("R")).all()
    reasons = {plan.refusal(run).split("(from")[0][:2] for run in np.flatnonzero(impossible).tolist()}
    assert len(reasons) >= 2
    run = int(np.argmax(store.read("R")))
    assert plan.refusal(run) == f"R = {float(store.read('R')[run])!r} (from run {run}): must be in (0, 0.707106781187)"


def test_a_record_explains_refusals_of_its_own_runs_and_a_report_counts_what_did_not_end(
    triangle: runtime.Model, tmp_path: Path
) -> None:
    """In each block by the numbers of the runs in the batch, the first three of them; stored or just computed."""
    campaign = Campaign("path", n=64, vary={"R": "uniform(0.6, 0.72)"}, options={"t_end": 0.05})
    reports: list[tuple[int, ...]] = []
    for resume in (False, True):
        store = run_batch(
            triangle, campaign, tmp_path / "s.zarr", chunk=16, resume=resume, report=lambda *now: reports.append(now)
        )
        status, plan = store.read(STATUS), Plan(triangle, campaign)
        for block in range(4):
            impossible = [run for run in store.runs(block) if status[run] == IMPOSSIBLE]
            assert store.about(block)["refusals"] == {str(run): plan.refusal(run) for run in impossible[:REFUSALS]}
        assert reports[-1] == (64, 64, np.count_nonzero(status == IMPOSSIBLE))
    assert 3 < reports[-1][-1] < 60


def test_strict_stops_at_the_first_impossible_run(triangle: runtime.Model, tmp_path: Path) -> None:
    campaign = Campaign("path", n=64, vary={"R": "uniform(0.6, 0.72)"}, options={"t_end": 0.05})
    lenient = run_batch(triangle, campaign, chunk=4)
    first = int(np.flatnonzero(lenient.read(STATUS) == IMPOSSIBLE)[0])
    for resume in (False, True):
        with pytest.raises(ImpossibleRunError, match=rf"R = 0.7.* \(from run {first}\): must be in \(0, 0.707"):
            run_batch(triangle, campaign, tmp_path / "s.zarr", chunk=4, strict=True, resume=resume)
    assert open_store(tmp_path / "s.zarr").stored()[-1] == first // 4


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"n": 0}, "n = 0 .*must be a whole number >= 1"),
        ({"n": 1.5}, "n = 1.5"),
        ({"seed": -1}, "seed = -1"),
        ({"vary": {"k_fi": "normal(1, 2)"}}, "unknown parameter or state 'k_fi' of triangle with path.*k_phi"),
        ({"vary": {"R": "normal(0.9, 0.1)"}}, r"R = 0.9 \(from the call or the middle of vary\): must be in"),
        ({"parameters": {"k_phi": 0.4}}, "k_phi is both set and varied"),
        ({"parameters": {"no": 1.0}}, "unknown parameter or option 'no'"),
        ({"options": {"t_end": -1.0}}, "t_end = -1.0"),
        ({"options": {"method": "euler"}}, "method = 'euler'"),
        ({"options": {"profile": "slow"}}, "profile = 'slow'"),
        ({"save_every": 0.015}, "save = 0.015.*multiple of the sampling step 0.01 s"),
        ({"controller": "pat"}, "unknown controller 'pat' of triangle"),
        ({"initial": {"rho": 0.1, "x": 1.0}}, "unknown state 'x'"),
    ],
)
def test_what_cannot_be_run_is_refused(
    triangle: runtime.Model, tmp_path: Path, change: dict[str, Any], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        run_batch(triangle, replace(TRIANGLE, **change), tmp_path / "runs.zarr")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"seed": 6}, "made with seed = 5, not 6"),
        ({"n": 61}, "made with n = 60, not 61"),
        ({"vary": {"R": "uniform(0.6, 0.7)"}}, "made with vary = .*not {'R'"),
        ({"options": {"t_end": 0.4}}, "made with options"),
    ],
)
def test_another_batch_is_not_continued(
    triangle: runtime.Model, tmp_path: Path, change: dict[str, Any], message: str
) -> None:
    out = tmp_path / "runs.zarr"
    run_batch(triangle, replace(TRIANGLE, save_every=None), out)
    before = contents(out)
    with pytest.raises(InputError, match=message):
        run_batch(triangle, replace(TRIANGLE, save_every=None, **change), out, resume=True)
    with pytest.raises(InputError, match="exists already"):
        run_batch(triangle, replace(TRIANGLE, save_every=None), out)
    assert contents(out) == before


def test_a_batch_with_requirements_is_not_continued_without_them(triangle: runtime.Model, tmp_path: Path) -> None:
    """Its records would be those of another batch."""
    out, campaign = tmp_path / "runs.zarr", replace(TRIANGLE, save_every=None)
    run_batch(triangle, campaign, out, require={"r": "quantile(0.5, t_stop) < 9"})
    for require in (None, {"r": "quantile(0.5, t_stop) < 8"}):
        with pytest.raises(InputError, match=r"made with require = '.*t_stop\) < 9.*', not '"):
            run_batch(triangle, campaign, out, resume=True, require=require)


def test_a_zero_of_the_other_sign_is_another_campaign(triangle: runtime.Model, tmp_path: Path) -> None:
    """0.0 is equal to -0.0; the search for the difference ended in a StopIteration."""
    out, campaign = tmp_path / "runs.zarr", replace(TRIANGLE, n=4, save_every=None)
    run_batch(triangle, replace(campaign, parameters={"disturbance": 0.0}), out)
    with pytest.raises(InputError, match=r"made with parameters = {'disturbance': 0.0}, not {'disturbance': -0.0}"):
        run_batch(triangle, replace(campaign, parameters={"disturbance": -0.0}), out, resume=True)


def test_another_model_is_not_continued(triangle: runtime.Model, tmp_path: Path) -> None:
    import shutil

    copy = tmp_path / "triangle"
    shutil.copytree(triangle.manifest.folder, copy)
    out, campaign = tmp_path / "runs.zarr", replace(TRIANGLE, n=4, save_every=None)
    run_batch(copy, campaign, out)
    header, manifest = copy / "triangle.h", copy / "manifest.json"
    before = header.read_text()
    header.write_text(before.replace(triangle.manifest.hash, "0" * 64))
    text = manifest.read_text().replace(triangle.manifest.hash, "0" * 64)
    hashes = [hashlib.sha256(content.encode()).hexdigest() for content in (before, header.read_text())]
    manifest.write_text(with_digest(text.replace(*hashes)))
    with pytest.raises(InputError, match=r"made with model_hash = .*, not '0000"):
        run_batch(copy, campaign, out, resume=True)
    assert not is_model_of(open_store(out), runtime.load(copy, "c"))


def test_a_lack_of_memory_stops_cleanly_and_the_rest_follows(pendulum: runtime.Model, tmp_path: Path) -> None:
    """The process limits its own memory; the block's series would take gigabytes."""
    campaign = Campaign("pd", n=40_000, options={"t_end": 10.0}, save_every=0.01)
    limits = resource.getrlimit(resource.RLIMIT_AS)
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    resource.setrlimit(resource.RLIMIT_AS, (pages * resource.getpagesize() + 2**28, limits[1]))
    try:
        with pytest.raises(OutOfMemoryError, match=r"not enough memory for a block of 40000 runs \("):
            run_batch(pendulum, campaign, tmp_path / "runs.zarr", chunk=40_000, threads=1)
    finally:
        resource.setrlimit(resource.RLIMIT_AS, limits)
    assert OutOfMemoryError.resumable
    assert open_store(tmp_path / "runs.zarr").stored() == []


@pytest.mark.parametrize("kept", [True, False], ids=["whole", "unfinished"])
def test_a_store_on_a_disk_that_cannot_be_written(
    triangle: runtime.Model, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kept: bool
) -> None:
    """There is nothing to write into a whole one."""
    out, campaign = tmp_path / "runs.zarr", replace(TRIANGLE, n=4, save_every=None)
    run_batch(triangle, campaign, out)
    if not kept:
        (out / "records" / "end.json").unlink()
    before = contents(out)

    def read_only(*_: object) -> NoReturn:
        raise OSError(errno.EROFS, "Read-only file system")

    monkeypatch.setattr(store_module, "Lock", read_only)
    if kept:
        assert run_batch(triangle, campaign, out, resume=True).stored() == [0]
    else:
        with pytest.raises(StoreError, match="Read-only file system"):
            run_batch(triangle, campaign, out, resume=True)
    assert contents(out) == before


def test_a_stop_rule_ends_at_the_same_run_whatever_was_stored_before(triangle: runtime.Model, tmp_path: Path) -> None:
    campaign = Campaign("path", n=400, vary={"R": "uniform(0.6, 0.72)"}, options={"t_end": 0.02})
    rule: dict[str, Any] = {"until": "ci(success) < 0.25", "success": "final(rho) < 0.7", "chunk": 8}
    straight = run_batch(triangle, campaign, tmp_path / "straight.zarr", **rule)
    assert straight.n < 200
    assert straight.n % 8 == 0
    broken = tmp_path / "broken.zarr"

    def interrupt(runs: int, *_: int) -> None:
        if runs > 20:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_batch(triangle, campaign, broken, report=interrupt, **rule)
    for _ in range(2):
        run_batch(triangle, campaign, broken, resume=True, **rule)
        assert contents(broken) == contents(tmp_path / "straight.zarr")
    with pytest.raises(InputError, match=r"made with until = 'ci\(success\) < 0.25', not ''"):
        run_batch(triangle, campaign, broken, resume=True, success="final(rho) < 0.7")


@pytest.mark.soak
def test_a_stop_rule_does_not_depend_on_the_order_of_blocks(
    triangle: runtime.Model, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Workers finish in any order; blocks beyond the end are dropped again."""
    campaign = Campaign("path", n=240, vary={"R": "uniform(0.6, 0.72)"}, options={"t_end": 0.02})
    rule: dict[str, Any] = {"until": "ci(success) < 0.3", "chunk": 8}
    straight = run_batch(triangle, campaign, tmp_path / "straight.zarr", **rule)
    assert straight.n < 240
    real = fill._local
    monkeypatch.setattr(fill, "_local", lambda blocks: lambda missing: real(blocks)(missing[::-1]))
    run_batch(triangle, campaign, tmp_path / "backwards.zarr", **rule)
    assert contents(tmp_path / "backwards.zarr") == contents(tmp_path / "straight.zarr")


@pytest.mark.parametrize(
    ("until", "sampling", "message"),
    [
        ("ci(success) < 0.1", "latin", "needs sampling random or sobol: latin needs all n runs"),
        ("ci(success) < 2", "random", "between 0 and 1"),
        ("mean(success) < 0.1", "random", r"'ci\(success\) < WIDTH'"),
    ],
)
def test_a_stop_rule_that_cannot_be_kept_is_refused(
    triangle: runtime.Model, until: str, sampling: Any, message: str
) -> None:
    with pytest.raises(InputError, match=message):
        run_batch(triangle, replace(TRIANGLE, sampling=sampling), until=until)


def test_success_is_the_end_and_a_condition(whole: Store) -> None:
    done, some = (
        fulfilment(whole, success_condition(text), whole.stored())
        for text in (None, "T_theta < 0.1 or max_rho < 0.3 and final(theta) > 0")
    )
    assert done.all()
    wanted = (whole.read("T_theta") < 0.1) | (whole.read("max_rho") < 0.3) & (whole.read("final")[:, 3] > 0)
    assert np.array_equal(some, wanted)
    assert 0 < some.sum() < whole.n
    with pytest.raises(InputError, match=r"unknown number 'max_roh' of a run.*did you mean max_rho"):
        fulfilment(whole, success_condition("max_roh < 1"), whole.stored())


def test_series_are_those_of_single_runs(triangle: runtime.Model, whole: Store) -> None:
    run = repeat_run(Plan(triangle, TRIANGLE), whole, 17)
    for name, column in run.variables().items():
        assert np.array_equal(whole.read(name)[17], column[::25]), name
    assert np.array_equal(whole.dataset().t, [0.0, 0.25, 0.5])


@pytest.mark.parametrize("number", [-1, 60])
def test_a_run_that_is_not_there_is_refused(triangle: runtime.Model, whole: Store, number: int) -> None:
    with pytest.raises(InputError, match=f"run = {number}: must be a whole number from 0 to 59"):
        repeat_run(Plan(triangle, TRIANGLE), whole, number)
