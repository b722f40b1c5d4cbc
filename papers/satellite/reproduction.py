# SPDX-License-Identifier: Apache-2.0
"""The paper on adaptive attitude control of a satellite: its words, and the functions that draw and check."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from mehvar.reproduction import read_reproduction

from .claims import CHECKS
from .design import independence_figure, locus_figure
from .figures import (
    angle_figure,
    angles_figure,
    board_angles_figure,
    board_torques_figure,
    both_figure,
    errors_figure,
    estimates_figure,
    ringing_figure,
    torques_figure,
)
from .picture import picture
from .readings import READINGS
from .rows import row_claims
from .schematic import bed, controller, parts
from .survival import survival_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from mehvar.reproduction import Runs


def _angles(runs: Runs) -> Figure:
    return angles_figure(runs("mrac", "paper"), runs("mrac-literal", "printed"))


def _torques(runs: Runs) -> Figure:
    return torques_figure(
        ("law that keeps the zero", runs("mrac", "paper")), ("law (32)", runs("mrac-literal", "printed"))
    )


def _delayed_pd(runs: Runs) -> Figure:
    run = runs("pd", "paper", delay=1)
    return both_figure(run.variables(), run.t)


REPRODUCTION = read_reproduction(
    Path(__file__).parent,
    draw={
        1: controller,
        2: bed,
        3: parts,
        4: _angles,
        5: _torques,
        6: lambda runs: angle_figure(runs("pd", "paper"), 0),
        7: lambda runs: angle_figure(runs("pd", "paper"), 1),
        8: lambda runs: angle_figure(runs("pd", "paper"), 2),
        9: lambda runs: torques_figure(("PD", runs("pd", "paper"))),
        10: board_angles_figure,
        11: board_torques_figure,
        12: estimates_figure,
        13: errors_figure,
        14: _delayed_pd,
        15: ringing_figure,
        16: survival_figure,
        17: independence_figure,
        18: locus_figure,
    },
    checks=CHECKS,
    readings=READINGS,
    more_claims=row_claims,
    picture=picture,
)
