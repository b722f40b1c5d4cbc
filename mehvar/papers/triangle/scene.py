# SPDX-License-Identifier: Apache-2.0
"""The triangle that turns by changing its shape: what the report's animation shows, and what its batch asks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from mehvar.papers.study import Line, Panel, Runs, Scene, Study
from mehvar.papers.triangle.chart import target_shape
from mehvar.papers.triangle.shapes import COLLINEAR, RODS, R, vertices
from mehvar.pictures.plots import BLACK

if TYPE_CHECKING:
    from mehvar.papers.study import FloatArray
    from mehvar.runtime.run.simulate import Run

_EVERY = 5
_RUNS: dict[str, tuple[str, dict[str, Any]]] = {
    "path law": ("path", {}),
    "sliding law": ("sliding", {}),
    "path law, drift": ("path", {"disturbance": 0.001}),
    "sliding law, drift": ("sliding", {"disturbance": 0.001}),
}

STUDY = Study(
    "Do the laws still turn the triangle in time when it starts from other rods and in another attitude? Success: "
    "attitude within its band after 20 s and shape within its band after 25 s.",
    laws={"path": "path law", "sliding": "sliding law"},
    runs=1000,
    vary={
        "l1_0": "normal(0.2, 0.01)",
        "l2_0": "normal(0.2, 0.01)",
        "l3_0": "normal(0.3, 0.01)",
        "theta_0": "uniform(0.5, 1.5)",
    },
    success="T_theta < 20 and T_rho < 25",
    bands={"theta": ("attitude θ [rad]", 1.0), "rho_error": ("distance to the target ρ̃ [1]", 1.0)},
    every=0.5,
    scenario="paper",
    options={"dt_out": 0.1},
)


def scene(runs: Runs) -> Scene:
    """Return the animation of both laws, without and with a drift."""
    paper = runs("path", "paper")
    target, final = target_shape(runs.model, paper), [paper.parameters.values[f"l{k}_f"] for k in (1, 2, 3)]
    place = vertices(final, paper.parameters.values["theta_f"])
    return Scene(
        "A turn without a torque",
        "Three masses and three rods that change their lengths. The angular momentum is zero at every instant, and yet "
        "the triangle turns by one radian: each loop of its shape in the disc at the right turns it by twice the area "
        "that the loop encloses. Dashed: where it is to arrive.",
        {title: _series(runs(law, "paper", **settings)) for title, (law, settings) in _RUNS.items()},
        {"target": [[p.real, p.imag] for p in place], "shape": [target.real, target.imag], "R": R, "rim": COLLINEAR},
        (
            Panel("rod length l [m]", _lines("l", "l<sub>{}</sub>")),
            Panel("rod rate l′ [m/s]", _lines("u_l", "l<sub>{}</sub>′")),
            Panel("attitude θ [rad]", (Line("theta", "θ", BLACK),)),
        ),
        (2.0, 1.0, 5.0, 0.5),
    )


def _lines(prefix: str, name: str) -> tuple[Line, ...]:
    return tuple(Line(f"{prefix}{k}", name.format(k), color) for k, color in enumerate(RODS, 1))


def _series(run: Run) -> dict[str, FloatArray]:
    names = ("theta", "rho", "phi", "l1", "l2", "l3", "u_l1", "u_l2", "u_l3")
    found = {name: run.variables()[name][::_EVERY] for name in names}
    rods = np.column_stack([found[f"l{k}"] for k in (1, 2, 3)])
    points = np.array([vertices(lengths, theta) for lengths, theta in zip(rods, found["theta"], strict=True)])
    masses = {f"{axis}{k + 1}": part[:, k] for axis, part in (("x", points.real), ("y", points.imag)) for k in range(3)}
    rho, phi = found.pop("rho"), found.pop("phi")
    return {"t": run.t[::_EVERY], **masses, "shape_x": rho * np.cos(phi), "shape_y": rho * np.sin(phi), **found}
