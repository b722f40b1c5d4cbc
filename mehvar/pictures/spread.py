# SPDX-License-Identifier: Apache-2.0
"""Pictures of a batch dataset: histograms, bands, scatter plots, success rates, convergence."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mehvar.base.errors import InputError, unknown_name
from mehvar.runtime.batch.evaluation.statistics import (
    NO_INTERVAL,
    column,
    design_of,
    drawn_names,
    fulfilment,
    interval,
    metric_names,
    scalars,
    success_condition,
    summary_names,
)
from mehvar.runtime.batch.store.dataset import DatasetBatch
from mehvar.runtime.batch.store.layout import NOT_RUN

from .batch import MOST_STATES, axis_text, draw_bands, draw_histogram, panels
from .style import BLUE, GREY, LIGHT, VERMILLION, case_text, new_figure

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

FloatArray = NDArray[np.float64]
_POINTS = 200
"""Number of points of the convergence curve, one per three pixels."""

_PER_CELL = 10
"""Average number of runs per cell of a map: its success rate then has an error of about 0.3. With half as many,
noise looks like a region; with twice as many, borders lose half of their sharpness."""
_FEWEST_CELLS = 4
"""Smallest number of cells per side, also for small batches; fewer would show no border."""


class Runs:
    """Stored runs of a batch, with access to their numbers by name.

    Attributes
    ----------
    dataset : xarray.Dataset
        The stored runs.
    numbers : ndarray of int
        Their numbers in the batch.
    whole : xarray.Dataset
        All runs of the batch, including missing ones.
    batch : DatasetBatch
        The stored runs as one block of a store.

    Parameters
    ----------
    dataset : xarray.Dataset
        What `mehvar.batch` returns.
    success : str, optional
        Condition for success; default: the batch's own condition.

    Raises
    ------
    InputError
        If no run is stored.
    """

    def __init__(self, dataset: xr.Dataset, success: str | None = None) -> None:
        self.numbers = np.flatnonzero(dataset["status"].values != NOT_RUN)
        self.whole = dataset
        if not self.numbers.size:
            raise InputError("this batch has no stored run yet")
        self.dataset = dataset if self.numbers.size == dataset.sizes["run"] else dataset.isel(run=self.numbers)
        self.batch = DatasetBatch(self.dataset, chunk=self.numbers.size)
        self.condition = success if success is not None else dataset.attrs["success"]
        self.metrics = metric_names(self.batch)
        self.drawn = drawn_names(self.batch)
        self.series = [name for name, variable in self.batch.variables().items() if variable.dimension == "t"]

    @property
    def summaries(self) -> list[str]:
        """Names of the metrics; for a model without metrics, of the first final states."""
        return summary_names(self.batch)[: None if self.metrics else MOST_STATES]

    def column(self, name: str) -> FloatArray:
        """Return one number per run: a metric, a drawn value, or an expression such as "final(roll)".

        Raises
        ------
        InputError
            For an unknown name.
        """
        if name not in scalars(self.batch):
            raise unknown_name("number of the runs", name, [*self.metrics, *self.drawn, "t_stop", "final(STATE)"])
        return column(self.batch, name).astype(float)

    def axis(self, name: str) -> str:
        """Return a name with its unit, for an axis."""
        return axis_text(self.batch, name)

    @cached_property
    def successful(self) -> NDArray[np.bool_]:
        """True for each run that reached its end time and fulfils the success condition, if any."""
        return fulfilment(self.batch, success_condition(self.condition or None), [0])

    @property
    def headline(self) -> str:
        """Title with the batch, its number of runs and its number of successes."""
        about, n = self.dataset.attrs, self.successful.size
        condition = f" ({self.condition})" if self.condition else ""
        return (
            f"{about['title']} (scenario {case_text(about)})\n"
            f"{int(self.successful.sum())} of {n} runs succeed{condition}"
        )


def metrics_picture(runs: Runs, names: Sequence[str] = ()) -> Figure:
    """Draw each metric as a histogram, and each stored series as quantile bands over time."""
    shown = list(names) or runs.metrics or runs.series or runs.summaries
    for name in shown:
        if name not in runs.series:
            runs.column(name)
    figure, axes = panels(runs.headline, len(shown), 3)
    for name, ax in zip(shown, axes, strict=True):
        if name in runs.series:
            draw_bands(ax, runs.batch, name)
            ax.axhline(0.0, color=GREY, lw=0.6, zorder=0.9)
        else:
            draw_histogram(ax, runs.batch, name, runs.successful)
    return figure


def scatter_picture(runs: Runs, x: str, y: str) -> Figure:
    """Draw one number of each run against another, with a colour for successful runs."""
    across, up = runs.column(x), runs.column(y)
    figure = new_figure(6.5, 4.5)
    ax = figure.subplots()
    for chosen, color, marker, text in (
        (runs.successful, BLUE, "o", "succeeds"),
        (~runs.successful, VERMILLION, "x", "does not"),
    ):
        ax.scatter(across[chosen], up[chosen], s=12, color=color, marker=marker, label=f"{text}: {int(chosen.sum())}")
    ax.set_title(runs.headline, wrap=True)
    ax.set_xlabel(runs.axis(x))
    ax.set_ylabel(runs.axis(y))
    ax.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), borderaxespad=0.0)
    return figure


def region_picture(runs: Runs, x: str, y: str) -> Figure:
    """Draw the success rate in each cell of a plane of two numbers, such as a region of attraction."""
    across, up = runs.column(x), runs.column(y)
    finite = np.isfinite(across) & np.isfinite(up)
    sides = [_edges(values[finite]) for values in (across, up)]
    count, wins = (np.histogram2d(across[part], up[part], sides)[0] for part in (finite, finite & runs.successful))
    share = np.ma.masked_array(wins / np.maximum(count, 1), mask=count == 0)
    figure = new_figure(6.5, 4.5)
    ax = figure.subplots()
    ax.grid(False)
    ax.set_facecolor(LIGHT)
    mesh = ax.pcolormesh(*sides, share.T, cmap="cividis", vmin=0.0, vmax=1.0)
    figure.colorbar(mesh, ax=ax, label="share of runs that succeed; grey: no runs")
    ax.set_title(runs.headline, wrap=True)
    ax.set_xlabel(runs.axis(x))
    ax.set_ylabel(runs.axis(y))
    return figure


def _edges(values: FloatArray) -> FloatArray:
    """Return the edges of cells over the range of some values."""
    low, high = (float(values.min()), float(values.max())) if values.size else (0.0, 1.0)
    widened = (low, high) if high > low else (low - 0.5, high + 0.5)
    return np.linspace(*widened, 1 + max(_FEWEST_CELLS, math.isqrt(values.size // _PER_CELL)))


def convergence_picture(runs: Runs) -> Figure:
    """Draw the success rate over the number of runs, with its exact 95 % interval if defined."""
    counts = np.unique(np.linspace(1, runs.successful.size, _POINTS).astype(int))
    successes = np.cumsum(runs.successful)[counts - 1]
    figure = new_figure(6.5, 3.5)
    ax = figure.subplots()
    if design_of(runs.dataset.attrs) not in NO_INTERVAL:
        ends = np.array([interval(int(k), int(n)) for k, n in zip(successes, counts, strict=True)])
        ax.fill_between(counts, ends[:, 0], ends[:, 1], color=BLUE, alpha=0.25, linewidth=0, label="95 % interval")
    ax.plot(counts, successes / counts, color=BLUE, label="share of runs that succeed")
    ax.set_title(runs.headline, wrap=True)
    ax.set_xlabel("runs")
    ax.set_ylabel("share of runs")
    ax.margins(x=0)
    ax.legend()
    return figure
