# SPDX-License-Identifier: Apache-2.0
"""Compiled kernel of a batch: many runs of one closed loop at once, with summaries of each."""

from __future__ import annotations

import ctypes
import functools
import itertools
import os
import threading
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor, wait
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mehvar.base.errors import InputError, bad_value, unknown_name
from mehvar.base.manifest import METRIC_KINDS
from mehvar.base.names import identifier

from ..compiling.compiler import require_compiler
from ..compiling.library import load_library
from ..compiling.processor import vector_flags, widest
from ..compiling.structures import structures
from ..model.functions import FloatArray
from ..model.model import Model
from ..run.calls import check_loop, jacobian_name
from ..run.metrics import COUNT, event_number
from ..run.options import AUTO, Profile, RunOptions, first_integrator
from ..run.problem import check_delay, check_hold, input_delays, variant_suffix
from ..run.ticks import rows_of, ticks_of, times_in
from ..run.user.law import PythonLaw
from .source import KernelLoop

_ALIGNMENT = 128  # bytes, of the widest vector
_CHUNKS = 16  # blocks per thread: the last block takes at most a sixteenth of the time; with half as many, an eighth
_PATIENCE = 0.1  # seconds between two checks of `stop`: a user waits at most this long


@dataclass(frozen=True)
class Block:
    """Results of n runs, one row per run.

    Attributes
    ----------
    final : array, (n, nx)
        State at `t_stop`.
    minimum, maximum : array, (n, variables)
        Extremes of the recorded samples; NaN where one is NaN.
    metric_values : array, (n, metrics)
        In the manifest's order.
    status : array of uint8, (n,)
        The `Status` of each run.
    violated : array of int32, (n,)
        Index of the limit that ended the run, or -1.
    t_stop : array, (n,)
        Last instant reached, s.
    error : array, (n,)
        Largest estimated error of an accepted step over its tolerance.
    steps : array of int64, (n,)
        Accepted steps.
    series : array, (n, samples, variables)
        Samples on the requested grid, NaN after the run's end; no samples unless requested.
    t_stiff : array, (n,)
        Instant at which `method="auto"` found the run stiff, s; NaN otherwise.
    events : array of int64, (n, events)
        Number of occurrences of each event of the loop.
    """

    final: FloatArray
    minimum: FloatArray
    maximum: FloatArray
    metric_values: FloatArray
    status: NDArray[np.uint8]
    violated: NDArray[np.int32]
    t_stop: FloatArray
    error: FloatArray
    steps: NDArray[np.int64]
    series: FloatArray
    t_stiff: FloatArray
    events: NDArray[np.int64]

    @classmethod
    def empty(cls, loop: KernelLoop, n: int, rows: int) -> Block:
        """Return a block of n runs without results, with series of `rows` samples."""
        variables = len(loop.variables)
        return cls(
            final=np.empty((n, len(loop.manifest.states))),
            minimum=np.empty((n, variables)),
            maximum=np.empty((n, variables)),
            metric_values=np.empty((n, len(loop.metrics))),
            status=np.empty(n, np.uint8),
            violated=np.empty(n, np.int32),
            t_stop=np.empty(n),
            error=np.empty(n),
            steps=np.empty(n, np.int64),
            series=np.full((n, rows, variables), np.nan),
            t_stiff=np.empty(n),
            events=np.zeros((n, len(loop.events)), np.int64),
        )


def compile_kernel(
    model: Model,
    controller: str,
    choices: Mapping[str, object] | None = None,
    options: RunOptions | None = None,
    *,
    lanes: int | None = None,
    own: PythonLaw | None = None,
    origin: str = "the call",
) -> Kernel:
    """Compile the loop of a model under a law, or load it from the cache.

    Parameters
    ----------
    model : Model
        On the C backend.
    controller : str
        The control law.
    choices : mapping, optional
        Choices of the model, as in {"plant": "reduced"}.
    options : RunOptions, optional
        Integration and sampling options, checked by `Plan`; end time and sampling step are given with the runs.
    lanes : int, optional
        Number of runs that a thread computes at once: 1, 2, 4, 8 or 16; default: `suitable_lanes`.
    own : OwnLaw, optional
        A law written in Python instead of a law of the model; `controller` is its name.
    origin : str
        Origin of these arguments in error messages.

    Raises
    ------
    InputError
        For anything unknown or out of bounds.
    BuildError
        If compilation fails.
    """
    law = model.manifest.controller(controller) if own is None else own.controller
    suffix = variant_suffix(model.manifest, choices or {}, origin)
    options = options or RunOptions()
    sampled = options.hold is not None or law.period is not None
    check_loop(model.manifest, law, options.method, None if own else options.hold, sampled, origin)
    if lanes not in (None, 1, 2, 4, 8, 16):
        raise bad_value("lanes", lanes, "1, 2, 4, 8 or 16", origin)
    if options.method == AUTO:
        jacobian_name(model.manifest, law, suffix, sampled, AUTO)
    method = first_integrator(options.method)
    loop = KernelLoop(model.manifest, law, suffix, sampled, method, options.method == AUTO)
    lanes = lanes or suitable_lanes(loop)
    return Kernel(
        loop=loop,
        library=_library(loop, options.profile, lanes),
        lanes=lanes,
        options=options,
        origin=origin,
        own=own,
    )


@dataclass(frozen=True)
class Kernel:
    """A compiled loop; see `compile_kernel`."""

    loop: KernelLoop
    library: ctypes.CDLL
    lanes: int
    options: RunOptions
    origin: str
    own: PythonLaw | None = None

    @functools.cached_property
    def variables(self) -> tuple[str, ...]:
        """Names of recorded variables, in the order of a result file's columns."""
        return self.loop.variables

    def run(
        self,
        first_run: int,
        p: FloatArray,
        c: FloatArray,
        s: FloatArray,
        x0: FloatArray,
        seed: int,
        t_end: float,
        dt: float,
        save_every: float | None = None,
        threads: int = 1,
        stop: Callable[[], bool] | None = None,
    ) -> Block | None:
        """Integrate n runs; with `method="auto"`, `STIFF` repeats stiff runs from the start.

        Parameters
        ----------
        first_run, seed : int
            Number of the first run, and the seed; noise depends on both.
        p, c, s : array, (n, parameters)
            Parameters of plant, law and scenario. The law's period is the same in all runs.
        x0 : array, (n, nx)
            Initial states, finite and within the limits.
        t_end, dt : float
            End time and sampling step, s.
        save_every : float, optional
            Step of the series, a multiple of `dt`; default: none are kept.
        threads : int
            Number of threads.
        stop : callable, optional
            Called regularly; ends the computation when it returns True.

        Returns
        -------
        Block, or None when `stop` ended it

        Raises
        ------
        InputError
            If times are incompatible.
        """
        vectors = {"p": p, "c": c, "s": s, "x0": x0}
        arrays = {name: np.ascontiguousarray(value, dtype=np.float64) for name, value in vectors.items()}
        arrays["number"] = np.arange(first_run, first_run + len(p), dtype=np.uint64)
        common = (seed, t_end, dt, save_every, threads, stop)
        block = self._integrate(arrays, *common)
        stiff = () if block is None else np.flatnonzero(np.isfinite(block.t_stiff))
        if block is None or not len(stiff):
            return block
        kernel = self.stiff if self.own is None else replace(self.stiff, own=self.own.among(len(p), stiff))
        again = kernel._integrate({name: array[stiff] for name, array in arrays.items()}, *common)
        if again is None:
            return None
        for field in fields(Block):
            if field.name != "t_stiff":
                getattr(block, field.name)[stiff] = getattr(again, field.name)
        return block

    @functools.cached_property
    def stiff(self) -> Kernel:
        """Kernel for stiff runs, compiled at first use."""
        loop = self.loop.stiff
        lanes = min(self.lanes, suitable_lanes(loop))
        return replace(self, loop=loop, lanes=lanes, library=_library(loop, self.options.profile, lanes))

    def _integrate(
        self,
        arrays: Mapping[str, NDArray[Any]],
        seed: int,
        t_end: float,
        dt: float,
        save_every: float | None,
        threads: int,
        stop: Callable[[], bool] | None,
    ) -> Block | None:
        """Integrate runs with this kernel's method; return None if `stop` ended it."""
        p = arrays["p"]
        schedule, ticks = self._schedule(p, t_end, dt)
        saved = 0 if save_every is None else schedule.record_every * (times_in(save_every, dt) or 0)
        rows = 0 if save_every is None else len(rows_of(save_every, t_end, dt, self.origin))
        block = Block.empty(self.loop, len(p), rows)
        metrics, signals = self._metric_structures
        halt = ctypes.c_int32(0)
        job = _Job(
            schedule=schedule,
            runs=len(p),
            seed=seed,
            save_every=saved or 1,
            rows=rows,
            metrics=len(metrics),
            metric=ctypes.addressof(metrics),
            signal=ctypes.addressof(signals),
            stop=ctypes.addressof(halt),
            **{name: array.ctypes.data for name, array in arrays.items()},
            **{field.name: getattr(block, field.name).ctypes.data for field in fields(Block)},
        )
        blocks = -(-len(p) // self.lanes)
        if self.own is None:
            complete = _in_threads(self.library, job, blocks, threads, halt, stop)
        else:
            complete = self._in_step(job, ticks, blocks, threads, stop)
        return block if complete else None

    def check(self, p: FloatArray, t_end: float, dt: float) -> None:
        """Refuse incompatible times, for runs with plant parameters p, shape (n, np).

        Raises
        ------
        InputError
            As `run` does.
        """
        self._schedule(p, t_end, dt)

    def _schedule(self, p: FloatArray, t_end: float, dt: float) -> tuple[Any, FloatArray]:
        """Return the common data of all runs as a C structure, and its array of ticks, which must outlive it."""
        hold = self._hold(p)
        ticks, record_every, hold_every = _ticks(t_end, dt, hold, self.origin)
        check_delay(self.options.delay, len(ticks), hold_every, self.origin)
        schedule = _Schedule(
            t=ticks.ctypes.data,
            ticks=len(ticks),
            record_every=record_every,
            hold_every=hold_every or 1,
            max_steps=self.options.max_steps,
            delay=self.options.delay,
            rtol=self.options.rtol,
            atol=self.options.atol,
            step=self.options.step or min(dt, hold or dt),
            longest=max(input_delays(self.loop.manifest, p, len(ticks), hold_every, self.origin), default=0),
        )
        return schedule, ticks

    def _hold(self, p: FloatArray) -> float | None:
        """Return the hold time, which is equal for all runs."""
        period = self.loop.controller.period
        if period is None:
            return self.options.hold
        column = p[:, [q.name for q in self.loop.manifest.parameters].index(period)]
        if np.any(column != column[0]):
            raise InputError(f"{period} (from {self.origin}): must be the same in all runs of a batch")
        check_hold(self.options.hold, self.loop.controller, float(column[0]), self.origin)
        return float(column[0])

    def _in_step(self, job: Any, ticks: FloatArray, blocks: int, threads: int, stop: Callable[[], bool] | None) -> bool:
        """Advance all blocks from sample to sample of a law in Python; return True when they are complete."""
        assert self.own is not None
        manifest, library, every = self.loop.manifest, self.library, job.schedule.hold_every
        widths = {"x": len(manifest.seen), "r": len(manifest.references), "u": len(manifest.inputs)}
        rows = {name: np.empty((width, job.runs)) for name, width in widths.items()}
        rows["z"] = np.repeat(self.own.start[:, None], job.runs, axis=1)
        places = np.empty(blocks * library.mv_place_size(ctypes.byref(job)) + _ALIGNMENT, np.uint8)
        place = places.ctypes.data + -places.ctypes.data % _ALIGNMENT
        own = _Own(places=place, **{name: array.ctypes.data for name, array in rows.items()})
        shares = list(itertools.pairwise(blocks * k // threads for k in range(threads + 1)))
        # for a run that has ended, the law gets its last values, which need not be finite
        with ThreadPoolExecutor(threads) as pool, np.errstate(all="ignore"):

            def each(function: Any, *until: int) -> None:
                parts = [
                    pool.submit(function, ctypes.byref(job), ctypes.byref(own), *until, *share) for share in shares
                ]
                for part in parts:
                    part.result()

            each(library.mv_begin_blocks)
            for tick in range(0, len(ticks), every):
                if stop is not None and stop():
                    return False
                u, z = self.own.command(float(ticks[tick]), rows["x"], rows["r"], rows["z"])
                # a memory that is not finite ends its run, as an input does
                rows["u"][:], rows["z"][:] = np.where(np.isfinite(z).all(axis=0), u, np.nan), z
                each(library.mv_continue_blocks, min(tick + every, len(ticks)))
        return True

    @functools.cached_property
    def _metric_structures(self) -> tuple[Any, Any]:
        """Metrics and their signals as C structures."""
        columns = {name: i for i, name in enumerate(self.variables)}
        metrics, signals = [], []
        for metric in self.loop.metrics:
            metrics.append((METRIC_KINDS.index(metric.kind), len(metric.of), metric.band, metric.since, metric.until))
            for of in metric.of:
                if metric.kind == COUNT:
                    signals.append((event_number(metric, of, self.loop.events), -1))
                    continue
                names = [name.strip() for name in of.split(" - ")]
                for name in names:
                    if name not in columns:
                        raise unknown_name(f"variable in metric {metric.name}", name, columns)
                signals.append((columns[names[0]], columns[names[1]] if len(names) > 1 else -1))
        return (_Metric * len(metrics))(*metrics), (_Signal * len(signals))(*signals)


_STRUCTURES = structures("step/schedule.h", "batch/job.h", "batch/lockstep.h")
_Schedule, _Metric, _Signal, _Job, _Own = (
    _STRUCTURES[f"mv_{name}"] for name in ("schedule", "metric", "signal", "job", "own")
)


LEAST_PARALLEL = 5
"""Operations of a loop for each one in its longest chain. With fewer, the processor mostly waits for results, so lanes
fill two registers, whose operations alternate. The loops of the triangle have 3; they then take 0.70 to 0.74 of the
time with AVX2, 0.80 to 0.86 with AVX-512. Loops of slosh have 8 to 13 and would take 1.09 to 1.13 times as long. Half
this value excludes the triangle; twice includes slosh.
"""


def suitable_lanes(loop: KernelLoop) -> int:
    """Return the number of runs that a thread computes at once: as many as fill one register or two."""
    if loop.sampled or "loop_jac" in loop.calls or not _copies_registers():
        return widest()
    slope = loop.calls["loop"]
    return widest() * (2 if slope.operations < LEAST_PARALLEL * slope.chain else 1)


def _copies_registers() -> bool:
    """Return True if the compiler handles vectors of two registers well."""
    return widest() > 2 and require_compiler().copies_registers


LONGEST_SCHEDULED = 10_000
"""Number of operations above which gcc does not schedule a function's instructions, because the compile time grows
faster than linearly. Slosh with sixteen pendulums (6840 operations) compiles in 22.6 s with scheduling and 10.9 s
without, but then runs 1.07 times as long. Without scheduling, 32 pendulums compile in 32 instead of 102 s. Half this
value includes the sixteen pendulums, twice excludes the 32.
"""


def kernel_flags(loop: KernelLoop, profile: Profile, lanes: int) -> tuple[str, ...]:
    """Return the compiler flags of a kernel, in addition to those of every library."""
    contract = "off" if profile == "portable" else "fast"
    short = max(function.operations for function in loop.calls.values()) <= LONGEST_SCHEDULED
    scheduling = require_compiler().scheduling if short else ()
    flags = ("-O2", "-fno-tree-slp-vectorize", "-Wno-psabi", f"-DMEHVAR_LANES={lanes}")
    bits = 64 * widest()
    copies = (f"-mmove-max={bits}", f"-mstore-max={bits}") if lanes > widest() and _copies_registers() else ()
    return (*flags, *vector_flags(), *copies, *scheduling, f"-ffp-contract={contract}")


def _library(loop: KernelLoop, profile: Profile, lanes: int) -> ctypes.CDLL:
    """Compile a kernel or load it from the cache."""
    name = f"{identifier(loop.manifest.model)}_batch"
    library = load_library(name, loop.sources, ["batch.c"], kernel_flags(loop, profile, lanes))
    library.mv_job_size.restype = library.mv_work_size.restype = ctypes.c_int64
    library.mv_work_size.argtypes = [ctypes.c_void_p]
    library.mv_run_blocks.argtypes = [ctypes.c_void_p, *[ctypes.c_int64] * 2, ctypes.c_void_p]
    if not loop.generated:
        library.mv_place_size.restype, library.mv_place_size.argtypes = ctypes.c_int64, [ctypes.c_void_p]
        library.mv_begin_blocks.argtypes = [*[ctypes.c_void_p] * 2, *[ctypes.c_int64] * 2]
        library.mv_continue_blocks.argtypes = [*[ctypes.c_void_p] * 2, *[ctypes.c_int64] * 3]
    if library.mv_job_size() != ctypes.sizeof(_Job):
        raise RuntimeError("the compiled batch kernel does not match its Python interface; reinstall mehvar")
    return library


def _in_threads(
    library: ctypes.CDLL,
    job: Any,
    blocks: int,
    threads: int,
    halt: ctypes.c_int32,
    stop: Callable[[], bool] | None,
) -> bool:
    """Run all blocks in several threads; return True when they are complete."""
    chunk = max(1, blocks // (_CHUNKS * threads))
    starts, lock = iter(range(0, blocks, chunk)), threading.Lock()
    size = library.mv_work_size(ctypes.byref(job))

    def work() -> None:
        buffer = np.empty(size + _ALIGNMENT, np.uint8)
        place = buffer.ctypes.data + -buffer.ctypes.data % _ALIGNMENT
        while not halt.value:
            with lock:
                first = next(starts, None)
            if first is None:
                return
            library.mv_run_blocks(ctypes.byref(job), first, min(first + chunk, blocks), place)

    running = {_pool(threads).submit(work) for _ in range(min(threads, blocks))}
    try:
        while running:
            done, running = wait(running, None if stop is None else _PATIENCE)
            for future in done:
                future.result()
            if stop is not None and stop():
                halt.value = 1
    except BaseException:
        halt.value = 1
        wait(running)  # before the memory that they write to is freed
        raise
    return not halt.value


_ticks = functools.lru_cache(maxsize=4)(ticks_of)
"""Cache of instants for one or two campaigns."""


@functools.lru_cache(maxsize=4)
def _pool(threads: int) -> ThreadPoolExecutor:
    """Return a thread pool that later calls reuse."""
    return ThreadPoolExecutor(threads)


os.register_at_fork(after_in_child=_pool.cache_clear)  # threads do not survive a fork
