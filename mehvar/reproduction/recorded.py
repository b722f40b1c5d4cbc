# SPDX-License-Identifier: Apache-2.0
"""Animation of a stored run by the scene of its model's paper."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from mehvar.pictures.scene import Scene
from mehvar.pictures.style import case_text
from mehvar.runtime.model.catalogue import is_installed
from mehvar.runtime.model.functions import FloatArray
from mehvar.runtime.model.model import Model, load
from mehvar.runtime.model.parameters import Resolved

from .paper import Reproduction, has_paper, load_reproduction

if TYPE_CHECKING:
    import xarray as xr

    from mehvar.base.manifest import Manifest


@dataclass(frozen=True)
class RecordedRun:
    """A stored run in the form that scenes use."""

    t: FloatArray
    series: Mapping[str, FloatArray]
    parameters: Resolved

    def variables(self) -> Mapping[str, FloatArray]:
        """Return every series by its name in the result."""
        return self.series


class _RecordedRuns:
    """Runs that return the same stored run for every loop."""

    def __init__(self, model: Model, run: RecordedRun) -> None:
        self.model = model
        self._run = run

    def __call__(self, *_: object, **__: object) -> RecordedRun:
        return self._run


def recorded_scene(dataset: xr.Dataset, manifest: Manifest) -> tuple[Reproduction, Scene] | None:
    """Return the paper of a run's model and its animation of the run.

    None if the model has no paper or is not installed in the version of the run, or if the law lacks a series of the
    paper's scene.

    Parameters
    ----------
    dataset : xarray.Dataset
        Result of `mehvar.simulate` or `mehvar.open_result`.
    manifest : Manifest
        Manifest of the run.
    """
    name = manifest.model
    if not has_paper(name) or not is_installed(name, manifest.hash):
        return None
    paper, values = load_reproduction(name), json.loads(dataset.attrs["parameters"])
    laws = [
        q for law in manifest.controllers.values() if law.name == dataset.attrs["controller"] for q in law.parameters
    ]
    groups = (manifest.parameters, laws, manifest.scenario_parameters)
    p, c, s = (np.array([values[q.name] for q in group]) for group in groups)
    series = {str(key): variable.values for key, variable in dataset.data_vars.items() if variable.dims == ("t",)}
    run = RecordedRun(dataset["t"].values, series, Resolved(p, c, s, values, {}))
    runs: Any = _RecordedRuns(load(name, "python"), run)
    try:
        scene = paper.scene(runs)
    except KeyError:
        return None
    title = f"{dataset.attrs['controller']}, {case_text(dataset.attrs)}"
    return paper, replace(scene, runs={title: next(iter(scene.runs.values()))})
