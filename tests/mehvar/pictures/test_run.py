# SPDX-License-Identifier: Apache-2.0
import importlib.util
import subprocess
import sys
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest

from mehvar.base.errors import InputError
from mehvar.pictures.files import save
from mehvar.pictures.run import panels_picture
from mehvar.pictures.style import style
from mehvar.reproduction.paper import run_picture
from mehvar.runtime.model.model import load
from mehvar.runtime.run.results import to_dataset
from mehvar.runtime.run.simulate import simulate

PENDULUM = Path(__file__).parents[2] / "runtime" / "pendulum"


@pytest.fixture(scope="module")
def swing():
    model = load(PENDULUM)
    return to_dataset(simulate(model, "pd", "swing")), model.manifest


@pytest.fixture(scope="module")
def turn():
    model = load("triangle")
    return to_dataset(simulate(model, "path", "paper", t_end=10.0)), model.manifest


def test_any_model_gets_a_panel_for_each_kind_and_unit(swing):
    dataset, manifest = swing
    figure = run_picture(dataset, manifest)
    groups = [
        *((q.unit, "states") for q in manifest.states),
        *((q.unit, "inputs") for q in manifest.inputs),
        *((q.unit, "outputs") for q in manifest.outputs),
    ]
    assert len(figure.axes) == len(set(groups))
    assert all(ax.get_xlabel() == "time t [s]" for ax in figure.axes)
    assert all(ax.get_ylabel().endswith("]") for ax in figure.axes)
    drawn = [line.get_ydata() for ax in figure.axes for line in ax.lines]
    names = [q.name for q in manifest.states]
    names += [f"u_{q.name}" for q in manifest.inputs] + [q.name for q in manifest.outputs]
    assert len(drawn) == len(names)
    for name in names:
        assert any(np.array_equal(series, dataset[name].values) for series in drawn), name


def test_variables_of_one_unit_share_a_panel_and_are_told_apart(turn):
    dataset, manifest = turn
    with style():
        figure = panels_picture(dataset, manifest)
    panel = next(ax for ax in figure.axes if ax.get_title(loc="left") == "outputs in m")
    assert [text.get_text().split(":")[0] for text in panel.get_legend().get_texts()] == [
        "l1", "l2", "l3", "length_error",
    ]  # fmt: skip
    assert len({line.get_color() for line in panel.lines}) == 4


def test_a_reference_is_drawn_over_its_state_and_magnitudes_are_not_mixed():
    """Wheels turn 10^5 times as fast as the body: in one panel the rates of the body would be a line at zero."""
    model = load("satellite")
    dataset = to_dataset(simulate(model, "pd", "paper", t_end=50.0))
    with style():
        figure = panels_picture(dataset, model.manifest)
    drawn = [[line.get_label().split(":")[0] for line in ax.lines] for ax in figure.axes]
    assert ["roll", "ref_roll", "pitch", "ref_pitch", "yaw", "ref_yaw", "latitude"] in drawn
    assert ["wheel_x", "wheel_y", "wheel_z"] in drawn
    assert ["rate_x", "rate_y", "rate_z"] in drawn
    state, reference = figure.axes[0].lines[:2]
    assert (reference.get_color(), reference.get_linestyle()) == (state.get_color(), "--")


def test_a_paper_module_draws_its_own_picture(turn):
    dataset, manifest = turn
    figure = run_picture(dataset, manifest)
    disc = next(ax for ax in figure.axes if "rho" in ax.get_xlabel())
    assert disc.get_aspect() == 1.0
    path = next(line for line in disc.lines if line.get_label() == "path")
    np.testing.assert_allclose(path.get_xdata(), dataset["rho"] * np.cos(dataset["phi"]))
    radii = sorted(patch.radius for patch in disc.patches)
    assert radii == pytest.approx([0.65, np.sqrt(0.5)])
    target = next(line for line in disc.lines if line.get_label() == "target")
    rho_f, phi_f, _ = load("triangle").functions["shape"](0.3, 0.3, 0.5)
    assert target.get_xdata()[0] == pytest.approx(rho_f * np.cos(phi_f))


def test_the_picture_says_that_and_why_a_run_ended_early():
    model = load("triangle")
    run = simulate(model, "path", "printed", hold=0.5)
    assert run.t_stop < 15.0
    figure = run_picture(to_dataset(run), model.manifest)
    assert figure.get_suptitle().endswith(f"ended early: {run.reason}")
    assert "collinear (at t = " in run.reason


@pytest.mark.parametrize("dataset", ["swing", "turn"])
@pytest.mark.share(2)
def test_a_run_of_one_sample_can_be_drawn(dataset, request, tmp_path):
    run, manifest = request.getfixturevalue(dataset)
    save(run_picture(run.isel(t=slice(0, 1)), manifest), tmp_path / "short.png")


@pytest.mark.parametrize("suffix", [".png", ".svg", ".pdf"])
@pytest.mark.share(3)
def test_the_same_run_gives_the_same_bytes_whatever_the_users_style(swing, tmp_path, suffix):
    first, second = tmp_path / f"a{suffix}", tmp_path / f"b{suffix}"
    save(run_picture(*swing), first)
    with mpl.rc_context({"lines.linewidth": 9, "font.size": 20, "axes.grid": False, "savefig.dpi": 40}):
        save(run_picture(*swing), second)
    assert first.read_bytes() == second.read_bytes()
    assert sorted(path.name for path in tmp_path.iterdir()) == [first.name, second.name]


def test_png_has_150_dots_per_inch_and_no_note_of_its_maker(swing, tmp_path):
    figure = run_picture(*swing)
    save(figure, tmp_path / "run.PNG")
    data = (tmp_path / "run.PNG").read_bytes()
    width, height = (int.from_bytes(data[i : i + 4], "big") for i in (16, 20))
    assert (width, height) == tuple(round(150 * inches) for inches in figure.get_size_inches())
    assert b"tEXt" not in data


def test_refuses_a_suffix_it_does_not_know_and_a_folder_that_is_not_there(swing, tmp_path):
    figure = run_picture(*swing)
    with pytest.raises(InputError, match=r"run\.bmp.*\.png, \.svg or \.pdf"):
        save(figure, tmp_path / "run.bmp")
    with pytest.raises(InputError, match="does not exist"):
        save(figure, tmp_path / "none" / "run.png")
    (tmp_path / "run.png").mkdir()
    with pytest.raises(InputError, match="is a folder"):
        save(figure, tmp_path / "run.png")


def test_an_old_picture_survives_a_failed_one(swing, tmp_path, monkeypatch):
    path, figure = tmp_path / "run.png", run_picture(*swing)
    path.write_bytes(b"old")

    def fill_the_disc(target, content):
        with target.open("wb") as file:
            file.write(content[: len(content) // 2])
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", fill_the_disc)
    with pytest.raises(OSError, match=r"run\.png: No space left"):
        save(figure, path)
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


def test_without_matplotlib_the_message_says_how_to_install_it(swing, monkeypatch):
    found = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name, *a: None if name == "matplotlib" else found(name, *a))
    with pytest.raises(InputError, match=r'pip install "mehvar\[plot\]"'):
        run_picture(*swing)


def test_importing_does_not_load_matplotlib():
    code = "import sys, mehvar.pictures.run, mehvar.reproduction.paper; sys.exit('matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_names_of_near_settling_times_stand_below_each_other():
    model = load("satellite")
    dataset = to_dataset(simulate(model, "mrac", "paper"))
    with style():
        axes = panels_picture(dataset, model.manifest).axes
    places = [text.xy[1] for ax in axes for text in ax.texts if text.get_text() in ("T_roll", "T_pitch")]
    assert abs(places[0] - places[1]) > 0.1
