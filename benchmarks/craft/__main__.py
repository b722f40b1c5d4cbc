# SPDX-License-Identifier: Apache-2.0
"""A craft of 16 degrees of freedom in mehvar, Basilisk and Drake: right-hand sides, single runs, a thousand runs.

Run: python -m benchmarks.craft, in the environment of `make compare`. A tool that is not installed gets a line that
says so.
"""

from __future__ import annotations

import importlib
import os
import tempfile
from collections.abc import Iterator, Sequence
from importlib.metadata import version
from time import process_time
from typing import Any

import numpy as np

from benchmarks.craft import in_mehvar, task
from benchmarks.machine import command_line, machine, table, write
from benchmarks.peers.contenders import Contender
from benchmarks.peers.report import REPEATS, attempt, everything, take_turns, time_for
from mehvar.runtime.compiling.processor import widest

RUNS, CHECKED = 1000, 4
"""Runs of a batch; runs of the peers, single runs of mehvar, and runs of which errors are taken."""
ERRORS = (1e-4, 1e-6)
CALLS = 5000
STARTS = task.starts(RUNS)
BATCH, SINGLE = "mehvar, batch", "mehvar, single runs"
INSIDE = {SINGLE: "1e-08", BATCH: "1e-08", "Basilisk rk4": "0.0125 s", "Drake runge_kutta5": "1e-08"}
"""Settings whose time a right-hand side is computed from."""


def contender(name: str, setting: str, runs: int, fly: task.Fly) -> Contender:
    begun = process_time()
    fly(STARTS[:1])
    return Contender(name, setting, runs, lambda n: fly(STARTS[:n]), process_time() - begun)


def ours() -> Iterator[Contender]:
    for tolerance in (1e-4, 1e-5, 1e-6, 1e-7, 1e-8):
        options = {"rtol": tolerance, "atol": tolerance}
        yield contender(BATCH, f"{tolerance:.0e}", RUNS, in_mehvar.batch(**options))
        yield contender(SINGLE, f"{tolerance:.0e}", CHECKED, in_mehvar.single(**options))
    yield contender(BATCH, "defaults", RUNS, in_mehvar.batch())
    yield contender(SINGLE, "defaults", CHECKED, in_mehvar.single(dt_out=None))


def basilisk() -> Iterator[Contender]:
    own = importlib.import_module("benchmarks.craft.in_basilisk")
    for step in (0.1, 0.05, 0.025, 0.0125):
        yield contender("Basilisk rk4", f"{step:g} s", CHECKED, own.fly(step))
    for tolerance in (1e-4, 1e-6, 1e-8):
        yield contender("Basilisk rkf78", f"{tolerance:.0e}", CHECKED, own.fly(0.1, tolerance))


def drake() -> Iterator[Contender]:
    own = importlib.import_module("benchmarks.craft.in_drake")
    for scheme, accuracies in (("runge_kutta3", (4, 5, 6)), ("runge_kutta5", (8, 10, 12))):
        for k in accuracies:
            yield contender(f"Drake {scheme}", f"1e-{k:02d}", CHECKED, own.fly(10.0**-k, scheme))
    yield contender("Drake", "defaults", CHECKED, own.fly())


TOOLS = {"mehvar": ("mehvar", ours), "Basilisk": ("bsk", basilisk), "Drake": ("drake", drake)}


def of(name: str, rows: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    return [row for row in rows if row["name"].startswith(name) and row["setting"] != "defaults"]


def agreement(rows: Sequence[dict[str, Any]]) -> list[list[str]]:
    """Return each peer's smallest difference from mehvar."""
    best = [min(of(peer, rows), key=lambda row: row["largest"]) for peer in ("Basilisk", "Drake") if of(peer, rows)]
    return [[row["name"], row["setting"], f"{row['largest']:.0e}"] for row in best]


def compared(rows: Sequence[dict[str, Any]], set_up: float) -> list[list[str]]:
    """Return times at equal error, and how many runs a peer ends before mehvar has started for the first time."""
    result = []
    for error in ERRORS:
        best = {name: time_for(error, of(name, rows)) for name in (BATCH, SINGLE, "Basilisk", "Drake")}
        for name, seconds in best.items():
            numbers = (1000 * seconds, RUNS * seconds, seconds / best[SINGLE], seconds / best[BATCH])
            before = "-" if name in (BATCH, SINGLE) else f"{set_up / (seconds - best[BATCH]):.0f}"
            result.append([name, f"{error:.0e}", *(f"{n:.0f}" if n >= 100 else f"{n:.3g}" for n in numbers), before])
    return result


def slopes(rows: Sequence[dict[str, Any]], modules: dict[str, Any]) -> list[list[str]]:
    """Return the time of a right-hand side: called from Python, and a run's time over its evaluations."""
    result = []
    for name, setting in INSIDE.items():
        own = modules.get(name.split()[0].strip(","))
        if own is None:
            continue
        call, taken = own.rhs(), []
        for _ in range(REPEATS):
            begun = process_time()
            for _ in range(CALLS):
                call()
            taken.append((process_time() - begun) / CALLS)
        row = next(row for row in rows if (row["name"], row["setting"]) == (name, setting))
        inside = row["seconds"] / np.mean([own.evaluations(setting, start) for start in STARTS[:CHECKED]])
        result.append([name, "-" if name == BATCH else f"{1e6 * np.median(taken):.2f}", f"{1e6 * inside:.2f}"])
    return result


def start() -> tuple[task.Array, float]:
    """Return the reference, and the processor time of a first start of mehvar, compilers included, s."""
    begun = os.times()
    final = in_mehvar.batch(rtol=1e-13, atol=1e-13)(STARTS[:CHECKED])
    ended = os.times()
    return final, sum(ended[:4]) - sum(begun[:4])


def main() -> None:
    """Measure and write the page."""
    command_line(__doc__).parse_args()
    facts = machine()
    with tempfile.TemporaryDirectory() as scratch:
        os.environ["MEHVAR_CACHE"] = scratch
        reference, set_up = start()
        contenders, modules, remarks = list[Contender](), dict[str, Any](), [f"- mehvar: {widest()} lanes in a batch"]
        for tool, (package, make) in TOOLS.items():
            made, why = attempt(make)
            contenders += made
            if not why:
                modules[tool] = importlib.import_module(f"benchmarks.craft.in_{tool.lower()}")
            remarks.append(f"- {tool}: not run ({why})" if why else f"- {tool} {version(package)}")
        rows = take_turns(contenders, lambda final: np.max(np.abs(final[:CHECKED] - reference), axis=1))
        inside = slopes(rows, modules)
    functions = in_mehvar.model().manifest.functions
    times = ["tool", "at error", "a run, ms", "a thousand runs, s", "tool / single", "tool / batch", "runs first"]
    write("craft.md", [
        *_HEAD, "", *facts, *remarks, "",
        "## Agreement", "",
        *table(["tool", "most exact setting", "largest difference"], agreement(rows)), "", *_ERRORS, "",
        "## Runs of 100 s at equal error", "", *table(times, compared(rows, set_up)), "", *_RUNS,
        f"{set_up:.0f} s of processor time.", "",
        "## A right-hand side", "", *table(["tool", "called from Python, us", "in a run, us"], inside), "",
        f"mehvar's has {functions['rhs'].operations} operations, in a run {functions['rhs_prepared'].operations}.",
        *_SLOPES, "",
        "## All measurements", "", *_DEFAULTS, "", *everything(rows),
    ])  # fmt: skip


_HEAD = """# A craft of 16 degrees of freedom beside Basilisk and Drake

Written by `python -m benchmarks.craft`, in the environment of `make compare`. A hub with four skew wheels, two panels
of two hinged bodies each and a spherical pendulum, under a constant force and constant torques of the wheels, from
dispersed starts ([numbers](../craft/task.py)). No law, no orbit. The mechanics are the same in each tool; differences:

- Panels are bodies on hinges, because Basilisk has no appendage of modes.
- In Drake each wheel is a body with an angle; hubs of mehvar and Basilisk include mass and inertia of the wheels.
- The attitude is a quaternion in mehvar and Drake, modified Rodrigues parameters with a shadow set in Basilisk.
- The pendulum is a direction in mehvar, two angles in Drake, two angles about axes that move in Basilisk.
- Basilisk and Drake also integrate the position of the craft.
- The force is an `ExternalForce` in mehvar, an `extForceTorque` in Basilisk, a `Propeller` in Drake.
- No run calls Python.

## Machine
""".splitlines()
_ERRORS = f"""Beside mehvar at 1e-13, of {CHECKED} runs, in the entries of attitude, rate, velocity, angles, rates and
directions, and wheel speeds over 100 rad/s.""".splitlines()
_RUNS = f"""Processor time on one core, medians of {REPEATS} turns in one process, interpolated to an equal median
error over the settings below; each tool's fastest counts. `inf`: no setting reaches the error. Ratios are to mehvar's
single runs and to its batch of {RUNS} runs. Times of a thousand runs of the others are of {CHECKED}, scaled up.
Basilisk assembles each simulation anew, Drake keeps its simulator. Basilisk and Drake need no compiler: of fewer runs
than in the last column they are done before mehvar, if nothing is kept from earlier starts.
Deriving and compiling takes""".splitlines()
_SLOPES = """A run's time over its evaluations includes the integrator, in Basilisk also the modules and messages of a
step, in mehvar's single runs some milliseconds of Python. A call from Python includes the binding. Basilisk's
`equationsOfMotion` takes about as long as mehvar's call; most of its run is outside its equations.""".splitlines()
_DEFAULTS = """mehvar's defaults are dop853 at 1e-11 and, of a single run, a sample every 0.1 s; Drake's are
runge_kutta3 at 1e-4. Basilisk's method is rk4 unless set; its step is the user's. rkf78 adapts within steps of 0.1 s:
with 0.5 s some runs ended with NaN. Drake's steps are at most 0.5 s: a first trial step of 100 s ended with NaN. A
batch has 1000 runs, others 4.""".splitlines()


if __name__ == "__main__":
    main()
