# SPDX-License-Identifier: Apache-2.0
"""Growth of time, memory and bytes with runs, horizon, samples, members and processes.

python -m benchmarks.batch.growth            # all parts, an hour of a core
python -m benchmarks.batch.growth runs       # some; the others keep their recorded numbers
python -m benchmarks.batch.growth --tables   # nothing is measured

Each point is a process of its own, of which the system counts processor time and peak memory.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import log
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

from benchmarks.machine import RESULTS, command_line, machine, table, write
from mehvar.runtime.batch.store.store import open_store
from mehvar.runtime.batch.store.verification import verify

RECORD, PICTURE, PAGE = RESULTS / "growth.json", "growth.png", "growth.md"
RUNS = (10**3, 10**4, 10**5, 10**6)
HORIZONS = (10**2, 10**3, 10**4, 10**5)
SAMPLES = (10**2, 10**3, 10**4, 10**5)
MEMBERS = (2, 4, 8, 16, 32, 64)
WORKERS = (1, 2)
VARIED = ("--vary", "theta_0=uniform(0.8, 1.2)", "--vary", "l1_0=normal(0.2, 0.01)")
"""Different runs; equal runs would compress to almost nothing."""
MOST = 1.1
"""Largest exponent that counts as proportional growth."""
QUANTITIES = {
    "time": "s",
    "memory": "MB",
    "bytes": "MB",
    "opening": "s",
    "verifying": "s",
    "compiling": "s",
    "running": "s",
}

Row = dict[str, float]
Line = dict[str, Row]


@dataclass(frozen=True)
class Part:
    """A series of measurements: growing quantity, unit, and constant settings."""

    title: str
    axis: str
    about: str
    rows: Callable[[], Iterator[tuple[int, Row]]]
    note: str = ""


def main() -> None:
    """Measure the named series, and write the page with the picture."""
    parser = command_line(__doc__, PARTS)
    parser.add_argument("--tables", action="store_true", help="measure nothing, write the page again")
    given = parser.parse_args()
    record: dict[str, Any] = json.loads(RECORD.read_text(encoding="utf-8")) if RECORD.is_file() else {}
    for name in [] if given.tables else given.parts or list(PARTS):
        about, line = machine(), {}
        for value, row in PARTS[name].rows():
            line[str(value)] = row
            print(name, value, row, flush=True)
        record[name] = {"machine": about, "rows": line}
        RECORD.write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
    _picture(record)
    write(PAGE, _page(record))


def runs() -> Iterator[tuple[int, Row]]:
    """Measure growth with the number of short runs in a store."""
    _stored("triangle", "path", "-n", 1, "--t-end", 0.05)  # compiles
    for n in RUNS:
        yield n, _stored("triangle", "path", "-n", n, "--t-end", 0.05, "--set", "dt_out=0.01", *VARIED)


def horizon() -> Iterator[tuple[int, Row]]:
    """Measure growth with the duration, at a constant number of samples."""
    _stored("satellite", "mrac", "-n", 1, "--t-end", 1)
    for end in HORIZONS:
        yield end, _stored("satellite", "mrac", "-n", 64, "--t-end", end, "--set", f"dt_out={end / 100:g}")


def samples() -> Iterator[tuple[int, Row]]:
    """Measure growth with the number of samples."""
    for count in SAMPLES:
        step = 10 / count
        options = ("-n", 16, "--t-end", 10, "--set", f"dt_out={step:g}", "--save", step, *VARIED)
        yield count, _stored("triangle", "path", *options)


def members() -> Iterator[tuple[int, Row]]:
    """Measure growth with the number of pendulums of slosh."""
    for count in MEMBERS:
        with tempfile.TemporaryDirectory() as folder:
            os.environ["MEHVAR_CACHE"] = f"{folder}/cache"  # nothing has been derived or compiled before
            model = Path(folder) / "model"
            row = _measured("mehvar", "generate", "slosh", "--structure", f"pendulums={count}", "--out", model)
            times = [_stored(model, "lyapunov-v1", "--t-end", 10, "-n", n)["time"] for n in (8, 8, 8192)]
            row["bytes"] = sum(path.stat().st_size for path in model.rglob("*.c")) / 1e6
            yield count, {**row, "compiling": times[0] - times[1], "running": times[2] - times[1]}


def threads() -> Iterator[tuple[int, Row]]:
    """Measure the same runs on several threads."""
    _stored("slosh", "lyapunov-v2", "-n", 1, "--t-end", 1)
    for count in WORKERS:
        yield count, _stored("slosh", "lyapunov-v2", "-n", 4096, "--t-end", 20, threads=count)


def workers() -> Iterator[tuple[int, Row]]:
    """Measure the same runs on several dask processes, including start and end."""
    for count in WORKERS:
        code = _CLUSTER.format(count=count)
        yield count, _measured("-c", code)


_CLUSTER = """
import sys
from distributed import Client, LocalCluster
from mehvar.runtime.batch.fill import run_batch
from mehvar.runtime.batch.plan import Campaign
if __name__ == "__main__":
    campaign = Campaign("lyapunov-v2", 4096, options={{"t_end": 20.0}})
    with LocalCluster(n_workers={count}, threads_per_worker=1, dashboard_address=None) as cluster:
        run_batch("slosh", campaign, client=Client(cluster))
"""


def _stored(model: str | Path, law: str, *options: object, threads: int = 1) -> Row:
    """Return time and memory of a batch, and of opening and verifying its store."""
    with tempfile.TemporaryDirectory() as folder:
        store = Path(folder) / "runs.zarr"
        row = _measured("mehvar", "batch", model, "--controller", law, *options, "--threads", threads, "--out", store)
        row["bytes"] = sum(path.stat().st_size for path in store.rglob("*") if path.is_file()) / 1e6
        row["opening"] = _seconds(lambda: open_store(store).stored())
        row["verifying"] = _seconds(lambda: verify(store))
    return row


def _measured(*words: object) -> Row:
    """Return processor time, wall time and peak memory of a process and its children."""
    line = [sys.executable, *(["-m"] if words[0] == "mehvar" else []), *map(str, words)]
    started = perf_counter()
    process = subprocess.Popen(line, stdout=subprocess.DEVNULL)
    _, status, used = os.wait4(process.pid, 0)
    if status:
        raise SystemExit(f"{' '.join(line)} ended with {status}")
    elapsed = perf_counter() - started
    return {"time": used.ru_utime + used.ru_stime, "elapsed": elapsed, "memory": used.ru_maxrss / 1e3}


def _seconds(job: Callable[[], object]) -> float:
    job()
    started = process_time()
    job()
    return process_time() - started


PARTS = {
    "runs": Part("Runs", "runs", "triangle, path, 0.05 s, five samples, values vary, one thread", runs),
    "horizon": Part("Horizon", "seconds of a run", "64 runs of the satellite, mrac, 100 samples, one thread", horizon),
    "samples": Part(
        "Samples", "samples of a run", "16 runs of the triangle, path, 10 s, all stored, one thread", samples
    ),
    "members": Part(
        "Members",
        "pendulums",
        "slosh; time is that of deriving, bytes those of its C, running that of 8184 runs of 10 s",
        members,
        "From 16 pendulums on, Jacobians are loops over them, so that bytes fall there. Of the time of deriving, "
        "CasADi's search for common subexpressions and the check by a dense Jacobian grow faster than the pendulums.",
    ),
    "threads": Part("Threads", "threads", "4096 runs of slosh, lyapunov-v2, 20 s", threads),
    "workers": Part(
        "Processes",
        "processes of dask",
        "the same runs in memory, with start and end of the workers",
        workers,
        "Time is that of this process and of the workers that it waits for. More than two were not measured, as the "
        "machine has two cores.",
    ),
}


def exponents(line: Mapping[str, Row], quantity: str) -> tuple[float, float]:
    """Return the exponent between the last two points, and between the first and the last one."""
    points = [(log(float(x)), log(row[quantity])) for x, row in line.items() if row.get(quantity, 0) > 0]
    if len(points) < 2:
        return float("nan"), float("nan")
    (x0, y0), (x1, y1), (x2, y2) = points[0], points[-2], points[-1]
    return (y2 - y1) / (x2 - x1), (y2 - y0) / (x2 - x0)


def _page(record: Mapping[str, Any]) -> list[str]:
    lines = [
        "# How cost grows",
        "",
        "Written by `python -m benchmarks.batch.growth`. Time is processor time of a whole command, start included;",
        "memory is the peak of the process; opening and verifying are those of the finished store. The last exponent",
        "is that between the two largest points, where fixed costs weigh least. Other programs ran, so elapsed",
        "time says little.",
        "",
        f"![growth]({PICTURE})",
        "",
    ]
    for name, part in PARTS.items():
        if name in record:
            lines += [f"## {part.title}", "", f"`python -m benchmarks.batch.growth {name}`: {part.about}.", ""]
            lines += [*_table(part, record[name]["rows"]), "", *([part.note, ""] if part.note else [])]
            lines += [*record[name]["machine"], ""]
    return lines[:-1]


def _table(part: Part, line: Mapping[str, Row]) -> list[str]:
    names = [name for name in ("time", "elapsed", *list(QUANTITIES)[1:]) if any(name in row for row in line.values())]
    units = {**QUANTITIES, "elapsed": "s"}
    rows = [[f"{int(x):,}", *(f"{row[name]:.3g}" if name in row else "" for name in names)] for x, row in line.items()]
    if part.axis not in ("threads", "processes of dask"):
        ends = [exponents(line, name) for name in names]
        rows.append(["**last exponent**", *(_marked(last) for last, _ in ends)])
    return table([part.axis, *(f"{name}, {units[name]}" for name in names)], rows)


def _marked(exponent: float) -> str:
    return f"**{exponent:.2f}, above {MOST}**" if exponent > MOST else f"{exponent:.2f}"


def _picture(record: Mapping[str, Any]) -> None:
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    shown = [name for name in ("runs", "horizon", "samples", "members") if name in record]
    figure, axes = plt.subplots(1, len(shown), figsize=(3.4 * len(shown), 3.6), squeeze=False)
    for axis, name in zip(axes[0], shown, strict=True):
        for (quantity, unit), style in zip(QUANTITIES.items(), _STYLES, strict=True):
            line = record[name]["rows"]
            points = [(float(x), row[quantity]) for x, row in line.items() if row.get(quantity, 0) > 0]
            if points:
                label = f"{quantity} [{unit}]"
                axis.plot(*zip(*points, strict=True), color=style[0], marker=style[1], markersize=4, label=label)
        axis.set(xscale="log", yscale="log", title=PARTS[name].title, xlabel=PARTS[name].axis)
        axis.grid(True, which="major", alpha=0.3)
        places = [int(x) for x in record[name]["rows"]]
        if places[-1] < 100 * places[0]:  # too short for a label at each power of ten
            axis.set_xticks(places, list(map(str, places)))
            axis.minorticks_off()
    handles = {label: h for a in axes[0] for h, label in zip(*a.get_legend_handles_labels(), strict=True)}
    figure.legend(handles.values(), handles.keys(), loc="lower center", ncols=len(handles), frameon=False)
    figure.tight_layout(rect=(0, 0.1, 1, 1))
    figure.savefig(RESULTS / PICTURE, dpi=110, metadata={"Software": None})


_STYLES: Sequence[tuple[str, str]] = (
    *(("#000000", "o"), ("#56B4E9", "s"), ("#009E73", "^")),
    *(("#D55E00", "D"), ("#CC79A7", "v"), ("#E69F00", "x"), ("#0072B2", "P")),
)
"""Palette of Okabe and Ito; and a marker for each, so that the picture can be read without colour."""


if __name__ == "__main__":
    main()
