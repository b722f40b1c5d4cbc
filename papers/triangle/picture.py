# SPDX-License-Identifier: Apache-2.0
"""The picture of any run of the triangle, and figures 9 to 11, which are such pictures."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import numpy as np

from mehvar import load
from mehvar.pictures import BLACK, BLUE, GREY, VERMILLION, headline, label, new_figure, time_axis
from mehvar.reproduction import Runs
from mehvar.runtime import to_dataset

from .shapes import (
    PATH,
    RODS,
    START,
    TARGET,
    boundary_names,
    shape_disc,
)

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from mehvar.runtime import Manifest


_DASHED = (0, (4, 3))


def sliding_run(runs: Runs) -> Figure:
    """Draw figure 9."""
    return picture(to_dataset(runs("sliding", "paper")), runs.model.manifest)


def path_run(runs: Runs) -> Figure:
    """Draw figure 10."""
    return picture(to_dataset(runs("path", "paper")), runs.model.manifest)


def picture(dataset: xr.Dataset, manifest: Manifest) -> Figure:
    """Draw a run: rod lengths, rod rates and attitude over time, and the path in the disc of shapes.

    Parameters
    ----------
    dataset : xarray.Dataset
        A run of the triangle.
    manifest : Manifest
        The model's.

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure = new_figure(10.0, 5.6)
    figure.suptitle(headline(dataset), fontsize=10, wrap=True)
    axes = figure.subplot_mosaic(
        [["lengths", "disc"], ["rates", "disc"], ["theta", "disc"]], width_ratios=(1.0, 1.1), empty_sentinel=None
    )
    rod_lengths(axes["lengths"], dataset, _final_lengths(dataset))
    rod_rates(axes["rates"], dataset)
    _attitude(axes["theta"], dataset)
    _disc(axes["disc"], dataset, _target(dataset, manifest))
    return figure


def disturbed_runs(runs: Runs) -> Figure:
    """Draw figure 11: both laws with d = 0.001 rad/s."""
    both = {law: to_dataset(runs(law, "paper", disturbance=0.001)) for law in ("path", "sliding")}
    figure = new_figure(10.0, 7.2)
    axes = figure.subplot_mosaic([["a", "b"], ["c", "d"], ["e", "e"]])
    for name, law in (("a", "path"), ("b", "sliding")):
        rod_lengths(axes[name], both[law], _final_lengths(both[law]))
        axes[name].set_title(f"({name}) {law} law")
    for name, law in (("c", "path"), ("d", "sliding")):
        rod_rates(axes[name], both[law])
        axes[name].set_title(f"({name}) {law} law")
    for left, right in (("a", "b"), ("c", "d")):
        axes[right].sharey(axes[left])
        axes[right].autoscale(axis="y")
    for law, color, line in (("path", BLUE, "-"), ("sliding", VERMILLION, "--")):
        axes["e"].plot(both[law]["t"], both[law]["theta"], line, color=color, label=f"{law} law")
    time_axis(axes["e"], label(r"$\theta$", "attitude", "rad"))
    axes["e"].set_title("(e) both laws")
    axes["e"].legend(loc="upper right")
    return figure


def rod_lengths(ax: Axes, dataset: xr.Dataset, final: tuple[float, ...]) -> None:
    """Draw the three lengths over time, and the final ones as dashed lines."""
    for k, color in enumerate(RODS, 1):
        ax.plot(dataset["t"], dataset[f"l{k}"], color=color, label=f"$l_{k}$")
        ax.axhline(final[k - 1], color=color, ls=_DASHED, lw=0.8, label="target")
    ax.set_ylim(bottom=0.0)
    time_axis(ax, label("$l$", "rod length", "m"))
    _legend(ax)


def rod_rates(ax: Axes, dataset: xr.Dataset) -> None:
    """Draw the rates of the three rods over time."""
    for k, color in enumerate(RODS, 1):
        ax.plot(dataset["t"], dataset[f"u_l{k}"], color=color, label=f"$l_{k}'$")
    time_axis(ax, label("$l'$", "rod rate", "m/s"))
    _legend(ax)


def _attitude(ax: Axes, dataset: xr.Dataset) -> None:
    ax.plot(dataset["t"], dataset["theta"], color=BLACK, label=r"$\theta$")
    target = float(dataset["theta"][-1] - dataset["theta_error"][-1])
    ax.axhline(target, color=TARGET, ls=_DASHED, lw=1.0, label="target")
    time_axis(ax, label(r"$\theta$", "attitude", "rad"))
    _legend(ax)


def _legend(ax: Axes) -> None:
    """Draw a legend beside a panel; targets of several colours have one entry, in grey."""
    from matplotlib.lines import Line2D

    handles, texts = ax.get_legend_handles_labels()
    lines = dict(zip(texts, handles, strict=True))
    target = lines.pop("target", None)
    if texts.count("target") > 1:
        target = Line2D([], [], color=GREY, ls=_DASHED, lw=0.8)
    if target is not None:
        lines["target"] = target
    ax.legend(lines.values(), lines, loc="upper left", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2, handlelength=1.8)


def _disc(ax: Axes, dataset: xr.Dataset, target: complex) -> None:
    radius = json.loads(dataset.attrs["parameters"])["R"]
    zeta = (dataset["rho"] * np.exp(1j * dataset["phi"])).values
    shape_disc(ax, radius)
    boundary_names(ax, radius)
    ax.plot(zeta.real, zeta.imag, color=PATH, label="path")
    for at, color, name in ((zeta[0], START, "start"), (target, TARGET, "target")):
        ax.plot(at.real, at.imag, "o", color=color, ms=7, mec="white", zorder=7, label=name)
    ax.legend(loc="lower right", bbox_to_anchor=(1.03, -0.01), handlelength=1.2)


def _final_lengths(dataset: xr.Dataset) -> tuple[float, ...]:
    values = json.loads(dataset.attrs["parameters"])
    return tuple(values[f"l{k}_f"] for k in (1, 2, 3))


def _target(dataset: xr.Dataset, manifest: Manifest) -> complex:
    """Return zeta_f of a stored run, by the model's own reference."""
    values = json.loads(dataset.attrs["parameters"])
    p = [values[q.name] for q in manifest.parameters]
    s = [values[q.name] for q in manifest.scenario_parameters]
    reference = load(manifest.folder, "python").functions["reference"](0.0, p, s)
    return complex(reference[0] * np.exp(1j * reference[1]))
