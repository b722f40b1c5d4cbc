# SPDX-License-Identifier: Apache-2.0
"""The paper on the planar three-mass triangle: its figures, and the picture of any run."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import numpy as np

from mehvar.papers.study import PaperFigure, Runs
from mehvar.papers.triangle.claims import claims
from mehvar.papers.triangle.scene import STUDY, scene
from mehvar.papers.triangle.shapes import (
    PATH,
    RODS,
    START,
    TARGET,
    boundary_names,
    polar_plane,
    schematic,
    shape_disc,
    shape_grid,
    shifted_origin,
)
from mehvar.papers.triangle.surfaces import cylinder, limited_arc, nested_surfaces, xi_curve
from mehvar.pictures.plots import BLACK, BLUE, VERMILLION, headline, label, new_figure, time_axis
from mehvar.runtime.model.model import load
from mehvar.runtime.run.results import to_dataset

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from mehvar.runtime.model.manifest import Manifest

__all__ = ["BOARD", "CITATION", "READINGS", "STUDY", "claims", "figures", "picture", "scene"]

BOARD: str | None = None

CITATION = (
    "H. Makarem, H. Salarieh, G. Vossoughi, A. Alasty: Kinematic attitude control of three pairwise connected "
    "in-plane masses by varying the lengths of the links (in Persian)."
)
READINGS = (
    "Every equation was derived again. The text that could be had is partly garbled and its figures are missing, so "
    "the figures here are drawn anew from the equations and from what the text says they show.",
    "Rods: the numbers that can be read in the text are incomplete. The runs go from 0.2, 0.2, 0.3 m to "
    "0.3, 0.3, 0.5 m (scenario paper) and to 0.3, 0.4, 0.5 m (paper-b). This is an assumption.",
    "Gain of the path law: printed 5, read as 0.5. With 5 the run is ten times faster than the sliding run, and what "
    "the paper says about comparing the two is not so (scenario printed).",
    "Equation (22) needs a minus sign before its last term, and (27) has no factor 1/2 (claim 9).",
    "The expected numbers were computed beforehand by an independent program from the corrected equations; the text "
    "of the paper puts its claims in words.",
)


def figures() -> list[PaperFigure]:
    """Return the paper's eleven figures."""
    return [
        PaperFigure(
            1,
            "Three masses and three rods",
            "Rod k lies opposite mass k. The attitude θ is the angle by which the base triangle is turned before it is "
            "stretched into the present shape; it is not the direction of any rod.",
            schematic,
        ),
        PaperFigure(
            2,
            "What ρ and φ do to a shape",
            "Triangles of the same size μ and attitude θ = 0. At ρ = 0 all rods are equal whatever φ is; a larger ρ "
            "makes the triangle flatter, and φ says along which direction. Turning φ by 120° hands the shape on to the "
            "next rod.",
            shape_grid,
        ),
        PaperFigure(
            3,
            "The disc of shapes",
            "Every shape is a point with polar coordinates ρ and φ. On the rim the three masses lie on one line; the "
            "laws stay inside ρ = R. A closed loop in this disc turns the triangle by twice the area it encloses.",
            polar_plane,
        ),
        PaperFigure(
            4,
            "The origin moved to the target",
            "The distance ρ̃ to the target and the direction φ̃ in which it lies, counted from the direction φ_f of the "
            "target itself (dotted).",
            shifted_origin,
            claims=("9",),
        ),
        PaperFigure(
            5,
            "Sliding surfaces, nested",
            "Where the sliding variable s is zero, for several shifted attitudes θ̃. The surface is the circle ρ = R at "
            "θ̃ = θ* = 4 rad and shrinks onto the target as θ̃ goes to zero.",
            nested_surfaces,
            claims=("6",),
        ),
        PaperFigure(
            6,
            "The sliding surface in space",
            "The same surfaces stacked over θ̃, inside the cylinder ρ = R, with the run of figure 9: it reaches the "
            "surface and winds down to the target.",
            cylinder,
            claims=("1", "6"),
        ),
        PaperFigure(
            7,
            "The arc to the target",
            "Solution ξ of (42). K compares the attitude that is left with the square of the distance: ξ near π is "
            "almost the straight way, ξ near −π almost a full circle. Dots: what the generated law computes.",
            xi_curve,
        ),
        PaperFigure(
            8,
            "When the arc does not fit",
            "At the start θ̃ is larger than an arc inside ρ = R can enclose. The law takes the arc that touches the "
            "circle, follows the circle, and leaves it when an arc can enclose what is left.",
            limited_arc,
            claims=("4",),
        ),
        PaperFigure(
            9,
            "Sliding law, no disturbance",
            _run_caption("the sliding law"),
            sliding_run,
            claims=("1", "2", "3", "4", "5", "7", "T1"),
        ),
        PaperFigure(
            10,
            "Path law, no disturbance",
            _run_caption("the path law"),
            path_run,
            claims=("1", "2", "3", "4", "5", "T2"),
        ),
        PaperFigure(
            11,
            "Both laws under a drift of 0.001 rad/s",
            "Rod lengths and rates of the path law (a, c) and of the sliding law (b, d), and the attitude (e). The "
            "drift cannot be held by any shape: both laws end in a small cycle around the target.",
            disturbed_runs,
            claims=("8",),
        ),
    ]


def _run_caption(law: str) -> str:
    return (
        f"One radian clockwise and a change of shape with {law}: rod lengths, rod rates, attitude, and the path in the "
        "disc of shapes. Dashed: final lengths."
    )


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
        axes[name].set_title(f"({name}) {law} law: rod lengths")
    for name, law in (("c", "path"), ("d", "sliding")):
        rod_rates(axes[name], both[law])
        axes[name].set_title(f"({name}) {law} law: rod rates")
    for left, right in (("a", "b"), ("c", "d")):
        axes[right].sharey(axes[left])
        axes[right].autoscale(axis="y")
    for law, color, line in (("path", BLUE, "-"), ("sliding", VERMILLION, "--")):
        axes["e"].plot(both[law]["t"], both[law]["theta"], line, color=color, label=f"{law} law")
    time_axis(axes["e"], label(r"$\theta$", "attitude", "rad"))
    axes["e"].set_title("(e) attitude")
    axes["e"].legend(loc="upper right")
    return figure


def rod_lengths(ax: Axes, dataset: xr.Dataset, final: tuple[float, ...]) -> None:
    """Draw the three lengths over time, and the final ones as dashed lines."""
    for k, color in enumerate(RODS, 1):
        ax.plot(dataset["t"], dataset[f"l{k}"], color=color, label=f"$l_{k}$")
        ax.axhline(final[k - 1], color=color, ls=(0, (4, 3)), lw=0.8)
    ax.set_ylim(bottom=0.0)
    time_axis(ax, label("$l$", "rod length", "m"))
    ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2, handlelength=1.2)


def rod_rates(ax: Axes, dataset: xr.Dataset) -> None:
    """Draw the rates of the three rods over time."""
    for k, color in enumerate(RODS, 1):
        ax.plot(dataset["t"], dataset[f"u_l{k}"], color=color, label=f"$l_{k}'$")
    time_axis(ax, label("$l'$", "rod rate", "m/s"))
    ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2, handlelength=1.2)


def _attitude(ax: Axes, dataset: xr.Dataset) -> None:
    ax.plot(dataset["t"], dataset["theta"], color=BLACK, label=r"$\theta$")
    target = float(dataset["theta"][-1] - dataset["theta_error"][-1])
    ax.axhline(target, color=TARGET, ls=(0, (4, 3)), lw=1.0)
    time_axis(ax, label(r"$\theta$", "attitude", "rad"))


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
