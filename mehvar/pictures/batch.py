# SPDX-License-Identifier: Apache-2.0
"""Pictures of a batch: bands of its series over time with the worst runs, or histograms of its metrics."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mehvar.base.errors import unknown_name
from mehvar.base.units import pretty_unit
from mehvar.runtime.batch.evaluation.statistics import (
    bands,
    column,
    metric_names,
    number_attributes,
    summary_names,
    worst,
    wraps,
)
from mehvar.runtime.batch.sampling import FloatArray
from mehvar.runtime.batch.store.dataset import Batch
from mehvar.runtime.batch.store.store import Store

from .style import BAND_HIGH, BAND_LOW, BLUE, GREY, VERMILLION, case_text, label, new_figure, require_matplotlib, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BANDS = ((0.01, 0.99, 0.18), (0.05, 0.95, 0.3), (0.25, 0.75, 0.45))
"""Quantiles and opacity of the bands, for 98, 90 and 50 % of the runs."""
UNWRAPPED = ", unwrapped"
"""End of the title of a band of an angle that wraps."""
_WORST = 3
"""Largest number of single runs that are drawn: that of distinguishable line styles."""
MOST_STATES = 12
"""Largest number of final states that are drawn for a model without metrics, so that panels fit a screen."""
_ROUNDING, _TINY = 1e-9, 1e-300
"""Relative and absolute spread below which a histogram is a single bar; narrower bars would be invisible."""
_TITLE = 62
"""Largest number of characters per line of a panel's title; longer lines overlap the next panel."""
BINS = 60
"""Number of bars of a histogram. Half as many hide a second peak; twice as many show the noise of 1000 runs."""


def batch_picture(store: Store, names: list[str]) -> Figure:
    """Draw a batch.

    Parameters
    ----------
    store : Store
        Store of the batch. Series are drawn as quantile bands over time with the runs of largest magnitude; without
        series, metrics as histograms.
    names : list of str
        The series or metrics; all states or all metrics if empty.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    InputError
        If matplotlib is not installed, or the store lacks a name.
    """
    require_matplotlib()
    variables = store.variables()
    series = [name for name, variable in variables.items() if variable.dimension == "t"]
    metrics = metric_names(store)
    states = [str(name) for name in store.coordinate("state").values]
    shown = names or (states if series else metrics or summary_names(store)[:MOST_STATES])
    for name in names:
        if name not in (*series, *metrics, "t_stop"):
            raise unknown_name(f"series or metric of {store.name}", name, [*series, *metrics])
    with style():
        about = store.attributes
        title = f"{about['title']} (scenario {case_text(about)}), {store.n} runs"
        figure, axes = panels(title, len(shown), 4)
        for name, ax in zip(shown, axes, strict=True):
            if name in series:
                draw_bands(ax, store, name, _largest(store, name))
            else:
                highest = worst(store, lambda block, name=name: column(store, name, [block]), _WORST)  # type: ignore[misc]
                draw_histogram(ax, store, name, marked=[run for run, _ in highest])
        return figure


def panels(title: str, count: int, most: int) -> tuple[Figure, list[Axes]]:
    """Return a figure with panels below each other, in two columns above `most` panels."""
    columns = 1 if count <= most else 2
    rows = -(-count // columns)
    figure = new_figure(5.5 * columns, 0.6 + 2.1 * rows)
    figure.suptitle(title, fontsize=10, wrap=True)
    axes: list[Axes] = list(figure.subplots(rows, columns, squeeze=False).T.flat)
    for ax in axes[count:]:
        ax.remove()
    return figure, axes[:count]


def axis_text(batch: Batch, name: str) -> str:
    """Return a name with its unit, for an axis."""
    unit = number_attributes(batch, name).get("units", "")
    return f"{name} [{pretty_unit(unit)}]" if unit else name


def draw_bands(ax: Axes, batch: Batch, name: str, marked: Sequence[int] = ()) -> None:
    """Draw a stored series as quantile bands over time, with the lines of up to three marked runs."""
    t = np.asarray(batch.coordinate("t").values)
    levels = [level for low, high, _ in BANDS for level in (low, high)]
    *edges, median = bands(batch, name, [*levels, 0.5])
    wrapped = wraps(batch, name)
    for (low, high, opacity), below, above in zip(BANDS, edges[::2], edges[1::2], strict=True):
        text = f"{100 * low:g} to {100 * high:g} %"
        ax.fill_between(t, below, above, color=BLUE, alpha=opacity, linewidth=0, label=text)
        if (low, high) == BANDS[1][:2]:  # a chart has one band
            for edge, level, side in ((below, low, BAND_LOW), (above, high, BAND_HIGH)):
                ax.plot(t, edge, color=BLUE, lw=0.4, gid=side, label=f"{100 * level:g} %")
    ax.plot(t, median, color=BLUE, label="median")
    for line, run in zip(("-", "--", ":"), marked, strict=False):
        block, row = divmod(run, batch.chunk)
        values = batch.series(name, 0, len(t), [block])[row]
        if wrapped:
            values = np.unwrap(values)
            values += 2 * np.pi * np.round((median[0] - values[0]) / (2 * np.pi))
        ax.plot(t, values, color=VERMILLION, linewidth=0.8, linestyle=line, label=f"run {run}")
    ax.set_title(f"{_meaning(batch, name)}{UNWRAPPED if wrapped else ''}")
    ax.set_xlabel(label("t", "time", "s"))
    ax.set_ylabel(axis_text(batch, name))
    ax.margins(x=0)
    handles = [handle for handle in ax.get_legend_handles_labels()[0] if handle.get_gid() not in (BAND_LOW, BAND_HIGH)]
    ax.legend(handles=handles, loc="upper left", bbox_to_anchor=(1.01, 1.0), borderaxespad=0.0)


def draw_histogram(
    ax: Axes, batch: Batch, name: str, successful: NDArray[np.bool_] | None = None, marked: Sequence[int] = ()
) -> None:
    """Draw a number of the runs as a histogram, stacked by success if that is given, with some marked runs."""
    values = column(batch, name)
    finite = np.isfinite(values)
    groups = [finite] if successful is None else [finite & successful, finite & ~successful]
    colours = (BLUE, VERMILLION)[: len(groups)]
    bars: dict[str, Any] = {"stacked": True, "color": colours, "histtype": "stepfilled"}  # one shape, not sixty
    ax.hist([values[group] for group in groups], bins=list(bin_edges(values[finite])), **bars)
    for run in marked:
        block, row = divmod(run, batch.chunk)
        value = column(batch, name, [block])[row]
        if np.isfinite(value):
            place: dict[str, Any] = {"xycoords": ("data", "axes fraction"), "rotation": 90, "ha": "right", "va": "top"}
            ax.axvline(value, color=VERMILLION, linewidth=0.8)
            ax.annotate(f"run {run}", (value, 0.95), fontsize=7, color=GREY, **place)
    title = f"{_meaning(batch, name)}: {np.count_nonzero(finite)} of {values.size} runs"
    ax.set_title(textwrap.fill(title, _TITLE))
    ax.set_xlabel(axis_text(batch, name))
    ax.set_ylabel("runs")


def _meaning(batch: Batch, name: str) -> str:
    return str(number_attributes(batch, name).get("long_name", name))


def _largest(store: Store, name: str) -> list[int]:
    """Return the runs with the largest magnitude of a variable."""

    def magnitude(block: int) -> FloatArray:
        low, high = (column(store, f"{end}({name})", [block]) for end in ("minimum", "maximum"))
        return np.fmax(np.abs(low), np.abs(high))

    return [run for run, _ in worst(store, magnitude, _WORST)]


def bin_edges(values: FloatArray) -> FloatArray:
    """Return the edges of a histogram's bins, with values that are equal up to rounding in the middle bin.

    Narrower bins would be invisible or have coinciding edges, which NumPy refuses.
    """
    if not values.size:
        return np.linspace(0.0, 1.0, BINS + 1)
    low, high = float(values.min()), float(values.max())
    size = max(abs(low), abs(high))
    if high - low <= _ROUNDING * size or size < _TINY:
        middle, half = low / 2 + high / 2, 0.1 * size if size >= _TINY else 1.0
        return np.linspace(middle - half, middle + half, BINS + 1) + half / BINS
    return np.linspace(low, high, BINS + 1)
