# SPDX-License-Identifier: Apache-2.0
"""Pictures of two versions: a run with the variables that differ, and the rates and eigenvalues that differ."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from mehvar.base.units import pretty_unit

from .style import BLUE, COLORS, GREY, ORANGE, label, new_figure

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MOST = 3
"""Largest number of panels, which fit on a screen; they show the variables with the largest change."""
_RATES = 10
"""Largest number of rates in the picture, those that differ most."""
_NARROWEST = 1e-2
"""Smallest width of an axis relative to its numbers."""
_VISIBLE = 1e-3
"""Change relative to a variable's size that the width of a line hides."""


def overlay_picture(old: xr.Dataset, new: xr.Dataset, title: str) -> Figure | None:
    """Draw the common variables of two runs that differ visibly, over time, in `style`; None without such variables."""
    names = _moved(old, new)[:_MOST]
    if not names:
        return None
    figure = new_figure(7.0, 0.8 + 1.5 * len(names))
    figure.suptitle(title, fontsize=10, wrap=True)
    axes = figure.subplots(len(names), 1, sharex=True, squeeze=False)[:, 0]
    for number, (ax, name) in enumerate(zip(axes, names, strict=True)):
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


def effects_picture(
    rates: Mapping[str, float], spectra: Sequence[tuple[str, str, Sequence[tuple[complex, complex]]]]
) -> Figure:
    """Draw what a change does to rates and eigenvalues; call it in `style`.

    Parameters
    ----------
    rates : mapping of str to float
        Largest difference of each rate relative to its size before, %.
    spectra : sequence of (str, str, pairs of complex)
        Title, unit and pairs of old and new eigenvalues, of the plant and of loops.
    """
    count = bool(rates) + len(spectra)
    figure = new_figure(3.5 * max(count, 2), 3.2)
    axes = list(figure.subplots(1, count, squeeze=False)[0])
    if rates:
        _draw_rates(axes.pop(0), dict(sorted(rates.items(), key=lambda rate: -rate[1])[:_RATES]))
    for ax, (title, unit, pairs) in zip(axes, spectra, strict=True):
        for side, (name, look) in enumerate((("old", {"marker": "o", "facecolors": "none", "edgecolors": ORANGE}),
                                             ("new", {"marker": "x", "color": BLUE}))):  # fmt: skip
            values = np.array([value for pair in pairs for value in (pair[side], pair[side].conjugate())])
            ax.scatter(values.real, values.imag, s=36, label=name, **look)
        ax.margins(0.2)
        ax.set_xlim(_widened(*ax.get_xlim()))
        ax.set_ylim(_widened(*ax.get_ylim()))
        ax.set_title(title)
        ax.set_xlabel(f"real part [{pretty_unit(unit)}]")
        ax.set_ylabel(f"imaginary part [{pretty_unit(unit)}]")
        ax.legend()
    return figure


def _widened(low: float, high: float) -> tuple[float, float]:
    """Return limits far enough apart for short numbers at the ticks."""
    middle = (low + high) / 2
    half = max(high - low, _NARROWEST * abs(middle)) / 2
    return middle - half, middle + half


def _draw_rates(ax: Axes, rates: Mapping[str, float]) -> None:
    ax.barh(list(rates), list(rates.values()), color=BLUE)
    ax.invert_yaxis()
    if max(rates.values()) > 100 * min(rates.values()):
        ax.set_xscale("log")
    ax.set_title("rates without a law")
    ax.set_xlabel("largest difference [% of the rms before]")
