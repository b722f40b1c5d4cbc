# SPDX-License-Identifier: Apache-2.0
"""Vocabulary of `papers/MODEL/ledger.py`: printed equations of a paper, and the derived meaning of its symbols.

`mehvar diff --paper` and `judge` judge a ledger; `judge_entry` judges a single entry. `mehvar.models.paper` describes
how to write entries.
"""

from __future__ import annotations

from mehvar.codegen.ledger.ledger import Ledger, Standing, judge, judge_entry
from mehvar.models.derivation import Definition, Equation
from mehvar.models.paper import (
    Case,
    Cross,
    Erratum,
    Names,
    Paper,
    Printed,
    Reading,
    Relation,
    Side,
    Slip,
    follow,
    frozen,
    printed,
)

__all__ = [
    "Case",
    "Cross",
    "Definition",
    "Equation",
    "Erratum",
    "Ledger",
    "Names",
    "Paper",
    "Printed",
    "Reading",
    "Relation",
    "Side",
    "Slip",
    "Standing",
    "follow",
    "frozen",
    "judge",
    "judge_entry",
    "printed",
]
