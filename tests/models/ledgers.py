# SPDX-License-Identifier: Apache-2.0
"""What the ledger of every paper must have."""

from __future__ import annotations

from mehvar.codegen.ledger.ledger import Ledger, Standing


def equations(ledger: Ledger) -> list[int]:
    """Return the numbers of the numbered equations, sorted."""
    return sorted(int(entry.number[1:-1]) for entry in ledger.entries if entry.number.startswith("("))


def judged(ledger: Ledger, verdict: Standing) -> set[str]:
    """Return the numbers of the entries with a verdict."""
    return {entry.number for entry in ledger.entries if entry.verdict is verdict}
