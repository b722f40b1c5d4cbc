# SPDX-License-Identifier: Apache-2.0
"""The satellite that follows its reference: what the report's animation shows, and what its batch asks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from mehvar.papers.satellite.figures import COLORS
from mehvar.papers.satellite.rows import AXES
from mehvar.papers.study import Line, Panel, Runs, Scene, Study
from mehvar.pictures.plots import BLACK, GREY

if TYPE_CHECKING:
    from mehvar.papers.study import FloatArray
    from mehvar.runtime.run.simulate import Run

_DEGREES = 180 / np.pi
_SYMBOLS = ("φ", "θ", "ψ")
_RUNS: dict[str, tuple[str, dict[str, Any]]] = {
    "adaptive law": ("mrac", {}),
    "PD": ("pd", {}),
    "adaptive law, delay": ("mrac", {"delay": 1}),
    "PD, delay": ("pd", {"delay": 1}),
}

STUDY = Study(
    "Does the satellite still follow its reference in flight (limited wheels, disturbances, noise) when its inertia is "
    "known to ten percent only and it starts turned away? Success: the RMS error of each axis is below 0.1 degrees "
    "from 200 s on.",
    laws={"mrac": "adaptive law", "pd": "PD"},
    runs=1000,
    vary={
        "I_x": "normal(2.13, 0.213)",
        "I_y": "normal(3.04, 0.304)",
        "I_z": "normal(3.09, 0.309)",
        "roll_0_deg": "uniform(-15, 15)",
        "pitch_0_deg": "uniform(-15, 15)",
        "yaw_0_deg": "uniform(-15, 15)",
    },
    success=" and ".join(f"rms_{axis} < 0.0017453" for axis in AXES),
    bands={"roll": ("roll φ [°]", _DEGREES), "yaw": ("yaw ψ [°]", _DEGREES)},
    every=4.0,
    scenario="flight",
)


def scene(runs: Runs) -> Scene:
    """Return the animation of the adaptive law and of PD, without and with the delay."""
    return Scene(
        "A satellite after its reference",
        "Solid: the satellite, with its body axes. Wire frame: where the reference model wants it. The adaptive law "
        "lies on top of it; PD with the paper's gains swings around it and never settles. x flies ahead, z points at "
        "the Earth. Drag the picture to look from another side.",
        {title: _series(runs(law, "paper", **settings)) for title, (law, settings) in _RUNS.items()},
        {},
        tuple(_panel(k, axis) for k, axis in enumerate(AXES)),
        (20.0, 5.0, 50.0),
    )


def _panel(k: int, axis: str) -> Panel:
    lines = (
        Line(f"ref_{axis}", "reference", GREY),
        Line(axis, axis, COLORS[k]),
        Line(f"ym_{axis}", "reference model", BLACK, dash=True),
    )
    return Panel(f"{axis} {_SYMBOLS[k]} [°]", lines, _DEGREES)


def _series(run: Run) -> dict[str, FloatArray]:
    series = run.variables()
    names = [f"{prefix}{axis}" for prefix in ("", "ym_", "ref_") for axis in AXES]
    return {"t": run.t, **{name: series[name] for name in names}}
