# SPDX-License-Identifier: Apache-2.0
"""Animation of runs of a system with a declared geometry, as data for the page's scripts."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from itertools import cycle
from typing import TYPE_CHECKING, Any

import numpy as np

from mehvar.base.manifest import Shape
from mehvar.base.schema import plain
from mehvar.base.units import pretty_unit
from mehvar.pictures.run import panels, references
from mehvar.pictures.style import COLORS

from .charts import COLOR_NAMES
from .series import FloatArray, track

if TYPE_CHECKING:
    import xarray as xr

    from mehvar.base.manifest import Manifest
    from mehvar.runtime.model.model import Model

_PANELS = 3
"""Largest number of panels beside the animation; a fourth would push the controls off a laptop's screen."""
_LINES = 3
"""Largest number of signals in a panel; the legend of more would exceed the panel's height."""
_SHOWN = 15.0
"""Duration of an animation at the default speed, s. Half is too fast for a run that settles, twice is tedious."""


def scene(
    runs: Mapping[str, xr.Dataset], model: Model, signals: Mapping[str, Sequence[str]] | None = None
) -> dict[str, Any]:
    """Return the animation of runs of a model with a declared geometry.

    Parameters
    ----------
    runs : mapping of str to xarray.Dataset
        Results of `mehvar.simulate` by title.
    model : Model
        Model with shapes.
    signals : mapping of str to sequences of str, optional
        Variables of each panel beside the animation by its title; default: outputs first, by unit.
    """
    signals, first = signals or _first_signals(model.manifest), next(iter(runs.values()))
    names = [name for several in signals.values() for name in several]
    return {
        "runs": {title: _track(dataset, model, names) for title, dataset in runs.items()},
        "shapes": [plain(Shape, shape) for shape in model.manifest.geometry],
        "panels": [_panel(title, first, several) for title, several in signals.items()],
        "speeds": _speeds(float(first["t"].values[-1])),
    }


def _first_signals(manifest: Manifest) -> dict[str, Sequence[str]]:
    """Return the first variables of the first panels, outputs before states and inputs, references left out."""
    shown = sorted(panels(manifest, references(manifest).values()), key=lambda panel: panel.kind != "output")
    names = [[name for name, _ in panel.variables[:_LINES]] for panel in shown[:_PANELS]]
    return {f"{panel.kind}s {', '.join(several)}": several for panel, several in zip(shown, names, strict=False)}


def _track(dataset: xr.Dataset, model: Model, names: Sequence[str]) -> dict[str, object]:
    columns = {f"point{k}": column for k, column in enumerate(points(dataset, model).T)}
    return track(dataset["t"].values, columns | {name: dataset[name].values for name in names})


def points(dataset: xr.Dataset, model: Model) -> FloatArray:
    """Return the coordinates of all points at every sample, shape (n, 3 points)."""
    manifest, t, values = model.manifest, dataset["t"].values, json.loads(dataset.attrs["parameters"])
    p, s = ([values[q.name] for q in group] for group in (manifest.parameters, manifest.scenario_parameters))
    x = _stacked(dataset, [q.name for q in manifest.states])
    u = _stacked(dataset, [f"u_{q.name}" for q in manifest.inputs])
    places: FloatArray = model.functions["geometry"](x, u, model.functions["reference"](t, p, s), p)
    return places


def _stacked(dataset: xr.Dataset, names: list[str]) -> FloatArray:
    columns = [np.asarray(dataset[name].values, dtype=float) for name in names]
    return np.stack(columns, axis=-1) if columns else np.zeros((dataset.sizes["t"], 0))


def _panel(title: str, dataset: xr.Dataset, names: Sequence[str]) -> dict[str, Any]:
    unit = dataset[names[0]].attrs.get("units", "1")
    colors = zip(names, cycle(COLORS), strict=False)
    return {
        "label": title if unit == "1" else f"{title} [{pretty_unit(unit)}]",
        "lines": [{"column": name, "name": name, "color": COLOR_NAMES[color]} for name, color in colors],
    }


def _speeds(duration: float) -> tuple[float, ...]:
    """Return the available speeds, of which the first shows the run in the default duration."""
    fast = duration / _SHOWN
    power = 10.0 ** math.floor(math.log10(fast)) if fast > 0 else 1.0
    speed = power * max((digit for digit in (1, 2, 5) if digit * power <= fast), default=1)
    return speed, speed / 5, speed * 5
