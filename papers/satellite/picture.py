# SPDX-License-Identifier: Apache-2.0
"""The picture of any run of the satellite."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mehvar.pictures import headline, label, new_figure, time_axis

from .figures import (
    COLORS,
    angle,
    legend,
    torque,
)
from .rows import AXES

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from mehvar.runtime import Manifest


def picture(dataset: xr.Dataset, manifest: Manifest) -> Figure:
    """Draw a run: angles, torques, tracking errors and the wheels' momentum over time.

    Parameters
    ----------
    dataset : xarray.Dataset
        A run of the satellite.
    manifest : Manifest
        The model's.

    Returns
    -------
    matplotlib.figure.Figure
    """
    series = {str(name): dataset[name].values for name in dataset.data_vars}
    t = dataset["t"].values
    figure = new_figure(10.0, 7.6)
    figure.suptitle(headline(dataset), fontsize=10, wrap=True)
    axes = figure.subplots(4, 2, sharex=True)
    for k in range(3):
        angle(axes[k, 0], t, series, k, False)
        torque(axes[k, 1], t, series, k, False)
    for k, axis in enumerate(AXES):
        error = np.degrees(series[axis] - series[f"ym_{axis}"])
        axes[3, 0].plot(t, error, color=COLORS[k], lw=1.2)
        axes[3, 1].plot(t, series[f"h{'xyz'[k]}"], color=COLORS[k], lw=1.2)
    time_axis(axes[3, 0], label("$e$", "error", "°"))
    time_axis(axes[3, 1], label("$h$", "momentum", "N m s"))
    legend(figure, "outside lower center")
    return figure
