# SPDX-License-Identifier: Apache-2.0
"""The picture of any run: for any number of pendulums and any chart of the attitude."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import cycle
from typing import TYPE_CHECKING

import numpy as np

from mehvar.pictures import COLORS, headline, new_figure, time_axis

from .figures import AXES

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from mehvar.runtime import Manifest


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
class _CraftPanel:
    """Variables of one unit: meaning, unit shown, and name, symbol, colour and line of each."""

    meaning: str
    unit: str
    variables: Sequence[tuple[str, str, str, str]]


def _panels(dataset: xr.Dataset) -> list[_CraftPanel]:
    names = [str(name) for name in dataset.data_vars]
    count = sum(name.startswith("phi") and name[3:].isdigit() for name in names)
    lines = zip(range(1, count + 1), cycle(COLORS), cycle(("-", "--")))
    bobs = [(str(k), color, line) for k, color, line in lines]
    x, y, z = AXES
    return [
        _CraftPanel("velocity", "m/s", [("vx", "$v_x$", x, "-")]),
        _CraftPanel("velocity", "m/s", [("vy", "$v_y$", y, "-"), ("vz", "$v_z$", z, "-")]),
        _CraftPanel("attitude", "°", [(f"att{k}", rf"$\vartheta_{k}$", AXES[k - 1], "-") for k in (1, 2, 3)]),
        _CraftPanel("lateral thrust", "1", [("lateral", r"$f_\perp/F$", x, "-")]),
        _CraftPanel("pendulums", "°", [(f"phi{k}", rf"$\varphi_{{{k}}}$", color, line) for k, color, line in bobs]),
        _CraftPanel("azimuth", "°", [(f"theta{k}", rf"$\theta_{{{k}}}$", color, line) for k, color, line in bobs]),
        _CraftPanel("moment", "N m", [(f"u_M{k}", f"$M_{k}$", c, "-") for k, c in zip("xyz", AXES, strict=True)]),
        _CraftPanel("gimbal", "°", [("u_delta1", r"$\delta_1$", z, "-"), ("u_delta2", r"$\delta_2$", y, "-")]),
    ]


_MOST_NAMED = 6
"""Entries of a legend: two rows of three, which hide little of a panel this low."""


def _draw(ax: Axes, dataset: xr.Dataset, panel: _CraftPanel, last: bool) -> None:
    """Draw a panel; angles are in radians in the dataset."""
    for k, (name, symbol, color, line) in enumerate(panel.variables):
        values = np.degrees(dataset[name].values) if panel.unit == "°" else dataset[name].values
        ax.plot(dataset["t"].values, values, line, color=color, lw=1.2, label=symbol if k < _MOST_NAMED else None)
    only = panel.variables[0][1] + " " if len(panel.variables) == 1 else ""
    time_axis(ax, f"{panel.meaning} {only}[{panel.unit}]", last, zero=panel.variables[0][0] != "vx")
    if not only:
        ax.legend(loc="upper right", ncols=3)
