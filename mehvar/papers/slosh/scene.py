# SPDX-License-Identifier: Apache-2.0
"""The spacecraft with its pendulums: what the report's animation shows, and what its batch asks."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mehvar.papers.slosh.figures import AXES, BOBS
from mehvar.papers.slosh.rows import FULL, LAWS, REDUCED
from mehvar.papers.study import Line, Panel, Runs, Scene, Study

if TYPE_CHECKING:
    from collections.abc import Mapping
    from typing import Any

    from mehvar.papers.study import FloatArray
    from mehvar.runtime.run.simulate import Run

_UNTIL = 120.0
_STATES = ("att1", "att2", "att3", "phi1", "theta1", "phi2", "theta2")
_DEGREES = 180 / np.pi

STUDY = Study(
    "Do attitude and fuel still come to rest in time when mass and damping of the fuel, thrust and the place of the "
    "bobs at the start are uncertain? Success: attitude within 0.1 degrees after 200 s, and bob 1 travels less than 70 "
    "degrees in the first 20 s.",
    laws={"lyapunov-v1": "V1", "lyapunov-v2": "V2"},
    runs=512,
    vary={
        "m1": "normal(50, 5)",
        "eps1": "lognormal(1.27, 0.3)",
        "F": "normal(2450, 50)",
        "phi1_0": "uniform(0.1, 1.0)",
        "theta1_0": "uniform(-3.1, 3.1)",
        "phi2_0": "uniform(0.1, 1.0)",
        "theta2_0": "uniform(-3.1, 3.1)",
    },
    success="t_att < 200 and travel_phi1 < 1.2217",
    bands={"phi1": ("pendulum 1, φ<sub>1</sub> [°]", _DEGREES), "vy": ("velocity v<sub>y</sub> [m/s]", 1.0)},
    every=1.0,
    scenario="paper",
    options={"dt_out": 0.5, "t_end": 250.0},
)


def scene(runs: Runs) -> Scene:
    """Return the animation of both laws on both plants."""
    values = runs(LAWS[0], "paper").parameters.values
    found: dict[str, Mapping[str, Any]] = {"full model": FULL, "reduced model": REDUCED}
    return Scene(
        "Fuel that swings",
        "Fuel in a tank moves like the two bobs. The thrust is turned to take away the lateral velocity, and the bobs "
        "follow the apparent gravity (dashed arrow). Law V1 looks at their rates and calms them within a few seconds; "
        "under V2 they swing on. Show both, and drag the picture to look from another side.",
        {
            f"{law[-2:].upper()}, {plant}": _series(runs(law, "paper", **settings))
            for plant, settings in found.items()
            for law in LAWS
        },
        {name: values[name] for name in ("h1", "h2", "l1", "l2", "b", "d", "h0")},
        (
            Panel("pendulums φ [°]", _lines(("phi1", "phi2"), "φ<sub>{}</sub>", BOBS), _DEGREES),
            Panel("attitude ϑ [°]", _lines(("att1", "att2", "att3"), "ϑ<sub>{}</sub>", AXES), _DEGREES),
            Panel("gimbal δ [°]", _lines(("delta1", "delta2"), "δ<sub>{}</sub>", (AXES[2], AXES[1])), _DEGREES),
        ),
        (4.0, 1.0, 10.0),
    )


def _lines(columns: tuple[str, ...], name: str, colors: tuple[str, ...]) -> tuple[Line, ...]:
    return tuple(Line(c, name.format(k), color) for k, (c, color) in enumerate(zip(columns, colors, strict=True), 1))


def _series(run: Run) -> dict[str, FloatArray]:
    part, series = run.t <= _UNTIL, run.variables()
    gimbals = {name: series[f"u_{name}"][part] for name in ("delta1", "delta2")}
    gravity = {name: series[name][part] for name in ("ax", "ay", "az")}
    return {"t": run.t[part], **{name: series[name][part] for name in _STATES}, **gimbals, **gravity}
