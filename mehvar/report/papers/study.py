# SPDX-License-Identifier: Apache-2.0
"""Batch of a system: success rates of its laws, and bands of series over time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from mehvar.pictures.batch import UNWRAPPED
from mehvar.pictures.style import BAND_HIGH, BAND_LOW, BLUE, VERMILLION, label, new_figure, style
from mehvar.report.charts import plain
from mehvar.runtime.batch.evaluation.statistics import MetricStatistics, Statistics, bands, summarise, wraps
from mehvar.runtime.batch.fill import run_batch
from mehvar.runtime.batch.plan import Campaign

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from mehvar.reproduction.study import Study
    from mehvar.runtime.batch.store.store import Store
    from mehvar.runtime.model.model import Model

SEED = 1
_LOW, _HIGH = 0.05, 0.95
"""Quantiles of the band, which holds 90 % of the runs. With 512 runs, 25 beyond each edge make it smooth."""
_COLORS = (BLUE, VERMILLION)


@dataclass(frozen=True)
class Batch:
    """Results of a study's batches: title and statistics of each law, and the metrics of its condition."""

    study: Study
    laws: Sequence[tuple[str, Statistics]]
    figure: Figure

    @property
    def metrics(self) -> list[tuple[str, MetricStatistics]]:
        """Return the metrics in the success condition, with the title of the law."""
        return [(title, row) for title, law in self.laws for row in law.rows if row.name in self.study.success]


def run_study(model: Model, study: Study, advance: Callable[[float, str], None]) -> Batch:
    """Run the batches of a study, one per law, with the same random numbers.

    Parameters
    ----------
    model : Model
        On the C backend.
    study : Study
        Dispersions and success condition.
    advance : callable
        Called with the finished share, and the current work.
    """
    stores: list[tuple[str, Store]] = []
    for k, (law, title) in enumerate(study.laws.items()):

        def report(runs: int, total: int, _failed: int, k: int = k, title: str = title) -> None:
            advance((k + runs / total) / len(study.laws), f"{total} runs, {title}")

        campaign = Campaign(
            law, study.runs, study.scenario, SEED, study.vary, options=study.options, save_every=study.every
        )
        stores.append((title, run_batch(model, campaign, success=study.success, report=report)))
    with style():
        figure = _figure(study, stores)
    return Batch(study, [(title, summarise(store)) for title, store in stores], figure)


def _figure(study: Study, stores: Sequence[tuple[str, Store]]) -> Figure:
    """Return the bands over time, with a row per series and a column per law."""
    figure = new_figure(10.0, 0.4 + 2.2 * len(study.bands))
    axes = figure.subplots(len(study.bands), len(stores), sharex=True, sharey="row", squeeze=False)
    for row, (name, band) in zip(axes, study.bands.items(), strict=True):
        for ax, (title, store), color in zip(row, stores, _COLORS, strict=True):
            _draw(ax, store, name, band.scale, color)
            ax.set_xlabel(label("$t$", "time", "s"))
            ax.set_ylabel(plain(band.label))
            ax.set_title(title + (UNWRAPPED if wraps(store, name) else ""))
    return figure


def _draw(ax: Axes, store: Store, name: str, scale: float, color: str) -> None:
    """Draw the median of a series and the band of 90 % of the runs."""
    t = store.coordinate("t").values
    low, middle, high = scale * bands(store, name, (_LOW, 0.5, _HIGH))
    edge: dict[str, Any] = {"color": color, "lw": 0.6}
    ax.fill_between(t, low, high, color=color, alpha=0.2, linewidth=0)
    ax.plot(t, low, gid=BAND_LOW, label=f"{100 * _LOW:g} %", **edge)
    ax.plot(t, high, gid=BAND_HIGH, label=f"{100 * _HIGH:g} %", **edge)
    ax.plot(t, middle, color=color, label="median")
    ax.margins(x=0)
