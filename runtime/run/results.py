# SPDX-License-Identifier: Apache-2.0
"""Conversion of results to labelled datasets with their origin."""

from __future__ import annotations

import functools
import json
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from mehvar.base import cache
from mehvar.base.errors import InputError
from mehvar.base.manifest import Controller, Manifest, Metric
from mehvar.base.versions import installed

from .metrics import early_end, evaluate, metrics_of, undetermined
from .options import AUTO
from .simulate import Run

if TYPE_CHECKING:
    import xarray

_PACKAGES = ("python", "mehvar", "numpy", "scipy", "xarray", "h5netcdf", "zarr")


def to_dataset(run: Run) -> xarray.Dataset:
    """Return a run as a dataset.

    Parameters
    ----------
    run : Run
        Result of `simulate`.

    Returns
    -------
    xarray.Dataset
        Coordinate `t` in seconds; one variable per state, `u_NAME` per input, `u_cmd_NAME` per input of a
        sampled law, one per output, per number of the law's memory and per report of the law; one number per metric of
        the model. Each has `units` and `long_name`; a metric without a number also has a `note`. Attributes hold
        model, law, scenario, status, effective parameters and the manifest, structured ones as JSON.
    """
    manifest, about, series = run.manifest, _descriptions(run.manifest, run.controller), run.variables()
    known = metrics_of(manifest, run.controller.name, series)
    notes = _notes(run, known)
    numbers = {name: attributes_of(metric, notes.get(name)) for name, metric in known.items()}
    twice = [name for name in ("t", *numbers) if name in series]
    if twice:
        raise InputError(f"a result cannot hold two variables called {twice[0]}: rename one in {manifest.model}")
    form = _form(run.t.tobytes(), _texts({name: about[name] for name in series}), _texts(numbers))
    counts = Counter(name for _, name in run.events)
    values = {name: evaluate(metric, run.t, series, counts, early_end(run)) for name, metric in known.items()}
    dataset = form.copy(data={**series, **values})
    dataset.attrs = _attributes(run)
    return dataset


_Texts = tuple[tuple[str, tuple[tuple[str, str], ...]], ...]
"""Names and their attributes as one hashable value."""


def _texts(attributes: Mapping[str, Mapping[str, str]]) -> _Texts:
    return tuple((name, tuple(about.items())) for name, about in attributes.items())


@functools.lru_cache(maxsize=8)  # for several models at once; aligning 50 variables with their index costs 1 ms
def _form(instants: bytes, series: _Texts, numbers: _Texts) -> xarray.Dataset:
    """Return a result without numbers, which runs of a law at equal instants share."""
    import xarray

    t = np.frombuffer(instants)
    columns = {name: ("t", np.empty_like(t), dict(about)) for name, about in series}
    scalars = {name: ((), np.nan, dict(about)) for name, about in numbers}
    return xarray.Dataset({**columns, **scalars}, coords={"t": ("t", t, {"units": "s", "long_name": "time"})})


def notes_of(run: Run) -> dict[str, str]:
    """Return the reason for each undetermined metric of a run."""
    return _notes(run, metrics_of(run.manifest, run.controller.name, run.variables()))


def _notes(run: Run, known: Mapping[str, Metric]) -> dict[str, str]:
    return undetermined(known, run.t_stop, float(run.options["dt_out"]), early_end(run))


def attributes_of(metric: Metric, note: str | None) -> dict[str, str]:
    """Return a metric's attributes in a result, with a note if it has no value."""
    about = {"units": metric.unit, "long_name": metric.description}
    return about if note is None else {**about, "note": note}


def hidden_names(manifest: Manifest) -> list[str]:
    """Return the result names that are also attributes of `xarray.Dataset`.

    `run.NAME` is then the attribute; `run["NAME"]` is always the variable.
    """
    names = {name for law in manifest.controllers.values() for name in _descriptions(manifest, law)}
    return sorted((names | manifest.metrics.keys()) & _dataset_attributes())


def _dataset_attributes() -> set[str]:
    """Return the attributes of `xarray.Dataset` from the cache, because importing xarray takes half a second."""

    def fill(folder: Path) -> None:
        import xarray

        (folder / "attributes.json").write_text(json.dumps(dir(xarray.Dataset)), encoding="utf-8")

    folder = cache.entry("dataset", f"xarray-{installed('xarray')['xarray']}", fill)
    return set(json.loads((folder / "attributes.json").read_text(encoding="utf-8")))


def _descriptions(manifest: Manifest, law: Controller) -> dict[str, dict[str, str]]:
    """Return unit and description of each series."""
    quantities = (*manifest.states, *manifest.outputs, *law.memory, *law.outputs)
    texts = [
        *((q.name, q.unit, q.description) for q in quantities),
        *((f"u_{q.name}", q.unit, f"{q.description}, applied") for q in manifest.inputs),
        *((f"u_cmd_{q.name}", q.unit, f"{q.description}, commanded") for q in manifest.inputs),
    ]
    return {name: {"units": unit, "long_name": text} for name, unit, text in texts}


def _attributes(run: Run) -> dict[str, str | float]:
    """Return the attributes of a result, which suffice to repeat the run."""
    manifest: Manifest = run.manifest
    instants, names = zip(*run.events, strict=True) if run.events else ((), ())
    events = {"events": json.dumps({"t": instants, "name": names})} if run.possible_events else {}
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
        "advice": "; ".join(run.advice),
        "structure": json.dumps(manifest.structure),
        "parameters": json.dumps(run.parameters.values),
        "parameter_origins": json.dumps(run.parameters.origins),
        "initial": json.dumps({q.name: float(v) for q, v in zip(manifest.states, run.x[0], strict=True)}),
        "options": json.dumps(run.options),
        "changed": json.dumps(run.changed),
        **({"method": run.method, "t_stiff": run.t_stiff} if run.options["method"] == AUTO else {}),
        "statistics": json.dumps(run.statistics),
        **events,
        "manifest": manifest.text,
        "versions": json.dumps({**manifest.versions, **versions()}),
    }


@functools.cache
def versions() -> dict[str, str]:
    """Return the versions of Python and of packages that affect results."""
    return installed(*_PACKAGES)
