# SPDX-License-Identifier: Apache-2.0
"""Conversion of results and batches to the formats of other programs."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mehvar.base.errors import InputError, bad_value
from mehvar.runtime.batch.store.layout import NOT_RUN, STATUS
from mehvar.runtime.files import check_file, checked_ending, write_atomic
from mehvar.runtime.run.formats import checked_format, columnar, matlab5, matlab_values, open_result, save

from .attitude import attitude, kernel, message
from .matlab import matlab73
from .messages import ORIGIN
from .orbit import orbit_message

if TYPE_CHECKING:
    import pyarrow
    import xarray

ENDINGS = {
    "parquet": ".parquet", "arrow": ".arrow", "netcdf": ".nc", "csv": ".csv", "mat": ".mat", "mat73": ".mat",
    "aem": ".aem", "oem": ".oem", "ck": ".bc",
}  # fmt: skip
"""File endings by the format name of `--to`. An ending that two formats share selects the first."""
_MATLAB = {"mat": matlab5, "mat73": matlab73}
_MESSAGES: Mapping[str, Callable[[xarray.Dataset, Mapping[str, str]], bytes]] = {
    "aem": lambda run, about: message(attitude(run, "aem", about)),
    "oem": orbit_message,
    "ck": lambda run, about: kernel(attitude(run, "ck", about)),
}


@dataclass(frozen=True)
class Column:
    """A column of a flat table: values, unit, and a line of description."""

    values: NDArray[Any]
    unit: str
    description: str


@dataclass(frozen=True)
class Conversion:
    """Files of a conversion, and a note about missing runs, which may be empty."""

    paths: list[Path]
    note: str = ""


def flat_name(name: str, unit: str) -> str:
    """Return a column name with its unit, such as "wx_rad_per_s"; the unit 1 is omitted."""
    if unit in ("", "1"):
        return name
    above, *below = unit.split("/")
    words = [word for word in (above.replace("^-", "^m"), *(f"per_{part}" for part in below)) if word != "1"]
    return f"{name}_{re.sub(r'[^A-Za-z0-9]+', '_', '_'.join(words).replace('^', '')).strip('_')}"


def format_of(out: str | os.PathLike[str]) -> str:
    """Return the format of a file name's ending.

    Raises
    ------
    InputError
        For another ending.
    """
    ending = Path(out).suffix.lower()
    for name, own in ENDINGS.items():
        if own == ending:
            return name
    allowed = ", ".join(dict.fromkeys(ENDINGS.values()))
    raise bad_value("out", os.fspath(out), f"a file name that ends in one of {allowed}")


def convert(
    source: str | os.PathLike[str],
    to: str,
    out: str | os.PathLike[str],
    about: Mapping[str, str] | None = None,
) -> Conversion:
    """Write a result or a batch in another format.

    In the flat formats `parquet`, `arrow` and `csv` a batch is a table with a row per run. Its series, if any, are a
    second file with the suffix `_series` and a row per run and sample. Columns have names `NAME_UNIT`; Parquet and
    Arrow also store unit and description as metadata. Missing runs of an unfinished batch are omitted.

    Parameters
    ----------
    source : path
        A result file (`.nc`) or the folder of a batch.
    to : str
        "parquet", "arrow", "netcdf", "csv", "mat" (version 5 of MATLAB) or "mat73" (7.3, for arrays of 2 GB and more);
        of a run's attitude "aem" (CCSDS) or "ck" (SPICE), of its orbit "oem" (CCSDS).
    out : path
        The file to write.
    about : mapping of str to str, optional
        For an attitude or orbit, its variables, frames and epoch, by the names in `attitude.NAMES` and `orbit.NAMES`.

    Returns
    -------
    Conversion
        The written files, and the number of runs if the batch is unfinished.

    Raises
    ------
    InputError
        If a name is unknown, the source is no result or batch or has no run, or a package is missing.
    OSError
        If a file cannot be written.
    """
    if to not in ENDINGS:
        raise bad_value("to", to, f"one of {', '.join(ENDINGS)}")
    target = Path(out)
    checked_ending("out", target, [ENDINGS[to]])
    if about and to not in _MESSAGES:
        raise bad_value("to", to, f"one of {', '.join(_MESSAGES)} with {ORIGIN}")
    if to not in _MESSAGES:
        checked_format(target)
    if Path(source).resolve() in target.resolve().parents:
        raise bad_value("out", os.fspath(out), f"a file outside the folder of the batch, {os.fspath(source)}")
    check_file(target)
    if not os.path.isdir(source):  # noqa: PTH112 - pathlib raises for a name that is too long
        result = open_result(source)
        if to in _MESSAGES:
            write_atomic(target, _MESSAGES[to](result, about or {}))
        elif to in _MATLAB:
            write_atomic(target, _MATLAB[to](matlab_values(result)))
        elif to == "netcdf":
            save(result, target)
        else:
            _write_table(target, _series_of_a_run(result), result)
        return Conversion([target])
    from mehvar.runtime.batch.store.store import open_store

    if to in _MESSAGES:
        raise bad_value("source", os.fspath(source), f"a result (.nc) of one run for {to}, not a batch")
    dataset, note = _stored(open_store(source).dataset().load())
    if to in ("netcdf", *_MATLAB):
        write_atomic(target, _netcdf(dataset) if to == "netcdf" else _MATLAB[to](_matlab_values(dataset)))
        return Conversion([target], note)
    _write_table(target, _row_per_run(dataset), dataset)
    series = _row_per_sample(dataset)
    if not series:
        return Conversion([target], note)
    beside = target.with_name(f"{target.stem}_series{target.suffix}")
    _write_table(beside, series, dataset)
    return Conversion([target, beside], note)


def _stored(dataset: xarray.Dataset) -> tuple[xarray.Dataset, str]:
    """Return the completed runs of a batch by number, and a note about missing ones."""
    planned = dataset.sizes["run"]
    stored = np.flatnonzero(dataset[STATUS].values != NOT_RUN)
    if not stored.size:
        raise InputError("this batch has no stored run yet")
    note = f"{stored.size} of {planned} runs are stored; the others are left out" if stored.size < planned else ""
    numbers = {"run": ("run", np.arange(planned), {"long_name": "number of the run"})}
    return dataset.assign_coords(numbers).isel(run=stored), note


def _series_of_a_run(result: xarray.Dataset) -> dict[str, Column]:
    along = {"t": result["t"], **{str(n): a for n, a in result.data_vars.items() if a.dims == ("t",)}}
    return {name: _column(array) for name, array in along.items()}


def _row_per_run(dataset: xarray.Dataset) -> dict[str, Column]:
    """Return columns with a row per run; a summary per state, variable or event becomes a column for each."""
    units = _units(dataset)
    columns = {"run": _column(dataset["run"])}
    for name, array in dataset.data_vars.items():
        if array.dims == ("run",):
            columns[str(name)] = _column(array)
        elif array.ndim == 2 and array.dims[1] in ("state", "variable", "event"):
            for k, what in enumerate(array[array.dims[1]].values.tolist()):
                text = f"{array.attrs.get('long_name', name)}: {what}"
                columns[f"{name}_{what}"] = Column(array.values[:, k], units.get(what, "1"), text)
    return columns


def _row_per_sample(dataset: xarray.Dataset) -> dict[str, Column]:
    """Return columns with a row per run and instant; none if the store has no series."""
    series = {str(name): array for name, array in dataset.data_vars.items() if array.dims == ("run", "t")}
    if not series:
        return {}
    runs, samples = dataset["run"], dataset["t"]
    head = {
        "run": Column(np.repeat(runs.values, samples.size), "1", runs.attrs["long_name"]),
        "t": Column(np.tile(samples.values, runs.size), "s", "time"),
    }
    return head | {
        name: Column(array.values.ravel(), array.attrs.get("units", "1"), array.attrs.get("long_name", name))
        for name, array in series.items()
    }


def _column(array: xarray.DataArray) -> Column:
    return Column(array.values, array.attrs.get("units", "1"), array.attrs.get("long_name", str(array.name)))


def _units(dataset: xarray.Dataset) -> dict[str, str]:
    """Return the unit of each summarised variable."""
    variables = dataset["variable"]
    return dict(zip(variables.values.tolist(), variables.attrs["units"], strict=True))


def _write_table(path: Path, columns: Mapping[str, Column], dataset: xarray.Dataset) -> None:
    named = {flat_name(name, column.unit): column for name, column in columns.items()}
    if len(named) < len(columns):
        raise InputError(f"{path}: two columns would have the same name; use netcdf or mat")
    ending = path.suffix.lower()
    write_atomic(path, _csv(named) if ending == ".csv" else columnar(_table(named, dataset), ending))


def _csv(columns: Mapping[str, Column]) -> bytes:
    import xarray

    frame = xarray.Dataset({name: ("row", column.values) for name, column in columns.items()}).to_dataframe()
    return bytes(frame.to_csv(index=False, lineterminator="\n").encode())


def _table(columns: Mapping[str, Column], dataset: xarray.Dataset) -> pyarrow.Table:
    """Return columns as an Arrow table, with units and descriptions in the schema."""
    import pyarrow

    arrays = [pyarrow.array(np.ascontiguousarray(column.values)) for column in columns.values()]
    fields = [
        pyarrow.field(name, array.type, metadata={"units": column.unit, "long_name": column.description})
        for (name, column), array in zip(columns.items(), arrays, strict=True)
    ]
    about = {str(name): _text(value) for name, value in dataset.attrs.items()}
    return pyarrow.table(arrays, pyarrow.schema(fields, metadata=about))


def _netcdf(dataset: xarray.Dataset) -> bytes:
    """Return a batch as a NetCDF-4 file, with names of fixed length and attributes as plain texts."""
    plain = dataset.assign_coords({n: c.astype(object) for n, c in dataset.coords.items() if c.dtype.kind not in "fiu"})
    return bytes(plain.assign_attrs({n: _text(v) for n, v in dataset.attrs.items()}).to_netcdf(engine="h5netcdf"))


def _matlab_values(dataset: xarray.Dataset) -> dict[str, Any]:
    values = {str(name): array.values for name, array in dataset.variables.items() if array.dtype.kind in "fiu"}
    units = {name: dataset[name].attrs["units"] for name in values if "units" in dataset[name].attrs}
    names = {str(n): [str(v) for v in c.values] for n, c in dataset.coords.items() if c.dtype.kind not in "fiu"}
    return {**values, "units": units, "names": names}


def _text(value: object) -> str:
    return value if isinstance(value, str) else json.dumps(value, default=str)
