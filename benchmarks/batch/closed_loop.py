# SPDX-License-Identifier: Apache-2.0
"""Cost of batches of closed loops, and the same loop in other integrators.

Run in an environment that has benchmarks/peers/requirements.txt beside mehvar:

    python -m benchmarks.batch.closed_loop                     # all parts
    python -m benchmarks.batch.closed_loop triangle campaigns  # some; the others keep their recorded numbers
    python -m benchmarks.batch.closed_loop --tables            # nothing is measured
"""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from time import process_time
from typing import Any

os.environ.setdefault("XLA_FLAGS", "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1")

import numpy as np

from benchmarks.machine import RESULTS, machine, table, write
from benchmarks.peers import contenders, sampled
from benchmarks.peers.contenders import Contender
from benchmarks.peers.problem import LOOPS, Problem, problem
from benchmarks.peers.report import REPEATS, attempt, everything, parts_to_measure, take_turns, time_for
from mehvar.runtime.batch.fill import run_batch
from mehvar.runtime.batch.plan import Campaign

RECORD = RESULTS / "batch_closed_loop.json"
ERRORS = (1e-6, 1e-9)
TOLERANCES = tuple(10.0**-k for k in range(4, 12))
PEERS = ("heyoka", "numba", "scipy", "casadi", "jax", "diffrax")
DIFFRAX = {"slosh": ("Kvaerno5", "Kvaerno3"), "triangle": ("Dopri8", "Tsit5")}
"""Diffrax's explicit solvers took over a second per run of slosh. Kvaerno5 did not finish eight runs of the triangle,
whose law has kinks, in ten minutes."""
RK4 = {"slosh": (3_000, 6_000), "triangle": (350, 1400, 5600)}  # steps


@dataclass(frozen=True)
class Campaigned:
    """A campaign, with the numbers of requested and measured runs."""

    title: str
    asked: int
    measured: int
    model: str
    law: str
    options: dict[str, Any]
    vary: dict[str, str]


TIGHT = {"rtol": 1e-6, "atol": 1e-6}
CAMPAIGNS = {
    "slosh": Campaigned(
        "slosh, `paper`, lyapunov-v2, 1000 s, samples every 1 s, rock4", 10**5, 10**5, "slosh", "lyapunov-v2",
        {"t_end": 1000.0, "dt_out": 1.0, "method": "rock4", **TIGHT},
        {"m1": "normal(50, 2)", "phi1_0": "uniform(0.4, 0.6)"},
    ),
    "slosh, implicit": Campaigned(
        "slosh, `paper`, lyapunov-v2, 1000 s, samples every 1 s, rodas5p", 10**5, 10**5, "slosh", "lyapunov-v2",
        {"t_end": 1000.0, "dt_out": 1.0, "method": "rodas5p", **TIGHT},
        {"m1": "normal(50, 2)", "phi1_0": "uniform(0.4, 0.6)"},
    ),
    "triangle": Campaigned(
        "triangle, `paper`, path, 35 s, samples every 0.1 s, dopri5", 10**6, 10**6, "triangle", "path",
        {"t_end": 35.0, "dt_out": 0.1, "method": "dopri5", **TIGHT},
        {"l1_0": "normal(0.2, 0.01)", "theta_0": "uniform(0.8, 1.2)"},
    ),
    "satellite": Campaigned(
        "satellite, `flight` with noise, mrac, 600 samples, dopri5", 10**5, 10**5, "satellite", "mrac",
        {"t_end": 300.0, "dt_out": 0.5, "method": "dopri5", **TIGHT},
        {"I_x": "normal(2.13, 0.05)", "I_y": "normal(3.04, 0.05)"},
    ),
}  # fmt: skip


def main() -> None:
    """Measure the requested parts, and write all tables."""
    record: dict[str, Any] = json.loads(RECORD.read_text()) if RECORD.exists() else {}
    parts: dict[str, Callable[[], dict[str, Any]]] = {
        **{name: lambda name=name: continuous(name) for name in LOOPS},
        "satellite": discrete,
        "campaigns": campaigns,
    }
    for name in parts_to_measure(__doc__, parts):
        record[name] = parts[name]()
        RECORD.write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
    tables(record)


def continuous(name: str) -> dict[str, Any]:
    """Time all integrators in turns on a loop without samples."""
    with tempfile.TemporaryDirectory() as scratch:
        given = problem(LOOPS[name], Path(scratch))
        makers: dict[str, Callable[[], Iterator[Contender]]] = {
            "mehvar": lambda: contenders.ours(given, TOLERANCES, contenders.OURS_IN_LOOPS),
            "heyoka": lambda: contenders.heyoka(given, TOLERANCES, compact=False),
            "numba": lambda: (c for steps in RK4[name] for c in contenders.numba_rk4(given, steps)),
            "scipy": lambda: contenders.scipy_lsoda(given, TOLERANCES),
            "casadi": lambda: contenders.casadi_bdf(given, TOLERANCES, Path(scratch)),
            "diffrax": lambda: contenders.diffrax(given, (1e-5, 1e-7, 1e-9), DIFFRAX[name]),
        }
        return _measured(given, makers)


def discrete() -> dict[str, Any]:
    """Time all integrators in turns on the satellite's sampled law."""
    given = sampled.sampled(512, 1 / 4)
    makers: dict[str, Callable[[], Iterator[Contender]]] = {
        "mehvar": lambda: sampled.ours(given, (1e-6, 1e-8)),
        "numba": lambda: sampled.numba_rk4(given, (1, 2)),
        "scipy": lambda: sampled.scipy_lsoda(given, (1e-6, 1e-8)),
        "heyoka": lambda: sampled.heyoka(given, (1e-6,)),
    }
    return _measured(given, makers)


def _measured(given: Problem | sampled.Sampled, makers: dict[str, Callable[[], Iterator[Contender]]]) -> dict[str, Any]:
    lines, result, missing = machine(), list[Contender](), dict[str, str]()
    for title, make in makers.items():
        built, why = attempt(make)
        result += built
        if why:
            missing[title] = why
    versions = ", ".join(f"{peer} {version(peer)}" for peer in PEERS)
    rows = take_turns(result, given.error)
    return {"title": given.case.title, "machine": [*lines, f"- peers: {versions}"], "rows": rows, "not run": missing}


def campaigns() -> dict[str, Any]:
    """Do the work of `mehvar batch`: draw, integrate, summarise, store."""
    lines, rows = machine(), []
    for campaign in CAMPAIGNS.values():
        with tempfile.TemporaryDirectory() as folder:
            few = Campaign(campaign.law, 64, seed=1, vary=campaign.vary, options=campaign.options,
                           scenario="flight" if campaign.model == "satellite" else "paper")  # fmt: skip
            run_batch(campaign.model, few, Path(folder) / "few.zarr", threads=1)
            given = Campaign(**{**few.__dict__, "n": campaign.measured})
            started = process_time()
            store = run_batch(campaign.model, given, Path(folder) / "runs.zarr", threads=1)
            seconds = process_time() - started
        rows.append({"title": campaign.title, "asked": campaign.asked, "measured": campaign.measured,
                     "seconds": seconds})  # fmt: skip
        print(rows[-1], flush=True)
        del store
    return {"machine": lines, "rows": rows}


def tables(record: dict[str, Any]) -> None:
    """Write the page."""
    lines = [*_head(), ""]
    if "campaigns" in record:
        lines += ["## Whole campaigns", "", *record["campaigns"]["machine"], "", *_campaign_table(record), ""]
    for name in (name for name in (*LOOPS, "satellite") if name in record):
        entry = record[name]
        lines += [f"## {entry['title']}", "", *entry["machine"], "", *_ratios(entry["rows"]), ""]
        lines += [f"Not run: {peer} ({why})." for peer, why in entry["not run"].items()]
        lines += ["<details><summary>all measurements</summary>", "", *everything(entry["rows"]), "", "</details>", ""]
    write("batch_closed_loop.md", lines)


def _campaign_table(record: dict[str, Any]) -> list[str]:
    columns = ["campaign", "runs measured", "core-seconds", "ms per run", "runs asked for", "core-seconds for them"]
    return table(
        columns,
        [
            [
                *(row["title"], f"{row['measured']:,}", f"{row['seconds']:.1f}"),
                *(f"{row['seconds'] / row['measured'] * 1e3:.3f}", f"{row['asked']:,}"),
                f"{row['seconds'] / row['measured'] * row['asked']:,.0f}"
                + ("" if row["asked"] == row["measured"] else " (scaled)"),
            ]
            for row in record["campaigns"]["rows"]
        ],
    )


def _ratios(rows: Sequence[dict[str, Any]]) -> list[str]:
    """Compare at equal error; an integrator that is always more exact counts with its loosest setting."""
    result = []
    ours = [row for row in rows if row["name"].startswith("mehvar")]
    for name in dict.fromkeys(row["name"] for row in rows if row not in ours and "alone" not in row["name"]):
        theirs = [row for row in rows if row["name"] == name]
        for error in ERRORS:
            times = [time_for(error, group, least) for least in (False, True) for group in (ours, theirs)]
            if not np.isfinite(times[0]):  # nothing to compare with
                continue
            cells = [f"{v * 1e6:,.0f}" if np.isfinite(v) else "not reached" for v in times[:2]]
            ratios = [f"{them / us:.1f}" if np.isfinite(them) else "-" for us, them in (times[:2], times[2:])]
            result.append([name, f"{error:.0e}", *cells, *ratios])
    columns = ["peer", "error", "mehvar, us per run", "peer, us per run", "peer / mehvar", "of the least times"]
    return table(columns, result)


def _head() -> list[str]:
    return [
        "# Batches of closed loops",
        "",
        "Written by `python -m benchmarks.batch.closed_loop`.",
        "",
        "- Campaigns: the processor time of one thread from drawing the runs to the complete store, tolerance 1e-6;",
        "  all metrics of the scenario are computed on the way. Measured once; where fewer runs were measured than",
        "  asked for, the time is scaled, which the cost per run in [the growth](growth.md) allows.",
        f"- Comparison: processor time, medians of {REPEATS} repeats in which all take turns in one process, on the",
        "  same runs, with the same equations from the tape: the law, its input and the plant in one function. Error:",
        "  median over the runs of the largest |x - x_ref|/(1 + |x_ref|) at the end, against our dop853 at 1e-13;",
        "  equal error by log-log interpolation, of medians and of the least times. A setting that is more exact than",
        "  that at its loosest counts so.",
        "- Our times contain samples, metrics, minimum and maximum and the limits of every step. The peers' do not.",
        "- heyoka is called from Python once for each batch of lanes; what these calls cost without a step is a row of",
        "  its own.",
        "- heyoka does not see the kinks of minimum, maximum and select; the error column shows what that costs.",
        "- The satellite's law is sampled and has memory. No peer runs such a loop by itself: it was written around",
        "  them (peers/sampled.py); without noise, so that all can be compared. diffrax was not tried there.",
        "- The machine was shared with other programs; compare ratios.",
    ]


if __name__ == "__main__":
    main()
