# SPDX-License-Identifier: Apache-2.0
"""Closed loops in C: the native loop drives the compiled functions of a model."""

from __future__ import annotations

import ctypes
import time
from typing import Any

import numpy as np

from mehvar.errors import InputError

from ..compiling.library import load_native
from ..model.functions import CBackend, FloatArray
from ..model.manifest import Function, identifier
from .options import METHODS
from .problem import STAGES, Problem, Status, Trajectory

_CHUNK_SECONDS = 0.03  # between two looks at the keyboard and the progress callback

_ARGUMENTS = {
    "rhs": "x u p",
    "outputs": "x u r p",
    "limits": "x u p",
    "reference": "t p s",
    "law": "x r p c",
    "law_memory": "x r v z p c",
    "loop": "q r p c",
    "observe": "q r p c",
    "observe_command": "q r p c",
    "actuate": "x u_cmd p",
    "measure": "x e p",
    "project": "q",
}


class _Stepper(ctypes.Structure):
    """Mirrors mv_stepper of integrator.h."""

    _fields_ = (
        *((name, ctypes.c_int32) for name in ("method", "n", "held", "ready")),
        *((name, ctypes.c_double) for name in ("rtol", "atol", "step", "t", "h", "reserve")),
        *((name, ctypes.c_int64) for name in ("max_steps", "accepted", "rejected", "evaluations")),
        ("work", ctypes.c_void_p),
    )


class _Loop(ctypes.Structure):
    """Mirrors mv_loop of loop.c."""

    _fields_ = (
        ("stepper", _Stepper),
        *((name, ctypes.c_int32) for name in ("nq", "nx", "nu", "nz", "ny", "nm", "ne")),
        *((name, ctypes.c_int32) for name in ("reference_constant", "sampled", "delay", "violated")),
        *((name, ctypes.c_int64) for name in ("hold_every", "record_every", "ticks", "tick", "records")),
        *((name, ctypes.c_void_p) for name in _ARGUMENTS),
        *((name, ctypes.c_void_p) for name in ("p", "c", "s", "t", "noise")),
        *((name, ctypes.c_void_p) for name in ("q", "q_next", "x", "seen", "u", "u_cmd", "delayed", "r")),
        *((name, ctypes.c_void_p) for name in ("z", "z_next", "margin", "queue")),
        *((name, ctypes.c_void_p) for name in ("rec_t", "rec_x", "rec_u", "rec_u_cmd", "rec_y", "rec_z")),
    )


def run(problem: Problem, backend: CBackend) -> Trajectory:
    """Integrate a closed loop; the interpreter lock is free while it runs."""
    library = load_native()
    if library.mv_loop_size() != ctypes.sizeof(_Loop):
        raise RuntimeError("the native loop and its Python mirror disagree; reinstall mehvar")
    loop, arrays = _prepare(problem, backend)
    elsewhere = None if problem.law is None else _Elsewhere(problem, loop)
    status = _drive(library, loop, problem)
    if elsewhere is not None and elsewhere.error is not None:
        raise elsewhere.error
    count = loop.records
    steps = loop.stepper
    x_stop = arrays["q"]
    if problem.hold_every is None and "from_coordinates" in problem.model.manifest.functions:
        x_stop = problem.model.functions["from_coordinates"](x_stop)
    return Trajectory(
        t=arrays["rec_t"][:count],
        x=arrays["rec_x"][:count],
        u=arrays["rec_u"][:count],
        u_cmd=arrays["rec_u_cmd"][:count],
        y=arrays["rec_y"][:count],
        z=arrays["rec_z"][:count],
        status=status,
        violated=loop.violated,
        t_stop=float(steps.t),
        x_stop=x_stop,
        statistics={"steps": steps.accepted, "rejected": steps.rejected, "evaluations": steps.evaluations},
    )


class _Elsewhere:
    """Has a Python callable evaluate the law; what it raises ends the run and is kept, as C cannot pass it on."""

    def __init__(self, problem: Problem, loop: _Loop) -> None:
        assert problem.law is not None
        self.error: BaseException | None = None
        self._law = problem.law
        self._nx, self._nu, self._nz = loop.nx, loop.nu, loop.nz
        self._nr = len(problem.model.manifest.references)
        pointer = ctypes.POINTER(ctypes.c_double)
        with_memory = bool(problem.controller.memory)
        kind = ctypes.CFUNCTYPE(None, *[pointer] * (8 if with_memory else 5))
        self._callback = kind(self._with_memory if with_memory else self._without)
        address = ctypes.cast(self._callback, ctypes.c_void_p)
        if with_memory:
            loop.law_memory = address
        else:
            loop.law = address

    def _without(self, x: Any, r: Any, _p: Any, _c: Any, u: Any) -> None:
        applied, memory = np.zeros(self._nu), np.empty(0)
        self._evaluate(_view(x, self._nx), _view(r, self._nr), applied, memory, _view(u, self._nu), memory)

    def _with_memory(self, x: Any, r: Any, v: Any, z: Any, _p: Any, _c: Any, u: Any, z_next: Any) -> None:
        given = _view(x, self._nx), _view(r, self._nr), _view(v, self._nu), _view(z, self._nz)
        self._evaluate(*given, _view(u, self._nu), _view(z_next, self._nz))

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


def _drive(library: ctypes.CDLL, loop: _Loop, problem: Problem) -> Status:
    """Call the native loop in chunks of samples: interrupts and the progress callback get their turn."""
    chunk, end = 16, len(problem.t)
    while loop.tick < end:
        start = time.perf_counter()
        until = min(loop.tick + chunk, end)
        status = Status(library.mv_run(ctypes.byref(loop), ctypes.c_int64(until)))
        if status is not Status.DONE:
            return status
        if problem.progress:
            problem.progress(float(problem.t[until - 1]), float(problem.t[-1]))
        elapsed = max(time.perf_counter() - start, 1e-6)
        chunk = max(1, int(chunk * min(8.0, _CHUNK_SECONDS / elapsed)))
    return Status.DONE


def _prepare(problem: Problem, backend: CBackend) -> tuple[_Loop, dict[str, FloatArray]]:
    """Return the loop structure and the arrays that it points to."""
    manifest = problem.model.manifest
    sampled = problem.hold_every is not None
    addresses = _addresses(problem, backend)
    x0 = problem.x0
    if not sampled and "to_coordinates" in manifest.functions:
        x0 = problem.model.functions["to_coordinates"](x0)
    nq, nx, nu = len(x0), len(manifest.states), len(manifest.inputs)
    ny, nz = len(manifest.outputs), len(problem.controller.memory)
    nr, nm = len(manifest.references), len(manifest.limits)
    rows = (len(problem.t) - 1 + problem.record_every - 1) // problem.record_every + 1
    given = {"p": problem.p, "c": problem.c, "s": problem.s, "t": problem.t, "noise": problem.noise}
    state = {"q": x0, "z": problem.z0}
    shapes: dict[str, tuple[int, ...]] = {
        **{"x": (nx,), "u": (nu,), "u_cmd": (nu,), "r": (nr,), "z_next": (nz,), "margin": (nm,)},
        **{"q_next": (nq,), "seen": (nx,), "delayed": (nu,)},
        **{"queue": (problem.delay, nu), "work": (STAGES + 3, nq)},
        **{"rec_t": (rows,), "rec_x": (rows, nx), "rec_u": (rows, nu), "rec_u_cmd": (rows, nu)},
        **{"rec_y": (rows, ny), "rec_z": (rows, nz)},
    }
    arrays = {name: np.array(value, dtype=np.float64) for name, value in (given | state).items()}
    arrays |= {name: np.zeros(shape) for name, shape in shapes.items()}
    pointers = {name: array.ctypes.data for name, array in arrays.items()}
    stepper = _Stepper(
        method=METHODS.index(problem.method),
        n=nq,
        held=sampled,
        rtol=problem.rtol,
        atol=problem.atol,
        step=problem.step,
        t=problem.t[0],
        reserve=1.0,
        max_steps=problem.max_steps,
        work=pointers.pop("work"),
    )
    loop = _Loop(
        stepper=stepper,
        **{"nq": nq, "nx": nx, "nu": nu, "nz": nz, "ny": ny, "nm": nm, "ne": problem.noise.shape[-1]},
        reference_constant=manifest.reference_constant,
        sampled=sampled,
        delay=problem.delay,
        hold_every=problem.hold_every or 1,
        record_every=problem.record_every,
        ticks=len(problem.t),
        **addresses,
        **pointers,
    )
    return loop, arrays


def _addresses(problem: Problem, backend: CBackend) -> dict[str, int]:
    """Return the C functions that the loop calls, after a look at their signatures."""
    functions, law = problem.model.manifest.functions, identifier(problem.controller.name)
    by_identifier = {identifier(name): function for name, function in functions.items()}
    names = {"rhs": f"rhs{problem.suffix}", "outputs": "outputs", "reference": "reference"}
    if problem.model.manifest.limits:
        names["limits"] = "limits"
    if problem.hold_every is None:
        seen = "observe_command" if "actuate" in by_identifier else "observe"
        names |= {"loop": f"{law}_loop{problem.suffix}", seen: f"{law}_observe"}
    else:
        names["law_memory" if problem.controller.memory else "law"] = law
        names |= {name: name for name in ("actuate", "measure") if name in by_identifier}
    if "project" in by_identifier and (problem.hold_every is None or "to_coordinates" not in by_identifier):
        names["project"] = "project"
    found = {role: _checked(by_identifier, name, _ARGUMENTS[role].split()) for role, name in names.items()}
    narrow = {"law", "law_memory"} if problem.real == "float" else set()
    return {
        role: backend.address(function.name, "float" if role in narrow else "double")
        for role, function in found.items()
    }


def _checked(functions: dict[str, Function], name: str, arguments: list[str]) -> Function:
    function = functions.get(name)
    if function is None or [a.name for a in function.arguments] != arguments:
        wanted = f"{name}({', '.join(arguments)})"
        raise InputError(f"the generated folder lacks the function {wanted}; generate the model again")
    return function
