# SPDX-License-Identifier: Apache-2.0
"""The batch kernel and a bare loop of the same dop853 in C, compared with each other and with the processor's limits.

python -m benchmarks.batch.bare
"""

from __future__ import annotations

import ctypes
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from time import process_time

import numpy as np

from benchmarks.batch.instructions import Counts, counts
from benchmarks.machine import command_line, machine, table, write
from benchmarks.peers.problem import CASES, LOOPS, Array, Case, dispersed, first_input, loaded
from mehvar.runtime.batch.kernel import Kernel, compile_kernel, kernel_flags
from mehvar.runtime.compiling.library import load_library
from mehvar.runtime.run.options import RunOptions

RUNS = 8192  # of a closed loop, whose runs are ten times as long, an eighth
REPEATS = 7
TOLERANCES = (1e-6, 1e-10)
ASKED = 1.15
SAMPLES = 350
CALLS = 20_000  # of what takes nanoseconds
ISSUED = 4  # instructions in a cycle that we take for the most
SYSTEMS = {**CASES, "triangle": LOOPS["triangle"]}
SOURCE = Path(__file__).with_name("bare.c")


class Job(ctypes.Structure):
    """The structure of the same name in bare.c."""

    _fields_ = (
        ("runs", ctypes.c_int64),
        *((name, ctypes.c_double) for name in ("t_end", "rtol", "atol")),
        *((name, ctypes.c_void_p) for name in ("p", "c", "s", "x0", "u", "final", "steps", "evaluations")),
    )


@dataclass(frozen=True)
class Pair:
    """Times of a system at a tolerance, us per run: medians, minima, and the median ratio of neighbouring runs."""

    title: str
    tolerance: float
    evaluations: float
    bare: tuple[float, float]
    product: tuple[float, float]
    ratio: float

    def row(self) -> list[str]:
        """Return the times as a row of the table."""
        least = self.product[1] / self.bare[1]
        return [self.title, f"{self.tolerance:.0e}", f"{self.evaluations:.0f}",
                *(f"{v[0]:.2f} ({v[1]:.2f})" for v in (self.bare, self.product)),
                f"{self.ratio:.2f}", f"{least:.2f}", "yes" if min(self.ratio, least) <= ASKED else "no"]  # fmt: skip


class System:
    """A case: arguments, kernel and bare loop as functions."""

    def __init__(self, case: Case, tolerance: float, scratch: Path) -> None:
        model = loaded(case, scratch)
        held = {} if case.sample else {"hold": case.t_end}
        self.case, self.tolerance, self.runs = case, tolerance, RUNS // (8 if case.sample else 1)
        self.vectors = dispersed(model, case.law, case.scenario, held, self.runs)
        options = RunOptions(method="dop853", rtol=tolerance, atol=tolerance, **held)
        self.kernel = compile_kernel(model, case.law, options=options)
        u = np.zeros((self.runs, len(model.input_names))) if case.sample else first_input(case, model, *self.vectors)
        self.arrays = dict(zip(("p", "c", "s", "x0", "u"), (*self.vectors, u), strict=True))
        self.arrays["final"] = np.empty_like(self.vectors[3])
        self.arrays["steps"], self.arrays["evaluations"] = (
            np.empty(self.runs),
            np.empty(-(-self.runs // self.kernel.lanes)),
        )
        addresses = (array.ctypes.data for array in self.arrays.values())
        self.job = Job(self.runs, case.t_end, tolerance, tolerance, *addresses)
        self.library = compiled(self.kernel)

    def bare(self) -> Array:
        """Run the bare loop; return the states at the end."""
        self.library.bare_run(ctypes.byref(self.job))
        return self.arrays["final"]

    def product(self, samples: int = 1) -> Array:
        """Run the kernel as a user does."""
        t_end = self.case.t_end
        block = self.kernel.run(0, *self.vectors, seed=0, t_end=t_end, dt=t_end / samples)
        assert block is not None
        assert not block.status.any(), "a run ended early"
        return block.final

    def pairs(self) -> list[Pair]:
        """Time both in turns; the kernel also with samples within its steps."""
        closed = self.case.sample is not None
        # the last step of a continuous loop also has to be good between its ends, see native/step/dense.h
        np.testing.assert_allclose(self.product(), self.bare(), rtol=1e-4 if closed else 0, atol=1e-4 if closed else 0)
        ways = {self.case.title: 1} | ({f"{self.case.title}, {SAMPLES} samples": SAMPLES} if closed else {})
        times: dict[str, list[tuple[float, float]]] = {title: [] for title in ways}
        for _ in range(REPEATS):
            for title, samples in ways.items():
                bare, product = seconds(self.bare), seconds(lambda n=samples: self.product(n))
                times[title].append((bare / self.runs * 1e6, product / self.runs * 1e6))
        evaluations = float(self.arrays["evaluations"].mean())
        return [_pair(title, self.tolerance, evaluations, both) for title, both in times.items()]


def _pair(title: str, tolerance: float, evaluations: float, both: list[tuple[float, float]]) -> Pair:
    bare, product = zip(*both, strict=True)
    ratio = median(ours / theirs for theirs, ours in both)
    spread = (median(bare), min(bare)), (median(product), min(product))
    return Pair(title, tolerance, evaluations, *spread, ratio)


def compiled(kernel: Kernel) -> ctypes.CDLL:
    """Compile the bare loop with the sources and flags of a kernel, and prepare its constants."""
    sources, loop = kernel.loop.sources, kernel.loop
    [line] = [line for line in sources["kernel.h"].splitlines() if line.startswith("#define CALL_PREPARE")]
    calls = line.removeprefix("#define CALL_PREPARE").split(";")
    needed = [call for call in calls if any(f"_{name}_prepare(" in call for name in ("rhs", "loop", "project"))]
    sources["kernel.h"] += f"#define BARE_PREPARE {';'.join(needed)}\n"
    flags = kernel_flags(loop, kernel.options.profile, kernel.lanes)
    return load_library("bare", {**sources, "bare.c": SOURCE.read_text()}, ["bare.c"], flags)


def seconds(job: Callable[[], object]) -> float:
    """Return the processor time of a call."""
    started = process_time()
    job()
    return process_time() - started


def least(function: Callable[[int], object], count: int) -> float:
    """Return the least processor time of one of `count`, s."""
    return min(seconds(lambda: function(count)) for _ in range(REPEATS)) / count


def main() -> None:
    """Measure all systems and write the page."""
    pairs, limits = list[Pair](), list[list[str]]()
    about = machine()
    with tempfile.TemporaryDirectory() as scratch:
        for case in SYSTEMS.values():
            for tolerance in TOLERANCES:
                system = System(case, tolerance, Path(scratch))
                pairs += system.pairs()
                print(*pairs[-1].row(), flush=True)
            limits.append(limit(system, pairs[-1]))
    few = ["system", "tolerance", "slopes a block", "bare, us a run (least)", "product, us a run (least)", "ratio",
           "of least", f"at most {ASKED}"]  # fmt: skip
    rest = ["system", "of a run, us", "of a slope, ns", "a slope of the bare loop, ns"]
    bounds = ["system", "instructions", "loads", "stores", "sums and products", "quotients", "roots",
              f"{ISSUED} a cycle", "sums and products, cycles", "quotients and roots, cycles", "measured, cycles",
              "share", "of the bare loop"]  # fmt: skip
    lines = [*_head(), *about, "", *table(few, [pair.row() for pair in pairs]), "", *_rest(), ""]
    lines += [*table(rest, beyond(pairs)), "", "## The limit", "", *_limit(), "", *table(bounds, limits)]
    write("bare.md", lines)


def beyond(pairs: list[Pair]) -> list[list[str]]:
    """Return the extra time of the kernel over the bare loop, for a run and for an evaluation in a lane."""
    rows = []
    for title in dict.fromkeys(pair.title for pair in pairs):
        loose, tight = (pair for pair in pairs if pair.title == title)
        slopes = tight.evaluations - loose.evaluations
        more = [pair.product[1] - pair.bare[1] for pair in (loose, tight)]
        each = (more[1] - more[0]) / slopes
        alone = (tight.bare[1] - loose.bare[1]) / slopes
        rows.append([title, f"{more[0] - each * loose.evaluations:.2f}", f"{each * 1e3:.2f}", f"{alone * 1e3:.2f}"])
    return rows


def limit(system: System, pair: Pair) -> list[str]:
    """Return the work of the right-hand side, its least time and its measured time."""
    library, job = system.library, system.job
    cycle = least(lambda n: library.bare_cycles(ctypes.c_int64(n)), 1600 * CALLS)
    chains = 12

    def cycles(name: str) -> float:
        function = getattr(library, name)
        return least(lambda n: function(ctypes.c_int64(n)), CALLS) / cycle / chains

    found: Counts = counts(Path(library._name), "bare_slope")
    bounds = (
        found.instructions / ISSUED,
        found.arithmetic * cycles("bare_products") / 2,
        found.quotients * cycles("bare_quotients") + found.roots * cycles("bare_roots"),
    )
    slope = least(lambda n: library.bare_slopes(ctypes.byref(job), ctypes.c_int64(n)), CALLS)
    share = slope * pair.evaluations / system.kernel.lanes / (pair.bare[1] * 1e-6)
    numbers = (found.instructions, found.loads, found.stores, found.arithmetic, found.quotients, found.roots)
    return [system.case.title, *(str(number) for number in numbers), *(f"{bound:.0f}" for bound in bounds),
            f"{slope / cycle:.0f}", f"{100 * max(bounds) * cycle / slope:.0f} %", f"{100 * share:.0f} %"]  # fmt: skip


def _head() -> list[str]:
    return [
        "# The kernel beside bare C",
        "",
        "Written by `python -m benchmarks.batch.bare`. [The bare loop](../batch/bare.c) has the generated right-hand",
        "side, the coefficients, the error estimate and the step control of the product in the same lanes with the",
        "same flags, and nothing else: no samples, no metrics, no limits, no law. The first input of a law is held to",
        "the end, as in [the comparison without a law](batch_open_loop.md), but for the triangle, which is a closed",
        "loop. Final states of both are the same bits; those of the triangle differ below 1e-4, as the product's last",
        "step has to be good between its ends too.",
        "",
        f"{RUNS} runs, {RUNS // 8} of the triangle, processor time of one thread, profile portable. Bare loop and",
        f"product take turns; medians of {REPEATS} repeats, in brackets the least of them; `ratio` is the median of",
        "the ratios of neighbours. The machine was shared: a row holds where one of the two ratios does.",
        "",
    ]


def _rest() -> list[str]:
    return [
        "What the product takes beyond the bare loop, from the least times at the two tolerances: so much of each run,",
        "whatever its steps (the law at both ends, its noise, outputs, extremes of all columns, metrics, the call),",
        "and so much of each slope in one lane (limits after every step, checks for numbers that are not finite). The",
        "part of a run is why rows of few slopes are above what was asked; with samples it holds what they cost. These",
        "are differences of differences: a few tenths of a microsecond are noise.",
    ]


def _limit() -> list[str]:
    return [
        "One right-hand side of a block of lanes: instructions in the disassembly, and cycles. The bounds are",
        f"instructions at {ISSUED} a cycle; sums and products, and quotients and roots, at the rates that loops of",
        "nothing else reach on this processor. `share` is the largest bound over what was measured with everything in",
        "the first cache; what it lacks is probably waiting for results, which was not measured apart: most of an",
        "expression depends on what stands before it. `of the bare loop` is how much of its time at the tighter",
        "tolerance such slopes make up; the rest are the sums of the stages, the error and the control.",
    ]


if __name__ == "__main__":
    command_line(__doc__).parse_args()
    main()
