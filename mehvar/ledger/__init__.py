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
    ErratumKind,
    Names,
    Paper,
    Printed,
    Reading,
    Relation,
    Side,
    frozen,
    insert_definitions,
    printed,
)

__all__ = [
    "Case",
    "Cross",
    "Definition",
    "EntryVerdict",
    "Equation",
    "Erratum",
    "ErratumKind",
    "Ledger",
    "Names",
    "Paper",
    "Printed",
    "Reading",
    "Relation",
    "Side",
    "check_entry",
    "check_paper",
    "frozen",
    "insert_definitions",
    "printed",
]
