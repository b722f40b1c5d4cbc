# SPDX-License-Identifier: Apache-2.0
"""The page of a batch: its order, the numbers of `stats`, and commands that repeat its runs."""

import re
import shlex
import subprocess

import numpy as np
import pytest

import mehvar
from mehvar.base.errors import InputError
from mehvar.pictures.spread import Runs
from mehvar.report.batch import batch_sections
from mehvar.report.page import Drawing, Page, Table, Text, page_text
from mehvar.runtime.batch.evaluation.sensitivity import sensitivities
from mehvar.runtime.batch.evaluation.statistics import summarise
from mehvar.runtime.batch.store.layout import NOT_RUN
from mehvar.runtime.batch.store.store import open_store
from tests import commands

ENDS = "Smallest and largest value of each metric"


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    where = tmp_path_factory.mktemp("batch") / "runs.zarr"
    vary = {"theta_0": "uniform(0.8, 1.2)", "mass": "normal(1, 0.05)"}
    mehvar.batch("triangle", "path", n=40, vary=vary, success="T_theta < 19", t_end=25.0, out=where)
    return open_store(where)


@pytest.fixture(scope="module")
def sections(store):
    return {section.anchor: section for section in batch_sections(Runs(store.dataset()), str(store.path))}


@pytest.fixture
def undrawn(monkeypatch):
    """Pages without their pictures, which take two seconds; those of `sections` are drawn."""
    monkeypatch.setattr("mehvar.report.batch._pictures", lambda *_: iter(()))


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


def test_a_map_of_colours_is_not_inverted_on_a_dark_page(sections):
    """Light is large in its scale; inverted, dark was."""
    pictures = [block.picture for block in sections["pictures"].blocks if isinstance(block, Drawing)]
    assert {picture.name for picture in pictures if picture.colors} == {"batch-region"}
    page = page_text(Page("Batch", [sections["pictures"]]))
    (head,) = re.findall(r'<div class="([^"]*)"><img [^>]*alt="Where the runs succeed', page)
    assert head == "picture map"
    assert ":is(.picture:not(.map), .part) img { filter: invert" in page


def test_the_head_has_size_and_seed_and_tables_explain_their_numbers(sections, store, undrawn):
    page = store.dataset().mehvar.page(str(store.path))
    assert page.title == "Batch: triangle under path (scenario paper, t_end = 25)"
    assert "A batch of 40 runs, random sampling, seed 0." in page.lead
    (shares,) = tables(sections["sensitivities"]).values()
    assert "least-squares fit" in shares.note
    assert "95 % intervals" in shares.note
    (metrics,) = tables(sections["metrics"]).values()
    assert "95 % confidence" in metrics.note


def test_its_numbers_are_those_of_stats(sections, store):
    statistics = summarise(store)
    assert f"{statistics.successes} of 40 runs succeed (T_theta < 19, T_theta in s)" in sections["batch"].blocks[1].text
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
    times = store.dataset()["T_theta"].values
    worst = sorted((run for run in range(40) if not succeeds[run]), key=lambda run: -times[run])[:5]
    drawn = store.dataset()["mass"].values
    assert [row[:3] for row in failed.rows] == [(str(run), f"{times[run]:.6g}", f"{drawn[run]:.6g}") for run in worst]
    (_, lower, *_), (name, end, value, _, run, command) = largest.rows[:2]
    assert (lower, end) == ("smallest", "largest")
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
    assert tables(sections["runs"])[ENDS].rows[0][-1].startswith("runs.mehvar.again(")
    pictures = [block.picture.title for block in sections["pictures"].blocks if isinstance(block, Drawing)]
    assert "Convergence" not in pictures
    assert "Metrics of the runs" in pictures


def test_a_run_whose_inputs_the_store_lacks_is_repeated_with_them(tmp_path, undrawn):
    """`simulate --from` has no inputs to repeat it with."""
    where = tmp_path / "runs.zarr"
    runs = mehvar.batch("satellite", inputs={"Tx": 0.1}, n=3, period=0.5, t_end=5.0, out=where,
                        vary={"roll": "uniform(0, 1)"}, success="maximum(roll) < 0")  # fmt: skip
    sections = {section.anchor: section for section in batch_sections(Runs(runs), str(where))}
    for table in tables(sections["runs"]).values():
        assert all(row[-1].endswith(", inputs=INPUTS)") for row in table.rows)
    command = tables(sections["runs"])[ENDS].rows[0][-1]
    assert eval(command, {"runs": runs, "INPUTS": {"Tx": 0.1}}).attrs["status"] == "done"


def stopped(whole, missing):
    """Return a batch of which some runs are not stored, as a store has them."""
    part = whole.copy(deep=True)
    part["status"][missing] = NOT_RUN
    for array in part.data_vars.values():
        if array.dtype.kind == "f":
            array.values[missing] = np.nan
    return part


@pytest.mark.soak
def test_an_unfinished_design_has_no_sobol_indices():
    vary = {"theta_0": "uniform(0.8, 1.2)", "mass": "normal(1, 0.05)"}
    whole = mehvar.batch("triangle", "path", n=16, vary=vary, sampling="saltelli", t_end=2.0).load()
    for part, kinds in ((whole, {"sobol"}), (stopped(whole, slice(12, 16)), {"regression"})):
        sections = {section.anchor: section for section in batch_sections(Runs(part))}
        assert {title.split()[0].lower() for title in tables(sections["sensitivities"])} <= {"sobol", "sensitivities:"}
        assert ("Sobol" in " ".join(tables(sections["sensitivities"]))) == (kinds == {"sobol"})


def test_of_an_unfinished_batch_the_stored_runs_are_counted(store, undrawn):
    whole = store.dataset().load()
    part = stopped(whole, slice(0, 30))
    runs = Runs(part)
    assert (runs.whole.sizes["run"], list(runs.numbers)) == (40, list(range(30, 40)))
    sections = {section.anchor: section for section in batch_sections(runs, "runs.zarr")}
    text, succeeds = sections["batch"].blocks[1].text, Runs(whole).successful[30:]
    assert f"{succeeds.sum()} of 10 runs succeed" in text
    assert text.endswith("10 of 40 runs are stored.")
    largest = tables(sections["runs"])[ENDS].rows[1]
    assert int(largest[4]) == 30 + int(whole[largest[0]].values[30:].argmax())
    part["status"][:] = NOT_RUN
    with pytest.raises(InputError, match="this batch has no stored run yet"):
        Runs(part)


def test_quantiles_of_runs_that_never_settle_are_infinite(store):
    dataset = store.dataset().load()
    dataset["T_theta"][:30] = np.inf
    row = dataset.mehvar.metrics().loc["T_theta"]
    assert (row["count"], row["50%"], row["max"]) == (10, np.inf, np.inf)
