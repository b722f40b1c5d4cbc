# SPDX-License-Identifier: Apache-2.0
"""Compare with every engine, and write the table of docs/validation.md.

Run: python -m tests.validation [what pytest understands, such as -k JEOD]
"""

from __future__ import annotations

import re
import sys
from collections import Counter
from datetime import UTC, datetime

import pytest

from tests.validation.table import ROOT, ROWS, Row, read

PAGE = ROOT / "docs" / "validation.md"
BEGIN, END = "<!-- table: written by make validate -->\n", "<!-- end of the table -->\n"


def main() -> int:
    """Run the cases and write what they showed; a case that was left out keeps its old row and date."""
    ROWS.unlink(missing_ok=True)
    options = ["-q", "-p", "no:cacheprovider", "-o", "python_files=against_*.py"]
    status = pytest.main([*options, *sys.argv[1:], str(ROOT / "tests" / "validation")])
    write(read())
    return int(status)


def write(rows: list[Row]) -> None:
    """Put rows into the page, in the place of rows of the same case."""
    text = PAGE.read_text(encoding="utf-8")
    head, rest = text.split(BEGIN)
    table, tail = rest.split(END)
    lines = {
        _case(line): line for line in table.splitlines() if line.startswith("| ") and not line.startswith("| case ")
    }
    today = f"{datetime.now(UTC):%Y-%m-%d}"
    lines |= {row.case: _line(row, today) for row in rows}
    kept = sorted(lines.values(), key=lambda line: (line.split(" | ")[1], _natural(line)))
    verdicts = Counter("holds" if line.endswith(" yes |") else "fails" for line in kept)
    title = (
        "| case | reference | version | numbers | largest error | bound | in | where the bound is from | date | holds |"
    )
    shown = [
        f"{len(kept)} cases: {verdicts['holds']} hold, {verdicts['fails']} fail.",
        "",
        title,
        "|" + "---|" * 10,
        *kept,
    ]
    PAGE.write_text(head + BEGIN + "\n".join(shown) + "\n" + END + tail, encoding="utf-8")


def _case(line: str) -> str:
    return line.split(" | ")[0].removeprefix("| ")


def _natural(line: str) -> list[str]:
    return [part.zfill(6) for part in re.split(r"(\d+)", line)]


def _line(row: Row, date: str) -> str:
    numbers = (f"{row.points}", f"{row.error:.1e}", f"{row.bound:.1e}")
    cells = (
        row.case,
        row.reference,
        row.version,
        *numbers,
        row.unit,
        row.reason,
        date,
        "yes" if row.holds else "**no**",
    )
    return f"| {' | '.join(cells)} |"


if __name__ == "__main__":
    sys.exit(main())
