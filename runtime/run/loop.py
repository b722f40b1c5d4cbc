# SPDX-License-Identifier: Apache-2.0
"""Integration of closed loops by the native loop, with compiled functions or those of the NumPy module."""

from __future__ import annotations

import ctypes
import functools
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from ..compiling.library import load_native
from ..compiling.structures import structures
from .callbacks import Callbacks, addresses
from .options import INTEGRATORS
from .problem import Problem, Status, Trajectory
from .user.law import Law

_CHUNK_SECONDS = 0.03  # between two checks for interrupts and calls of the progress callback

_STRUCTURES = structures("step/schedule.h", "single/single.h")
_Schedule, _Model, _Single, _Journal = (
    _STRUCTURES[f"mv_{name}"] for name in ("schedule", "model", "single", "journal")
)
_DOUBLES, _INTEGERS = ctypes.POINTER(ctypes.c_double), ctypes.POINTER(ctypes.c_int32)


def run(problem: Problem, interrupted: Callable[[], None]) -> Trajectory:
    """Integrate a closed loop without Python's lock.

    A sampled Python law runs between two calls of the native loop. A continuous law and functions of the NumPy module
    are callbacks. An exception in any of them or in a signal handler ends the run.

    Parameters
    ----------
    problem : Problem
        The loop.
    interrupted : callable
        Raises a signal handler's exception that a callback dropped; see `KeptInterrupts`.

    Raises
    ------
    MissingError
        Without a C compiler.
    """
    library = _library()
    callbacks = Callbacks()
    single, arrays = _prepare(problem, callbacks)
    journal = _Journal()
    single.happened, single.journal = ctypes.cast(library.mv_enter, ctypes.c_void_p), ctypes.addressof(journal)
    law = None if problem.law is None else _Callback(problem.law, single)

    def check() -> None:
        callbacks.check()
        interrupted()

    try:
        with np.errstate(all="ignore"):
            _drive(library, single, problem, law, check)
        crossings = _events(journal)
    finally:
        library.mv_journal_free(ctypes.byref(journal))
    count = single.records
    q = arrays["q"][: len(arrays["q"]) - (0 if problem.hold_every else len(problem.z0))]
    charted = problem.charted
    return Trajectory(
        t=arrays["record_t"][:count],
        x=arrays["record_x"][:count],
        u=arrays["record_u"][:count],
        u_cmd=arrays["record_u_cmd"][:count],
        y=arrays["record_y"][:count],
        z=arrays["record_z"][:count],
        status=Status(single.status),
        violated=single.violated if single.status == Status.LIMIT else -1,
        t_stop=float(single.t),
        error=float(single.error),
        t_stiff=float(single.t_stiff),
        x_stop=problem.model.functions["from_coordinates"](q) if charted else q,
        crossings=crossings,
        statistics={name: getattr(single, name) for name in ("steps", "rejected", "evaluations")},
    )


@functools.cache
def _library() -> ctypes.CDLL:
    library = load_native()
    library.mv_single_size.restype = library.mv_work_size.restype = ctypes.c_int64
    library.mv_start.argtypes = [ctypes.c_void_p, ctypes.c_void_p]
    library.mv_run.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int64]
    if library.mv_single_size() != ctypes.sizeof(_Single):
        raise RuntimeError("the compiled native loop does not match its Python interface; reinstall mehvar")
    return library


def _events(journal: Any) -> tuple[tuple[float, int], ...]:
    if journal.full:
        raise MemoryError(f"not enough memory for the events of a run after {journal.count} events")
    times, events = ctypes.cast(journal.t, _DOUBLES), ctypes.cast(journal.event, _INTEGERS)
    return tuple(zip(times[: journal.count], events[: journal.count], strict=True))


class _Callback:
    """Caller of a law outside of C, with arrays of its arguments and result at a sample."""

    def __init__(self, law: Law, single: Any) -> None:
        model = single.model
        sizes = {"x": model.nseen, "r": model.nr, "v": model.nu, "z": model.nz}
        self._law, self._seen = law, {name: np.zeros(size) for name, size in sizes.items()}
        self._u, self._z_next = np.zeros(model.nu + 1), np.zeros(model.nz)  # of no inputs, too, there is an address
        for name, array in self._seen.items():
            setattr(single, f"{name}_seen", array.ctypes.data)
        model.u_own, model.z_own = self._u.ctypes.data, self._z_next.ctypes.data

    def answer(self) -> None:
        """Evaluate the law at the current sample."""
        self._u[:-1], self._z_next[:] = self._law(*(array.copy() for array in self._seen.values()))


def _drive(
    library: ctypes.CDLL, single: Any, problem: Problem, law: _Callback | None, check: Callable[[], None]
) -> None:
    """Call the native loop in chunks of samples; in between, handle interrupts, external laws and progress."""
    work = np.empty(library.mv_work_size(ctypes.byref(single)), np.uint8)
    library.mv_start(ctypes.byref(single), work.ctypes.data)
    check()
    chunk, end = 16, len(problem.t)

    def goes_on(until: int) -> bool:
        return single.tick < until and single.status == Status.DONE and not single.t_stiff > 0

    while goes_on(end):
        start = time.perf_counter()
        until = min(single.tick + chunk, end)
        while goes_on(until):
            library.mv_run(ctypes.byref(single), work.ctypes.data, _answered(law, problem, single.tick, until))
            check()
        if problem.progress and single.status == Status.DONE:
            problem.progress(float(problem.t[until - 1]), float(problem.t[-1]))
        elapsed = max(time.perf_counter() - start, 1e-6)
        chunk = max(1, int(chunk * min(8.0, _CHUNK_SECONDS / elapsed)))


def _answered(law: _Callback | None, problem: Problem, tick: int, until: int) -> int:
    """Evaluate an external law if it is due at a tick, and return the tick until which the loop may run."""
    if law is None or problem.hold_every is None:
        return until
    if tick % problem.hold_every == 0:
        law.answer()
    return min(until, (tick // problem.hold_every + 1) * problem.hold_every)


def _prepare(problem: Problem, callbacks: Callbacks) -> tuple[Any, dict[str, Any]]:
    """Return the C structure of a run, and the arrays that it refers to."""
    manifest = problem.model.manifest
    sampled = problem.hold_every is not None
    timed = problem.continuous_own
    x0 = problem.x0
    if problem.charted:
        x0 = problem.model.functions["to_coordinates"](x0)
    if not sampled:
        x0 = np.concatenate((x0, problem.z0))
    nx, nu, ny = (len(group) for group in (manifest.states, manifest.inputs, manifest.outputs))
    nz = len(problem.controller.memory)
    rows = (len(problem.t) - 1 + problem.record_every - 1) // problem.record_every + 1
    values, options = problem.parameters, problem.options
    arguments = {"p": values.p, "c": values.c, "s": values.s, "e": problem.noise, "t": problem.t}
    arrays: dict[str, Any] = {
        name: np.array(v, dtype=np.float64) for name, v in (arguments | {"q": x0, "z": problem.z0}).items()
    }
    widths = {"x": nx, "u": nu, "u_cmd": nu, "y": ny, "z": nz}
    records = {"record_t": np.zeros(rows)} | {f"record_{name}": np.zeros((rows, n)) for name, n in widths.items()}
    arrays |= records
    numbers = [event.numbers for event in problem.events]
    arrays["events"] = np.array(numbers, dtype=np.int32)  # must live as long as the others
    pointers = {name: array.ctypes.data for name, array in arrays.items()}
    schedule = _Schedule(
        t=pointers["t"],
        ticks=len(problem.t),
        record_every=problem.record_every,
        hold_every=problem.hold_every or 1,
        max_steps=options.max_steps,
        delay=options.delay,
        rtol=options.rtol,
        atol=options.atol,
        step=problem.step,
        longest=max(problem.input_delays, default=0),
    )
    model = _Model(
        **{"nq": len(x0), "nx": nx, "nu": nu, "nz": nz, "ny": ny},
        **{"nr": len(manifest.references) + timed, "nm": len(manifest.limits), "ne": problem.noise.shape[-1]},
        nseen=len(manifest.seen),
        nw=len(manifest.wiener),
        nj=manifest.jump,
        seed=options.seed,
        run=options.run,
        nv=len(numbers),
        sampled=sampled,
        reference_constant=manifest.reference_constant and not timed,
        limits_of_state=manifest.limits_of_state,
        method=INTEGRATORS.index(problem.method),
        stiff_test=problem.stiff_test,
        **addresses(problem, callbacks),
        **{name: pointers[name] for name in ("p", "c", "s", "e", "events")},
    )
    results = {name: pointers[name] for name in ("q", "z", *records)}
    return _Single(schedule=schedule, model=model, **results), arrays
