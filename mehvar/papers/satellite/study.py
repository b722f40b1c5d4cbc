# SPDX-License-Identifier: Apache-2.0
"""The paper on adaptive attitude control of a satellite: its figures, and the picture of any run."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mehvar.papers.satellite.claims import claims
from mehvar.papers.satellite.figures import (
    COLORS,
    angle,
    angles_figure,
    both_figure,
    errors_figure,
    estimates_figure,
    legend,
    ringing_figure,
    torque,
    torques_figure,
)
from mehvar.papers.satellite.rows import AXES
from mehvar.papers.satellite.scene import STUDY, scene
from mehvar.papers.study import PaperFigure, Runs
from mehvar.pictures.plots import headline, label, new_figure, time_axis

if TYPE_CHECKING:
    from collections.abc import Callable

    import xarray as xr
    from matplotlib.figure import Figure
    from numpy.typing import ArrayLike

    from mehvar.papers.satellite.figures import Series
    from mehvar.runtime.model.manifest import Manifest

__all__ = ["BOARD", "CITATION", "READINGS", "STUDY", "claims", "figures", "picture", "scene"]

BOARD: str | None = "mrac"

CITATION = (
    "Fani Saberi, Ahmadi Dastgerdi: Design and implementation of a model-reference adaptive controller for three-axis "
    "satellite attitude with an ARM microcontroller (in Persian)."
)
READINGS = (
    "Every equation was derived again. Of the paper only garbled text could be had; all its figures are missing. What "
    "figures 4 to 11 show is our reading of what the text says about them: responses, torques and estimates without "
    "the delay between computer and board (4 to 9) and with it (10, 11). Figure 12 is ours.",
    "The law of these figures is mrac: the paper's estimator and reference model, but it keeps the zero of the sampled "
    "plant, which the paper's law (32) cancels. Law (32) is mrac-literal (claims 8 to 10, figure 12).",
    "Not given, and chosen: reference model (double pole, time constant 10 s), half period 200 s, F(0), pole 0.5, "
    "start of the reference model at the measured angles, no limits of torque and momentum.",
    "A delay of one sample makes d = 2. Errors are those against the reference model, from 200 s on where nothing else "
    "is said. Ring is the mean change of the torque over twice its mean size: 1 is pure alternation.",
    "The expected numbers were computed beforehand by an independent program. Amplitudes may differ by 2 % and half of "
    "the last digit given, settling times by one sample; with noise, also by half of the range over 16 seeds.",
)
_READING = "In our reading; the paper's picture is lost."


def figures() -> list[PaperFigure]:
    """Return figures 4 to 11 of the paper and one of ours."""
    return [
        PaperFigure(
            4,
            "Adaptive law: angles",
            "Roll, pitch and yaw from (10, 10, 5) degrees at rest, first guess the nominal plant. The reference model "
            f"lies on top of the angle: the error cannot be seen at this scale (figure 9 shows it). {_READING}",
            lambda runs: _drawn(angles_figure, runs, "mrac"),
            claims=("1",),
        ),
        PaperFigure(
            5,
            "Adaptive law: torques",
            "The torques of the run of figure 4. Each switch of the reference asks for a push and a brake; yaw works "
            f"against what roll and pitch do to it. {_READING}",
            lambda runs: _drawn(torques_figure, runs, "mrac"),
            claims=("4", "13"),
        ),
        PaperFigure(
            6,
            "Estimated parameters",
            "What the estimator of each axis learns when it starts from the printed B (circles) with F(0) = 1e4, on a "
            "logarithmic time axis. Within fifteen seconds b0 leaves the printed value for good. In roll and pitch "
            "both coefficients of B come near the true Ts²/(2 I). Yaw, wanted at zero, moves too little for its "
            f"parameters to be told apart, and they wander; it is still held at zero. {_READING}",
            estimates_figure,
            claims=("5", "12"),
        ),
        PaperFigure(
            7,
            "PD: angles",
            "The same manoeuvre with the printed gains. They make a loop of 0.03 rad/s that overshoots by 40 %: it "
            f"swings around the reference and never settles. {_READING}",
            lambda runs: _drawn(angles_figure, runs, "pd"),
            claims=("3",),
        ),
        PaperFigure(
            8,
            "PD: torques",
            f"The torques of the run of figure 7: a tenth of those of the adaptive law. {_READING}",
            lambda runs: _drawn(torques_figure, runs, "pd"),
            claims=("4",),
        ),
        PaperFigure(
            9,
            "Tracking errors",
            "Angle less reference model, adaptive law and PD: mind the scales, which differ by a factor of a hundred. "
            f"The adaptive law errs when a switch throws all three axes at once. {_READING}",
            errors_figure,
            claims=("1", "3"),
        ),
        PaperFigure(
            10,
            "Adaptive law with a delay of one sample",
            "The command acts one sample after the measurement, and the law is designed for that (d = 2). Angles and "
            f"torques are those of figures 4 and 5, half a second later. {_READING}",
            lambda runs: _drawn(both_figure, runs, "mrac", delay=1),
            claims=("2", "6", "7"),
        ),
        PaperFigure(
            11,
            "PD with a delay of one sample",
            f"At these gains the delay hardly matters: compare figures 7 and 8. {_READING}",
            lambda runs: _drawn(both_figure, runs, "pd", delay=1),
            claims=("3",),
        ),
        PaperFigure(
            12,
            "Law (32) rings",
            "Not in the paper. Law (32), started from the printed B, cancels the zero of the plant at -1: its torque "
            "changes sign at every sample and passes 10 N m, while the angles at the samples stay near the model. The "
            "law that keeps the zero needs 0.03 N m for the same.",
            ringing_figure,
            claims=("8", "9", "10"),
        ),
    ]


def _drawn(draw: Callable[[Series, ArrayLike], Figure], runs: Runs, law: str, delay: int = 0) -> Figure:
    run = runs(law, "paper", delay=delay)
    return draw(run.variables(), run.t)


def picture(dataset: xr.Dataset, manifest: Manifest) -> Figure:
    """Draw a run: angles, torques, tracking errors and the wheels' momentum over time.

    Parameters
    ----------
    dataset : xarray.Dataset
        A run of the satellite.
    manifest : Manifest
        The model's.

    Returns
    -------
    matplotlib.figure.Figure
    """
    series = {str(name): dataset[name].values for name in dataset.data_vars}
    t = dataset["t"].values
    figure = new_figure(10.0, 7.6)
    figure.suptitle(headline(dataset), fontsize=10, wrap=True)
    axes = figure.subplots(4, 2, sharex=True)
    for k in range(3):
        angle(axes[k, 0], t, series, k, False)
        torque(axes[k, 1], t, series, k, False)
    for k, axis in enumerate(AXES):
        error = np.degrees(series[axis] - series[f"ym_{axis}"])
        axes[3, 0].plot(t, error, color=COLORS[k], lw=1.2)
        axes[3, 1].plot(t, series[f"h{'xyz'[k]}"], color=COLORS[k], lw=1.2)
    time_axis(axes[3, 0], label("$e$", "error", "°"))
    time_axis(axes[3, 1], label("$h$", "momentum", "N m s"))
    legend(figure, "outside lower center")
    return figure
