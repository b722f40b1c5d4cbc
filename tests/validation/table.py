# SPDX-License-Identifier: Apache-2.0
"""Rows of benchmarks/results/validation.md: compared quantities, errors and bounds."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

ROOT = Path(__file__).parents[2]
ROWS = ROOT / "build" / "validation" / "rows.jsonl"


@dataclass(frozen=True)
class Row:
    """A case of the table.

    Attributes
    ----------
    case, reference, version : str
        What was compared, with what, and which version of it.
    points : int
        Numbers compared.
    error, bound : float
        Largest error and what it may be, in `unit`.
    unit : str
        Of both, as the table says it.
    reason : str
        Where the bound comes from.
    """

    case: str
    reference: str
    version: str
    points: int
    error: float
    bound: float
    unit: str
    reason: str

    @property
    def holds(self) -> bool:
        """Return True if the error is within the bound; NaN is not."""
        return self.error <= self.bound


Record = Callable[..., None]


def record(case: str, reference: str, version: str, errors: ArrayLike, bound: float, unit: str, reason: str) -> None:
    """Write a row, then fail if its error exceeds the bound."""
    values = np.abs(np.asarray(errors, dtype=float))
    row = Row(case, reference, version, values.size, float(values.max()), float(bound), unit, reason)
    ROWS.parent.mkdir(parents=True, exist_ok=True)
    with ROWS.open("a", encoding="utf-8") as file:
        file.write(json.dumps(dataclasses.asdict(row)) + "\n")
    assert row.holds, f"{case}: {row.error:.2e} {unit}, {reference} allows {bound:.2e}"


def read() -> list[Row]:
    """Return the rows of the last run."""
    if not ROWS.exists():
        return []
    return [Row(**json.loads(line)) for line in ROWS.read_text(encoding="utf-8").splitlines()]
