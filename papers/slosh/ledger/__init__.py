# SPDX-License-Identifier: Apache-2.0
"""The slosh paper as printed, for the ledger: equations (1)-(36), Tables 1 and 2, sentences that can be checked."""

from __future__ import annotations

from mehvar import System
from mehvar.ledger import Names, Paper

from .angles import pendulums
from .balances import acceleration, forces, moments
from .energy import energy, laws_of_motion
from .errata import ERRATA
from .laws import Laws, candidates, control
from .numbers import Numbers, simulation, tables
from .reduced import equilibrium, reduced
from .symbols import Spacecraft

NUMBERS = 36
"""The equations are numbered from 1 to this."""
_NOTE = (
    "The paper was read from a scan by a machine, and its figures are lost. Whether an error is the scan's or the "
    "paper's is judged by the formulas around it; the printed volume can decide otherwise."
    " The paper prints theta_1 both for an attitude angle and for the azimuth of pendulum 1; the attitude angles are "
    "written vartheta here, as in (18)."
)


def paper(system: System) -> Paper:
    """Return what the paper prints, its symbols explained by a derived system with two pendulums."""
    names = Names()
    s = Spacecraft(system, names)
    law, numbers = Laws(system, names, s), Numbers(system, names)
    entries = (
        *laws_of_motion(s),
        *energy(s),
        *forces(s),
        *moments(s),
        *pendulums(s),
        acceleration(s),
        *equilibrium(s, law),
        *reduced(s, law),
        *candidates(s, law),
        *control(s, law),
        *tables(s, law, numbers),
        *simulation(s, law, numbers),
    )
    return Paper(system.source, NUMBERS, names, entries, _NOTE, ERRATA)
