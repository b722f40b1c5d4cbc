# SPDX-License-Identifier: Apache-2.0
"""Closed loops in C: the native loop drives the compiled functions of a model."""

from __future__ import annotations

import ctypes
import functools
import time
from typing import Any

import numpy as np

from ..compiling.library import load_native
from ..compiling.structures import structures
from ..model.functions import CBackend, FloatArray, Real
from .calls import loop_calls, model_fields
from .options import INTEGRATORS
from .problem import Problem, Status, Trajectory

_CHUNK_SECONDS = 0.03  # between two looks at the keyboard and the progress callback

_STRUCTURES = structures("step/schedule.h", "single/single.h")
_HAPPENED = ctypes.CFUNCTYPE(None, ctypes.c_double, ctypes.c_int32)
_Schedule, _Model, _Single = (_STRUCTURES[name] for name in ("mv_schedule", "mv_model", "mv_single"))


def run(problem: Problem, backend: CBackend) -> Trajectory:
    """Integrate a closed loop; the interpreter lock is free while it runs."""
    library = _library()
    single, arrays = _prepare(problem, backend)
    log: list[tuple[float, int]] = []
    happened = _HAPPENED(lambda t, event: log.append((t, event)))
    single.happened = ctypes.cast(happened, ctypes.c_void_p)
    elsewhere = None if problem.law is None else _Elsewhere(problem, single.model)
    _drive(library, single, problem)
    if elsewhere is not None and elsewhere.error is not None:
        raise elsewhere.error
    count = single.records
    q = arrays["q"][: len(arrays["q"]) - (0 if problem.hold_every else len(problem.z0))]
    charted = problem.hold_every is None and "from_coordinates" in problem.model.manifest.functions
    return Trajectory(
        t=arrays["record_t"][:count],
        x=arrays["record_x"][:count],
        u=arrays["record_u"][:count],
        u_cmd=arrays["record_u_cmd"][:count],
        y=arrays["record_y"][:count],
        z=arrays["record_z"][:count],
        status=Status(single.status),
        violated=single.violated,
        t_stop=float(single.t),
        error=float(single.error),
        t_stiff=float(single.t_stiff),
        x_stop=problem.model.functions["from_coordinates"](q) if charted else q,
        events=tuple(log),
        statistics={name: getattr(single, name) for name in ("steps", "rejected", "evaluations")},
    )


@functools.cache
def _library() -> ctypes.CDLL:
    library = load_native()
    library.mv_single_size.restype = library.mv_work_size.restype = ctypes.c_int64
    library.mv_start.argtypes = [ctypes.c_void_p, ctypes.c_void_p]
    library.mv_run.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int64]
    if library.mv_single_size() != ctypes.sizeof(_Single):
        raise RuntimeError("the native loop and its Python mirror disagree; reinstall mehvar")
    return library


class _Elsewhere:
    """Has a Python callable evaluate the law; what it raises ends the run and is kept, as C cannot pass it on."""

    def __init__(self, problem: Problem, model: Any) -> None:
        assert problem.law is not None
        self.error: BaseException | None = None
        self._law = problem.law
        self._nx, self._nr, self._nu, self._nz = model.nseen, model.nr, model.nu, model.nz
        pointer = ctypes.POINTER(ctypes.c_double)
        with_memory = bool(problem.controller.memory)
        kind = ctypes.CFUNCTYPE(None, *[pointer] * (8 if with_memory else 5))
        self._callback = kind(self._with_memory if with_memory else self._without)
        address = ctypes.cast(self._callback, ctypes.c_void_p)
        if with_memory:
            model.law_memory = address
        else:
            model.law = address

    def _without(self, x: Any, r: Any, _p: Any, _c: Any, u: Any) -> None:
        applied, memory = np.zeros(self._nu), np.empty(0)
        self._evaluate(_view(x, self._nx), _view(r, self._nr), applied, memory, _view(u, self._nu), memory)

    def _with_memory(self, x: Any, r: Any, v: Any, z: Any, _p: Any, _c: Any, u: Any, z_next: Any) -> None:
        arguments = _view(x, self._nx), _view(r, self._nr), _view(v, self._nu), _view(z, self._nz)
        self._evaluate(*arguments, _view(u, self._nu), _view(z_next, self._nz))

    def _evaluate(
        self, x: FloatArray, r: FloatArray, v: FloatArray, z: FloatArray, u: FloatArray, z_next: FloatArray
    ) -> None:
        try:
            u[:], z_next[:] = self._law(x, r, v, z)
        except BaseException as error:
            self.error = error
            u[:] = np.nan


def _view(pointer: Any, size: int) -> FloatArray:
    return np.ctypeslib.as_array(pointer, (size,)) if size else np.empty(0)


def _drive(library: ctypes.CDLL, single: Any, problem: Problem) -> None:
    """Call the native loop in chunks of samples: interrupts and the progress callback get their turn."""
    work = np.empty(library.mv_work_size(ctypes.byref(single)), np.uint8)
    library.mv_start(ctypes.byref(single), work.ctypes.data)
    chunk, end = 16, len(problem.t)
    while single.tick < end and single.status == Status.DONE and not single.t_stiff > 0:
        start = time.perf_counter()
        until = min(single.tick + chunk, end)
        library.mv_run(ctypes.byref(single), work.ctypes.data, until)
        if problem.progress and single.status == Status.DONE:
            problem.progress(float(problem.t[until - 1]), float(problem.t[-1]))
        elapsed = max(time.perf_counter() - start, 1e-6)
        chunk = max(1, int(chunk * min(8.0, _CHUNK_SECONDS / elapsed)))


def _prepare(problem: Problem, backend: CBackend) -> tuple[Any, dict[str, Any]]:
    """Return the structure of a run and the arrays that it points to."""
    manifest = problem.model.manifest
    sampled = problem.hold_every is not None
    x0 = problem.x0
    if not sampled and "to_coordinates" in manifest.functions:
        x0 = problem.model.functions["to_coordinates"](x0)
    if not sampled:
        x0 = np.concatenate((x0, problem.z0))
    nx, nu, ny = (len(group) for group in (manifest.states, manifest.inputs, manifest.outputs))
    nz = len(problem.controller.memory)
    rows = (len(problem.t) - 1 + problem.record_every - 1) // problem.record_every + 1
    arguments = {"p": problem.p, "c": problem.c, "s": problem.s, "e": problem.noise, "t": problem.t}
    arrays: dict[str, Any] = {
        name: np.array(v, dtype=np.float64) for name, v in (arguments | {"q": x0, "z": problem.z0}).items()
    }
    widths = {"x": nx, "u": nu, "u_cmd": nu, "y": ny, "z": nz}
    records = {"record_t": np.zeros(rows)} | {f"record_{name}": np.zeros((rows, n)) for name, n in widths.items()}
    arrays |= records
    numbers = [event.numbers for event in problem.events]
    arrays["events"] = np.array(numbers, dtype=np.int32)  # kept as long as the others
    pointers = {name: array.ctypes.data for name, array in arrays.items()}
    schedule = _Schedule(
        t=pointers["t"],
        ticks=len(problem.t),
        record_every=problem.record_every,
        hold_every=problem.hold_every or 1,
        max_steps=problem.max_steps,
        delay=problem.delay,
        rtol=problem.rtol,
        atol=problem.atol,
        step=problem.step,
        longest=max(problem.late, default=0),
    )
    model = _Model(
        **{"nq": len(x0), "nx": nx, "nu": nu, "nz": nz, "ny": ny},
        **{"nr": len(manifest.references), "nm": len(manifest.limits), "ne": problem.noise.shape[-1]},
        nseen=len(manifest.seen),
        nw=len(manifest.wiener),
        nj=len(manifest.random_step),
        seed=problem.seed,
        run=problem.run,
        nv=len(numbers),
        sampled=sampled,
        reference_constant=manifest.reference_constant,
        limits_of_state=manifest.limits_of_state,
        method=INTEGRATORS.index(problem.method),
        stiff_test=problem.stiff_test,
        **_addresses(problem, backend),
        **{name: pointers[name] for name in ("p", "c", "s", "e", "events")},
    )
    results = {name: pointers[name] for name in ("q", "z", *records)}
    return _Single(schedule=schedule, model=model, **results), arrays


def _addresses(problem: Problem, backend: CBackend) -> dict[str, int]:
    """Return where the C functions are that the loop calls."""
    controller, sampled = problem.controller, problem.hold_every is not None
    manifest = problem.model.manifest
    calls = loop_calls(manifest, controller, problem.suffix, sampled, problem.method)
    reals: dict[str, Real] = {"law": problem.real, "law_memory": problem.real}
    return {
        field: backend.address(function.name, reals.get(field, "double"))
        for field, function in model_fields(calls, manifest, controller).items()
    }
