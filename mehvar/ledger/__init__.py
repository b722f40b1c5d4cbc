# SPDX-License-Identifier: Apache-2.0
"""Vocabulary of `papers/MODEL/ledger.py`: printed equations of a paper, and the derived meaning of its symbols.

`mehvar diff --paper` judges a ledger, and so does `judge`; `judge_entry` judges one entry while it is being written.
How an entry is written stands in `mehvar.models.paper`.
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
