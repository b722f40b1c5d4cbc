# SPDX-License-Identifier: Apache-2.0
"""Checks that several claims of the satellite share: the end of a run, and the size of an error."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mehvar.reproduction import Check, about
from mehvar.runtime import Status

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from mehvar.runtime import Run

    FloatArray = NDArray[np.float64]

_LOST = 0.02
"""Allowed deviation of the time at which a run is lost, relative: below one sample, 0.5 s, for times up to 25 s. All
but that of claim 7 agree to the sample, so half of this changes nothing; with twice, claim 7's agrees too."""


def ends(run: Run, what: str = "the run") -> Check:
    """Return the check that a run reaches its end time."""
    return Check(what, "reaches its end", run.reason, run.status is Status.DONE)


def lost(what: str, expected: float, run: Run) -> tuple[Check, Check]:
    """Return the checks that a run ends early, and at which time."""
    fate = Check(what, "lost", "lost" if run.status is Status.LIMIT else run.reason, run.status is Status.LIMIT)
    return fate, about(f"{what}: time", expected, run.t_stop, "s", _LOST)


def rms_degrees(off: Sequence[FloatArray]) -> FloatArray:
    """Return the root mean square of each series in degrees."""
    rms: FloatArray = np.degrees(np.sqrt(np.square(off).mean(axis=1)))
    return rms
