# SPDX-License-Identifier: Apache-2.0
"""The paper on a spacecraft with sloshing fuel: its diagrams, and the picture of any run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import cycle
from typing import TYPE_CHECKING

import numpy as np

from mehvar.papers.slosh.claims import claims
from mehvar.papers.slosh.figures import AXES, attitude, gimbals, laws, moments, pendulums, thrust, velocities
from mehvar.papers.slosh.scene import STUDY, scene
from mehvar.papers.slosh.schematic import schematic
from mehvar.papers.study import PaperFigure
from mehvar.pictures.plots import COLORS, headline, new_figure, time_axis

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from mehvar.runtime.model.manifest import Manifest

__all__ = ["BOARD", "CITATION", "READINGS", "STUDY", "claims", "figures", "picture", "scene"]

BOARD: str | None = None

CITATION = (
    "M. Navabi, A. Davoodi: Modeling of fuel sloshing in a spacecraft and control it by active control method using "
    "nonlinear control (in Persian), Modares Mechanical Engineering 19(9), 2019, 2121-2128."
)
READINGS = (
    "Every equation was derived again from the energy (5), the dissipation (8) and the balances (1) to (3). The text "
    "that could be had is garbled and its pictures are missing, so they are drawn anew. Equations (12) to (16), (25) "
    "and (26) are abbreviated or misprinted there, the damping of (15), (25) and (26) with the wrong sign; (31), (32), "
    "(34) and (35) lack a minus sign (claim 11).",
    "The paper counts drawings (1 and 2) and diagrams (1 to 8) apart. Figures 1 to 8 here are its diagrams, figure 9 "
    "its two drawings, figure 10 is ours.",
    "Taken as printed: the masses, I1, I2, F, h0, l2, eps2, r1, r2, r4, r6, r8, r9, r10 and the initial state.",
    "Assumed: h1, h2, b, d, l1 and eps1 (decimal strokes were lost), J and I0 (missing), r3, r5, r7 (printed 1e-5, "
    "claim 13), w1 to w5 (exponents lost). Each is marked in the table of mehvar show slosh, with the reason.",
    "The paper closes the loop over the reduced model (20)-(26), whose a_x is constant, and computes moments and "
    "gimbal angles afterwards. Here the laws also steer the full model (9)-(16) by them: the coloured lines.",
    "The expected numbers were computed beforehand by an independent program from the corrected equations: every "
    "number of claims R1 to R6 within 1 %.",
)
_READING = "The paper's picture is lost; this is its run, computed anew."


def figures() -> list[PaperFigure]:
    """Return the eight diagrams of the paper, its drawings and a figure of ours."""
    return [
        PaperFigure(
            1,
            "Velocity of the tank's centre",
            "Law V1. Turning the craft by five degrees at 3000 m/s gives the body axes a lateral velocity of more than "
            "100 m/s, which is then taken down with a time constant of 125 s. The reduced model differs in v_x only: "
            f"there the thrust that goes sideways is not missing ahead. {_READING}",
            velocities,
            claims=("1", "5", "7", "R1", "R3"),
        ),
        PaperFigure(
            2,
            "Attitude",
            f"Law V1. Weights and gains of the law make a time constant of 40 s, in both models alike. {_READING}",
            attitude,
            claims=("2", "5", "13"),
        ),
        PaperFigure(
            3,
            "Angle of the pendulums from the x axis",
            "Law V1. After the first swings the bobs hang in the direction of the apparent gravity, which the lateral "
            "acceleration turns away from the x axis by up to 38 degrees; phi goes to zero as slowly as the velocities "
            f"do. A negative phi is the same place as a positive one with theta turned by 180 degrees. {_READING}",
            lambda runs: pendulums(runs, "phi", "varphi", (700.0, 700.0)),
            claims=("3", "12"),
        ),
        PaperFigure(
            4,
            "Azimuth of the pendulums",
            "Law V1. Both bobs turn into the direction of the lateral acceleration within a minute. That theta_1 takes "
            f"much longer than theta_2 is not reproduced (claim 8). {_READING}",
            lambda runs: pendulums(runs, "theta", "theta", (700.0, 100.0)),
            claims=("4", "8"),
        ),
        PaperFigure(
            5,
            "Moments",
            "Law V1. They depend on the inertia of the hull, which the paper does not give. The rates answer the law "
            "within a twentieth of a second (w3/r4 = 80 1/s): M_x is a kick at the start, which sets the craft "
            f"turning, and nearly nothing after that. {_READING}",
            moments,
            claims=("R1", "R2"),
        ),
        PaperFigure(
            6,
            "Gimbal angles",
            "Law V1. Of the thrust 62 % go sideways at 80 s. In the first second the law throws the gimbal against the "
            f"falling pendulums. {_READING}",
            gimbals,
            claims=("9", "R3", "R4"),
        ),
        PaperFigure(
            7,
            "Angle from the x axis under both laws",
            "Only V1 looks at the rates of the pendulums. Under V2 they swing twice as far in the first 20 s; after "
            f"a minute there is about a degree between the two. {_READING}",
            lambda runs: laws(runs, "phi", "varphi"),
            claims=("6", "9"),
        ),
        PaperFigure(
            8,
            "Azimuth under both laws",
            "The differences in the azimuth last about as long as those of figure 7. Where phi passes through zero the "
            f"azimuth means little. {_READING}",
            lambda runs: laws(runs, "theta", "theta"),
            claims=("6", "8"),
        ),
        PaperFigure(
            9,
            "Craft and pendulums",
            "The paper's drawings 1 and 2. The hull's centre of mass m lies ahead of the tank's centre O (b is "
            "negative), where the first pendulum is hung. phi is counted from -x; the azimuth theta from z towards y. "
            "delta_2 (not shown) turns the thrust towards y.",
            schematic,
            claims=("12", "11"),
        ),
        PaperFigure(
            10,
            "Thrust sideways and ahead",
            "Not in the paper. Left: the part of the thrust that goes sideways; 1 is all of it. Right: what is left "
            "for a_x; the reduced model takes it from nowhere. With gains ten times as large the law asks for more "
            "than the thrust: all of it goes sideways, body rates are still as demanded, and a_x falls to zero.",
            thrust,
            claims=("7",),
        ),
    ]


def picture(dataset: xr.Dataset, manifest: Manifest) -> Figure:
    """Draw a run: velocities, attitude, pendulums and inputs over time, for any number of pendulums and any chart.

    Parameters
    ----------
    dataset : xarray.Dataset
        A run of the spacecraft.
    manifest : Manifest
        The model's.

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure = new_figure(10.0, 8.4)
    figure.suptitle(headline(dataset), fontsize=10, wrap=True)
    axes = figure.subplots(4, 2, sharex=True)
    for ax, panel in zip(axes.flat, _panels(dataset), strict=True):
        _draw(ax, dataset, panel, ax in axes[-1])
    return figure


@dataclass(frozen=True)
class _Panel:
    """Variables of one unit: meaning, unit shown, and name, symbol, colour and line of each."""

    meaning: str
    unit: str
    variables: Sequence[tuple[str, str, str, str]]


def _panels(dataset: xr.Dataset) -> list[_Panel]:
    names = [str(name) for name in dataset.data_vars]
    count = sum(name.startswith("phi") and name[3:].isdigit() for name in names)
    lines = zip(range(1, count + 1), cycle(COLORS), cycle(("-", "--")))
    bobs = [(str(k), color, line) for k, color, line in lines]
    x, y, z = AXES
    return [
        _Panel("velocity", "m/s", [("vx", "$v_x$", x, "-")]),
        _Panel("velocity", "m/s", [("vy", "$v_y$", y, "-"), ("vz", "$v_z$", z, "-")]),
        _Panel("attitude", "°", [(f"att{k}", rf"$\vartheta_{k}$", AXES[k - 1], "-") for k in (1, 2, 3)]),
        _Panel("lateral thrust", "1", [("lateral", r"$f_\perp/F$", x, "-")]),
        _Panel("pendulums", "°", [(f"phi{k}", rf"$\varphi_{{{k}}}$", color, line) for k, color, line in bobs]),
        _Panel("azimuth", "°", [(f"theta{k}", rf"$\theta_{{{k}}}$", color, line) for k, color, line in bobs]),
        _Panel("moment", "N m", [(f"u_M{k}", f"$M_{k}$", c, "-") for k, c in zip("xyz", AXES, strict=True)]),
        _Panel("gimbal", "°", [("u_delta1", r"$\delta_1$", z, "-"), ("u_delta2", r"$\delta_2$", y, "-")]),
    ]


_MOST_NAMED = 6


def _draw(ax: Axes, dataset: xr.Dataset, panel: _Panel, last: bool) -> None:
    """Draw a panel; angles are in radians in the dataset."""
    for k, (name, symbol, color, line) in enumerate(panel.variables):
        values = np.degrees(dataset[name].values) if panel.unit == "°" else dataset[name].values
        ax.plot(dataset["t"].values, values, line, color=color, lw=1.2, label=symbol if k < _MOST_NAMED else None)
    only = panel.variables[0][1] + " " if len(panel.variables) == 1 else ""
    time_axis(ax, f"{panel.meaning} {only}[{panel.unit}]", last, zero=panel.variables[0][0] != "vx")
    if not only:
        ax.legend(loc="upper right", ncols=3)
