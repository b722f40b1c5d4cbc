# SPDX-License-Identifier: Apache-2.0
"""Cost of a law in Python beside a generated one: the satellite under PD, alone and in a batch.

python -m benchmarks.own_law
"""

from __future__ import annotations

from functools import partial
from statistics import median
from time import process_time

import mehvar
from benchmarks.machine import command_line, machine, table, write

REPEATS = 7
RUNS = (100, 1000, 4000)
T_END = 100.0
MODEL = mehvar.load("satellite", backend="c")
GAINS = {q.name: q.default or 0.0 for q in MODEL.manifest.controller("pd").parameters}


def pd(_t, x):
    """Return the commands of the generated law `pd`, but with inertial rates."""
    return [
        -GAINS[f"Kp_{axis}"] * (x[angle] - x[f"ref_{angle}"]) - GAINS[f"Kd_{axis}"] * x[f"w{axis}"]
        for axis, angle in zip("xyz", ("roll", "pitch", "yaw"), strict=True)
    ]


def main() -> None:
    """Measure and write the page."""
    command_line(__doc__).parse_args()
    facts = machine()
    generated, own = {"controller": "pd"}, {"controller": pd, "period": 0.5}
    alone = {
        "generated": partial(mehvar.simulate, MODEL, t_end=T_END, **generated),
        "in Python, sampled": partial(mehvar.simulate, MODEL, t_end=T_END, **own),
        "in Python, continuous": partial(mehvar.simulate, MODEL, t_end=T_END, controller=pd),
        "open loop, held": partial(mehvar.simulate, MODEL, t_end=T_END, controller=None, inputs={"Tx": 1e-4}),
    }
    rows = _rows(seconds(alone, REPEATS))
    lines = [
        "# A law in Python",
        "",
        "Written by `python -m benchmarks.own_law`. The satellite under PD, a sample every",
    ]
    lines += [f"0.5 s, {T_END:g} s, method and tolerances by default; medians"]
    lines += [f"of {REPEATS} turns of processor time, all threads together. Compare ratios.", ""]
    lines += [
        "## Machine",
        "",
        *facts,
        "",
        "## One run",
        "",
        "With making the dataset, a few milliseconds of each.",
        "",
    ]
    lines += [*table(("law", "ms", "times the generated law"), rows), "", "## A batch", ""]
    lines += ["The Python law is called once a sample for all runs of a block; the lanes wait for it.", ""]
    batches = []
    for n in RUNS:
        vary = {"I_x": "normal(2.13, 0.1)", "roll": "uniform(-0.3, 0.3)"}
        jobs = {
            name: partial(mehvar.batch, MODEL, n=n, vary=vary, t_end=T_END, **law)
            for name, law in (("generated", generated), ("own", own))
        }
        times = seconds(jobs, 3)
        ratio = times["own"] / times["generated"]
        batches.append([str(n), f"{n / times['generated']:.0f}", f"{n / times['own']:.0f}", f"{ratio:.2f}"])
    lines += table(("runs", "generated, runs per s", "in Python, runs per s", "times the generated law"), batches)
    write("own_law.md", lines)


def seconds(jobs, repeats):
    """Return the median processor time of each job over all threads, which other programs affect less than wall time.

    The jobs take turns, after each has run once, so that what it runs is compiled.
    """
    times = {name: [] for name in jobs}
    for turn in range(repeats + 1):
        for name, job in jobs.items():
            start = process_time()
            job()
            if turn:
                times[name].append(process_time() - start)
    return {name: median(several) for name, several in times.items()}


def _rows(times):
    return [[name, f"{1e3 * t:.1f}", f"{t / times['generated']:.1f}"] for name, t in times.items()]


if __name__ == "__main__":
    main()
