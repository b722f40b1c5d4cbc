# SPDX-License-Identifier: Apache-2.0
"""Results answer for themselves: tables, pictures, pages; of a user's own system too."""

from __future__ import annotations

import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
import xarray as xr
from matplotlib import pyplot
from matplotlib.colors import to_rgba
from PIL import Image

import mehvar
from mehvar.base.errors import InputError
from mehvar.cli import report as report_command
from mehvar.cli.store.stats import print_statistics
from mehvar.parts import Hub, Spacecraft
from mehvar.pictures.batch import BINS, batch_picture, bin_edges
from mehvar.pictures.files import save
from mehvar.pictures.run import panels_picture
from mehvar.pictures.style import BLUE, VERMILLION, style
from mehvar.reproduction.paper import result_picture, run_picture
from mehvar.runtime.batch.repeat import SESSION_LAWS
from mehvar.runtime.batch.store.store import open_store
from tests.docs.formulas import faults

PENDULUM = Path(__file__).parents[2] / "runtime" / "pendulum"


@pytest.fixture(scope="module", autouse=True)
def _no_window():
    with mpl.rc_context({"backend": "agg"}):
        yield
    pyplot.close("all")


@pytest.fixture(scope="module")
def run():
    return mehvar.simulate("triangle", "path", t_end=25.0)


@pytest.fixture(scope="module")
def batch():
    vary = {"theta_0": "uniform(0.5, 1.5)"}
    return mehvar.batch("triangle", "path", 40, vary=vary, success="T_theta < 19.3", save=1.0, dt_out=0.1)


def damp(t, x):
    return [-0.1 * x.roll - 0.5 * x.wx, 0.0, 0.0]


def math(page: str) -> list[str]:
    return re.findall(r"<math.*?</math>", page, re.DOTALL)


def test_metrics_are_a_table(run, batch):
    table = run.mehvar.metrics()
    assert table.loc["T_theta", "value"] == float(run["T_theta"])
    assert table.loc["T_theta", "unit"] == "s"
    assert batch.mehvar.metrics().loc["travel", "mean"] == pytest.approx(float(batch["travel"].mean()))


def test_plot_is_the_picture_that_the_command_saves(run, tmp_path):
    """Also in the file that a user saves, whose ticks Matplotlib makes at that moment."""
    saved, shown = run_picture(run, mehvar.load("triangle").manifest), run.mehvar.plot()
    assert shown.get_suptitle() == saved.get_suptitle()
    for ax, other in zip(saved.axes, shown.axes, strict=True):
        for line, twin in zip(ax.lines, other.lines, strict=True):
            np.testing.assert_array_equal(line.get_xydata(), twin.get_xydata())
    save(saved, tmp_path / "saved.png")
    shown.savefig(tmp_path / "shown.png")
    with Image.open(tmp_path / "saved.png") as one, Image.open(tmp_path / "shown.png") as other:
        np.testing.assert_array_equal(np.asarray(one), np.asarray(other))


def test_a_result_of_another_version_has_no_picture_by_the_papers_functions(run):
    """They are those of the installed model."""
    mine = mehvar.load("triangle").manifest
    with style():
        panels = [ax.get_ylabel() for ax in panels_picture(run, mine).axes]
        assert [ax.get_ylabel() for ax in result_picture(run, replace(mine, hash="0" * 64)).axes] == panels
        assert [ax.get_ylabel() for ax in result_picture(run, mine).axes] != panels


def test_a_run_is_drawn_with_its_settling_times(run):
    with style():
        axes = panels_picture(run, mehvar.load("triangle").manifest).axes
    texts = [text.get_text() for ax in axes for text in ax.texts]
    assert sorted(texts) == ["T_length", "T_rho", "T_theta"]
    marked = next(ax for ax in axes if "T_rho" in [text.get_text() for text in ax.texts])
    assert any(line.get_xdata()[0] == float(run["T_rho"]) for line in marked.get_lines())


def area(corners):
    x, y = corners.T
    return abs(np.sum(x * np.roll(y, 1) - y * np.roll(x, 1))) / 2


def test_runs_are_counted_by_success(batch):
    wins = int(((batch["status"] == 0) & (batch["T_theta"] < 19.3)).sum())
    histogram, bands, last = batch.mehvar.plot("T_theta", "theta", "final(rho)").axes
    width = np.ptp(batch["T_theta"].values) / BINS
    runs = {shape.get_facecolor(): area(shape.get_xy()) / width for shape in histogram.patches}
    assert runs == pytest.approx({to_rgba(BLUE): wins, to_rgba(VERMILLION): 40 - wins})
    assert len(bands.collections) == 3
    assert last.get_xlabel() == "final(rho) [1]"
    scatter = batch.mehvar.scatter("theta_0", "T_theta")
    assert [len(part.get_offsets()) for part in scatter.collections] == [wins, 40 - wins]
    region = batch.mehvar.region("theta_0", "travel").collections[0].get_array()
    assert region.count() > 4
    assert 0 <= region.min() <= region.max() <= 1
    only = batch.mehvar.region("theta_0", "theta_0", success="T_theta < 0").collections[0].get_array()
    assert only.count() == 4
    assert only.max() == 0
    share = batch.mehvar.convergence().get_lines()[0].get_ydata()
    assert share[-1] == wins / 40
    assert batch.mehvar.convergence(success="T_theta < 0").get_lines()[0].get_ydata()[-1] == 0


def test_two_runs_are_compared_at_the_samples_of_both(run):
    """Straight lines between samples said 4e-4 rad of two runs that are the same motion."""
    other = mehvar.simulate("triangle", "path", t_end=10.0, dt_out=0.05)
    for table in (run.mehvar.compare(other), other.mehvar.compare(run)):
        assert table.loc["theta", "largest"] < 1e-8
        assert table["at"].max() <= 10.0
        assert np.allclose(table["at"] / 0.05, np.round(table["at"] / 0.05))
    assert (run.mehvar.compare(run)["largest"] == 0).all()


def test_a_run_of_a_batch_is_repeated(batch):
    again = batch.mehvar.again(17)
    np.testing.assert_array_equal(again["theta"].sel(t=batch["t"]), batch["theta"][17])
    assert repr(again.mehvar).startswith("<mehvar: a run of triangle with path")
    changed = batch.load().copy(deep=True)
    changed["travel"][17] *= 1 + 1e-15
    with pytest.raises(mehvar.MehvarError, match="run 17: differs from the store in travel by up to"):
        changed.mehvar.again(17)


@pytest.mark.parametrize("order", [[3, 7, 11], list(range(19, -1, -1))])
def test_a_row_of_a_selection_is_not_taken_for_the_run_of_its_number(batch, order):
    """It was compared with another run, and the data were blamed."""
    with pytest.raises(mehvar.InputError, match=f"^row 1 holds run {order[1]} of the batch, as after isel or sortby"):
        batch.isel(run=order).mehvar.again(1)
    assert batch.isel(run=slice(0, 5)).mehvar.again(1).attrs["reason"]
    for wrong in ("1", True, 1.0, None):
        with pytest.raises(InputError, match=r"run = .*must be the number of a run"):
            batch.mehvar.again(wrong)


def test_a_run_under_a_law_in_python_is_repeated_with_that_law_only(monkeypatch):
    batch = mehvar.batch("satellite", damp, 3, period=0.5, t_end=5.0, vary={"roll": "uniform(-0.1, 0.1)"})
    for law in ((), (damp,)):
        again = batch.mehvar.again(2, *law)
        np.testing.assert_array_equal(again.isel(t=-1)["roll"], batch["final"][2].sel(state="roll"))
    SESSION_LAWS.clear()
    with pytest.raises(mehvar.InputError, match=r"a law in Python that is not defined here"):
        batch.mehvar.again(2)
    monkeypatch.setattr("__main__.damp", damp, raising=False)
    assert batch.mehvar.again(2).attrs["controller"] == "python:damp"
    with pytest.raises(mehvar.InputError, match=r"another version of python:damp:\ndef damp"):
        batch.mehvar.again(2, lambda t, x: [0.0, 0.0, 0.0])


def test_a_run_without_a_law_is_repeated_with_its_inputs():
    batch = mehvar.batch("satellite", inputs={"Tx": 0.1}, n=3, period=0.5, t_end=5.0, vary={"roll": "uniform(0, 1)"})
    np.testing.assert_array_equal(
        batch.mehvar.again(1, inputs={"Tx": 0.1}).isel(t=-1)["roll"], batch["final"][1].sel(state="roll")
    )
    with pytest.raises(mehvar.InputError, match="another version of none"):
        batch.mehvar.again(1, inputs={"Tx": 0.2})


def test_a_session_that_never_imported_mehvar_has_results(tmp_path):
    mehvar.batch("triangle", "path", 2, out=tmp_path / "runs.zarr", t_end=1.0)
    assert repr(mehvar.open_result(tmp_path / "runs.zarr").mehvar).startswith("<mehvar: a batch of 2 runs")
    path = repr(str(tmp_path / "runs.zarr"))
    for opened in (f"open_zarr({path})", f"open_dataset({path})"):
        text = f"import xarray; print(xarray.{opened}.mehvar)"
        fresh = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, check=False)
        assert fresh.stdout.startswith("<mehvar: a batch of 2 runs"), fresh.stderr


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda run, batch: batch.mehvar.plot("nothing"), "unknown number 'nothing' of the runs"),
        (lambda run, batch: run.mehvar.plot("theta"), "a single run has no names"),
        (lambda run, batch: run.mehvar.scatter("theta", "rho"), "unknown dimension 'run' of this result"),
        (lambda run, batch: run.mehvar.compare(batch), "the dataset of a run, because this is a run"),
        (lambda run, batch: run.mehvar.compare(run[["t"]]), "a run without variables of the same name"),
        (lambda run, batch: run.mehvar.compare(run.assign_coords(t=run["t"] + 0.003)), "without samples at the same"),
        (lambda run, batch: run.mehvar.report("run.pdf"), "ends in .html"),
        (lambda run, batch: batch.mehvar.animate(), "cannot animate triangle with path: this is a batch"),
        (lambda run, batch: run.mehvar.again(1), "this result is a single run"),
        (lambda run, batch: batch.mehvar.again(40), "run = 40: must be a whole number from 0 to 39"),
        (lambda run, batch: batch.mehvar.again(1, controller=damp), "run under path"),
        (lambda run, batch: xr.Dataset().mehvar.metrics(), "not a result of mehvar"),
    ],
)
def test_what_cannot_be_done_is_refused(run, batch, call, message):
    with pytest.raises(mehvar.InputError, match=message):
        call(run, batch)


def test_pages_of_run_and_batch_stand_alone(run, batch, tmp_path):
    series = [name for name, variable in batch.data_vars.items() if variable.dims == ("run", "t") and name != "theta"]
    few = batch.drop_vars(series).assign_attrs(metrics='["T_theta", "travel"]')  # pictures take the time
    for dataset, sections in (
        (run, ("animation", "run", "values", "derivation", "provenance")),
        (few, ("batch", "sensitivities", "metrics", "runs", "pictures", "derivation", "provenance")),
    ):
        page = dataset.mehvar.report(tmp_path / "page.html").read_text(encoding="utf-8")
        assert re.findall(r'<section id="(\w+)"', page) == list(sections)
        assert not re.search(r'(src|href)="(?!#|data:|\$)', page)
        assert len(math(page)) > 50
    assert not [fault for formula in math(page)[:60] for fault in faults(formula)]
    assert run.attrs["model_hash"] in (tmp_path / "page.html").read_text(encoding="utf-8")


def test_an_animation_is_shown_and_saved(run, tmp_path):
    animation = run.mehvar.animate()
    animation.save(tmp_path / "turn.html")
    assert 'data-scene="triangle"' in (tmp_path / "turn.html").read_text(encoding="utf-8")
    assert animation._repr_html_().startswith("<iframe srcdoc=")
    assert "<script>" not in animation._repr_html_()


def test_a_run_of_another_model_of_the_name_has_no_foreign_equations(run, tmp_path):
    """The manifest in the file is of a text that is not installed: neither its derivation nor its paper's picture."""
    other = mehvar.simulate(PENDULUM, "pd", "swing")
    page = other.mehvar.report(tmp_path / "page.html").read_text(encoding="utf-8")
    assert 'id="derivation"' not in page
    assert 'id="run-picture"' in page


@pytest.mark.soak
def test_a_page_of_ones_own_system(tmp_path, capsys):
    report_command.command(str(PENDULUM), tmp_path / "out")
    page = (tmp_path / "out" / "index.html").read_text(encoding="utf-8")
    assert re.findall(r'<section id="([\w-]+)"', page)[-1] == "provenance"
    assert 'id="run-pd"' in page
    assert str(tmp_path / "out" / "index.html") in capsys.readouterr().out


def test_a_batch_without_metrics_shows_the_states_at_the_end(tmp_path, capsys):
    hub = Spacecraft("hub", motion="plane")
    hub.add(Hub("hub", mass=3.0, inertia=(1.0, 1.0, 1.0)))
    path = tmp_path / "runs"
    vary = {"wz_0": "uniform(0, 1)"}
    runs = mehvar.batch(
        mehvar.build(hub), None, 5, inputs={}, t_end=1.0, vary=vary, success="final(wz) > 0.5", out=path
    )
    states = [f"final({name})" for name in runs["state"].values]
    assert list(runs.mehvar.metrics().index) == states
    assert runs.mehvar.metrics().loc["final(wz)", "mean"] == pytest.approx(float(runs["final"][:, -1].mean()))
    stored = batch_picture(open_store(path), [])
    for figure in (runs.mehvar.plot(), stored):
        assert {ax.get_xlabel().partition(" ")[0] for ax in figure.axes} == set(states)
        assert all(np.ptp(bars.get_path().vertices[:, 0]) > 1e-9 for ax in figure.axes for bars in ax.patches)
    print_statistics(open_store(path))
    assert "the model declares no metrics (in scenarios.toml" in " ".join(capsys.readouterr().out.split())
    assert "declares no metrics" in runs.mehvar.report(tmp_path / "page.html").read_text(encoding="utf-8")


@pytest.mark.parametrize("values", [[], [0.0], [5e-324], [0.65, 0.65 + 1e-16], [1e300, 1e300], [1.0, 2.0]])
def test_bins_have_edges_of_their_own(values):
    edges = bin_edges(np.array(values))
    assert len(edges) == BINS + 1
    assert (np.diff(edges) > 0).all()
    assert np.histogram(values, edges)[0].sum() == len(values)


def test_a_run_is_animated_by_its_own_model_only(run):
    assert "Report.players" in run.mehvar.animate(mehvar.load("triangle")).page
    with pytest.raises(InputError, match=r"model = 'slosh .*that of the run, triangle"):
        run.mehvar.animate("slosh")
