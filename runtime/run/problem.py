# SPDX-License-Identifier: Apache-2.0
"""A closed loop as common input of all backends, its construction from arguments, and the trajectory."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from mehvar.base.errors import InputError, Origin, bad_value, unknown_name
from mehvar.base.manifest import Controller, Event, Manifest, Scenario
from mehvar.base.names import identifier

from ..model.functions import CBackend, FloatArray, Real
from ..model.model import Model
from ..model.parameters import Resolved
from .calls import check_loop, events_of, jacobian_name
from .noise import normals
from .options import (
    AUTO,
    OPTIONS,
    Integrator,
    RunOptions,
    check_effects,
    first_integrator,
)
from .ticks import ticks_of
from .user.law import Law, PythonLaw

Progress = Callable[[float, float], None]

_AT_SAMPLES = frozenset(("actuate", "jump", "measure"))
"""Plant functions that act once per sample."""
STAGES = 16  # the most that a method has, and the length of a row of its coefficients: MV_STAGES


class Status(IntEnum):
    """Kinds of ends of a run, numbered as in native/step/schedule.h; in a batch, 5 is an impossible run."""

    DONE = 0
    NOT_FINITE = 1
    STEP_UNDERFLOW = 2
    TOO_MANY_STEPS = 3
    LIMIT = 4
    EVENT = 6
    CHATTERING = 7
    FAILURE = 8

    @property
    def text(self) -> str:
        """The status in words."""
        return self.name.lower().replace("_", " ")

    @property
    def complete(self) -> bool:
        """True if the run reached its end: the end time, or an event that counts as a regular end."""
        return self in COMPLETE

    @property
    def by_event(self) -> bool:
        """True if an event ended the run."""
        return self in (Status.EVENT, Status.FAILURE)


COMPLETE = (Status.DONE, Status.EVENT)
"""Statuses of complete runs."""


@dataclass(frozen=True)
class Problem:
    """One closed loop.

    Parameters
    ----------
    parameters : Resolved
        Parameters of plant, law and scenario.
    options : RunOptions
        Seed, run number, tolerances, delay, number type of a sampled law and largest number of trial steps; the fields
        below replace what depends on the scenario or the law.
    x0, z0 : array
        Initial state, and the memory of the law before its first sample or at the start.
    noise : array, (n, ne)
        Independent standard normal numbers for each evaluation of a sampled law.
    suffix : str
        Suffix of the functions that only the chosen variant of the plant has.
    t : array
        Ticks in seconds, the first at 0 and the last at the end; integration stops at each of them exactly.
    dt, hold : float
        Sampling step of the result and hold time of the law, s; no hold time for a continuous closed loop.
    record_every : int
        Ticks from one recorded sample to the next; the last tick is recorded too.
    hold_every : int or None
        Number of ticks for which a sampled law's input is held; None for a continuous loop.
    input_delays : tuple of int
        Further samples until each input acts, for a plant with input delays.
    method : str
        One of `METHODS`.
    step : float
        Largest step of a method with a fixed step, s.
    progress : callable, optional
        Called now and then with the time reached and the end time.
    law : callable, optional
        Evaluates the sampled law in place of the generated function.
    own : OwnLaw, optional
        A law written in Python instead of a law of the model.
    """

    model: Model
    controller: Controller
    parameters: Resolved
    options: RunOptions
    x0: FloatArray
    z0: FloatArray
    noise: FloatArray
    suffix: str
    t: FloatArray
    dt: float
    hold: float | None
    record_every: int
    hold_every: int | None
    input_delays: tuple[int, ...]
    method: Integrator
    stiff_test: bool
    step: float
    progress: Progress | None
    law: Law | None = None
    own: PythonLaw | None = None

    @property
    def events(self) -> tuple[Event, ...]:
        """Events of the loop."""
        return events_of(self.model.manifest, self.controller, self.hold_every is not None)

    @property
    def continuous_own(self) -> bool:
        """True for a continuous Python law: every slope evaluates it."""
        return self.own is not None and self.hold_every is None

    @property
    def charted(self) -> bool:
        """True if regular coordinates are integrated.

        Under a Python law, which returns inputs of the state's chart, they are not.
        """
        return self.hold_every is None and self.own is None and "to_coordinates" in self.model.manifest.functions


@dataclass(frozen=True, kw_only=True)
class Trajectory:
    """Recorded samples, one per row, and the end of the run; `Run` describes the fields."""

    t: FloatArray
    x: FloatArray
    u: FloatArray
    u_cmd: FloatArray
    y: FloatArray
    z: FloatArray
    status: Status
    violated: int
    t_stop: float
    x_stop: FloatArray
    statistics: Mapping[str, int]
    error: float = math.nan
    t_stiff: float = math.nan
    crossings: tuple[tuple[float, int], ...] = ()


def problem_of(
    model: Model,
    law: Controller,
    scenario: Scenario,
    resolved: Resolved,
    x0: FloatArray,
    options: RunOptions,
    given: Mapping[str, object],
    suffix: str,
    progress: Progress | None,
    origin: str,
    own: PythonLaw | None = None,
) -> Problem:
    """Return the problem from options, scenario and parameters, or raise InputError.

    `given` has the user's options, each of which must have an effect; `own` is a Python law.
    """
    origin = of_scenario(options, scenario, origin)
    end = OPTIONS["t_end"].check(options.t_end or scenario.duration, origin)
    dt = OPTIONS["dt_out"].check(options.dt_out or scenario.step, origin)
    period = None if law.period is None else resolved.values[law.period]
    check_hold(options.hold, law, period, origin)
    hold = options.hold or period
    hold, step = (
        (hold, hold)
        if own is None
        else own.hold(dt, origin, actuator_period(model.manifest, resolved.values, scenario))
    )
    check_sampled_parts(model.manifest, resolved.values, hold, origin)
    check_effects(given, options.method, hold is not None, model.manifest.random(hold is not None), origin)
    check_loop(model.manifest, law, options.method, options.hold, hold is not None, origin)
    if options.real == "float" and (model.backend != "c" or own is not None):
        raise bad_value("real", options.real, "double unless the law runs on the C backend", origin)
    if options.method == AUTO and (own is None or hold is not None):
        jacobian_name(model.manifest, law, suffix, hold is not None, AUTO)
    if model.manifest.algebraic and hold is None:
        _check_consistent(model, law, resolved, x0, options, origin)
    if options.hold is None and law.period is not None:
        origin = Origin(origin, {"hold": f"{law.period} of {law.name}, {resolved.origins[law.period]}"})
    ticks, record_every, every = ticks_of(end, dt, step, origin)
    hold_every = None if hold is None else every
    check_delay(options.delay, len(ticks), hold_every, origin)
    delays = input_delays(model.manifest, resolved.p, len(ticks), hold_every, origin)
    return Problem(
        model=model,
        controller=law,
        parameters=resolved,
        options=options,
        x0=x0,
        z0=start_memory(model, law, resolved, x0, options.real) if own is None else own.start,
        noise=_noise(model, len(ticks), hold_every, options),
        suffix=suffix,
        t=ticks,
        dt=dt,
        hold=hold,
        record_every=record_every,
        hold_every=hold_every,
        input_delays=delays,
        method=first_integrator(options.method),
        stiff_test=options.method == AUTO,
        step=options.step or min(dt, hold or dt),
        progress=progress,
        law=None if own is None or hold_every is None else own.at(ticks[::hold_every]),
        own=own,
    )


def of_scenario(options: RunOptions, scenario: Scenario, origin: str) -> Origin:
    """Return the origin of options; the origin of missing values is the scenario."""
    return Origin(origin, {n: f"scenario {scenario.name}" for n in ("t_end", "dt_out") if getattr(options, n) is None})


def variant_suffix(manifest: Manifest, choices: Mapping[str, object], origin: str) -> str:
    """Return the suffix of a variant's function names."""
    for name, value in choices.items():
        if name not in manifest.choices:
            raise unknown_name(f"option or choice of {manifest.model}", name, (*OPTIONS, *manifest.choices), origin)
        words = manifest.choices[name].values
        if not isinstance(value, str) or value not in words:
            raise bad_value(name, value, " or ".join(map(repr, words)), origin)
    values = [
        str(choices[c.name]) for c in manifest.choices.values() if choices.get(c.name, c.values[0]) != c.values[0]
    ]
    suffix = "".join(f"_{value}" for value in values)
    if f"rhs{suffix}" not in manifest.functions:
        raise InputError(f"{manifest.model} has no variant for {' with '.join(values)} (from {origin})")
    return suffix


def check_delay(delay: int, ticks: int, hold_every: int | None, origin: str) -> None:
    """Refuse a delay as long as the run, after which no input acts."""
    periods = 0 if hold_every is None else -(-(ticks - 1) // hold_every)
    if delay and delay >= periods:
        raise bad_value("delay", delay, f"less than {periods}, the number of periods in this run", origin)


def check_hold(hold: float | None, law: Controller, period: float | None, origin: str) -> None:
    """Refuse a sampling period that differs from the law's."""
    if hold is not None and period is not None and hold != period:
        allowed = f"left out, or {period:g} s, the period of the law {law.name}: set {law.period} to sample otherwise"
        raise bad_value("hold", hold, allowed, origin)


def check_sampled_parts(manifest: Manifest, values: Mapping[str, float], hold: float | None, origin: str) -> None:
    """Refuse a sampling period that differs from the one that the plant's sensor or actuator uses."""
    if hold is None:
        return
    for name, at_samples in sampled_parameters(manifest).items():
        if not math.isclose(values[name], hold, rel_tol=1e-12):
            allowed = f"{hold:g} s, the period of the loop: {at_samples} of {manifest.model} compute with it"
            raise bad_value(name, values[name], allowed, f"{origin}, or the default")


def actuator_period(manifest: Manifest, values: Mapping[str, float], scenario: Scenario) -> float | None:
    """Return the period of actuators that compute at samples: that of the laws, or the scenario's step without laws."""
    periods = [values[law.period] for law in manifest.controllers.values() if law.period]
    return min(periods, default=scenario.step) if "actuate" in manifest.functions else None


def sampled_parameters(manifest: Manifest) -> dict[str, str]:
    """Return the parameters that are a law's period and that sensor or actuator use, with these users."""
    periods = {law.period for law in manifest.controllers.values()}
    readers = {q.name: sorted(_AT_SAMPLES.intersection(q.readers)) for q in manifest.parameters if q.name in periods}
    return {name: " and ".join(functions) for name, functions in readers.items() if functions}


def input_delays(manifest: Manifest, p: FloatArray, ticks: int, hold_every: int | None, origin: str) -> tuple[int, ...]:
    """Return the largest delay of each input for parameters p, shape (np,) or (n, np); an empty result without delays.

    Raises
    ------
    InputError
        For a delay after which an input never acts.
    """
    if not manifest.delays or hold_every is None:
        return ()
    names, rows = [q.name for q in manifest.parameters], np.atleast_2d(p)
    greatest = {name: int(rows[:, names.index(name)].max()) for name in manifest.delays.values()}
    periods = -(-(ticks - 1) // hold_every)
    for name, delay in greatest.items():
        if delay and delay >= periods:
            raise bad_value(name, delay, f"less than {periods}, the number of periods in this run", origin)
    return tuple(greatest[manifest.delays[q.name]] if q.name in manifest.delays else 0 for q in manifest.inputs)


def evaluations_of(ticks: int, hold_every: int | None) -> int:
    """Return the evaluations of a sampled law in a run with this number of ticks."""
    return 0 if hold_every is None else (ticks - 1) // hold_every + 1


def initial_corrections(
    model: Model, law: Controller, p: FloatArray, c: FloatArray, s: FloatArray, x0: FloatArray
) -> FloatArray:
    """Return Newton's correction of each algebraic state at the start, shape (..., states); zero elsewhere.

    Other states stay unchanged. The loop has a continuous law of the model.
    """
    functions, name = model.functions, identifier(law.name)
    r = functions["reference"](0.0, p, s)
    slopes = np.asarray(functions[f"{name}_loop"](x0, r, p, c))
    jacobians = functions[f"{name}_loop_jac"](x0, r, p, c)
    jacobians = np.asarray(jacobians[0] if isinstance(jacobians, tuple) else jacobians)
    kept = np.asarray(functions["mass_diagonal"](p)) * np.ones_like(slopes)
    n = slopes.shape[-1]
    matrices = np.where(kept[..., None] == 0, jacobians.reshape(*slopes.shape[:-1], n, n), np.eye(n))
    right = np.where(kept == 0, slopes, 0.0)
    try:
        corrections: FloatArray = np.linalg.solve(matrices, -right[..., None])[..., 0]
    except np.linalg.LinAlgError:
        return np.full_like(slopes, math.nan)
    return corrections


def is_consistent(corrections: FloatArray, x0: FloatArray, options: RunOptions) -> NDArray[np.bool_]:
    """Return True for each state that fulfils its initial equation within tolerance."""
    allowed: NDArray[np.bool_] = np.abs(corrections) <= options.atol + options.rtol * np.abs(x0)
    return allowed


def _check_consistent(
    model: Model, law: Controller, resolved: Resolved, x0: FloatArray, options: RunOptions, origin: str
) -> None:
    """Refuse algebraic states that violate their equations at the start."""
    if law.name not in model.manifest.controllers:
        return
    corrections = initial_corrections(model, law, resolved.p, resolved.c, resolved.s, x0)
    good = is_consistent(corrections, x0, options)
    if good.all():
        return
    start = _solved(model, law, resolved, x0, corrections, options)
    place = int(np.flatnonzero(~good)[0])
    allowed = "a solution of its algebraic equation; Newton's method found none from here"
    if start is not None:
        others = ", ".join(f"{model.state_names[k]} = {start[k]:.15g}" for k in np.flatnonzero(~good)[1:])
        beside = f", beside {others}" if others else ""
        allowed = f"about {start[place]:.15g}{beside}, the solution of its algebraic equation"
    raise bad_value(f"initial state {model.state_names[place]}", float(x0[place]), allowed, origin)


_NEWTON_STEPS = 50
"""Number of Newton steps from a distant start. At a double root each step gains one bit, elsewhere more, so that the
method converges within these steps or never. Half as many would miss double roots.
"""


def _solved(
    model: Model, law: Controller, resolved: Resolved, x0: FloatArray, corrections: FloatArray, options: RunOptions
) -> FloatArray | None:
    """Return the start with solved algebraic states; None without convergence."""
    x = x0
    with np.errstate(all="ignore"):
        for _ in range(_NEWTON_STEPS):
            x = x + corrections
            corrections = initial_corrections(model, law, resolved.p, resolved.c, resolved.s, x)
            if is_consistent(corrections, x, options).all():
                return x + corrections
    return None


def start_memory(model: Model, law: Controller, values: Resolved, x0: FloatArray, real: Real) -> FloatArray:
    """Return a law's initial memory, in float with the bits of a board."""
    if not law.memory:
        return np.empty(0)
    name, r = f"{identifier(law.name)}_start", model.functions["reference"](0.0, values.p, values.s)
    if real == "float" and isinstance(model.evaluator, CBackend):
        return np.asarray(model.evaluator.narrow(name, x0, r, values.p, values.c))
    return np.array(model.functions[name](x0, r, values.p, values.c))


def _noise(model: Model, ticks: int, hold_every: int | None, options: RunOptions) -> FloatArray:
    """Return standard normal numbers for each evaluation of a sampled law."""
    size = len(model.manifest.noise)
    return normals(options.seed, options.run, evaluations_of(ticks, hold_every), size)
