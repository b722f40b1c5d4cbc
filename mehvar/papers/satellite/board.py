# SPDX-License-Identifier: Apache-2.0
"""What any run of the adaptive law on a board shows of figures 10 and 11, angles and torques behind the delay."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..reproduction import BoardPart
from .figures import both_figure
from .rows import AXES, LATE, measure

if TYPE_CHECKING:
    from collections.abc import Mapping

    from matplotlib.figure import Figure

    from mehvar.runtime.run.simulate import Run

_FIGURES = {"mrac": 10}


def _draw(run: Run) -> Figure:
    return both_figure(run.variables(), run.t)


def _numbers(law: str, runs: Mapping[str, Run], period: float) -> dict[str, Any] | None:
    """Return errors and torques from 200 s on, if the board's run has more than a sample there."""
    board, *_ = runs.values()
    if board.t[-1] <= LATE + period:
        return None
    metrics = {name: measure(run) for name, run in runs.items()}
    return {
        "number": _FIGURES[law],
        "from": LATE,
        "rms_error_degrees": {name: list(m.rms) for name, m in metrics.items()},
        "largest_error_degrees": {name: list(m.largest) for name, m in metrics.items()},
        "largest_torque": {name: list(m.torque) for name, m in metrics.items()},
    }


def _rows(numbers: Mapping[str, Any]) -> list[tuple[str, str, str]]:
    return [
        (
            f"RMS error of {', '.join(AXES)} from {numbers['from']:g} s on, {name.replace('_', ' ')}",
            ", ".join(f"{value:.4f}" for value in values) + " deg",
            f"measured, as in figure {numbers['number']}",
        )
        for name, values in numbers["rms_error_degrees"].items()
    ]


BOARD = BoardPart("mrac", _FIGURES, _draw, _numbers, _rows)
