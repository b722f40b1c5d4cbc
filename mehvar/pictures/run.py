# SPDX-License-Identifier: Apache-2.0
"""The picture of a run of any model: every state, input and output over time, a panel for each kind and unit."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import cycle, islice
from typing import TYPE_CHECKING

from .style import COLORS, GREY, Canvas, headline, label, new_figure, pretty_unit

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from mehvar.base.manifest import Manifest, Quantity

_LINES = ("-", "--", ":", "-.")
_MOST_NAMED = 12
"""Entries of a legend: more do not fit beside a panel of this height."""


@dataclass(frozen=True)
class Panel:
    """Variables of one kind and unit: pairs of the dataset's variable and its meaning."""

    kind: str
    unit: str
    variables: tuple[tuple[str, Quantity], ...]


def panels_picture(dataset: xr.Dataset, manifest: Manifest, canvas: Canvas = new_figure) -> Figure:
    """Draw a run, with its settling times marked; call it in `mehvar.pictures.style.style`."""
    groups = panels(manifest)
    columns = 1 if len(groups) <= 4 else 2
    rows = -(-len(groups) // columns)
    figure = canvas(7.0 * columns, 0.6 + 1.9 * rows)
    figure.suptitle(headline(dataset), fontsize=10, wrap=True)
    grid = figure.subplots(rows, columns, sharex=True, squeeze=False)
    axes: list[Axes] = list(grid.T.flat)
    for panel, ax in zip(groups, axes, strict=False):
        _draw(ax, dataset, panel)
        _mark(ax, dataset, panel, manifest)
        ax.set_xlabel(label("t", "time", "s"))
        ax.tick_params(labelbottom=True)
    for ax in axes[len(groups) :]:
        ax.remove()
    return figure


def panels(manifest: Manifest) -> list[Panel]:
    """Return the variables of a run in panels, one for each kind and unit."""
    kinds: tuple[tuple[str, str, Sequence[Quantity]], ...] = (
        ("state", "", manifest.states),
        ("input", "u_", manifest.inputs),
        ("output", "", manifest.outputs),
    )
    return [
        Panel(kind, unit, tuple((prefix + q.name, q) for q in quantities if q.unit == unit))
        for kind, prefix, quantities in kinds
        for unit in dict.fromkeys(q.unit for q in quantities)
    ]


def _draw(ax: Axes, dataset: xr.Dataset, panel: Panel) -> None:
    t = dataset["t"].values
    for number, (variable, quantity) in enumerate(panel.variables):
        line = next(islice(cycle(_LINES), number // len(COLORS), None))
        text = textwrap.fill(f"{variable}: {quantity.description}", 34)
        named = number < _MOST_NAMED
        ax.plot(t, dataset[variable].values, line, label=text if named else None)
    ax.margins(x=0)
    if len(panel.variables) == 1:
        variable, quantity = panel.variables[0]
        ax.set_title(f"{panel.kind}: {quantity.description}")
        ax.set_ylabel(f"{variable} [{pretty_unit(panel.unit)}]")
        return
    ax.set_title(f"{panel.kind}s in {pretty_unit(panel.unit)}")
    ax.set_ylabel(f"{panel.kind}s [{pretty_unit(panel.unit)}]")
    hidden = len(panel.variables) - _MOST_NAMED
    title = f"the first {_MOST_NAMED} of {len(panel.variables)}" if hidden > 0 else None
    ax.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), borderaxespad=0.0, title=title)


def _mark(ax: Axes, dataset: xr.Dataset, panel: Panel, manifest: Manifest) -> None:
    """Draw a line at each settling time of the panel's variables."""
    names = {variable for variable, _ in panel.variables}
    for name, metric in manifest.metrics.items():
        if metric.kind.startswith("settling") and names & set(metric.of) and name in dataset:
            at = float(dataset[name])
            if math.isfinite(at):
                ax.axvline(at, color=GREY, lw=0.8, ls=(0, (4, 3)))
                ax.annotate(name, (at, 0.98), xycoords=("data", "axes fraction"), fontsize=7, color=GREY, va="top")
