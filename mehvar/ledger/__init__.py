# SPDX-License-Identifier: Apache-2.0
"""Vocabulary of `papers/MODEL/ledger.py`: printed equations of a paper, and the derived meaning of its symbols.

`mehvar diff --paper` and `check_paper` check a ledger; `check_entry` checks a single entry. `mehvar.models.paper`
describes how to write entries.
"""

from __future__ import annotations

from mehvar.codegen.ledger.ledger import EntryVerdict, Ledger, check_entry, check_paper
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
    "EntryVerdict",
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
    "check_entry",
    "check_paper",
    "follow",
    "frozen",
    "printed",
]
