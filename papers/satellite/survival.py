# SPDX-License-Identifier: Apache-2.0
"""Initial covariances that law (32) survives, by its pole, the delay and the integration of the satellite."""

from __future__ import annotations

import functools
import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

import mehvar
from mehvar.pictures import BLACK, BLUE, GREY, VERMILLION, label, new_figure
from mehvar.runtime import Status, simulate

from .coarse import coarse_runs
from .rows import AXES, LATE, ring

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from mehvar import Model
    from mehvar.reproduction import Runs

    from .coarse import Step

    FloatArray = NDArray[np.float64]
    BoolArray = NDArray[np.bool_]

POLES = (0.001, 0.5)
"""The paper's, and one with a margin: that of `mrac`."""
COVARIANCES = np.geomspace(1.0, 1e6, 41)
"""Values of F(0), which the paper does not give: seven per decade. Of 81 values in this range the same share
survives, within one in ten.
"""
CLEAN = 0.12
"""RMS error below which a run is clean, deg: that of `mrac` with the delay in yaw, its worst axis."""


_LOST_AT = 100.0
"""Plotted error of a run that does not reach its end, deg: above the largest error of a run that does."""


@dataclass(frozen=True)
class Survival:
    """Runs of law (32), one for each of `COVARIANCES`.

    Attributes
    ----------
    done : array of bool, (41,)
        Which runs reach their end.
    rms : array, (41, 3)
        RMS errors of roll, pitch and yaw from 200 s on, deg.
    ring : array, (41, 3)
        Ring of the torques from 200 s on, 1 for pure alternation; of a run that is lost it means nothing.
    """

    done: BoolArray
    rms: FloatArray
    ring: FloatArray

    @property
    def clean(self) -> BoolArray:
        """True for the runs that reach their end with every axis below `CLEAN`."""
        return self.done & (self.rms < CLEAN).all(axis=1)

    def calm(self, most: float) -> BoolArray:
        """Return which runs reach their end with a ring below `most` on every axis."""
        return self.done & (self.ring < most).all(axis=1)


@functools.lru_cache(maxsize=16)
def survival(
    model: Model, step: Step | None, pole: float, delay: int = 0, scenario: str = "printed", **parameters: float
) -> Survival:
    """Run law (32) once for each first covariance.

    Parameters
    ----------
    model : Model
        The satellite.
    step : Step or None
        Of the coarse simulator; None for the batch engine, which integrates between samples.
    pole : float
        Double pole of C2.
    delay : int
        Samples between command and action; the law is designed for them.
    scenario : str
        "printed" for the printed B as first guess, "paper" for the nominal plant.
    **parameters
        Further ones of the law.

    Raises
    ------
    InputError
        If the batch engine has no C compiler.
    """
    period = float(model.parameters()[model.parameter_names.index("Ts")])
    case: dict[str, Any] = {"controller": "mrac-literal", "scenario": scenario, "delay": delay}
    case["parameters"] = {"C2_pole": pole, **parameters}
    if step:
        coarse = coarse_runs(model, simulate(model, **case, t_end=2 * period), step, delay, COVARIANCES)
        return Survival(coarse.done, coarse.rms, ring(coarse.torque))
    runs = mehvar.batch(model, **case, vary={"F0": COVARIANCES.tolist()}, save=period)
    rms = np.degrees([runs[f"rms_{axis}"].values for axis in AXES]).T
    torque = np.stack([runs[f"u_T{i}"].values[:, round(LATE / period) : -1] for i in "xyz"], axis=-1)
    return Survival(runs["status"].values == Status.DONE, rms, ring(torque))


def survival_figure(runs: Runs) -> Figure:
    """Draw the error of law (32) over F(0), for both poles, without and with the delay, for both ways to step."""
    figure = new_figure(10.0, 5.4)
    axes = figure.subplots(2, 4, sharex=True, sharey=True)
    steps: tuple[tuple[str, Step | None], ...] = (("integrated", None), ("coarse step", "semi-implicit"))
    for row, (how, step) in zip(axes, steps, strict=True):
        for ax, (pole, delay) in zip(row, itertools.product(POLES, (0, 1)), strict=True):
            cell = survival(runs.model, step, pole, delay)
            _cell(ax, cell)
            ax.set_title(
                f"{how}, pole {pole:g}, {'delay' if delay else 'no delay'}\n"
                f"{cell.done.sum()} survive, {cell.clean.sum()} clean",
                fontsize=8,
            )
            ax.xaxis.label.set_visible(step is not None)
            ax.yaxis.label.set_visible(ax is row[0])
    axes[0, 0].set(ylim=(2e-3, 2 * _LOST_AT), xlim=(COVARIANCES[0] / 2, 2 * COVARIANCES[-1]))
    axes[1, 3].legend(loc="lower right", fontsize=7)
    return figure


def _cell(ax: Axes, cell: Survival) -> None:
    worst = cell.rms.max(axis=1)
    rough = cell.done & ~cell.clean
    ax.loglog(COVARIANCES[cell.clean], worst[cell.clean], "o", color=BLUE, ms=3.5, label="clean")
    ax.loglog(COVARIANCES[rough], worst[rough], "o", color=VERMILLION, mfc="none", ms=3.5, label="survives")
    ax.loglog(COVARIANCES[~cell.done], np.full((~cell.done).sum(), _LOST_AT), "x", color=GREY, ms=4.0, label="lost")
    ax.axhline(CLEAN, color=BLACK, lw=0.6, ls=":", label="limit of clean")
    ax.set_xlabel(label("$F(0)$", "first covariance", "1"))
    ax.set_ylabel("worst RMS error [°]")
