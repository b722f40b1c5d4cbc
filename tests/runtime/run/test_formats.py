# SPDX-License-Identifier: Apache-2.0
"""Result files: what the name says, read back by the libraries that people read them with, or a refusal."""

from __future__ import annotations

import csv
import json
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray

from mehvar import runtime
from mehvar.runtime import InputError, Model
from mehvar.runtime.run.formats import _FORMATS, checked_format


@pytest.fixture(scope="module")
def dataset(pendulum: Model) -> xarray.Dataset:
    """A run with a metric that is not finite, and samples that are none."""
    run = runtime.to_dataset(runtime.simulate(pendulum, "p-sum", delay=1, t_end=0.3))
    run["power"][3] = np.nan
    assert any(not np.isfinite(float(value)) for value in run.data_vars.values() if not value.ndim)
    return run


def series(dataset: xarray.Dataset) -> dict[str, xarray.DataArray]:
    return {"t": dataset["t"], **{str(name): array for name, array in dataset.data_vars.items() if array.ndim}}


def test_csv_has_a_column_with_its_unit_for_each_series(dataset: xarray.Dataset, tmp_path: Path) -> None:
    runtime.save(dataset, tmp_path / "run.csv")
    with (tmp_path / "run.csv").open(newline="") as file:
        header, *rows = csv.reader(file)
    assert header == [f"{name} [{array.units}]" for name, array in series(dataset).items()]
    numbers = np.array([[float(text or "nan") for text in row] for row in rows])
    assert np.array_equal(numbers, np.stack([a.values for a in series(dataset).values()], axis=1), equal_nan=True)


def test_parquet_keeps_units_attributes_and_metrics(dataset: xarray.Dataset, tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    runtime.save(dataset, tmp_path / "run.parquet")
    table = parquet.read_table(tmp_path / "run.parquet")
    for name, array in series(dataset).items():
        assert np.array_equal(table[name].to_numpy(), array.values, equal_nan=True)
        assert table.schema.field(name).metadata[b"units"].decode() == array.units
    assert table.schema.metadata[b"model_hash"].decode() == dataset.attrs["model_hash"]
    metrics = json.loads(table.schema.metadata[b"metrics"], parse_constant=pytest.fail)
    assert {name: float(m["value"]) for name, m in metrics.items()} == {name: float(dataset[name]) for name in metrics}


def test_matlab_has_everything_by_name(dataset: xarray.Dataset, tmp_path: Path) -> None:
    from scipy.io import loadmat

    runtime.save(dataset, tmp_path / "run.mat")
    contents = loadmat(tmp_path / "run.mat", squeeze_me=True)
    for name, array in {**series(dataset), **dataset.data_vars}.items():
        assert np.array_equal(contents[str(name)], array.values, equal_nan=True)
        assert str(contents["units"][str(name)]) == array.units
    assert str(contents["attributes"]["model_hash"]) == dataset.attrs["model_hash"]
    assert loadmat(tmp_path / "run.mat")["t"].shape == (dataset.sizes["t"], 1)
    taken = dataset.rename({"energy": "units"})
    with pytest.raises(InputError, match="variable = 'units': must be a name for MATLAB"):
        runtime.save(taken, tmp_path / "run.mat")


@pytest.mark.parametrize("suffix", _FORMATS)
def test_the_same_run_is_the_same_file(dataset: xarray.Dataset, tmp_path: Path, suffix: str) -> None:
    if suffix in (".parquet", ".arrow"):
        pytest.importorskip("pyarrow")
    for name in ("one", "other"):
        runtime.save(dataset, tmp_path / f"{name}{suffix.upper()}")
    one, other = (tmp_path / f"{name}{suffix.upper()}" for name in ("one", "other"))
    assert one.read_bytes() == other.read_bytes()


@pytest.mark.parametrize("name", ["run.xyz", "run", "run.nc.gz", "run.h5", ".nc", "run.CSVX"])
def test_another_ending_is_refused(dataset: xarray.Dataset, tmp_path: Path, name: str) -> None:
    with pytest.raises(InputError, match=r"must be a file name that ends in \.nc, \.csv, \.parquet, \.arrow or \.mat"):
        runtime.save(dataset, tmp_path / name)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("suffix", [".parquet", ".arrow"])
def test_arrow_without_its_package_is_refused_before_anything(monkeypatch: pytest.MonkeyPatch, suffix: str) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(InputError, match=rf'\{suffix} needs pyarrow: pip install "mehvar\[parquet\]"'):
        checked_format(f"run{suffix}")


@pytest.mark.parametrize("suffix", [".csv", ".mat"])
def test_a_batch_is_no_table(tmp_path: Path, suffix: str) -> None:
    batch = xarray.Dataset({"final": (("run", "state"), np.zeros((2, 3)))})
    with pytest.raises(InputError, match="only a single run can be a table"):
        runtime.save(batch, tmp_path / f"batch{suffix}")


def test_only_netcdf_is_read(dataset: xarray.Dataset, tmp_path: Path) -> None:
    runtime.save(dataset, tmp_path / "run.csv")
    with pytest.raises(InputError, match=r"run\.csv': must be a result in NetCDF.*pandas\.read_csv"):
        runtime.open_result(tmp_path / "run.csv")
    xarray.Dataset({"a": ("b", [1.0])}).to_netcdf(tmp_path / "other.nc", engine="h5netcdf")
    with pytest.raises(InputError, match="it lacks model_hash, or it has neither a time t nor runs"):
        runtime.open_result(tmp_path / "other.nc")


def test_a_damaged_file_is_refused_or_has_the_same_numbers(dataset: xarray.Dataset, tmp_path: Path) -> None:
    path = tmp_path / "run.nc"
    runtime.save(dataset, path)
    whole, rng, refused = path.read_bytes(), np.random.default_rng(0), 0
    for _ in range(600):
        place, bit = int(rng.integers(len(whole))), 1 << int(rng.integers(8))
        path.write_bytes(whole[:place] + bytes([whole[place] ^ bit]) + whole[place + 1 :])
        try:
            again = runtime.open_result(path)
        except InputError:
            refused += 1
            continue
        for name, array in series(again).items():
            if name in dataset:
                assert np.array_equal(array.values, dataset[name].values, equal_nan=True), (name, place, bit)
    assert refused
    for length in (*range(0, len(whole) - 50, len(whole) // 50), *range(len(whole) - 46, len(whole))):  # in the seal
        path.write_bytes(whole[:length])
        with pytest.raises(InputError, match=r"is not a result file|is damaged"):
            runtime.open_result(path)
