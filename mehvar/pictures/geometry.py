# SPDX-License-Identifier: Apache-2.0
"""Animation of a system with a declared geometry, from the positions of its shapes along runs."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from itertools import cycle, islice
from typing import TYPE_CHECKING

import numpy as np

from mehvar.base.manifest import Shape
from mehvar.base.schema import plain
from mehvar.base.units import pretty_unit

from .run import Panel, panels
from .scene import Scene, SceneLine, ScenePanel
from .style import COLORS

if TYPE_CHECKING:
    import xarray as xr

    from mehvar.runtime.model.model import Model

    from .scene import FloatArray

_PANELS = 3
"""Largest number of panels beside the animation; a fourth would push the controls off a laptop's screen."""
_LINES = 3
"""Largest number of signals in a panel; the legend of more would exceed the panel's height."""
_SHOWN = 15.0
"""Duration of an animation at the default speed, s. Half is too fast for a run that settles, twice is tedious."""


def geometry_scene(runs: Mapping[str, xr.Dataset], model: Model) -> Scene:
    """Return the animation of runs of a model with a declared geometry.

    Parameters
    ----------
    runs : mapping of str to xarray.Dataset
        Results of `mehvar.simulate` by title.
    model : Model
        Model with shapes.
    """
    manifest = model.manifest
    shown = panels(manifest)
    chosen = [*(p for p in shown if p.kind == "output"), *(p for p in shown if p.kind != "output")][:_PANELS]
    first = next(iter(runs.values()))
    return Scene(
        {title: _series(dataset, model, chosen) for title, dataset in runs.items()},
        {"shapes": [plain(Shape, shape) for shape in manifest.geometry]},
        tuple(map(_panel, chosen)),
        _speeds(float(first["t"].values[-1])),
    )


def _series(dataset: xr.Dataset, model: Model, chosen: list[Panel]) -> dict[str, FloatArray]:
    points = _points(dataset, model)
    names = [name for panel in chosen for name, _ in panel.variables[:_LINES]]
    columns = {f"point{k}": column for k, column in enumerate(points.T)}
    return {"t": dataset["t"].values, **columns, **{name: dataset[name].values for name in names}}


def _points(dataset: xr.Dataset, model: Model) -> FloatArray:
    """Return the coordinates of all points at every sample, shape (n, 3 points)."""
    manifest, t, values = model.manifest, dataset["t"].values, json.loads(dataset.attrs["parameters"])
    p, s = ([values[q.name] for q in group] for group in (manifest.parameters, manifest.scenario_parameters))
    x = _stacked(dataset, [q.name for q in manifest.states])
    u = _stacked(dataset, [f"u_{q.name}" for q in manifest.inputs])
    points: FloatArray = model.functions["geometry"](x, u, model.functions["reference"](t, p, s), p)
    return points


def _stacked(dataset: xr.Dataset, names: list[str]) -> FloatArray:
    columns = [np.asarray(dataset[name].values, dtype=float) for name in names]
    return np.stack(columns, axis=-1) if columns else np.zeros((dataset.sizes["t"], 0))


def _panel(panel: Panel) -> ScenePanel:
    colors = islice(cycle(COLORS), _LINES)
    lines = tuple(SceneLine(name, name, color) for (name, _), color in zip(panel.variables, colors, strict=False))
    unit = "" if panel.unit == "1" else f" [{pretty_unit(panel.unit)}]"
    return ScenePanel(f"{panel.kind}{unit}", lines)


def _speeds(duration: float) -> tuple[float, ...]:
    """Return the available speeds, of which the first shows the run in the default duration."""
    fast = duration / _SHOWN
    power = 10.0 ** math.floor(math.log10(fast)) if fast > 0 else 1.0
    speed = power * max((digit for digit in (1, 2, 5) if digit * power <= fast), default=1)
    return speed, speed / 5, speed * 5
