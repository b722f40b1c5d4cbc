# SPDX-License-Identifier: Apache-2.0
"""Animation of the satellite following its reference, for the report."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from mehvar.pictures import BLACK, GREY, Scene, SceneLine, ScenePanel
from mehvar.reproduction import Runs

from .figures import COLORS
from .rows import AXES

if TYPE_CHECKING:
    from numpy.typing import NDArray

    FloatArray = NDArray[np.float64]
    from mehvar.runtime import Run

_DEGREES = 180 / np.pi
_SYMBOLS = ("φ", "θ", "ψ")
_RUNS: dict[str, tuple[str, dict[str, Any]]] = {
    "adaptive law": ("mrac", {}),
    "PD": ("pd", {}),
    "adaptive law, delay": ("mrac", {"delay": 1}),
    "PD, delay": ("pd", {"delay": 1}),
}


def scene(runs: Runs) -> Scene:
    """Return the animation of the adaptive law and of PD, without and with the delay."""
    return Scene(
        {title: _series(runs(law, "paper", **settings)) for title, (law, settings) in _RUNS.items()},
        {},
        tuple(_panel(k, axis) for k, axis in enumerate(AXES)),
        (20.0, 5.0, 50.0),
    )


def _panel(k: int, axis: str) -> ScenePanel:
    lines = (
        SceneLine(f"ref_{axis}", "reference", GREY),
        SceneLine(axis, axis, COLORS[k]),
        SceneLine(f"ym_{axis}", "reference model", BLACK, dash=True),
    )
    return ScenePanel(f"{axis} {_SYMBOLS[k]} [°]", lines, _DEGREES)


def _series(run: Run) -> dict[str, FloatArray]:
    series = run.variables()
    names = [f"{prefix}{axis}" for prefix in ("", "ym_", "ref_") for axis in AXES]
    return {"t": run.t, **{name: series[name] for name in names}}
