# SPDX-License-Identifier: Apache-2.0
"""Contenders, measurements in turns, and times at equal error."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from statistics import median
from time import process_time
from typing import Any

import numpy as np

from benchmarks.machine import command_line, table
from benchmarks.peers.contenders import Contender
from benchmarks.peers.problem import Array

REPEATS = 5


def parts_to_measure(about: str | None, parts: Iterable[str]) -> Iterable[str]:
    """Return the parts named on the command line; none with --tables; default: all."""
    parser = command_line(about, parts)
    parser.add_argument("--tables", action="store_true", help="measure nothing, write the tables of what is recorded")
    given = parser.parse_args()
    return () if given.tables else given.parts or parts


def attempt(make: Callable[[], Iterable[Contender]]) -> tuple[list[Contender], str]:
    """Build contenders; also return the reasons why others are not installed or cannot run."""
    found: list[Contender] = []
    try:
        found.extend(make())
    except Exception as error:
        why = f"{type(error).__name__}: {str(error).splitlines()[0][:120]}"
        print(f"  not run: {why}", flush=True)
        return found, why
    return found, ""


def take_turns(contenders: Sequence[Contender], error: Callable[[Array], Array]) -> list[dict[str, Any]]:
    """Return name, setting, processor time per run and error of each."""
    times: list[list[float]] = [[] for _ in contenders]
    finals: list[Any] = [None] * len(contenders)
    for _ in range(REPEATS):
        for place, contender in enumerate(contenders):
            started = process_time()
            finals[place] = contender.integrate(contender.runs)
            times[place].append((process_time() - started) / contender.runs)
    rows = []
    for contender, took, final in zip(contenders, times, finals, strict=True):
        errors = error(final)
        rows.append(
            {
                **{"name": contender.name, "setting": contender.setting, "set_up": contender.set_up},
                **{"seconds": median(took), "spread": [min(took), max(took)]},
                **{"error": float(np.median(errors)), "largest": float(np.max(errors))},
            }
        )
        print(f"  {contender.name} {contender.setting}: {rows[-1]['seconds'] * 1e6:.2f} us, {rows[-1]['error']:.1e}")
    return rows


def time_for(error: float, rows: Sequence[dict[str, Any]], least: bool = False) -> float:
    """Interpolate log(time) over log(error) on the fastest settings; beyond the largest error, use its time.

    Of medians of the repeats, or of the least of them.
    """
    errors = np.array(sorted({row["error"] for row in rows if np.isfinite(row["error"])}))
    if not len(errors) or error < errors[0]:
        return float("inf")
    best = [min(r["spread"][0] if least else r["seconds"] for r in rows if r["error"] <= e) for e in errors]
    return float(np.exp(np.interp(np.log(error), np.log(errors), np.log(best))))


def everything(rows: Sequence[dict[str, Any]]) -> list[str]:
    """Return the table of all measurements."""
    columns = ["integrator", "setting", "us per run", "least to most", "runs per core-second", "median error",
               "largest error", "set-up, s"]  # fmt: skip
    return table(
        columns,
        [
            [
                *(row["name"], row["setting"], f"{row['seconds'] * 1e6:.2f}"),
                " to ".join(f"{s * 1e6:.2f}" for s in row["spread"]),
                *(f"{1 / row['seconds']:,.0f}", f"{row['error']:.1e}", f"{row['largest']:.1e}"),
                f"{row['set_up']:.1f}",
            ]
            for row in rows
        ],
    )
