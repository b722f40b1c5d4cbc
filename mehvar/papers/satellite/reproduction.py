# SPDX-License-Identifier: Apache-2.0
"""The paper on adaptive attitude control of a satellite: its words, and the functions that draw and check."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from ..reproduction import read_reproduction
from .claims import CHECKS
from .figures import angles_figure, both_figure, errors_figure, estimates_figure, ringing_figure, torques_figure
from .picture import picture
from .rows import row_claims
from .scene import scene

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.figure import Figure
    from numpy.typing import ArrayLike

    from ..runs import Runs
    from .figures import Series


def _drawn(draw: Callable[[Series, ArrayLike], Figure], law: str, delay: int = 0) -> Callable[[Runs], Figure]:
    """Return how a figure of one run is drawn."""

    def drawn(runs: Runs) -> Figure:
        run = runs(law, "paper", delay=delay)
        return draw(run.variables(), run.t)

    return drawn


REPRODUCTION = read_reproduction(
    Path(__file__).parent,
    draw={
        4: _drawn(angles_figure, "mrac"),
        5: _drawn(torques_figure, "mrac"),
        6: estimates_figure,
        7: _drawn(angles_figure, "pd"),
        8: _drawn(torques_figure, "pd"),
        9: errors_figure,
        10: _drawn(both_figure, "mrac", delay=1),
        11: _drawn(both_figure, "pd", delay=1),
        12: ringing_figure,
    },
    checks=CHECKS,
    more_claims=row_claims,
    scene=scene,
    picture=picture,
)
