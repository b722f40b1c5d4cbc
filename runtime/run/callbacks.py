# SPDX-License-Identifier: Apache-2.0
"""Addresses of functions for the native loop, with callbacks for Python functions.

Compiled functions are called directly. Functions of the NumPy module, and the loop under a continuous law in Python,
get an address by `ctypes`. C cannot propagate exceptions. The first one is stored, later results are NaN, and the
loop ends; `Callbacks.check` then raises the exception.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from mehvar.base.manifest import Function

from ..model.functions import CBackend, FloatArray
from .calls import loop_calls, model_fields
from .problem import Problem

Shape = tuple[int, ...]

_LAWS = ("law", "law_memory")
"""Functions that may compute in float."""
_OF_PLANT = ("outputs", "limits", "resets", "mass", "diffuse", "project")
"""Plant functions that a loop under a continuous Python law calls unchanged."""
_DIFFERENCE = 1.5e-8
"""Step of a forward difference relative to a state or one, the square root of double precision. An implicit method
accepts inexact Jacobians; ten times or a tenth costs digits.
"""


class Callbacks:
    """Addresses of Python functions, valid during this object's life, and the first exception that they raised."""

    def __init__(self) -> None:
        self._alive: list[Any] = []
        self._error: BaseException | None = None

    def check(self) -> None:
        """Raise the first exception of a callback, if any."""
        if self._error is not None:
            raise self._error

    def address(self, function: Callable[..., Any], arguments: Sequence[Shape], results: Sequence[Shape]) -> int:
        """Return the address of a function of arrays.

        Parameters
        ----------
        function : callable
            Function of arrays of these shapes (numbers for the shape ()) that returns one result or a tuple.
        arguments, results : sequence of tuple of int
            Shapes.
        """
        inputs, outputs = [_reader(shape) for shape in arguments], [_reader(shape or (1,)) for shape in results]

        def call(*addresses: int) -> None:
            places: list[Any] = []
            try:
                places = [read(at) for read, at in zip(outputs, addresses[len(inputs) :], strict=True)]
                if self._error is None:
                    values = function(*(read(at) for read, at in zip(inputs, addresses, strict=False)))
                    for place, value in zip(places, values if len(places) > 1 else (values,), strict=True):
                        place[...] = value
                    return
            except BaseException as error:
                self._error = error
            for place in places:
                place[...] = np.nan

        pointer = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * (len(inputs) + len(outputs)))(call)
        self._alive.append(pointer)
        return ctypes.cast(pointer, ctypes.c_void_p).value or 0


def addresses(problem: Problem, callbacks: Callbacks) -> dict[str, int]:
    """Return the functions of a loop by address field of mv_model, native/single/single.h."""
    manifest, law = problem.model.manifest, problem.controller
    if problem.continuous_own:
        calls = loop_calls(manifest, law, problem.suffix, True)
        calls = {name: function for name, function in calls.items() if name in _OF_PLANT}
    else:
        calls = loop_calls(manifest, law, problem.suffix, problem.hold_every is not None, problem.method)
    fields = model_fields(calls, manifest, law)
    result = {field: _address(problem, field, function, callbacks) for field, function in fields.items()}
    return result | (_own_addresses(problem, callbacks) if problem.continuous_own else {})


def _address(problem: Problem, field: str, function: Function, callbacks: Callbacks) -> int:
    evaluator = problem.model.evaluator
    if isinstance(evaluator, CBackend):
        return evaluator.address(function.name, problem.options.real if field in _LAWS else "double")
    arguments = [argument.shape for argument in function.arguments]
    return callbacks.address(evaluator.raw(function.name), arguments, function.shapes)


def _own_addresses(problem: Problem, callbacks: Callbacks) -> dict[str, int]:
    """Return the functions of a loop under a continuous Python law; time is appended to the reference."""
    loop, manifest = _OwnLoop(problem), problem.model.manifest
    p, c, s = (vector.shape for vector in (problem.parameters.p, problem.parameters.c, problem.parameters.s))
    x, u, r = ((len(group),) for group in (manifest.states, manifest.inputs, (*manifest.references, "t")))
    observed, observe = (x, u, u) if loop.acts else (x, u), "observe_command" if loop.acts else "observe"
    functions: dict[str, tuple[Callable[..., Any], Sequence[Shape], Sequence[Shape]]] = {
        "reference": (loop.reference, ((), p, s), (r,)),
        "loop": (loop.slope, (x, r, p, c), (x,)),
        observe: (loop.observed, (x, r, p, c), observed),
        "loop_jac_r": (loop.jacobians, (x, r, p, c), ((*x, *x), (*x, *r))),
    }
    if problem.events:
        functions["loop_guards"] = (loop.guards, (x, r, p, c), ((len(problem.events),),))
    return {field: callbacks.address(*function) for field, function in functions.items()}


class _OwnLoop:
    """Loop under a continuous Python law, in functions of state and reference."""

    def __init__(self, problem: Problem) -> None:
        assert problem.own is not None
        functions = problem.model.functions
        self._rhs, self._reference = functions[f"rhs{problem.suffix}"], functions["reference"]
        self._actuate = functions.get("actuate")
        self._guards = functions["guards"] if problem.events else None
        self._command, self._memory = problem.own.command, np.empty(0)

    @property
    def acts(self) -> bool:
        """True if an actuator lies between command and input."""
        return self._actuate is not None

    def reference(self, t: float, p: FloatArray, s: FloatArray) -> FloatArray:
        return np.append(self._reference(t, p, s), t)

    def observed(self, x: FloatArray, r: FloatArray, p: FloatArray, _c: FloatArray) -> tuple[FloatArray, ...]:
        command, _ = self._command(float(r[-1]), x, r[:-1], self._memory)
        return (x, command) if self._actuate is None else (x, self._actuate(x, command, p), command)

    def slope(self, x: FloatArray, r: FloatArray, p: FloatArray, c: FloatArray) -> FloatArray:
        return np.asarray(self._rhs(x, self.observed(x, r, p, c)[1], p))

    def guards(self, x: FloatArray, r: FloatArray, p: FloatArray, c: FloatArray) -> FloatArray:
        assert self._guards is not None
        return np.asarray(self._guards(x, self.observed(x, r, p, c)[1], p))

    def jacobians(self, x: FloatArray, r: FloatArray, p: FloatArray, c: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the derivatives of the slope with respect to state and reference, from forward differences."""
        from scipy.optimize import approx_fprime

        def steps(at: FloatArray) -> FloatArray:
            return _DIFFERENCE * np.maximum(np.abs(at), 1.0)

        by_state = approx_fprime(x, lambda y: self.slope(y, r, p, c), steps(x))
        return by_state, approx_fprime(r, lambda y: self.slope(x, y, p, c), steps(r))


def _reader(shape: Shape) -> Callable[[int], Any]:
    """Return a reader of arrays of a shape at an address, which for the shape () reads numbers."""
    size = int(np.prod(shape))
    if not size:
        return lambda _: np.empty(shape)
    kind = ctypes.c_double * size
    if not shape:
        return lambda at: np.frombuffer(memoryview(kind.from_address(at)))[0]
    return lambda at: np.frombuffer(memoryview(kind.from_address(at))).reshape(shape)
