# SPDX-License-Identifier: Apache-2.0
"""Short measurement of the main claims of speed: mehvar, heyoka and CVODES, with the published ratios.

    make sceptic

sets up an environment of its own with heyoka and runs this. Everything is what the long benchmarks use, with fewer
peers: the same equations, the same runs, the same way to find times at equal error.
"""

from __future__ import annotations

import json
import tempfile
from pathlib import Path
from typing import Any

from benchmarks.batch import closed_loop, open_loop
from benchmarks.machine import machine, table
from benchmarks.peers import contenders
from benchmarks.peers.contenders import Contender
from benchmarks.peers.problem import CASES, LOOPS, Case, problem
from benchmarks.peers.report import take_turns, time_for

LOOP = (1e-5, 1e-6, 1e-7, 1e-8)
"""Tolerances whose errors lie on both sides of 1e-6 for all three."""

PEERS = (1e-6, 1e-8, 1e-10, 1e-12)
"""Tolerances of heyoka, which compiles for each, in its width and in mehvar's."""


def main() -> None:
    """Measure and print; nothing is written."""
    print("\n".join(machine()), flush=True)
    recorded = json.loads(open_loop.RECORD.read_text(encoding="utf-8"))
    rows = [row for name, case in CASES.items() for row in _without_law(case, recorded[name]["rows"])]
    rows += _loop(LOOPS["slosh"], json.loads(closed_loop.RECORD.read_text(encoding="utf-8"))["slosh"]["rows"])
    columns = ["case", "peer", "error", "ours, us a run", "peer, us a run", "peer / ours", "on the page"]
    print("\n" + "\n".join(table(columns, rows)))


def _without_law(case: Case, recorded: list[dict[str, Any]]) -> list[list[str]]:
    with tempfile.TemporaryDirectory() as scratch:
        given = problem(case, Path(scratch))
        candidates = [
            *contenders.ours(given, open_loop.TOLERANCES, contenders.OURS[:2]),
            *contenders.heyoka(given, PEERS, compact=False),
            *contenders.heyoka_flags(given, PEERS),
        ]
        rows = take_turns(candidates, given.error)
    return [_compared(case, "heyoka taylor", error, rows, recorded) for error in open_loop.ERRORS]


def _loop(case: Case, recorded: list[dict[str, Any]]) -> list[list[str]]:
    with tempfile.TemporaryDirectory() as scratch:
        given = problem(case, Path(scratch))
        candidates: list[Contender] = [
            *contenders.ours(given, LOOP, (("rodas5p", "portable"),)),
            *contenders.heyoka(given, LOOP, compact=False),
            *contenders.casadi_bdf(given, LOOP, Path(scratch)),
        ]
        rows = take_turns(candidates, given.error)
    return [_compared(case, peer, closed_loop.ERRORS[0], rows, recorded) for peer in ("heyoka taylor", "casadi")]


def _compared(
    case: Case, peer: str, error: float, rows: list[dict[str, Any]], recorded: list[dict[str, Any]]
) -> list[str]:
    us, them = (_time(name, error, rows) for name in ("mehvar", peer))
    best = min({row["name"] for row in rows if row["name"].startswith(peer)}, key=lambda n: _time(n, error, rows))
    before = _time(peer, error, recorded) / _time("mehvar", error, recorded)
    return [
        case.title,
        best,
        f"{error:.0e}",
        f"{us * 1e6:.2f}",
        f"{them * 1e6:.2f}",
        f"{them / us:.1f}",
        f"{before:.1f}",
    ]


def _time(name: str, error: float, rows: list[dict[str, Any]]) -> float:
    return time_for(error, [row for row in rows if row["name"].startswith(name)])


if __name__ == "__main__":
    main()
