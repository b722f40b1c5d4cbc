# SPDX-License-Identifier: Apache-2.0
"""The page of a batch: its order, the numbers of `stats`, and commands that repeat its runs."""

import shlex
import subprocess

import pytest

import mehvar
from mehvar.pictures.spread import Runs
from mehvar.report.batch import batch_sections
from mehvar.report.page import Drawing, Table, Text
from mehvar.runtime.batch.evaluation.sensitivity import sensitivities
from mehvar.runtime.batch.evaluation.statistics import summarise
from mehvar.runtime.batch.store.store import open_store
from tests import commands


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    where = tmp_path_factory.mktemp("batch") / "runs.zarr"
    vary = {"theta_0": "uniform(0.8, 1.2)", "mass": "normal(1, 0.05)"}
    mehvar.batch("triangle", "path", n=40, vary=vary, success="T_theta < 19", t_end=25.0, out=where)
    return open_store(where)


@pytest.fixture(scope="module")
def sections(store):
    return {section.anchor: section for section in batch_sections(Runs(store.dataset()), str(store.path))}


def tables(section):
    return {block.title: block for block in section.blocks if isinstance(block, Table) and block.rows}


def test_what_was_varied_comes_first_then_success_sensitivities_metrics_and_runs(sections):
    assert list(sections)[:5] == ["batch", "sensitivities", "metrics", "runs", "pictures"]
    varied, success = sections["batch"].blocks[:2]
    assert varied.rows == [
        ("mass", "normal(1, 0.05)", "kg", "each of the three masses"),
        ("theta_0", "uniform(0.8, 1.2)", "rad", "initial attitude"),
    ]
    assert isinstance(success, Text)


def test_its_numbers_are_those_of_stats(sections, store):
    statistics = summarise(store)
    assert f"{statistics.successes} of 40 runs succeed (T_theta < 19)" in sections["batch"].blocks[1].text
    assert 0 < statistics.successes < 40
    (metrics,) = tables(sections["metrics"]).values()
    for row, cells in zip(statistics.rows, metrics.rows, strict=True):
        assert cells[:2] == (row.name, row.description)
        assert cells[6].startswith(f"{row.quantiles[0.5]:.4g} [")
    (shares,) = tables(sections["sensitivities"]).values()
    assert [cells[:3] for cells in shares.rows] == [
        (item.metric, item.text("mass"), item.text("theta_0")) for item in sensitivities(store)
    ]


def test_each_run_has_the_command_that_repeats_it(sections, store, tmp_path):
    failed, largest = tables(sections["runs"]).values()
    succeeds = Runs(store.dataset()).successful
    assert [int(row[0]) for row in failed.rows] == [run for run in range(40) if not succeeds[run]][:5]
    name, value, _, run, command = largest.rows[0]
    program, *words = shlex.split(command)
    assert program == "mehvar"
    done = subprocess.run(
        [*commands.mehvar(), *words, "--out", "run.nc"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert f"{float(mehvar.open_result(tmp_path / 'run.nc')[name]):.6g}" == value
    assert int(run) == int(store.dataset()[name].values.argmax())


def test_in_memory_a_run_is_repeated_by_a_call_and_a_constant_share_has_no_picture():
    runs = mehvar.batch("triangle", "path", n=4, vary={"theta_0": "uniform(0.8, 1.2)"}, t_end=2.0)
    sections = {section.anchor: section for section in runs.mehvar.page().sections}
    assert tables(sections["runs"])["Largest value of each metric"].rows[0][-1].startswith("runs.mehvar.again(")
    pictures = [block.picture.title for block in sections["pictures"].blocks if isinstance(block, Drawing)]
    assert "Convergence" not in pictures
    assert "Metrics of the runs" in pictures
