# SPDX-License-Identifier: Apache-2.0
"""Picture of a run: states, inputs and outputs over time, one panel per kind and unit."""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import cycle, islice
from typing import TYPE_CHECKING

import numpy as np

from mehvar.base.units import pretty_unit

from .style import COLORS, GREY, headline, label, new_figure

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from mehvar.base.manifest import Manifest, Quantity

_LINES = ("-", "--", ":", "-.")
_MOST_NAMED = 12
"""Largest number of legend entries, which fit beside a panel."""
_FLAT = 30
"""Ratio of peaks above which the smaller curve gets its own panel, because it would look like zero."""
_MARK, _MARKS = 0.12, 7
"""Height of a mark's name relative to its panel, and largest number of names below each other."""
_REFERENCE = re.compile(r"^ref_|_ref$")
"""Pattern of the prefix or suffix that distinguishes a reference from its state."""


@dataclass(frozen=True)
class Panel:
    """Variables of one kind and unit, as pairs of the dataset's variable and its meaning."""

    kind: str
    unit: str
    variables: tuple[tuple[str, Quantity], ...]


def panels_picture(dataset: xr.Dataset, manifest: Manifest) -> Figure:
    """Draw a run, with its settling times marked; call it in `mehvar.pictures.style.style`."""
    dashed = references(manifest)
    groups = [part for panel in panels(manifest, dashed.values()) for part in _by_magnitude(panel, dataset)]
    columns = 1 if len(groups) <= 4 else 2
    rows = -(-len(groups) // columns)
    figure = new_figure(7.0 * columns, 0.6 + 1.9 * rows)
    figure.suptitle(headline(dataset), fontsize=10, wrap=True)
    grid = figure.subplots(rows, columns, sharex=True, squeeze=False)
    axes: list[Axes] = list(grid.T.flat)
    for panel, ax in zip(groups, axes, strict=False):
        _draw(ax, dataset, panel, dashed)
        _mark(ax, dataset, panel, manifest)
        ax.set_xlabel(label("t", "time", "s"))
        ax.tick_params(labelbottom=True)
    for ax in axes[len(groups) :]:
        ax.remove()
    return figure


def panels(manifest: Manifest, without: Collection[Quantity] = ()) -> list[Panel]:
    """Return the variables of a run in panels, one for each kind and unit."""
    kinds: tuple[tuple[str, str, Sequence[Quantity]], ...] = (
        ("state", "", manifest.states),
        ("input", "u_", manifest.inputs),
        ("output", "", [q for q in manifest.outputs if q not in without]),
    )
    return [
        Panel(kind, unit, tuple((prefix + q.name, q) for q in quantities if q.unit == unit))
        for kind, prefix, quantities in kinds
        for unit in dict.fromkeys(q.unit for q in quantities)
    ]


def references(manifest: Manifest) -> dict[str, Quantity]:
    """Return the references among the outputs, by the name of their state."""
    states, outputs = {q.name for q in manifest.states}, {q.name: q for q in manifest.outputs}
    names = {q.name: _REFERENCE.sub("", q.name) for q in manifest.references}
    return {state: outputs[name] for name, state in names.items() if name in outputs and state in states}


def _by_magnitude(panel: Panel, dataset: xr.Dataset) -> Iterator[Panel]:
    """Split a panel by magnitude so that every curve is visible; zero curves join the largest."""
    peaks = {variable: _peak(dataset[variable].values) for variable, _ in panel.variables}
    rest = panel.variables
    while rest:
        top = max(peaks[variable] for variable, _ in rest)
        flat = {variable for variable, _ in rest if 0 < peaks[variable] * _FLAT < top}
        yield replace(panel, variables=tuple(pair for pair in rest if pair[0] not in flat))
        rest = tuple(pair for pair in rest if pair[0] in flat)


def _peak(values: NDArray[np.float64]) -> float:
    """Return the largest magnitude of the finite values; zero if there are none."""
    return float(np.max(np.abs(values), where=np.isfinite(values), initial=0.0))


def _draw(ax: Axes, dataset: xr.Dataset, panel: Panel, dashed: Mapping[str, Quantity]) -> None:
    """Draw a panel's variables; a dashed line in the same colour is a variable's reference."""
    t = dataset["t"].values
    for number, (variable, quantity) in enumerate(panel.variables):
        line = next(islice(cycle(_LINES), number // len(COLORS), None))
        named = number < _MOST_NAMED
        (drawn,) = ax.plot(t, dataset[variable].values, line, label=_entry(variable, quantity) if named else None)
        if (wanted := dashed.get(variable)) is not None:
            text = _entry(wanted.name, wanted) if named else None
            ax.plot(t, dataset[wanted.name].values, "--", color=drawn.get_color(), lw=1.0, label=text)
    ax.margins(x=0)
    if len(panel.variables) == 1 and panel.variables[0][0] not in dashed:
        variable, quantity = panel.variables[0]
        ax.set_title(f"{panel.kind}: {quantity.description}")
        ax.set_ylabel(f"{variable} [{pretty_unit(panel.unit)}]")
        return
    ax.set_title(f"{panel.kind}s in {pretty_unit(panel.unit)}")
    ax.set_ylabel(f"{panel.kind}s [{pretty_unit(panel.unit)}]")
    hidden = len(panel.variables) - _MOST_NAMED
    title = f"the first {_MOST_NAMED} of {len(panel.variables)}" if hidden > 0 else None
    ax.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), borderaxespad=0.0, title=title)


def _entry(variable: str, quantity: Quantity) -> str:
    """Return the text of a curve in a legend."""
    return textwrap.fill(f"{variable}: {quantity.description}", 34)


def _mark(ax: Axes, dataset: xr.Dataset, panel: Panel, manifest: Manifest) -> None:
    """Draw a line at each settling time of the panel's variables, with names below each other."""
    names, marks = {variable for variable, _ in panel.variables}, 0
    for name, metric in manifest.metrics.items():
        if metric.kind.startswith("settling") and names & set(metric.of) and name in dataset:
            at = float(dataset[name])
            if math.isfinite(at):
                ax.axvline(at, color=GREY, lw=0.8, ls=(0, (4, 3)))
                place = (at, 0.98 - _MARK * (marks % _MARKS))
                ax.annotate(name, place, xycoords=("data", "axes fraction"), fontsize=7, color=GREY, va="top")
                marks += 1
