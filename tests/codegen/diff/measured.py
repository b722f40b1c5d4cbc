# SPDX-License-Identifier: Apache-2.0
"""Verdicts of `mehvar diff` on the corpus, by class, for docs/explanation/how-a-verdict-is-reached.md.

Run: python -m tests.codegen.diff.measured [SEED ...]
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Iterable, Sequence

from mehvar.codegen.diff import compare
from mehvar.codegen.diff.report import Comparison, EquationVerdict

from .pairs import SEED, pairs

COLUMNS = (
    "class",
    "pairs that differ",
    "called same",
    "undecided",
    "pairs that are equal",
    "called different",
    "undecided",
)
Answers = Counter[tuple[bool, str]]
"""Numbers of pairs, by whether they differ and by their verdict."""


def answer(comparison: Comparison) -> str:
    """Return the verdict for a person: the same, different, or undecided."""
    if not comparison.differs:
        return "same"
    telling = [equation for equation in comparison if equation.matters]
    decided = comparison.parameters or any(equation.verdict is not EquationVerdict.UNDECIDED for equation in telling)
    return "different" if decided else "undecided"


def answers(seeds: Iterable[int]) -> dict[str, Answers]:
    """Compare every pair of some seeds, count the answers by class, and print wrong answers."""
    counts: dict[str, Answers] = {}
    for seed in seeds:
        for pair in pairs(seed):
            verdict = answer(compare(pair.old, pair.new))
            counts.setdefault(pair.group, Counter())[pair.differs, verdict] += 1
            if verdict != ("different" if pair.differs else "same"):
                print(f"seed {seed}, {pair.name}: {verdict}", file=sys.stderr)
    return counts


def table(counts: dict[str, Answers]) -> list[str]:
    """Return the lines of the table, the last one for all classes."""
    rows = {**counts, "all": sum(counts.values(), Counter())}
    return [_row(COLUMNS), _row(["---"] * len(COLUMNS)), *(_row(_cells(*row)) for row in rows.items())]


def _cells(group: str, count: Answers) -> list[str]:
    cells = [group]
    for differs, wrong in ((True, "same"), (False, "different")):
        total = sum(n for (kind, _), n in count.items() if kind is differs)
        cells += [str(total), str(count[differs, wrong]), str(count[differs, "undecided"])]
    return cells


def _row(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"


if __name__ == "__main__":
    print("\n".join(table(answers(map(int, sys.argv[1:] or [SEED])))))
