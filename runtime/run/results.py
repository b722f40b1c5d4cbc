# SPDX-License-Identifier: Apache-2.0
"""Results as labelled datasets, and as NetCDF-4 files that say how they came about."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import TYPE_CHECKING

from mehvar.errors import InputError
from mehvar.manifest import Manifest
from mehvar.versions import installed

from ..files import write_atomic
from .simulate import Run

if TYPE_CHECKING:
    import xarray

_PACKAGES = ("python", "mehvar", "numpy", "scipy", "xarray", "h5netcdf", "zarr")


def to_dataset(run: Run) -> xarray.Dataset:
    """Return a run as a dataset.

    Parameters
    ----------
    run : Run
        What `simulate` returns.

    Returns
    -------
    xarray.Dataset
        Coordinate `t` in seconds; one variable per state, `u_NAME` per input, `u_cmd_NAME` per input of a
        sampled law, one per output, per number of the law's memory and per report of the law, each with `units` and
        `long_name`. The attributes hold model, law, scenario, status, effective parameters and the manifest, structured
        ones as JSON.
    """
    import xarray

    names = _descriptions(run)
    variables = {
        name: ("t", values, {"units": names[name][0], "long_name": names[name][1]})
        for name, values in run.variables().items()
    }
    time = ("t", run.t, {"units": "s", "long_name": "time"})
    return xarray.Dataset(variables, coords={"t": time}, attrs=_attributes(run))


def save(dataset: xarray.Dataset, path: str | os.PathLike[str]) -> None:
    """Write a dataset as NetCDF-4; the file is complete or absent, an old one stays until then.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result, as `to_dataset` makes it.
    path : path
        The file, in a folder that exists.

    Raises
    ------
    InputError
        If the folder of `path` does not exist, or `path` is a folder.
    OSError
        If the file cannot be written; the message names `path`.
    """
    # In memory first: HDF5 does not report every write that failed.
    write_atomic(path, bytes(dataset.to_netcdf(None, engine="h5netcdf", format="NETCDF4")))


def open_result(path: str | os.PathLike[str]) -> xarray.Dataset:
    """Read a result file whole.

    Parameters
    ----------
    path : path
        A file that `save` or `mehvar simulate --out` wrote.

    Raises
    ------
    InputError
        If there is no such file or it is not a result file.
    """
    import xarray

    if not Path(path).is_file():
        raise InputError(f"no result file {os.fspath(path)}")
    try:
        with xarray.open_dataset(path, engine="h5netcdf", decode_timedelta=False) as dataset:
            return dataset.load()
    except (OSError, ValueError, KeyError, RuntimeError) as error:
        raise InputError(f"{os.fspath(path)} is not a result file: {error}") from error


def _descriptions(run: Run) -> dict[str, tuple[str, str]]:
    """Return unit and long name of every variable."""
    manifest, inputs = run.manifest, run.manifest.inputs
    law = run.controller
    quantities = (*manifest.states, *manifest.outputs, *law.memory, *law.outputs)
    return {
        **{q.name: (q.unit, q.description) for q in quantities},
        **{f"u_{q.name}": (q.unit, f"{q.description}, applied") for q in inputs},
        **{f"u_cmd_{q.name}": (q.unit, f"{q.description}, commanded") for q in inputs},
    }


def _attributes(run: Run) -> dict[str, str | float]:
    manifest: Manifest = run.manifest
    return {
        "title": f"{manifest.title}: {run.controller.title}",
        "model": manifest.model,
        "controller": run.controller.name,
        "scenario": run.scenario.name,
        "model_hash": manifest.hash,
        "backend": run.backend,
        "status": run.status.text,
        "reason": run.reason,
        "t_stop": run.t_stop,
        "exceeded": "; ".join(run.exceeded()),
        "structure": json.dumps(manifest.structure),
        "parameters": json.dumps(run.parameters.values),
        "parameter_origins": json.dumps(run.parameters.origins),
        "options": json.dumps(run.options),
        "statistics": json.dumps(run.statistics),
        "manifest": manifest.text,
        "versions": json.dumps({**manifest.versions, **versions()}),
    }


def versions() -> dict[str, str]:
    """Return the versions of Python and of the packages that results depend on."""
    return installed(*_PACKAGES)
