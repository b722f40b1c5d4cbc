# SPDX-License-Identifier: Apache-2.0
"""The satellite's paper as printed, for the ledger: equations (1)-(50), Table 1, and sentences that can be checked."""

from __future__ import annotations

from mehvar import System
from mehvar.ledger import Names, Paper

from . import design, identification, motion, numbers
from .errata import ERRATA
from .identification import Estimator
from .loop import SampledLoop
from .numbers import Numbers
from .symbols import Motion

NUMBERS = 50
"""The equations are numbered from 1 to this."""
_NOTE = (
    "The paper was read from a scan by a machine, and its figures are lost. Whether an error is the scan's or the "
    "paper's is judged by the formulas around it; the printed volume can decide otherwise."
)


def paper(system: System) -> Paper:
    """Return what the paper prints, its symbols explained by a system derived with three angles."""
    names = Names()
    m, c = Motion(system, names), SampledLoop(system, names)
    e = Estimator(system, names)
    v = Numbers(system, names, c)
    entries = (
        *motion.balance(m),
        *motion.kinematics(m),
        *motion.linear(m),
        *design.form(c),
        *design.goals(c),
        *design.equation(c),
        *design.law(c),
        *identification.model(e),
        design.offset(c),
        *identification.recursion(e),
        *numbers.table(m, v),
        *numbers.sampled(c, v),
        *numbers.design(c, v),
        *numbers.runs(c, v),
    )
    return Paper(system.source, NUMBERS, names, entries, _NOTE, ERRATA)
