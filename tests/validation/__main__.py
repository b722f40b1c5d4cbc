# SPDX-License-Identifier: Apache-2.0
"""Compare with every reference; write benchmarks/results/validation.md and the summary in docs/validation.md.

Run: python -m tests.validation [what pytest understands, such as -k JEOD]
"""

from __future__ import annotations

import re
import sys
from collections import Counter
from collections.abc import Collection, Mapping
from datetime import UTC, datetime

import pytest

from tests.validation.table import ROOT, ROWS, Row, read

PAGE = ROOT / "benchmarks" / "results" / "validation.md"
BEGIN, END = "<!-- table: written by make validate -->\n", "<!-- end of the table -->\n"
SUMMARY = ROOT / "docs" / "validation.md"
SUMMARY_BEGIN, SUMMARY_END = "<!-- summary: written by make validate -->\n", "<!-- end of the summary -->\n"


def main() -> int:
    """Run the cases and write their rows; omitted cases keep row and date.

    A case that ends without a result, as when a model refuses its options, has a row that says so.
    """
    ROWS.unlink(missing_ok=True)
    options = ["-q", "-p", "no:cacheprovider", "-o", "python_files=against_*.py"]
    ends = _Ends()
    status = pytest.main([*options, *sys.argv[1:], str(ROOT / "tests" / "validation")], plugins=[ends])
    complete = not sys.argv[1:] and status in (pytest.ExitCode.OK, pytest.ExitCode.TESTS_FAILED)
    write(read(), ends.passed, ends.without_result, complete)
    return int(status)


class _Ends:
    """A pytest plugin that distinguishes cases without a row from cases whose row does not hold."""

    def __init__(self) -> None:
        self.passed: set[str] = set()
        self.without_result: dict[str, str] = {}
        self._broken = 0

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.passed and report.when == "call":
            self.passed.add(report.nodeid)
        if report.failed:
            broken = sum(not row.holds for row in read())
            if broken == self._broken:
                self.without_result[report.nodeid] = str(report.longrepr).splitlines()[-1]
            self._broken = broken


def write(
    rows: list[Row], passed: Collection[str] = (), without_result: Mapping[str, str] = {}, complete: bool = False
) -> None:
    """Replace the rows of the same cases, or all rows, of the page.

    Parameters
    ----------
    rows : list of Row
        What the cases showed.
    passed : collection of str
        Tests that passed: an old row that says that one ended without a result goes.
    without_result : mapping
        Tests that ended otherwise, and how.
    complete : bool
        Whether all cases ran: old rows are of cases that are no more, or that end without a result now.
    """
    text = PAGE.read_text(encoding="utf-8")
    head, rest = text.split(BEGIN)
    table, tail = rest.split(END)
    lines = {
        _case(line): line for line in table.splitlines() if line.startswith("| ") and not line.startswith("| case ")
    }
    today = f"{datetime.now(UTC):%Y-%m-%d}"
    lines = {} if complete else {case: line for case, line in lines.items() if case not in passed}
    lines |= {row.case: _line(row, today) for row in rows}
    for name, reason in without_result.items():
        lines[name] = (
            f"| {name} | none | none | 0 | none | none | none | ended without a result: {reason} | {today} | **no** |"
        )
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
    _put_summary(summary(kept))


def _put_summary(lines: list[str]) -> None:
    head, rest = SUMMARY.read_text(encoding="utf-8").split(SUMMARY_BEGIN)
    tail = rest.split(SUMMARY_END)[1]
    SUMMARY.write_text(head + SUMMARY_BEGIN + "\n".join(lines) + "\n" + SUMMARY_END + tail, encoding="utf-8")


def summary(rows: list[str]) -> list[str]:
    """Return a line for each reference: subjects, number of cases, how many hold, and the case nearest to its bound.

    Parameters
    ----------
    rows : list of str
        Rows of the table of all cases.
    """
    cells = [[cell.strip() for cell in row.strip("|").split(" | ")] for row in rows]
    lines = [
        "| reference | version | compared | cases | hold | largest error over its bound | last run |",
        "|" + "---|" * 7,
    ]
    for name in sorted({row[1] for row in cells}, key=str.lower):
        own = [row for row in cells if row[1] == name]
        shares = [float(row[4]) / float(row[5]) for row in own if row[4] != "none" and float(row[5])]
        values = (
            name,
            ", ".join(sorted({row[2] for row in own})),
            ", ".join(sorted({row[0].partition(":")[0] for row in own})),
            str(len(own)),
            str(sum(row[-1] == "yes" for row in own)),
            f"{max(shares):.2g}" if shares else "none",
            max(row[-2] for row in own),
        )
        lines.append(f"| {' | '.join(values)} |")
    return lines


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
