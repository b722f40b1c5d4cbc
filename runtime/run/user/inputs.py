# SPDX-License-Identifier: Apache-2.0
"""Inputs over time without a law: numbers, arrays, functions of time, or the inputs of an earlier run."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, get_args

import numpy as np

from mehvar.base.errors import InputError, bad_value, either, unknown_name, value_text
from mehvar.base.manifest import OPEN_LOOP, Manifest
from mehvar.base.schema import parse

from ...arguments import check_arguments, check_units
from ...interrupts import is_of_handler
from ...model.functions import FloatArray, unmasked
from ...model.parameters import number
from ..ticks import MULTIPLE
from .identity import identify
from .law import LawError, PythonLaw, describe

if TYPE_CHECKING:
    import xarray

Interpolation = Literal["hold", "linear"]

_ALLOWED = "a number, a pair (t, values) of arrays of real numbers, or a function of t"


@dataclass(frozen=True)
class Signal:
    """One input over time.

    Attributes
    ----------
    value : callable
        The input at an instant.
    held : bool
        True if it changes only at `instants`.
    instants : array, (n,)
        Instants of steps or kinks, s.
    last : float
        End of the known input, s.
    text : str
        Identity of the input, if available.
    unidentified : str
        Reason why it has no identity.
    """

    value: Callable[[float], float]
    held: bool
    instants: FloatArray = field(default_factory=lambda: np.empty(0))
    last: float = np.inf
    text: str = ""
    unidentified: str = ""


def open_loop(
    inputs: Mapping[str, object] | xarray.Dataset,
    manifest: Manifest,
    period: float | None,
    interpolation: str | None,
    end: float,
    origin: str,
) -> PythonLaw:
    """Return inputs over time as a law that depends on time only.

    Parameters
    ----------
    inputs : mapping or xarray.Dataset
        Inputs by name: a number, arrays (t, values), or a function of t; others are zero. Or the result of an earlier
        run, whose commands are shifted by its delay.
    manifest : Manifest
        Manifest of the model.
    period : float, optional
        Time for which an input is held, s.
    interpolation : {"hold", "linear"}, optional
        Meaning of an array between its instants; default: "hold".
    end : float
        End of the run, s.
    origin : str
        Origin of the arguments in error messages.

    Raises
    ------
    InputError
        For an unknown input, or invalid values.
    """
    check_arguments("text", origin, interpolation=interpolation)
    if interpolation not in (None, *get_args(Interpolation)):
        raise bad_value("interpolation", interpolation, either(map(repr, get_args(Interpolation))), origin)
    linear = interpolation == "linear"
    if hasattr(inputs, "data_vars"):
        inputs, recorded = _recorded(inputs, manifest, end, origin)
        period = period if linear or period is not None else recorded
    check_arguments("mapping", origin, inputs=inputs)
    names = [q.name for q in manifest.inputs]
    for name in inputs:
        if name not in names:
            raise unknown_name(f"input of {manifest.model}", name, names, origin)
    signals = [_signal(f"inputs[{name!r}]", inputs.get(name, 0.0), linear, origin) for name in names]
    if interpolation is not None and not any(len(signal.instants) for signal in signals):
        raise bad_value("interpolation", interpolation, "left out unless an input is an array over time", origin)
    for name, signal in zip(names, signals, strict=True):
        if signal.last < end * (1 - MULTIPLE):
            allowed = f"known until the end of the run, {end:g} s; they end at {signal.last:g} s"
            raise InputError(f"inputs[{name!r}] (from {origin}): must be {allowed}")
    texts = [signal.text for signal in signals]
    return PythonLaw(
        controller=describe(OPEN_LOOP, "open loop"),
        start=np.empty(0),
        command=_Inputs(names, signals),
        period=period,
        held=all(signal.held for signal in signals),
        text="\n".join([f"linear = {linear}", *texts]) if all(texts) else "",
        unidentified=next((signal.unidentified for signal in signals if signal.unidentified), ""),
        instants=np.unique(np.concatenate([signal.instants for signal in signals] or [np.empty(0)])),
    )


class _Inputs:
    """All inputs at an instant, equal for all runs."""

    def __init__(self, names: Sequence[str], signals: Sequence[Signal]) -> None:
        self._names, self._signals = names, signals

    def __call__(self, t: float, x: FloatArray, _r: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        u = np.array([self._value(k, t) for k in range(len(self._signals))], dtype=np.float64)
        runs = x.shape[1:]
        return np.array(np.broadcast_to(u.reshape(-1, *(1 for _ in runs)), (len(u), *runs))), z

    def _value(self, k: int, t: float) -> float:
        """Return input k at t, s; an error in it names the input and the time."""
        where = f"inputs[{self._names[k]!r}] at t = {t:.6g} s"
        try:
            value = self._signals[k].value(t)
        except Exception as error:
            if is_of_handler(error):
                raise
            raise LawError(f"{where} raised {type(error).__name__}: {' '.join(str(error).split())}") from error
        try:
            return number(where, value)
        except InputError as error:
            raise LawError(f"{where} is {value_text(value)}: must be a finite number") from error


def _signal(name: str, value: object, linear: bool, origin: str) -> Signal:
    """Return an input over time from a number, a pair of arrays, or a function of time."""
    if callable(value):
        text, unidentified = identify(value)
        return Signal(value, held=False, text=text, unidentified=unidentified)
    if not isinstance(value, tuple | list):
        try:
            constant = number(name, value, origin)
        except InputError:
            raise bad_value(name, value, _ALLOWED, origin) from None
        return Signal(lambda _t: constant, held=True, text=repr(constant))
    t, values = _series(name, value, origin)
    text = hashlib.sha256(t.tobytes() + values.tobytes()).hexdigest()
    if linear:
        last = float(t[-1])
        return Signal(lambda now: float(np.interp(now, t, values)), held=False, instants=t, last=last, text=text)

    def held(now: float) -> float:
        """Return the value that starts at an instant, also if the instant is rounded below its stamp."""
        return float(values[np.searchsorted(t, now * (1 + MULTIPLE), side="right") - 1])

    return Signal(held, held=True, instants=t, text=text)


def _series(name: str, pair: Sequence[Any], origin: str) -> tuple[FloatArray, FloatArray]:
    """Return instants, s, and values of a pair; refuse those that do not increase from 0 or before."""
    try:
        t, values = (
            part.astype(np.float64, casting="unsafe" if part.dtype.kind == "O" else "same_kind")
            for part in map(unmasked, pair)
        )
    except (TypeError, ValueError):
        raise bad_value(name, pair, _ALLOWED, origin) from None
    if t.ndim != 1 or t.shape != values.shape or not t.size:
        raise bad_value(
            name, pair, f"a pair of arrays of one length, not of shapes {t.shape} and {values.shape}", origin
        )
    for what, array in (("instants", t), ("values", values)):
        if not np.isfinite(array).all():
            raise bad_value(f"{what} of {name}", float(array[~np.isfinite(array)][0]), "finite", origin)
    if (np.diff(t) <= 0).any():
        k = int(np.argmax(np.diff(t) <= 0))
        raise bad_value(f"instants of {name}", float(t[k + 1]), f"after {t[k]:g}: instants must increase", origin)
    if t[0] > 0:
        raise bad_value(
            f"instants of {name}", float(t[0]), "at most 0 for the first instant: the run begins at 0", origin
        )
    return t, values


def _recorded(
    run: Any, manifest: Manifest, end: float, origin: str
) -> tuple[dict[str, tuple[FloatArray, FloatArray]], float | None]:
    """Return the commands of an earlier run, and its hold time."""
    if "t" not in run.coords or run["t"].dims != ("t",) or "run" in run.dims:
        raise bad_value("inputs", "a dataset without time", "the result of one run", origin)
    check_units(run, {"t": "s"}, origin)
    t = _numbers(run, "t", origin)
    if not t.size:
        raise bad_value("inputs", "a dataset without samples", "the result of one run", origin)
    if t[0] != 0:
        raise bad_value("inputs", f"a run whose first sample is at {t[0]:g} s", "one from its start, 0 s", origin)
    if t[-1] < end * (1 - MULTIPLE):
        raise InputError(f"inputs (from {origin}): the given run ends at {t[-1]:g} s: set t_end to at most that")
    _check_inputs(run, manifest, origin)
    kinds = ("u_cmd_", "u_") if _replays_commands(run, manifest) else ("u_", "u_cmd_")
    columns = {}
    for q in manifest.inputs:
        name = next((name for kind in kinds if (name := f"{kind}{q.name}") in run), None)
        if name is None:
            raise InputError(
                f"the dataset of inputs (from {origin}) has no u_{q.name}: add this input of {manifest.model}, zero "
                "where it does not act, or give a controller"
            )
        check_units(run, {name: q.unit}, origin)
        columns[q.name] = _numbers(run, name, origin)
    hold, delay = _held(run, origin)
    shift = 0
    if hold is not None and len(t) > 1:
        samples = hold / t[1]
        if samples < 1 - MULTIPLE:
            allowed = f"with a sample at every change of its inputs: repeat the run with dt_out={hold:g}"
            raise bad_value("inputs", f"a run with samples every {t[1]:g} s", allowed, origin)
        shift = min(delay * round(samples), len(t))
    return {name: (t, np.append(np.zeros(shift), u[: len(u) - shift])) for name, u in columns.items()}, hold


def _check_inputs(run: Any, manifest: Manifest, origin: str) -> None:
    """Refuse inputs that the model lacks, unless they are from a run's result."""
    laws = manifest.controllers.values()
    groups = (manifest.states, manifest.outputs, *(group for law in laws for group in (law.memory, law.outputs)))
    inputs = [f"{kind}{q.name}" for q in manifest.inputs for kind in ("u_", "u_cmd_")]
    usual = {*inputs, *(q.name for group in groups for q in group)}
    for variable in map(str, run.data_vars):
        if variable.startswith("u_") and variable not in usual:
            raise unknown_name(f"input of {manifest.model}", variable, inputs, f"inputs, {origin}")


def _replays_commands(run: Any, manifest: Manifest) -> bool:
    """Return True if commands give the run again: its delay is known, or its plant has delays or an actuator."""
    return "options" in run.attrs or commands_act_later(manifest)


def commands_act_later(manifest: Manifest) -> bool:
    """Return True if a plant has delays or an actuator: its commands repeat a run, its inputs do not."""
    return bool(manifest.delays) or "actuate" in manifest.functions


def _numbers(run: Any, name: str, origin: str) -> FloatArray:
    """Return a series of a run."""
    try:
        return np.array(run[name], dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise bad_value("inputs", f"a dataset whose {name} is no series", "the result of one run", origin) from error


def _held(run: Any, origin: str) -> tuple[float | None, int]:
    """Return the hold time of a run's inputs, None if continuous, and its delay in hold times."""
    try:
        options = parse(str(run.attrs.get("options", "{}")))
        if options.get("hold") is None:
            return None, 0
        hold, delay = float(options["hold"]), int(options["delay"])
        if not 0 < hold < math.inf or delay < 0:
            raise ValueError(f"hold = {hold}, delay = {delay}")
    except (ValueError, TypeError, LookupError, AttributeError, OverflowError) as error:
        raise InputError(f"attribute 'options' of inputs (from {origin}) is damaged: {error}") from error
    return hold, delay
