# SPDX-License-Identifier: Apache-2.0
"""Work and precision of open-loop batches: mehvar's kernel and other integrators of the same equations.

Run in an environment that has benchmarks/peers/requirements.txt beside mehvar; a few minutes for each case:

    python -m benchmarks.batch.open_loop            # all cases
    python -m benchmarks.batch.open_loop slosh ball # some; the others keep their recorded numbers
    python -m benchmarks.batch.open_loop --tables   # nothing is measured, tables and picture are made again
"""

from __future__ import annotations

import json
import os
import tempfile
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

os.environ.setdefault("XLA_FLAGS", "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1")

import numpy as np

from benchmarks.machine import RESULTS, machine, table, write
from benchmarks.peers import contenders
from benchmarks.peers.contenders import Contender
from benchmarks.peers.problem import CASES, CHECKED, REFERENCE_TOLERANCE, RUNS, SPREAD, Problem, problem
from benchmarks.peers.report import REPEATS, attempt, everything, parts_to_measure, take_turns, time_for
from mehvar.runtime.compiling.processor import widest

RECORD = RESULTS / "batch_open_loop.json"
ERRORS = (1e-7, 1e-10)
TOLERANCES = tuple(10.0**-k for k in range(5, 13))
STEPS = 100  # of rk4
AIMS = {
    "heyoka": (5, 10),
    "numba rk4": (4, 8),
    "scipy": (30, 60),
    "casadi": (50, 100),
    "diffrax": (40, 100),
    "jax": (40, 100),
}
"""Ratio of speeds for each peer: minimum and target."""
PEERS = ("heyoka", "numba", "scipy", "casadi", "jax", "diffrax")


def main() -> None:
    """Measure the requested cases, and write all tables and the picture."""
    record: dict[str, Any] = json.loads(RECORD.read_text()) if RECORD.exists() else {}
    for name in parts_to_measure(__doc__, CASES):
        with tempfile.TemporaryDirectory() as scratch:
            record[name] = measured(name, Path(scratch))
        RECORD.write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
    tables(record)
    from benchmarks.peers.picture import picture

    picture(record, RESULTS / "batch_open_loop.png")


def measured(name: str, scratch: Path) -> dict[str, Any]:
    """Build every contender, time all in turns, and return the time and error of each."""
    given, missing, result = problem(CASES[name], scratch), dict[str, str](), list[Contender]()
    print(f"{given.case.title}: {given.slope.operations} operations", flush=True)
    lines = machine()
    for title, make in makers(given, scratch).items():
        built, why = attempt(make)
        result += built
        if why:
            missing[title] = why
    rows = take_turns(result, given.error)
    versions = ", ".join(f"{peer} {version(peer)}" for peer in PEERS)
    return {
        **{"title": given.case.title, "operations": given.slope.operations, "rows": rows, "not run": missing},
        **{"machine": [*lines, f"- peers: {versions}"], "lanes": widest(), "floor": floor(given, rows)},
    }


def floor(given: Problem, rows: Sequence[dict[str, Any]]) -> float:
    """Return the difference of the most exact peer from the reference; smaller errors are not compared."""
    return min(row["error"] for row in rows if not row["name"].startswith("mehvar"))


def makers(given: Problem, scratch: Path) -> dict[str, Callable[[], Iterator[Contender]]]:
    """Return the contenders."""
    strict = tuple(10.0**-k for k in range(7, 13))
    return {
        "mehvar": lambda: contenders.ours(given, TOLERANCES),
        "mehvar rk4": lambda: contenders.ours_rk4(given, STEPS),
        "heyoka": lambda: contenders.heyoka(given, TOLERANCES, compact=False),
        "heyoka, flags": lambda: contenders.heyoka_flags(given, TOLERANCES),
        "heyoka, compact mode": lambda: contenders.heyoka(given, (1e-6, 1e-9), compact=True),
        "heyoka, ensemble": lambda: contenders.heyoka_ensemble(given, (1e-6, 1e-9)),
        "numba": lambda: contenders.numba_rk4(given, STEPS),
        "scipy": lambda: contenders.scipy_lsoda(given, strict),
        "casadi": lambda: contenders.casadi_cvodes(given, strict, scratch),
        "jax": lambda: contenders.jax_rk4(given, STEPS),
        "diffrax": lambda: contenders.diffrax(given, (1e-6, 1e-8, 1e-10, 1e-12)),
    }


def tables(record: dict[str, Any]) -> None:
    """Write the page."""
    lines = [*_head(), ""]
    for entry in record.values():
        lines += [f"## {entry['title']}", "", *entry["machine"], ""]
        lines += [f"{entry['operations']} operations a right-hand side, {entry['lanes']} lanes of double. "
                  f"The most exact peer is within {entry['floor']:.0e} of the reference.", ""]  # fmt: skip
        lines += [*table(["peer", "compared at", "mehvar, us per run", "peer, us per run", "peer / mehvar",
                          "asked", "aim", "holds"], comparison(entry["rows"])), ""]  # fmt: skip
        lines += [f"Not run: {name} ({why})." for name, why in entry["not run"].items()]
        lines += ["<details><summary>all measurements</summary>", "", *everything(entry["rows"]), "", "</details>", ""]
    write("batch_open_loop.md", lines)


def comparison(rows: Sequence[dict[str, Any]]) -> list[list[str]]:
    """Return the times of mehvar and of each peer at equal error, or for equal steps of the same method."""
    groups: dict[str, list[dict[str, Any]]] = defaultdict(list)
    for row in rows:
        groups["mehvar" if row["name"].startswith("mehvar dop") else row["name"]].append(row)
    result = []
    for peer, (least, aim) in AIMS.items():
        mine = [r for name, several in groups.items() if name.startswith(peer) for r in several]
        fixed = [r for r in mine if "rk4" in r["name"]]
        if any(np.isfinite(r["error"]) for r in fixed):
            us = min(r["seconds"] for r in rows if r["name"].startswith("mehvar rk4"))
            result.append(_ratio(peer, f"{STEPS} steps of rk4", us, min(r["seconds"] for r in fixed), least, aim))
        for error in ERRORS if len(mine) > len(fixed) else ():
            them = min(time_for(error, [r for r in mine if r["name"] == name]) for name in {r["name"] for r in mine})
            result.append(_ratio(peer, f"error {error:.0e}", time_for(error, groups["mehvar"]), them, least, aim))
    return result


def _ratio(peer: str, at: str, us: float, them: float, least: float, aim: float) -> list[str]:
    if not np.isfinite(us / them) or not np.isfinite(them):
        return [peer, at, f"{us * 1e6:.2f}", "not reached", "-", f"{least}", f"{aim}", "-"]
    ratio = them / us
    verdict = "aim reached" if ratio >= aim else ("yes" if ratio >= least else "no")
    return [peer, at, f"{us * 1e6:.2f}", f"{them * 1e6:.2f}", f"{ratio:.1f}", f"{least}", f"{aim}", verdict]


def _head() -> list[str]:
    return [
        "# Batches against other integrators, without a law",
        "",
        "Written by `python -m benchmarks.batch.open_loop`. The first input of a law is held to the end; initial",
        f"states and all parameters of {RUNS} runs differ by up to {100 * SPREAD:g} %.",
        "",
        "![work and precision](batch_open_loop.png)",
        "",
        "- Everybody integrates the same instructions, translated from the tape that our C is printed from: what is",
        "  left of the right-hand side once all that depends on parameters and held input alone has been computed.",
        "  Those constants differ from run to run, so nobody has them compiled in.",
        "- Time: processor time of the process on one thread. All contenders and settings take turns within one",
        f"  process; medians of {REPEATS} repeats. The machine was shared with other programs, so compare ratios. Its",
        "  two cores may be two threads of one: then a busy neighbour slows vector code more than scalar code.",
        f"- Error: the median over {CHECKED} runs of the largest |x - x_ref|/(1 + |x_ref|) at the end, against our own",
        f"  dop853 at tolerance {REFERENCE_TOLERANCE:g}; the floor below shows that a peer agrees with it.",
        "- Equal error: log-log interpolation over a ladder of tolerances. Of several ways to use a peer the fastest",
        "  counts, of our methods and profiles too. Loosest tolerance already more exact than asked: its time counts.",
        "- heyoka: one object for all batches; compiling it without compact mode is its fastest way, and its set-up",
        "  the longest. scipy and casadi are called once for each run. Set-up, which includes compiling, is not in the",
        "  times; it is what the process itself spent, without the C compiler's.",
    ]


if __name__ == "__main__":
    main()
