# SPDX-License-Identifier: Apache-2.0
"""Wrong terms that the physics gates detect: every additive term of every plant flipped, dropped, doubled.

Run: python -m benchmarks.mutation
"""

from __future__ import annotations

import subprocess
import sys
from collections import Counter
from datetime import UTC, datetime
from pathlib import Path
from time import perf_counter

from benchmarks.machine import command_line, table, write
from benchmarks.machine import machine as this_machine

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

from mehvar.physics.mutation import Mutant, Tally, run  # noqa: E402
from tests.mehvar.physics.declared import EVERY, Case, gates_of, title  # noqa: E402
from tests.mehvar.physics.installed import machine  # noqa: E402


def main() -> None:
    """Try every wrong term, and write the page."""
    lines = _head()
    tallies = {case: _try(case) for case in EVERY}
    lines += ["## Killed", "", *_table(tallies), "", *_list("Equivalent", tallies, "equivalent")]
    lines += _list("Survivors", tallies, "survivors")
    for model in dict.fromkeys(model for model, _ in EVERY):
        lines += _per_gate(model, [tally for (name, _), (tally, _) in tallies.items() if name == model])
    write("mutation.md", lines)


def _head() -> list[str]:
    return [
        "# Wrong terms that the physics gates notice",
        "",
        "Written by `python -m benchmarks.mutation` on "
        f"{datetime.now(UTC):%Y-%m-%d} at commit {_commit()}. What the gates are:",
        "[Physics gates](../../docs/explanation/physics-gates.md).",
        "",
        "A mutant is the plant with one additive term changed: sign flipped, dropped, or doubled. Terms are those of",
        "x', outputs, initial state, reference, regular chart and the model's own functions, and of every definition",
        "behind them, nested sums included; an expression without a sum is one term. Laws, actuators, sensors and",
        "margins are not mutated. A mutant is killed when a gate's relative error exceeds 1e-9 at one of six random",
        "points. The gates stand alone: the comparison with the derived equations, which generation makes, is not one",
        "of them. Equivalent is a mutant that no gate notices and that leaves every function of the plant unchanged,",
        "to 1e-13, at 500 random points of the ranges in `tests/sampling.py`. A side that is not finite is noticed.",
        "",
        "## Machine",
        "",
        *this_machine(),
        "",
    ]


def _try(case: Case) -> tuple[Tally, float]:
    model, structure = case
    start = perf_counter()
    subject = machine(model, *structure)
    tally = run(subject.system, subject.ranges, gates_of)
    print(f"{title(case)}: {tally.killed} of {tally.total}", file=sys.stderr, flush=True)
    return tally, perf_counter() - start


def _table(tallies: dict[Case, tuple[Tally, float]]) -> list[str]:
    rows = []
    for case, (v, seconds) in tallies.items():
        counts = (v.terms, v.total, v.killed, len(v.equivalent), len(v.survivors), len(v.verified))
        rows.append([title(case), *map(str, counts), f"{seconds:.0f}"])
    total = [sum(int(row[k]) for row in rows) for k in range(1, 8)]
    columns = ["structure", "terms", "mutants", "killed", "equivalent", "survived", "of these found by generation", "s"]
    return table(columns, [*rows, ["all", *map(str, total)]])


def _list(heading: str, tallies: dict[Case, tuple[Tally, float]], kind: str) -> list[str]:
    result: list[tuple[Case, Mutant]] = [(case, m) for case, (v, _) in tallies.items() for m in getattr(v, kind)]
    rows = [[title(case), m.term.owner, f"`{m.term.text[:100]}`", m.change] for case, m in result]
    shown = table(["structure", "in", "term", "change"], rows) if rows else ["None."]
    return [f"## {heading}", "", *shown, ""]


def _per_gate(model: str, tallies: list[Tally]) -> list[str]:
    killers = sum((tally.killers for tally in tallies), Counter[str]())
    rows = [[gate, str(count)] for gate, count in killers.most_common()]
    return [f"## First gate to notice, {model}", "", *table(["gate", "mutants"], rows), ""]


def _commit() -> str:
    def git(*arguments: str) -> str:
        done = subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True, check=True)
        return done.stdout.strip()

    used = ("models", "mehvar/physics", "tests/mehvar/physics", "tests/sampling.py")
    changed = git("status", "--porcelain", "--", *used)
    return git("rev-parse", "--short=10", "HEAD") + (", with uncommitted changes" if changed else "")


if __name__ == "__main__":
    command_line(__doc__).parse_args()
    main()
