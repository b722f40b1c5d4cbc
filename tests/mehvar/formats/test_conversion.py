# SPDX-License-Identifier: Apache-2.0
"""Results and batches in other formats: the numbers of the source, under names with units."""

from __future__ import annotations

import h5py
import numpy as np
import pandas
import pytest
import xarray
from hypothesis import given
from hypothesis import strategies as st
from pyarrow import ipc, parquet
from scipy.io import loadmat

import mehvar
from mehvar.base.errors import InputError
from mehvar.base.units import UNITS
from mehvar.formats import conversion
from mehvar.formats.conversion import ENDINGS, convert, flat_name, format_of
from mehvar.runtime.batch.fill import run_batch
from mehvar.runtime.batch.plan import Campaign
from mehvar.runtime.run import formats

READERS = {"csv": pandas.read_csv, "parquet": pandas.read_parquet, "arrow": pandas.read_feather}


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    path = tmp_path_factory.mktemp("run") / "run.nc"
    dataset = mehvar.simulate("triangle", "path", t_end=2.0)
    mehvar.save(dataset, path)
    return path, dataset


@pytest.fixture(scope="module")
def batch(tmp_path_factory):
    path = tmp_path_factory.mktemp("batch") / "runs.zarr"
    vary = {"theta_0": "uniform(0.8, 1.2)"}
    return path, mehvar.batch("triangle", "path", 5, vary=vary, t_end=2.0, save=1.0, out=path)


@pytest.mark.parametrize("to", ["csv", "parquet", "arrow"])
def test_a_run_as_a_table(run, to, tmp_path):
    source, dataset = run
    assert convert(source, to, tmp_path / f"run.{to}").paths == [tmp_path / f"run.{to}"]
    frame = READERS[to](tmp_path / f"run.{to}")
    assert len(frame) == dataset.sizes["t"]
    for name in ("t_s", "rho", "theta_rad", "u_w2_rad_per_s", "mu_m2"):
        source_name = {"t_s": "t", "theta_rad": "theta", "u_w2_rad_per_s": "u_w2", "mu_m2": "mu"}.get(name, name)
        np.testing.assert_array_equal(frame[name], dataset[source_name])


@pytest.mark.parametrize("to", ["parquet", "arrow"])
def test_units_are_in_the_metadata_of_columns(run, to, tmp_path):
    source, dataset = run
    convert(source, to, tmp_path / f"run.{to}")
    schema = (
        parquet.read_schema(tmp_path / "run.parquet")
        if to == "parquet"
        else ipc.open_file(tmp_path / "run.arrow").schema
    )
    assert schema.field("theta_rad").metadata[b"units"] == b"rad"
    assert schema.metadata[b"model_hash"].decode() == dataset.attrs["model_hash"]


@pytest.mark.parametrize("to", ["csv", "parquet", "arrow"])
def test_a_batch_as_two_tables(batch, to, tmp_path):
    source, dataset = batch
    table, series = convert(source, to, tmp_path / f"runs.{to}").paths
    runs, samples = (READERS[to](path) for path in (table, series))
    assert (len(runs), len(samples)) == (5, 5 * dataset.sizes["t"])
    np.testing.assert_array_equal(runs["theta_0_rad"], dataset["theta_0"])
    np.testing.assert_array_equal(runs["final_theta_rad"], dataset["final"].sel(state="theta"))
    np.testing.assert_array_equal(samples.query("run == 3")["theta_rad"], dataset["theta"][3])


def test_units_of_a_batch_need_no_installed_model(batch):
    """As of a craft that `mehvar.build` made."""
    _, dataset = batch
    columns = conversion._row_per_run(dataset.assign_attrs(model="elsewhere"))
    assert columns["final_theta"].unit == "rad"


class StopError(Exception):
    """Ends a batch after a block."""


@pytest.fixture(scope="module")
def part(tmp_path_factory):
    path = tmp_path_factory.mktemp("part") / "runs.zarr"

    def report(runs, *_):
        if runs == 2:
            raise StopError

    campaign = Campaign("path", 5, save_every=1.0, options={"t_end": 2.0})
    with pytest.raises(StopError):
        run_batch(mehvar.load("triangle"), campaign, path, chunk=2, report=report)
    return path


@pytest.mark.parametrize("to", ["csv", "parquet", "netcdf", "mat"])
def test_runs_that_were_not_made_are_left_out_and_counted(part, to, tmp_path):
    conversion = convert(part, to, tmp_path / f"runs{ENDINGS[to]}")
    assert conversion.note == "2 of 5 runs are stored; the others are left out"
    if to in READERS:
        runs, samples = (READERS[to](path) for path in conversion.paths)
        assert (list(runs["run"]), len(samples)) == ([0, 1], 2 * 3)
    elif to == "mat":
        assert loadmat(conversion.paths[0])["status"].ravel().tolist() == [0, 0]
    else:
        with xarray.open_dataset(conversion.paths[0], engine="h5netcdf", decode_timedelta=False) as whole:
            assert (whole["run"].values.tolist(), whole["status"].values.tolist()) == ([0, 1], [0, 0])


def test_a_batch_whole(batch, tmp_path):
    source, dataset = batch
    convert(source, "netcdf", tmp_path / "runs.nc")
    convert(source, "mat", tmp_path / "runs.mat")
    with xarray.open_dataset(tmp_path / "runs.nc", engine="h5netcdf", decode_timedelta=False) as whole:
        for name in dataset.data_vars:
            np.testing.assert_array_equal(whole[name], dataset[name])
    np.testing.assert_array_equal(loadmat(tmp_path / "runs.mat")["final"], dataset["final"])


@pytest.mark.parametrize(
    ("source", "to", "out", "message"),
    [
        ("run", "xls", "x.xls", "to = 'xls': must be one of parquet"),
        ("run", "csv", "x.parquet", "a file name that ends in .csv"),
        ("nothing.nc", "csv", "x.csv", "no result file"),
        ("nothing.nc", "csv", "", "a file name that ends in .csv"),
    ],
)
def test_what_cannot_be_is_refused(run, source, to, out, message, tmp_path):
    given_source = run[0] if source == "run" else tmp_path / source
    with pytest.raises(InputError, match=message):
        convert(given_source, to, tmp_path / out)
    assert not list(tmp_path.iterdir())


def test_matlabs_two_versions_hold_the_same(run, batch, tmp_path):
    """By h5py, MATLAB's matrices being transposed there; mat73 and hdf5storage read the same."""
    for (source, _), name in ((run, "u_w2"), (batch, "final")):
        (old,), (new,) = (convert(source, to, tmp_path / f"{to}.mat").paths for to in ("mat", "mat73"))
        assert new.read_bytes()[:10] == b"MATLAB 7.3"
        assert new.read_bytes()[124:128] == b"\0\2IM"
        expected = loadmat(old)
        with h5py.File(new) as file:
            assert {n for n in expected if n[0] != "_"} == set(file)
            assert file[name].attrs["MATLAB_class"] == b"double"
            np.testing.assert_array_equal(file[name][:].T, expected[name])
            unit = file["units"]["theta_0" if name == "final" else "u_w2"]
            assert unit.attrs["MATLAB_class"] == b"char"
            assert bytes(unit[:].ravel().astype("u1")).decode() == ("rad" if name == "final" else "rad/s")


def test_two_gigabytes_are_too_much_for_matlab_5(run, tmp_path, monkeypatch):
    monkeypatch.setattr(formats, "_MATLAB_BYTES", 1000)
    with pytest.raises(InputError, match=r"variable = 't': must be smaller than 2 GB .* --to mat73"):
        convert(run[0], "mat", tmp_path / "run.mat")
    convert(run[0], "mat73", tmp_path / "run.mat")


@pytest.mark.parametrize("name", sorted(set(ENDINGS) - {"mat73"}))
def test_the_ending_of_a_file_stands_for_a_format(name):
    assert format_of(f"a.b/runs{ENDINGS[name]}") == name
    assert format_of(f"RUNS{ENDINGS[name].upper()}") == name


@pytest.mark.parametrize("out", ["runs", "runs.xls", ".csv", "runs.csv.gz"])
def test_another_ending_is_refused(out):
    with pytest.raises(InputError, match=rf"out = '{out}': must be a file name that ends in one of \.parquet"):
        format_of(out)


@given(st.lists(st.tuples(st.sampled_from(sorted(UNITS)), st.integers(-3, 3)), min_size=1, max_size=3))
def test_names_with_units_are_words(factors):
    unit = " ".join(name if power == 1 else f"{name}^{power}" for name, power in factors)
    assert flat_name("x", unit).isidentifier()
    assert flat_name("x", "1") == "x"


@pytest.mark.parametrize("place", ["runs.csv", "g/runs.csv", "../runs.zarr/runs.csv"])
def test_nothing_is_written_into_a_batch(batch, place):
    before = sorted(batch[0].rglob("*"))
    with pytest.raises(InputError, match="a file outside the folder of the batch"):
        convert(batch[0], "csv", batch[0] / place)
    assert sorted(batch[0].rglob("*")) == before
