# SPDX-License-Identifier: Apache-2.0
"""Result files in NetCDF, CSV, Parquet, Arrow or MATLAB format, by the file's ending."""

from __future__ import annotations

import hashlib
import importlib.util
import io
import json
import math
import os
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mehvar.base.errors import InputError, MehvarError, bad_value

from ..files import checked_ending, write_atomic

if TYPE_CHECKING:
    import pyarrow
    import xarray

_SEAL = b"\nmehvar sha256 "
"""Mark before the hash of all bytes at the end of the file, which HDF5 does not read. The hash is checked first,
because damage can make HDF5 loop.
"""
_END = {b"\0": slice(40, 48), b"\1": slice(44, 52), b"\2": slice(28, 36), b"\3": slice(28, 36)}
"""Positions of the end-of-file address in HDF5 files, by version of the superblock."""
_MATLAB_HEADER = 116
"""Bytes of free text at the start of a MAT-file."""
_MATLAB_BYTES = 2**31
"""Size limit of a variable in version 5, in bytes."""
_MATLAB_NAME = re.compile(r"[A-Za-z]\w{0,62}", re.ASCII)
_NUMBERS = "biuf"
"""NumPy kinds of real numbers."""


def save(dataset: xarray.Dataset, path: str | os.PathLike[str]) -> None:
    """Write a result file. The file is complete or absent, and replaces an old one only when complete.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result, as `simulate` returns it.
    path : path
        The file, in an existing folder. Its ending determines the contents. `.nc`: everything, as NetCDF-4. `.csv`:
        the series, in columns `NAME [UNIT]`. `.parquet`: the series, with units, attributes and metrics as metadata.
        `.mat`: series and metrics by name, with the structures `units` and `attributes`.

    Raises
    ------
    InputError
        If the ending is unknown, a package or the folder is missing, or the format cannot store the dataset.
    OSError
        If the file cannot be written; the message names `path`.
    """
    import xarray

    suffix = checked_format(path)
    if not isinstance(dataset, xarray.Dataset):
        raise bad_value("dataset", dataset, "a result, as `simulate` or `batch` returns it", "the call")
    try:
        content = _FORMATS[suffix](dataset)  # in memory first: HDF5 does not report every failed write
    except (MehvarError, MemoryError):
        raise
    except Exception as error:  # each library has limits and exceptions of its own
        raise InputError(f"{_name(path)}: this dataset cannot be written as {suffix}: {_one_line(error)}") from error
    write_atomic(path, content)


def open_result(path: str | os.PathLike[str]) -> xarray.Dataset:
    """Read a complete result file.

    Parameters
    ----------
    path : path
        A `.nc` file that `save` or `mehvar simulate --out` wrote.

    Raises
    ------
    InputError
        If the file does not exist, or is not a result in NetCDF.
    """
    import h5py
    import xarray

    name = _name(path)
    if not os.path.isfile(path):  # noqa: PTH113 - pathlib raises for a name that is too long
        raise InputError(f"no result file {name}: give the path of a .nc file or of a batch store")
    if Path(path).suffix.lower() != ".nc":
        readers = "pandas.read_csv, pandas.read_parquet and scipy.io.loadmat read the other formats"
        raise bad_value("path", name, f"a result in NetCDF, whose name ends in .nc; {readers}")
    if not _whole(Path(path).read_bytes()):
        raise InputError(f"{name} is damaged: its bytes do not match its checksum; save the run again")
    try:
        with h5py.File(path, "r") as file:  # first: for unreadable attributes h5netcdf leaves a broken object behind
            dict(file.attrs)
        with xarray.open_dataset(path, engine="h5netcdf", decode_timedelta=False) as dataset:
            result = dataset.load()
    except Exception as error:  # for a damaged file HDF5 and its readers raise anything
        raise InputError(f"{name} is not a result file: {_one_line(error)}") from error
    if "model_hash" not in result.attrs or not {"t", "run"} & {*result.coords, *result.dims}:
        raise InputError(f"{name} is not a result file: it lacks model_hash, or it has neither a time t nor runs")
    result.attrs.pop("content_sha256", None)  # of older files
    return result


def checked_format(path: str | os.PathLike[str]) -> str:
    """Return a result file's ending in lower case; refuse unknown ones.

    Raises
    ------
    InputError
        If the ending is not a format, or the format needs a package that is not installed.
    """
    name = _name(path)
    suffix = checked_ending("result file", name, _FORMATS)
    if suffix in (".parquet", ".arrow") and importlib.util.find_spec("pyarrow") is None:
        raise InputError(f'{name}: {suffix} needs pyarrow: pip install "mehvar[parquet]"')
    return suffix


def _name(path: object) -> str:
    if not isinstance(path, str | os.PathLike):
        raise bad_value("path", path, "a path", "the call")
    return os.fspath(path)


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split()) or type(error).__name__


def _netcdf(dataset: xarray.Dataset) -> bytes:
    content = bytes(dataset.to_netcdf(None, engine="h5netcdf", format="NETCDF4"))
    return content + _SEAL + hashlib.sha256(content).digest()


def _whole(content: bytes) -> bool:
    """Return True if a file matches its hash; files of other programs have none and count as intact."""
    field = _END.get(content[8:9])
    if field is None or len(content) <= int.from_bytes(content[field], "little"):
        return True
    size = hashlib.sha256().digest_size
    return content[-size:] == hashlib.sha256(content[: -size - len(_SEAL)]).digest() and content[:-size].endswith(_SEAL)


def _csv(dataset: xarray.Dataset) -> bytes:
    series = _series(dataset)
    frame = series.to_dataframe().reset_index()
    header = [f"{name} [{series[name].attrs.get('units', '')}]".removesuffix(" []") for name in frame.columns]
    return bytes(frame.to_csv(index=False, header=header, lineterminator="\n").encode())


def _arrow_table(dataset: xarray.Dataset) -> pyarrow.Table:
    """Return series as columns with their units; attributes and metrics are metadata of the table."""
    import pyarrow

    series = _series(dataset)
    columns = _columns(series)
    fields = [
        pyarrow.field(name, pyarrow.float64(), metadata={str(key): str(text) for key, text in array.attrs.items()})
        for name, array in columns.items()
    ]
    about = {**{str(name): str(value) for name, value in dataset.attrs.items()}, "metrics": _metrics_text(dataset)}
    return pyarrow.table([array.values for array in columns.values()], pyarrow.schema(fields, metadata=about))


def columnar(table: pyarrow.Table, ending: str) -> bytes:
    """Return a table as a Parquet file; for `.arrow` as Arrow IPC, version 2 of Feather."""
    from pyarrow import ipc, parquet

    content = io.BytesIO()
    if ending == ".parquet":
        parquet.write_table(table, content)
    else:
        with ipc.new_file(content, table.schema) as writer:
            writer.write_table(table)
    return content.getvalue()


def matlab_values(dataset: xarray.Dataset) -> dict[str, Any]:
    """Return the contents of a run's MAT-file by name."""
    series = _series(dataset)
    columns = {**_columns(series), **_metrics(dataset)}
    about = {
        "units": {name: array.attrs.get("units", "") for name, array in columns.items()},
        "attributes": {str(name): value for name, value in dataset.attrs.items()},
    }
    for kind, names in (("variable", columns), ("attribute", about["attributes"])):
        for name in names:
            if not _MATLAB_NAME.fullmatch(name) or (names is columns and name in about):
                allowed = "a name for MATLAB, of up to 63 letters, digits and underscores of ASCII"
                raise bad_value(kind, name, f"{allowed}, and neither of {', '.join(about)}; take .nc")
    return {**{name: array.values for name, array in columns.items()}, **about}


def matlab5(values: Mapping[str, Any]) -> bytes:
    """Return a MAT-file of version 5; raise InputError for contents that it cannot hold."""
    from scipy.io import savemat

    for name, value in values.items():
        if getattr(value, "nbytes", 0) >= _MATLAB_BYTES:
            raise bad_value("variable", name, "smaller than 2 GB in MATLAB 5; take mehvar convert --to mat73, or .nc")
    content = io.BytesIO()
    savemat(content, dict(values), oned_as="column", long_field_names=True)
    header = b"MATLAB 5.0 MAT-file, written by mehvar".ljust(_MATLAB_HEADER)  # SciPy's contains the time of day
    return header + content.getvalue()[_MATLAB_HEADER:]


_FORMATS: Mapping[str, Callable[[xarray.Dataset], bytes]] = {
    ".nc": _netcdf,
    ".csv": _csv,
    ".parquet": lambda dataset: columnar(_arrow_table(dataset), ".parquet"),
    ".arrow": lambda dataset: columnar(_arrow_table(dataset), ".arrow"),
    ".mat": lambda dataset: matlab5(matlab_values(dataset)),
}
ENDINGS = tuple(_FORMATS)
"""Endings of result files."""


def _series(dataset: xarray.Dataset) -> xarray.Dataset:
    """Return the variables along time; raise InputError if there are others."""
    wide = [str(name) for name, array in dataset.data_vars.items() if array.dims not in ((), ("t",))]
    if wide or set(dataset.coords) != {"t"}:
        raise InputError("only a single run can be a table: save this dataset as .nc, or select one run")
    for name, array in {"t": dataset["t"], **dataset.data_vars}.items():
        if array.dtype.kind not in _NUMBERS or (name == "t" and not array.ndim):
            raise bad_value("variable", name, "real numbers along time in a table; save this dataset as .nc")
    return dataset[[name for name, array in dataset.data_vars.items() if array.ndim]]


def _columns(series: xarray.Dataset) -> dict[str, xarray.DataArray]:
    return {"t": series["t"], **{str(name): array for name, array in series.data_vars.items()}}


def _metrics(dataset: xarray.Dataset) -> dict[str, xarray.DataArray]:
    return {str(name): array for name, array in dataset.data_vars.items() if not array.ndim}


def _metrics_text(dataset: xarray.Dataset) -> str:
    """Return the metrics as JSON, with infinity and NaN as texts."""
    values = {name: (float(array), array.attrs.get("units", "")) for name, array in _metrics(dataset).items()}
    return json.dumps(
        {
            name: {"value": value if math.isfinite(value) else str(value), "units": units}
            for name, (value, units) in values.items()
        }
    )
