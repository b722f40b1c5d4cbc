# SPDX-License-Identifier: Apache-2.0
"""The triangle's paper as printed, for the ledger: equations (1)-(53), Table 1, and sentences that can be checked."""

from __future__ import annotations

from mehvar import System
from mehvar.ledger import Names, Paper

from .errata import ERRATA
from .forms import Forms, forms
from .kinematics import equal_masses, momentum, placing, rods, table
from .laws import Path, Shifted, Sliding
from .path import arcs, law, stability
from .simulation import runs
from .sliding import bound, control, shift, surface
from .symbols import Kinematics

NUMBERS = 53
"""The equations are numbered from 1 to this; (52) is printed twice, on two lines of one equation."""
_NOTE = (
    "The paper was read from a scan by a machine, and its figures are lost. Whether an error is the scan's or the "
    "paper's is judged by the formulas around it; the printed volume can decide otherwise."
)


def paper(system: System) -> Paper:
    """Return what the paper prints, its symbols explained by a derived system with equal masses."""
    names = Names()
    k = Kinematics(system, names)
    t = Shifted(system, names, k)
    s = Sliding(system, names, t)
    p = Path(system, names, t, s)
    entries = (
        *placing(k),
        *momentum(k),
        *equal_masses(k),
        *table(k),
        *rods(k),
        *forms(k, Forms(names, k)),
        *shift(k, t),
        *surface(k, t, s),
        *control(t, s),
        *bound(k, t, s),
        *arcs(t, p),
        *law(t, p),
        *stability(t, p),
        *runs(system, names, k, t, s),
    )
    return Paper(system.source, NUMBERS, names, entries, _NOTE, ERRATA)
