# SPDX-License-Identifier: Apache-2.0
"""One task in six tools: slosh under an LQR, a thousand runs; lines, processor time on one core, agreement.

Run: python -m benchmarks.compare, in an environment with mehvar and benchmarks/peers/lqr/requirements.txt. What is not
installed, or cannot do it, gets a row that says so.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from benchmarks.machine import command_line, machine, table, write

PROGRAMS = Path(__file__).parent / "peers" / "lqr"
BUILD = Path(__file__).parents[1] / "build" / "compare"
PAGE = Path(__file__).parents[1] / "docs" / "compare.md"
BEGIN, END = "<!-- table: written by python -m benchmarks.compare -->", "<!-- end of table -->"
TOOLS = {
    "mehvar": "mehvar",
    "parts": "mehvar",
    "own": "mehvar",
    "heyoka": "heyoka",
    "Drake": "drake",
    "PyDy": "pydy",
    "Basilisk": "bsk",
    "python-control": "control",
}
"""Packages of the tools; mehvar first, because it draws all initial states. `parts` is mehvar with a craft from parts,
`own` with a user's model."""
MODELS = {"mehvar": "its model", "parts": "from parts", "own": "own model"}
TURNS = 3
"""Number of starts: the first without caches, the others with caches; the tools take turns."""
REFERENCE = 1e-13


def main() -> None:
    """Measure and write the page."""
    command_line(__doc__).parse_args()
    facts = machine()
    shutil.rmtree(BUILD, ignore_errors=True)
    turns = [{tool: fly(tool) for tool in TOOLS} for _ in range(TURNS)]
    reference = fly("mehvar", "--tolerance", str(REFERENCE))["final"]
    rows = [row(tool, [turn[tool] for turn in turns], reference) for tool in TOOLS]
    columns = ["tool", "lines", "first start, s", "later starts, s", "one run, s", "a thousand runs, s", "flown",
               "difference, median", "largest"]  # fmt: skip
    lines = table(columns, rows)
    quote(lines)
    write(
        "compare.md",
        [
            "# One task in six tools",
            "",
            "Written by `python -m benchmarks.compare`. A craft with two fuel pendulums, a sample of its LQR every",
            "0.1 s, 20 s, from a thousand starts; every tool at its tolerance of 1e-9.",
            "[The page](../../docs/compare.md) says what the task is, and what the numbers do not say.",
            "",
            "## Machine",
            "",
            *facts,
            "",
            "## Lines, times, agreement",
            "",
            "Lines are those of the program with code in them; numbers and law, which all share, are not counted.",
            "Processor time on one core, compilers included: of a start until the first run is there, then of the",
            "second run, then of a thousand, from as many as were flown. Imports are not in it. First start: nothing",
            "is kept from earlier ones.",
            f"Medians of {TURNS} turns. Differences are to mehvar at {REFERENCE:.0e}: of each run the largest",
            "|x - x_ref| / (1 + |x_ref|) over its 22 last states.",
            "",
            *lines,
        ],
    )


def quote(lines: list[str]) -> None:
    """Insert the table into its page."""
    before, rest = PAGE.read_text(encoding="utf-8").split(BEGIN)
    after = rest.partition(END)[2]
    PAGE.write_text("\n".join([before + BEGIN, *lines, END + after]), encoding="utf-8", newline="\n")


def fly(tool: str, *more: str) -> dict[str, Any]:
    """Run a tool's program on one core; return its measurements and final states, or the reason of a failure."""
    name = tool.removeprefix("python-").lower()
    out = BUILD / f"{name}.npz"
    out.parent.mkdir(parents=True, exist_ok=True)
    threads = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    done = subprocess.run(
        [sys.executable, PROGRAMS / f"in_{name}.py", "--out", out, *more],
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | threads | {"MEHVAR_CACHE": str(BUILD / "cache"), "XDG_CACHE_HOME": str(BUILD / "cache")},
    )
    if done.returncode:
        why = (done.stderr.strip().splitlines() or ["no message"])[-1]
        print(f"{tool}: not run: {why}", flush=True)
        return {"why": why}
    with np.load(out) as kept:
        facts = json.loads(str(kept["facts"]))
        print(f"{tool}: {facts}", flush=True)
        return {**facts, "final": kept["final"]}


def row(tool: str, turns: list[dict[str, Any]], reference: np.ndarray) -> list[str]:
    """Return a row of the table."""
    try:
        name = f"{tool} {version(TOOLS[tool])}"
    except PackageNotFoundError:
        name = tool
    if tool in MODELS:
        name = f"mehvar {version('mehvar')}, {MODELS[tool]}"
    failed = [turn["why"] for turn in turns if "why" in turn]
    if failed:
        return [name, f"not run: {failed[0][:80]}", *["-"] * 7]
    final = turns[-1]["final"]
    wanted = reference[: len(final)]
    errors = np.max(np.abs(final - wanted) / (1 + np.abs(wanted)), axis=1)
    return [
        *(name, str(turns[0]["lines"]), f"{turns[0]['set_up']:.1f}"),
        f"{median(turn['set_up'] for turn in turns[1:]):.1f}",
        *(f"{median(turn[part] for turn in turns):.3g}" for part in ("one", "thousand")),
        *(str(len(final)), f"{np.median(errors):.0e}", f"{errors.max():.0e}"),
    ]


if __name__ == "__main__":
    main()
