# SPDX-License-Identifier: Apache-2.0
"""Masses moved by forces: cost, tolerance and behaviour in orbit of the paper's laws."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from mehvar.pictures import BLACK, BLUE, GREEN, VERMILLION, label, new_figure, time_axis
from mehvar.reproduction import AMPLITUDES, Check, Expected, Runs, about, above, below, read_beyond

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from mehvar.runtime import Run

    FloatArray = NDArray[np.float64]

_LAWS = (("path", BLUE), ("sliding", VERMILLION))
_FORCES = ("u_F1", "u_F2", "u_F3")
_ORBIT = {"path": BLUE, "sliding": VERMILLION, "path-thrust": GREEN}
_DASHED = (0, (4, 2.5))


def _largest(run: Run) -> FloatArray:
    """Return the largest force of a rod at each instant, N."""
    series = run.variables()
    return np.asarray(np.abs([series[name] for name in _FORCES]).max(axis=0))


def _same_turn(runs: Runs, expected: Expected) -> Sequence[Check]:
    checks: list[Check] = []
    for law, _ in _LAWS:
        new, old = runs(law, "paper").variables()["theta"], runs.paper(law, "paper").variables()["theta"]
        times = [which.metrics(law, "paper")["T_theta"] for which in (runs, runs.paper)]
        checks += [
            below(f"{law}: largest difference of attitude", expected(law), float(np.abs(new - old).max()), "rad"),
            below(f"{law}: its settling time, relative", expected("ratio"), abs(times[0] / times[1] - 1)),
        ]
    return checks


def _costs(runs: Runs, expected: Expected) -> Sequence[Check]:
    path, sliding = (runs.metrics(law, "paper") for law in ("path", "sliding"))
    return (
        about("largest force, path", expected("force"), path["max_force"], "N", AMPLITUDES),
        about("that of sliding over it", expected("forces"), sliding["max_force"] / path["max_force"], "", AMPLITUDES),
        about("work, path", expected("work"), path["total_work"], "J", AMPLITUDES),
        about("that of sliding over it", expected("works"), sliding["total_work"] / path["total_work"], "", AMPLITUDES),
    )


def _cycle(runs: Runs, expected: Expected) -> Sequence[Check]:
    run = runs("path", "momentum")
    radius = np.sqrt(expected("drift") / run.parameters.values["k_phi"])
    end = runs.metrics("path", "momentum")
    return (
        about("rho~ at the end over sqrt(d/k_phi)", 1.0, end["rho_final"] / radius),
        below("change of the angular momentum", expected("change"), end["max_H"] - end["H_final"], "kg m^2/s"),
    )


def _orbit(runs: Runs, expected: Expected) -> Sequence[Check]:
    late = {law: float(np.abs(runs(law, "orbit").variables()["theta_error"][-100:]).max()) for law in _ORBIT}
    revolution = 2 * np.pi / runs("path", "orbit").parameters.values["mean_motion"] / 60
    return (
        about("a revolution", expected("revolution"), float(revolution), "min"),
        *(above(f"{law}: largest error at the end", expected("band"), late[law], "rad") for law, _ in _LAWS),
        below("path-thrust: largest error at the end", expected("held"), late["path-thrust"], "rad"),
    )


def _turn(runs: Runs) -> Figure:
    figure = new_figure(8.0, 4.4)
    upper, lower = figure.subplots(2, 1, sharex=True)
    for law, color in _LAWS:
        new, old = runs(law, "paper"), runs.paper(law, "paper")
        upper.plot(new.t, new.variables()["theta"], color=color, label=law)
        upper.plot(old.t, old.variables()["theta"], color=BLACK, ls=_DASHED, lw=0.9, label=f"{law}, kinematic")
        lower.plot(new.t, _largest(new), color=color, label=law)
    time_axis(upper, label(r"$\theta$", "attitude", "rad"), last=False)
    time_axis(lower, label("$|F|$", "force", "N"))
    upper.legend()
    return figure


def _in_orbit(runs: Runs) -> Figure:
    figure = new_figure(8.0, 3.0)
    ax = figure.subplots()
    for law, color in _ORBIT.items():
        run = runs(law, "orbit")
        ax.plot(run.t, run.variables()["theta_error"], color=color, label=law)
    time_axis(ax, label(r"$\theta - \theta_f$", "attitude error", "rad"))
    ax.legend()
    return figure


BEYOND = read_beyond(
    Path(__file__).parent,
    draw={1: _turn, 2: _in_orbit},
    checks={"B1": _same_turn, "B2": _costs, "B3": _cycle, "B4": _orbit},
)
