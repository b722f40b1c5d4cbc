# SPDX-License-Identifier: Apache-2.0
"""Checked ledgers as an HTML page: printed and correct equations side by side."""

from __future__ import annotations

from collections.abc import Sequence

from mehvar.html import page

from .ledger_text import correction, counted, example, slips
from .ledgers import Ledger

FILTERS = {"counted": counted, "example": example, "slips": slips, "correction": correction}
"""Template functions for ledgers."""


def paper_page(ledgers: Sequence[Ledger]) -> str:
    """Return the page that compares printed with derived equations."""
    return page("diff_paper.html.j2", FILTERS, ledgers=ledgers) + "\n"
