# SPDX-License-Identifier: Apache-2.0
"""Vocabulary of `papers/MODEL/reproduction.py`: runs, claims, figures and extensions of a paper."""

from __future__ import annotations

from mehvar.base.schema import read_data
from mehvar.runtime.run.metrics import AMPLITUDES, TIMES

from .beyond import Beyond, read_beyond
from .claims import (
    Check,
    Checks,
    Claim,
    ClaimKind,
    Expected,
    Readings,
    about,
    above,
    below,
    count,
    in_words,
    not_essential,
)
from .paper import Reproduction, read_reproduction
from .runs import Runs

__all__ = [
    "AMPLITUDES",
    "TIMES",
    "Beyond",
    "Check",
    "Checks",
    "Claim",
    "ClaimKind",
    "Expected",
    "Readings",
    "Reproduction",
    "Runs",
    "about",
    "above",
    "below",
    "count",
    "in_words",
    "not_essential",
    "read_beyond",
    "read_data",
    "read_reproduction",
]
