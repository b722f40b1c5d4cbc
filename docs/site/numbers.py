# SPDX-License-Identifier: Apache-2.0
"""List the pages of benchmarks/results in docs/numbers.md, below a summary of the main results."""

from __future__ import annotations

import re
from pathlib import Path

RESULTS = Path(__file__).parents[2] / "benchmarks" / "results"
PAGE = Path(__file__).parents[1] / "numbers.md"

_SUMMARY = (
    ("one closed loop, beside SciPy with generated Python", "closed_loop.md", "SciPy / ours", "", "times as fast"),
    ("one closed loop, beside SciPy with compiled C", "closed_loop.md", "SciPy compiled / ours", "", "times as fast"),
    ("a batch without a law, beside heyoka", "batch_open_loop.md", "peer / mehvar", "heyoka", "times as fast"),
    ("a batch without a law, beside SciPy", "batch_open_loop.md", "peer / mehvar", "scipy", "times as fast"),
    ("a batch without a law, beside Diffrax", "batch_open_loop.md", "peer / mehvar", "diffrax", "times as fast"),
    ("a run of the triangle, 35 s, in a batch", "batch_closed_loop.md", "ms per run", "triangle", "ms"),
    ("a run of the satellite, 300 s, in a batch", "batch_closed_loop.md", "ms per run", "satellite", "ms"),
    ("a run of slosh, 1000 s, in a batch", "batch_closed_loop.md", "ms per run", "slosh", "ms"),
    (
        "a run of a craft of 16 degrees of freedom, beside Basilisk",
        "craft.md",
        "tool / single",
        "Basilisk",
        "times as fast",
    ),
    ("the same, beside Drake", "craft.md", "tool / single", "Drake", "times as fast"),
    ("the same in a batch, beside Basilisk", "craft.md", "tool / batch", "Basilisk", "times as fast"),
    ("the same in a batch, beside Drake", "craft.md", "tool / batch", "Drake", "times as fast"),
    (
        "a run under a sampled law in Python",
        "own_law.md",
        "times the generated law",
        "in Python, sampled",
        "times that of a generated law",
    ),
    (
        "a run under a continuous law in Python",
        "own_law.md",
        "times the generated law",
        "in Python, continuous",
        "times that of a generated law",
    ),
    ("the slowest of 60 comparisons of an edited model", "diff.md", "largest s", "", "s"),
)
"""Rows of the summary: quantity, page, column, beginning of the used rows, and unit of the numbers."""
_COMMANDS = {
    "batch.md": "put together by hand from the four pages of batches below; "
    + ", ".join(f"`python -m benchmarks.batch.{name}`" for name in ("rhs", "closed_loop", "open_loop", "scaling")),
    "soak.md": "made by `make soak`",
}
"""Commands of pages that do not name the command that wrote them."""
_SETTINGS = {
    "batch.md": "tolerance 1e-6; a user's default is 1e-11",
    "generate.md": "with a user's defaults",
    "fmi.md": "co-simulation with a user's defaults, model exchange with CVODE at 1e-10",
    "diff.md": "with a user's defaults",
    "mutation.md": "six points a gate; a user's default is 12",
    "mutation_parts.md": "12 to 400 points a gate; a user's default is 12",
    "kill_test.md": "0.2 s of the triangle, a sample every 0.1 s; a user's defaults are 35 s and none",
    "matrix.md": "with a user's defaults",
    "bare.md": "tolerances as the table says, a held input and one sample; a user's default is 1e-11",
    "fixed_costs.md": "tolerance 1e-6, one sample; a user's default is 1e-11",
    "precision.md": "whole scenarios at tolerances as the table says; a user's default is 1e-11",
    "own_law.md": "100 s of the satellite, own laws sampled every 0.5 s; a user's defaults are 800 s and continuous",
    "from_parts.md": "operations of a user's defaults",
    "small_edits.md": "the models in their default structure, which is a user's default",
    "soak.md": "settings stand on the page of each figure, beside a user's defaults where they differ",
    "store.md": "0.2 s of the triangle, a sample every 0.1 s; a user's defaults are 35 s and none",
    "tune.md": "16 runs of 40 s in each mean cost; a user's default is 256",
    "tools.md": "one call at one point with a user's default parameters",
    "validation.md": "tolerances of the cases; a user's default is 1e-11",
    "mutants.md": "the tests with a user's defaults",
    "closed_loop.md": "samples every 1 s where a heading says so; a user's default is 0.01 s",
    "batch_open_loop.md": "tolerances and steps as the tables say; a user's default is dop853 at 1e-11",
    "batch_closed_loop.md": "tolerance 1e-6, the method that a campaign names; a user's default is dop853 at 1e-11",
    "batch_rhs.md": "one call of a right-hand side; 'fast' is a profile to ask for, 'portable' a user's default",
    "growth.md": "horizons and samples as the headings say, everything else a user's default",
    "batch_scaling_pendulums.md": "rk4, 100 steps of 0.1 s, held input; a user's default is dop853 at 1e-11",
    "batch_scaling_threads.md": "tolerance 1e-6; a user's default is 1e-11",
    "compare.md": "tolerance 1e-9, on ball joints, own laws every 0.1 s; a user's default is 1e-11 and continuous",
    "craft.md": "tolerances and steps as the tables say; a user's defaults are among them",
    "board.md": "one sample of delay and 5000 samples; a user's defaults are none and 1600",
}
"""Settings of each page's measurements, where they differ from a user's defaults."""
_HEAD = """# Numbers

Every measurement has a page with machine, versions, date, command and caveats. Machines were shared: compare ratios.
[Benchmarks](../benchmarks/README.md) explains how to repeat them; `python docs/site/numbers.py` writes this page.

Times of different tools are at equal error. The smallest and the largest number of a page's tables:

| measured | result | page |
|---|---|---|
"""
_INDEX = """## All measurements

| page | how it was made |
|---|---|"""


def page(results: Path = RESULTS) -> str:
    """Return the page of numbers as Markdown: the summary, then a row for each page of results."""
    texts = {path.name: _text(path) for path in sorted(results.glob("*.md"))}
    summary = [
        f"| {what} | {_span(texts[name], *column)} | {_link(name, texts[name])} |" for what, name, *column in _SUMMARY
    ]
    rows = [f"| {_link(name, text)} | {_origin(name, text)} |" for name, text in texts.items()]
    return _HEAD + "\n".join([*summary, "", _INDEX, *rows, ""])


def _text(path: Path) -> str:
    """Return a page of results without its folded parts."""
    return re.sub(r"<details>.*?</details>", "", path.read_text(encoding="utf-8"), flags=re.DOTALL)


def _link(name: str, text: str) -> str:
    title = re.search(r"^# (.+)$", text, flags=re.MULTILINE)
    return f"[{title[1] if title else name}](../benchmarks/results/{name})"


def _span(text: str, column: str, row: str, what: str) -> str:
    """Return the smallest and largest number in a column of a page's tables, in rows with this beginning."""
    found = []
    for table in re.findall(r"(?:^\|.*\n){3,}", text, flags=re.MULTILINE):
        head, _, *rows = ([cell.strip() for cell in line.strip("| ").split("|")] for line in table.splitlines())
        if column in head:
            found += [entries[head.index(column)] for entries in rows if entries[0].startswith(row)]
    if not found:
        raise SystemExit(f"no table has {column!r} in rows of {row!r}: mend docs/site/numbers.py")
    ends = dict.fromkeys((min(found, key=float), max(found, key=float)))
    return f"{' to '.join(ends)} {what}"


def _origin(name: str, text: str) -> str:
    """Return the command that made the numbers of a page, with settings that differ from the defaults."""
    made = _COMMANDS.get(name, "")
    command = re.search(r"`((?:python|make) [^`\n]+)`", text)
    if not made and command is None:
        raise SystemExit(f"benchmarks/results/{name} names no command that wrote it")
    made = made or f"made by `{command[1]}`"
    return f"{made[0].upper()}{made[1:]}; {_SETTINGS[name]}"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
    print(f"wrote {PAGE}")
