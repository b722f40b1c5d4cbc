# SPDX-License-Identifier: Apache-2.0
"""Animation of the triangle that turns by changing its shape, for the report."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from mehvar.pictures import BLACK, Scene, SceneLine, ScenePanel
from mehvar.reproduction import Runs

from .chart import target_shape
from .shapes import COLLINEAR, RODS, vertices

if TYPE_CHECKING:
    from numpy.typing import NDArray

    FloatArray = NDArray[np.float64]
    from mehvar.runtime import Run

_EVERY = 0.05
"""Time between two positions of the run, s; pictures move along straight lines in between."""
_RUNS: dict[str, tuple[str, dict[str, Any]]] = {
    "path law": ("path", {}),
    "sliding law": ("sliding", {}),
    "path law, drift": ("path", {"disturbance": 0.001}),
    "sliding law, drift": ("sliding", {"disturbance": 0.001}),
}


def scene(runs: Runs) -> Scene:
    """Return the animation of both laws, without and with a drift."""
    paper = runs("path", "paper")
    shape, values = target_shape(runs.model, paper), paper.parameters.values
    target = vertices([values[f"l{k}_f"] for k in (1, 2, 3)], values["theta_f"])
    return Scene(
        {title: _series(runs(law, "paper", **settings)) for title, (law, settings) in _RUNS.items()},
        {
            "target": [[p.real, p.imag] for p in target],
            "shape": [shape.real, shape.imag],
            "R": values["R"],
            "rim": COLLINEAR,
        },
        (
            ScenePanel("rod length l [m]", _lines("l", "l<sub>{}</sub>")),
            ScenePanel("rod rate l′ [m/s]", _lines("u_l", "l<sub>{}</sub>′")),
            ScenePanel("attitude θ [rad]", (SceneLine("theta", "θ", BLACK),)),
        ),
        (2.0, 1.0, 5.0, 0.5),
    )


def _lines(prefix: str, name: str) -> tuple[SceneLine, ...]:
    return tuple(SceneLine(f"{prefix}{k}", name.format(k), color) for k, color in enumerate(RODS, 1))


def _series(run: Run) -> dict[str, FloatArray]:
    names = ("theta", "rho", "phi", "l1", "l2", "l3", "u_l1", "u_l2", "u_l3")
    every = max(1, round(_EVERY / (run.t[1] - run.t[0])))
    series = {name: run.variables()[name][::every] for name in names}
    rods = np.column_stack([series[f"l{k}"] for k in (1, 2, 3)])
    points = np.array([vertices(lengths, theta) for lengths, theta in zip(rods, series["theta"], strict=True)])
    masses = {f"{axis}{k + 1}": part[:, k] for axis, part in (("x", points.real), ("y", points.imag)) for k in range(3)}
    rho, phi = series.pop("rho"), series.pop("phi")
    return {"t": run.t[::every], **masses, "shape_x": rho * np.cos(phi), "shape_y": rho * np.sin(phi), **series}
