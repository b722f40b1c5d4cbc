# SPDX-License-Identifier: Apache-2.0
"""Law as a Python function, with checks of its results."""

from __future__ import annotations

import json
import traceback
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mehvar.base.errors import InputError, MehvarError, bad_value, value_text
from mehvar.base.manifest import Controller, Manifest, Quantity

from ...interrupts import is_of_handler
from ...model.functions import FloatArray, unmasked
from ..ticks import common_step
from .identity import identify
from .state import state_type

_MEMORY = "\nmemory = "
"""Mark between source and initial memory in a law's identity."""

LawFunction = Callable[..., Any]
"""Python function of a law: law(t, x) -> u, or law(t, x, z) -> (u, z_next) with memory. u has the shape (nu,), in a
batch (nu, runs)."""

_READ_ONLY = "; x and z cannot be changed in place: return the input and, with a memory, the next one"
_BLOCK = "; in a batch x has a column for each run: numpy.where decides for each"

Law = Callable[[FloatArray, FloatArray, FloatArray, FloatArray], tuple[FloatArray, FloatArray]]
"""Function of a sampled law: measured state, reference, applied input, memory -> input, memory."""


class LawError(MehvarError, RuntimeError):
    """Error for a Python law that failed or returned an invalid input; the message has time, value and line."""

    exit_status = 3


@dataclass(frozen=True)
class PythonLaw:
    """A law evaluated in Python: a user's function, or inputs over time.

    Attributes
    ----------
    controller : Controller
        Description like that of a model's law, with a name that no law of a model can have.
    start : array, (nz,)
        Memory before the first sample.
    command : callable
        (t, x, r, z) -> (u, z_next), checked; each of shape (n,), or (n, runs) for many runs at once.
    period : float, optional
        Time for which an input is held, s; None for a continuous law, or if undecided.
    held : bool
        True if the input changes only at `instants` and can be held between them.
    instants : array, (n,)
        Instants of steps or kinks of inputs over time, s; integration stops at each.
    text : str
        Identity: its source and everything that it reads from outside.
    unidentified : str
        Reason why the law has no identity: the unidentifiable part.
    """

    controller: Controller
    start: FloatArray
    command: Callable[[float, FloatArray, FloatArray, FloatArray], tuple[FloatArray, FloatArray]]
    period: float | None = None
    held: bool = False
    instants: FloatArray = field(default_factory=lambda: np.empty(0))
    text: str = ""
    unidentified: str = ""

    def hold(self, dt: float, origin: str, actuators: float | None = None) -> tuple[float | None, float]:
        """Return the hold time of an input (None in a continuous loop), and the step at which the loop stops.

        Limits of actuators act at the samples of inputs: these come at least once in the actuators' period.

        Raises
        ------
        InputError
            If the instants of the inputs have no common grid.
        """
        step = self.period or common_step(dt, self.instants, origin)
        if actuators is not None and self.held and not self.period:
            try:
                step = common_step(step, np.array([actuators]), origin)
            except InputError as error:
                allowed = f"a multiple of a part of the actuators' period of {actuators:g} s, unless you give a period"
                raise bad_value("dt_out", dt, allowed, origin) from error
        return (step if self.period or self.held else None), step

    def among(self, runs: int, places: Sequence[int] | NDArray[np.intp]) -> PythonLaw:
        """Return a law for some runs of a block, with arguments as wide as those of the block and equal results.

        BLAS rounds a column by the width of its matrix, so that `K @ x` of one column alone may have other bits.

        Parameters
        ----------
        runs : int
            Number of runs in the block.
        places : sequence of int
            Column of each run in the block. Copies of the first run fill the others.
        """
        copied = np.zeros(runs, dtype=np.intp)
        copied[places] = np.arange(len(places))

        def command(t: float, x: FloatArray, r: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
            shape = x.shape[1:]
            wide = (np.take(a.reshape(len(a), len(places)), copied, axis=1) for a in (x, r, z))
            with np.errstate(all="ignore"):
                u, z_next = (a[:, places] for a in self.command(t, *wide))
            # a memory that is not finite ends its run, as an input does
            u = np.where(np.isfinite(z_next).all(axis=0), u, np.nan)
            return u.reshape(-1, *shape), z_next.reshape(-1, *shape)

        return replace(self, command=command)

    def at(self, instants: FloatArray) -> Law:
        """Return the law for a loop that evaluates it once per given instant, in order."""
        now = iter(instants.tolist())
        return lambda x, r, _v, z: self.command(next(now), x, r, z)


def describe(name: str, title: str, memory: Sequence[Quantity] = ()) -> Controller:
    """Return the description of an external law for results."""
    return Controller(
        name=name,
        title=title,
        memory=tuple(memory),
        period=None,
        parameters=(),
        constraints=(),
        warnings=(),
    )


def python_law(
    function: LawFunction, manifest: Manifest, period: float | None, memory: ArrayLike | None, origin: str
) -> PythonLaw:
    """Return a user's function as a law of a model.

    Parameters
    ----------
    function : callable
        See `LawFunction`.
    manifest : Manifest
        Manifest of the model.
    period : float, optional
        Time from one evaluation to the next, s; the law is continuous without it.
    memory : array_like, (nz,), optional
        The law's memory before the first sample.
    origin : str
        Origin of the arguments in error messages.

    Raises
    ------
    InputError
        For an invalid memory, or one without a period.
    """
    start = np.empty(0) if memory is None else _memory(memory, period, origin)
    name = getattr(function, "__name__", type(function).__name__).strip("<>")
    title = next(iter((getattr(function, "__doc__", None) or "").strip().splitlines()), f"{name}, in Python")
    quantities = [
        Quantity(f"memory_{i}", "1", f"element {i} of the memory of {name}") for i in range(1, len(start) + 1)
    ]
    caller = _Caller(function, name, manifest, None if memory is None else len(start))
    text, unidentified = identify(function)
    if text:
        text += f"{_MEMORY}{json.dumps(start.tolist())}"
    described = describe(f"python:{name}", title, quantities)
    return PythonLaw(described, start, caller, period, text=text, unidentified=unidentified)


def recorded_memory(text: str) -> list[float] | None:
    """Return the initial memory from a law's identity; None for a law without memory."""
    return json.loads(text.rpartition(_MEMORY)[2]) or None


def _memory(memory: ArrayLike, period: float | None, origin: str) -> FloatArray:
    """Return the memory at the start; refuse one of a continuous law."""
    if period is None:
        raise bad_value(
            "memory", memory, "left out unless the law has a period: a continuous law has no memory", origin
        )
    try:
        start = unmasked(memory)
    except (TypeError, ValueError):
        start = np.empty((), dtype=object)
    if start.dtype.kind not in "iuf" or start.ndim != 1 or not start.size or not np.isfinite(start).all():
        raise bad_value("memory", memory, "a list of finite numbers", origin)
    return start.astype(np.float64)


class _Caller:
    """Caller of a user's function that refuses invalid results."""

    def __init__(self, function: LawFunction, name: str, manifest: Manifest, memory: int | None) -> None:
        self._function, self._name, self._memory = function, name, memory
        self._inputs = [q.name for q in manifest.inputs]
        self._type = state_type(tuple(q.name for q in manifest.seen), tuple(q.name for q in manifest.references))

    def __call__(self, t: float, x: FloatArray, r: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        state = np.array(x).view(self._type)
        state.r, memory = np.array(r), np.array(z)
        for array in (state, state.r, memory):
            array.flags.writeable = False
        try:
            result = self._function(t, state) if self._memory is None else self._function(t, state, memory)
        except Exception as error:
            if is_of_handler(error):
                raise
            raise LawError(f"{self._at(t)} raised {_message(error, self._function)}") from error
        runs = x.shape[1:]
        if self._memory is None:
            return self._checked(t, "u", result, (len(self._inputs), *runs)), z
        if not isinstance(result, tuple) or len(result) != 2:
            raise LawError(
                f"{self._at(t)} returned {value_text(result)}: must be the pair (u, z_next), since the law has a memory"
            )
        u, z_next = result
        return (
            self._checked(t, "u", u, (len(self._inputs), *runs)),
            self._checked(t, "z_next", z_next, (self._memory, *runs)),
        )

    def _checked(self, t: float, what: str, value: object, shape: tuple[int, ...]) -> FloatArray:
        """Return what a law returned as numbers of a shape; refuse other shapes, and vectors that are not finite."""
        array = _numbers(value, shape)
        names = f", one for each of {', '.join(self._inputs) or 'no inputs'}" if what == "u" else ""
        if array is None:
            size = f" of shape {value.shape}" if isinstance(value, np.ndarray) else ""
            raise LawError(
                f"{self._at(t)} returned {what} = {value_text(value)}{size}: must be numbers of shape {shape}{names}"
            )
        if len(shape) == 1 and not np.isfinite(array).all():
            raise LawError(f"{self._at(t)} returned {what} = {value_text(value)}: must be finite numbers{names}")
        return array

    def _at(self, t: float) -> str:
        return f"the law {self._name} at t = {t:.6g} s"


def _numbers(value: object, shape: tuple[int, ...]) -> FloatArray | None:
    """Return numbers of shape (n,) or (n, runs), where one number may fill a row, and a single row needs no list."""
    n, runs = shape[0], shape[1:]
    try:
        listed = value if isinstance(value, list | tuple) else unmasked(value)
        alone = (isinstance(listed, np.ndarray) and listed.ndim == 0) or len(listed) != n
        arrays = [unmasked(row) for row in ([listed] if alone else listed)]
    except (ValueError, TypeError):
        return None
    if len(arrays) != n or any(a.dtype.kind not in "iuf" or a.shape not in ((), runs) for a in arrays):
        return None
    return np.array([np.broadcast_to(a, runs) for a in arrays], dtype=np.float64).reshape(shape)  # n may be 0


def _message(error: Exception, function: LawFunction) -> str:
    """Return a law's exception with its place in the law's code."""
    code = getattr(function, "__code__", None)
    frames = [
        f for f in traceback.extract_tb(error.__traceback__) if code is not None and f.filename == code.co_filename
    ]
    place = f" ({frames[-1].filename}, line {frames[-1].lineno})" if frames else ""
    text = " ".join(str(error).split())
    hint = _READ_ONLY if "read-only" in text else _BLOCK if "truth value of an array" in text else ""
    return f"{type(error).__name__}{f': {text}' if text else ''}{place}{hint}"
