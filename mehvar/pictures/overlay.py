# SPDX-License-Identifier: Apache-2.0
"""Picture of a run in two versions, with the variables that differ: old dashed, new solid."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mehvar.base.units import pretty_unit

from .style import COLORS, GREY, label, new_figure

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

_MOST = 3
"""Largest number of panels, which fit on a screen; they show the variables with the largest change."""
_VISIBLE = 1e-3
"""Change relative to a variable's size that the width of a line hides."""


def overlay_picture(old: xr.Dataset, new: xr.Dataset, title: str) -> Figure:
    """Draw the common variables of two runs that differ, over time; call it in `style`."""
    names = _moved(old, new)[:_MOST]
    figure = new_figure(7.0, 0.8 + 1.5 * max(len(names), 1))
    figure.suptitle(title if names else f"{title}: no variable differs visibly", fontsize=10, wrap=True)
    axes = figure.subplots(max(len(names), 1), 1, sharex=True, squeeze=False)[:, 0]
    for number, (ax, name) in enumerate(zip(axes, names, strict=False)):
        ax.plot(old["t"], old[name], "--", color=GREY, label="old")
        ax.plot(new["t"], new[name], color=COLORS[0], label="new")
        ax.set_ylabel(f"{name} [{pretty_unit(new[name].attrs.get('units', '1'))}]")
        ax.margins(x=0)
        if number == 0:
            ax.legend(loc="upper right", ncols=2)
    axes[-1].set_xlabel(label("t", "time", "s"))
    return figure


def _moved(old: xr.Dataset, new: xr.Dataset) -> list[str]:
    """Return the common series, largest relative difference first."""
    moved = {}
    for name in new.data_vars:
        if name not in old or new[name].dims != ("t",) or old[name].dims != ("t",):
            continue
        count = min(old.sizes["t"], new.sizes["t"])
        before, after = old[name].values[:count], new[name].values[:count]
        size = float(np.nanmax(np.abs(np.concatenate([before, after, [1e-300]]))))
        moved[str(name)] = float(np.nanmax(np.abs(after - before), initial=0.0)) / size
    return sorted((name for name in moved if moved[name] > _VISIBLE), key=lambda name: -moved[name])
