# SPDX-License-Identifier: Apache-2.0
"""Datasets and files: labelled, complete or absent."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray

import mehvar
from mehvar import runtime
from mehvar.runtime import InputError, Model, find_model
from mehvar.runtime.files import check_folder, filling, replacing, write_atomic
from mehvar.runtime.run.results import hidden_names

ROOT = Path(mehvar.__file__).parent.parent
PENDULUM = Path(__file__).parents[1] / "pendulum"


@pytest.fixture(scope="module")
def dataset(pendulum: Model) -> xarray.Dataset:
    return runtime.to_dataset(runtime.simulate(pendulum, "p-sum", "stiff", delay=1, rate_0=0.1, dt_out=0.05))


def test_variables_have_names_and_units(dataset: xarray.Dataset) -> None:
    assert list(dataset.data_vars) == [
        *("angle", "rate", "u_torque", "u_cmd_torque", "energy", "angle_error", "power", "sum"),
        *runtime.load(PENDULUM).manifest.metrics,
    ]
    assert dataset["t"].attrs["units"] == "s"
    assert dataset["energy"].attrs == {"units": "J", "long_name": "kinetic and potential energy"}
    assert dataset["u_torque"].attrs == {"units": "N m", "long_name": "motor torque, applied"}


def test_command_is_left_out_of_a_continuous_loop(pendulum: Model) -> None:
    assert "u_cmd_torque" not in runtime.to_dataset(runtime.simulate(pendulum, "pd"))


def test_attributes_tell_how_it_came_about(dataset: xarray.Dataset) -> None:
    attrs = dataset.attrs
    assert (attrs["model"], attrs["controller"], attrs["scenario"]) == ("pendulum", "p-sum", "stiff")
    assert (attrs["status"], attrs["t_stop"], attrs["backend"]) == ("done", 1.0, "c")
    assert json.loads(attrs["parameters"])["rate_0"] == 0.1
    assert json.loads(attrs["parameter_origins"])["k_p"] == "scenario stiff"
    assert json.loads(attrs["options"])["delay"] == 1
    assert json.loads(attrs["manifest"])["model"] == "pendulum"
    assert {"python", "numpy", "hand"} <= set(json.loads(attrs["versions"]))


@pytest.mark.parametrize("initial", [{}, {"angle": 0.7}, {"angle": -0.7, "rate": 0.25}])
def test_attributes_have_the_start_wherever_it_came_from(pendulum: Model, initial: dict[str, object]) -> None:
    settings = {} if "rate" in initial else {"rate_0": 0.1}
    run = runtime.simulate(pendulum, "pd", "stiff", initial=initial, t_end=0.1, **settings)
    attrs = runtime.to_dataset(run).attrs
    parameters = json.loads(attrs["parameters"])
    start = {"angle": parameters["angle_0"], "rate": parameters["rate_0"]}
    assert json.loads(attrs["initial"]) == {**start, **initial}


def test_file_round_trip(dataset: xarray.Dataset, tmp_path: Path) -> None:
    path = tmp_path / "run.nc"
    path.write_text("old")
    runtime.save(dataset, path)
    assert [p.name for p in tmp_path.iterdir()] == ["run.nc"]
    again = runtime.open_result(path)
    xarray.testing.assert_identical(again, dataset)
    assert np.array_equal(again["t"].values, dataset["t"].values)


def test_metrics_are_in_the_dataset_and_its_file(pendulum: Model, dataset: xarray.Dataset, tmp_path: Path) -> None:
    runtime.save(dataset, tmp_path / "run.nc")
    again = runtime.open_result(tmp_path / "run.nc")
    assert pendulum.manifest.metrics
    for name, metric in pendulum.manifest.metrics.items():
        assert again[name].ndim == 0
        assert again[name].attrs == {"units": metric.unit, "long_name": metric.description}
        assert float(again[name]) == runtime.metrics(again, pendulum.manifest)[name]


def test_two_variables_of_one_name_are_refused(edited: Callable[[str, str, str], Path]) -> None:
    name = next(iter(runtime.load(PENDULUM).manifest.metrics))
    model = runtime.load(edited("manifest.json", f'"{name}": {{', '"energy": {'))
    with pytest.raises(InputError, match="two variables called energy: rename one in pendulum"):
        runtime.to_dataset(runtime.simulate(model, "pd"))


def test_names_that_a_dataset_hides_are_told(edited: Callable[[str, str, str], Path], pendulum: Model) -> None:
    assert hidden_names(pendulum.manifest) == ["sum"], "the law's memory"
    assert hidden_names(find_model("satellite")) == ["roll"]


def test_bad_places(dataset: xarray.Dataset, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"cannot write .*run\.nc: the folder .* does not exist"):
        runtime.save(dataset, tmp_path / "missing" / "run.nc")
    (tmp_path / "folder.nc").mkdir()
    with pytest.raises(InputError, match="it is a folder"):
        runtime.save(dataset, tmp_path / "folder.nc")
    with pytest.raises(InputError, match="no result file"):
        runtime.open_result(tmp_path / "none.nc")
    (tmp_path / "text.nc").write_text("not a result")
    with pytest.raises(InputError, match="is not a result file"):
        runtime.open_result(tmp_path / "text.nc")


def test_full_disk_leaves_the_old_file_and_no_rest(tmp_path: Path, folder: Path) -> None:
    path = tmp_path / "run.nc"
    path.write_text("old")
    code = (
        "import resource, sys\nfrom mehvar import runtime\n"
        f"run = runtime.simulate({str(folder)!r}, 'pd', t_end=1.0, dt_out=0.0005)\n"
        "dataset = runtime.to_dataset(run)\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (50_000, 50_000))\n"
        "try:\n"
        f"    runtime.save(dataset, {str(path)!r})\n"
        "except OSError as error:\n"
        "    print(error, file=sys.stdout)\n"
    )
    done = subprocess.run([sys.executable, "-P", "-c", code], capture_output=True, text=True, cwd=ROOT, check=False)
    assert f"cannot write {path}: " in done.stdout, done.stderr
    assert path.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["run.nc"]


def test_a_pipe_or_device_is_not_replaced(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(InputError, match="a socket; choose another name"), replacing(tmp_path / "pipe"):
        pass
    assert (tmp_path / "pipe").is_fifo()


def test_interrupted_write_leaves_nothing(tmp_path: Path) -> None:
    def interrupted() -> None:
        with replacing(tmp_path / "a.txt") as temporary:
            temporary.write_text("half")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert list(tmp_path.iterdir()) == []


def test_a_folder_gets_all_files_or_none(tmp_path: Path) -> None:
    def interrupted() -> None:
        with filling(tmp_path / "a" / "b", "maker") as folder:
            (folder / "half.txt").write_text("half")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert list(tmp_path.iterdir()) == []
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "mine.txt").write_text("mine")
    with filling(tmp_path / "a", "maker") as folder:
        (folder / "deep").mkdir()
        (folder / "deep" / "new.txt").write_text("new")
    assert sorted(str(p.relative_to(tmp_path)) for p in tmp_path.rglob("*.txt")) == ["a/deep/new.txt", "a/mine.txt"]
    assert len(list(tmp_path.iterdir())) == 1
    with filling(tmp_path / "other", "maker") as folder:
        (folder / "new.txt").write_text("new")
    assert (tmp_path / "other").stat().st_mode == (tmp_path / "a").stat().st_mode
    with pytest.raises(OSError, match="cannot write /dev/full/a"), filling("/dev/full/a", "maker"):
        pass


def test_a_folder_keeps_what_another_wrote_there(tmp_path: Path) -> None:
    def fill(maker: str, name: str) -> None:
        with filling(tmp_path, maker) as folder:
            (folder / name).write_text(maker)

    fill("mehvar first", "a.txt")
    fill("mehvar second", "b.txt")
    fill("mehvar first", "a.txt")
    (tmp_path / "c.txt").write_text("mine")
    for maker, name, why in (
        ("mehvar second", "a.txt", "a.txt, which `mehvar first` made"),
        ("mehvar first", "c.txt", "c.txt, which `mehvar first` did not make"),
    ):
        with pytest.raises(InputError, match=why):
            fill(maker, name)
        with pytest.raises(InputError, match=why):
            check_folder(tmp_path, maker, [name])
    assert {path.name: path.read_text() for path in tmp_path.glob("*.txt")} == {
        "a.txt": "mehvar first",
        "b.txt": "mehvar second",
        "c.txt": "mine",
    }


def test_text_and_bytes_are_written_as_they_are(tmp_path: Path) -> None:
    write_atomic(tmp_path / "a.txt", "a\nß\r\n")
    assert (tmp_path / "a.txt").read_bytes() == "a\nß\r\n".encode()
    write_atomic(tmp_path / "a.txt", b"\x00")
    assert (tmp_path / "a.txt").read_bytes() == b"\x00"
    assert [path.name for path in tmp_path.iterdir()] == ["a.txt"]


def test_results_of_one_form_share_nothing_that_can_be_changed(pendulum: Model) -> None:
    first, second = (runtime.to_dataset(runtime.simulate(pendulum, "pd", rate_0=rate)) for rate in (0.1, 0.2))
    assert first["angle"].values[-1] != second["angle"].values[-1]
    for name in first.variables:
        first[name].attrs["units"] = "changed"
        if name not in first.indexes:
            first[name].values[...] = -1.0
    first.attrs["title"], first["more"] = "changed", ("t", first["t"].values)
    again = runtime.to_dataset(runtime.simulate(pendulum, "pd", rate_0=0.2))
    xarray.testing.assert_identical(again, second)
    assert not first["t"].values.flags.writeable
