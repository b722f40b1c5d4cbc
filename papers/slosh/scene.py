# SPDX-License-Identifier: Apache-2.0
"""Animation of the spacecraft with its pendulums, for the report."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mehvar.pictures import Scene, SceneLine, ScenePanel
from mehvar.reproduction import Runs

from .figures import AXES, BOBS
from .rows import FULL, LAWS, REDUCED

if TYPE_CHECKING:
    from collections.abc import Mapping
    from typing import Any

    from numpy.typing import NDArray

    FloatArray = NDArray[np.float64]
    from mehvar.runtime import Run

_UNTIL = 120.0
"""Length of the animation, s: the bobs hang still after one minute, and the remaining motion is slow."""
_STATES = ("att1", "att2", "att3", "phi1", "theta1", "phi2", "theta2")
_DEGREES = 180 / np.pi


def scene(runs: Runs) -> Scene:
    """Return the animation of both laws on both plants."""
    values = runs(LAWS[0], "paper").parameters.values
    plants: dict[str, Mapping[str, Any]] = {"full model": FULL, "reduced model": REDUCED}
    return Scene(
        {
            f"{law[-2:].upper()}, {plant}": _series(runs(law, "paper", **settings))
            for plant, settings in plants.items()
            for law in LAWS
        },
        {name: values[name] for name in ("h1", "h2", "l1", "l2", "b", "d", "h0")},
        (
            ScenePanel("pendulums φ [°]", _lines(("phi1", "phi2"), "φ<sub>{}</sub>", BOBS), _DEGREES),
            ScenePanel("attitude ϑ [°]", _lines(("att1", "att2", "att3"), "ϑ<sub>{}</sub>", AXES), _DEGREES),
            ScenePanel("gimbal δ [°]", _lines(("delta1", "delta2"), "δ<sub>{}</sub>", (AXES[2], AXES[1])), _DEGREES),
        ),
        (4.0, 1.0, 10.0),
    )


def _lines(columns: tuple[str, ...], name: str, colors: tuple[str, ...]) -> tuple[SceneLine, ...]:
    return tuple(
        SceneLine(c, name.format(k), color) for k, (c, color) in enumerate(zip(columns, colors, strict=True), 1)
    )


def _series(run: Run) -> dict[str, FloatArray]:
    part, series = run.t <= _UNTIL, run.variables()
    gimbals = {name: series[f"u_{name}"][part] for name in ("delta1", "delta2")}
    gravity = {name: series[name][part] for name in ("ax", "ay", "az")}
    return {"t": run.t[part], **{name: series[name][part] for name in _STATES}, **gimbals, **gravity}
