# SPDX-License-Identifier: Apache-2.0
"""A closed-loop run of a model under a control law."""

from __future__ import annotations

import math
import os
import time
import warnings
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from numbers import Real
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from mehvar.base.errors import InputError, bad_value
from mehvar.base.manifest import Controller, Event, Manifest, Scenario, reads_memory
from mehvar.base.names import identifier

from ..arguments import check_arguments
from ..interrupts import KeptInterrupts
from ..model.functions import BackendName, FloatArray, check_manifold
from ..model.model import Model, shared_model
from ..model.parameters import Resolved, advice, all_parameters, elements, named_values, resolve, say
from . import loop
from .calls import events_of
from .options import AUTO, EXPLICIT, FIXED, OPTIONS, STIFF, Integrator, RunOptions, merged, read_options
from .problem import Problem, Progress, Status, Trajectory, problem_of, start_memory, variant_suffix
from .readers import check_read
from .user.choice import law_of
from .user.law import Law, LawFunction, PythonLaw

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True, kw_only=True)
class Run(Trajectory):
    """A closed-loop run: one row per sample, columns in the manifest's order.

    Attributes
    ----------
    manifest, controller, scenario, backend
        Model, law and scenario of the run, and "c", "python" or "casadi".
    t : array, (n,)
        Sample instants in seconds.
    x, y : array, (n, nx) and (n, ny)
        States and outputs.
    u : array, (n, nu)
        The applied input over [t_k, t_k+1); u(t_k) for a continuous loop.
    u_cmd : array, (n, nu)
        The commanded input; differs from u with a delay.
    z : array, (n, nz)
        The law's memory at t_k, before its evaluation; a continuous law's own states.
    w : array, (n, nw)
        Reports of the law.
    status : Status
        End of the run.
    reason : str
        Reason for the end in words.
    t_stop : float
        Last instant reached, s.
    x_stop : array, (nx,)
        The state there.
    violated : int
        Index of the limit that ended the run, -1 for none.
    error : float
        Largest estimated error of a step over its tolerance.
    hold : float or None
        Hold time of a sampled law in seconds; None for a continuous loop.
    parameters : Resolved
        Effective parameters with their origins.
    advice : tuple of str
        Warnings of the law about accepted but unwise parameters.
    options : mapping
        Effective method, tolerances, sampling.
    changed : mapping
        Changes of the scenario: choices, parameters, options, initial states, inputs.
    events, crossings : tuple of (float, str or int)
        Instant of each event in seconds, and its name, or its number among `possible_events`.
    method : str
        The integrator; for `method="auto"`, the one finally used.
    t_stiff : float
        Instant at which `method="auto"` found the run stiff and restarted it, s; NaN otherwise.
    statistics : mapping
        Steps, rejected steps, and evaluations of the right-hand side.
    compile_seconds, run_seconds : float
        Time to compile or load the code, and to integrate.
    """

    manifest: Manifest
    controller: Controller
    scenario: Scenario
    backend: BackendName
    w: FloatArray
    reason: str
    hold: float | None
    parameters: Resolved
    advice: tuple[str, ...]
    options: Mapping[str, float | str]
    changed: Mapping[str, float | str]
    events: tuple[tuple[float, str], ...]
    method: Integrator
    compile_seconds: float
    run_seconds: float

    def variables(self) -> dict[str, FloatArray]:
        """Return all series by their names in a result file."""
        manifest = self.manifest
        columns = {q.name: self.x[:, i] for i, q in enumerate(manifest.states)}
        columns |= {f"u_{q.name}": self.u[:, i] for i, q in enumerate(manifest.inputs)}
        if self.hold is not None or "actuate" in manifest.functions:
            columns |= {f"u_cmd_{q.name}": self.u_cmd[:, i] for i, q in enumerate(manifest.inputs)}
        columns |= {q.name: self.y[:, i] for i, q in enumerate(manifest.outputs)}
        columns |= {q.name: self.z[:, i] for i, q in enumerate(self.controller.memory)}
        columns |= {q.name: self.w[:, i] for i, q in enumerate(self.controller.outputs)}
        return columns

    @property
    def possible_events(self) -> tuple[Event, ...]:
        """Events of the loop."""
        return events_of(self.manifest, self.controller, self.hold is not None)

    @property
    def checksum(self) -> str:
        """CRC-32 of all numbers of the run: t, x, u, u_cmd, y, z in turn, as little-endian doubles.

        Runs with equal checksums are bit-identical, with a probability of error of 2^-32. All NaN count as equal.
        """
        total = 0
        for series in (self.t, self.x, self.u, self.u_cmd, self.y, self.z):
            total = zlib.crc32(np.where(np.isnan(series), np.nan, series).astype("<f8").tobytes(), total)
        return f"{total:08x}"

    def stiffness(self) -> list[str]:
        """Return a sentence with the time at which `method="auto"` found the run stiff."""
        if math.isnan(self.t_stiff):
            return []
        return [f"{EXPLICIT} found the run stiff at t = {self.t_stiff:.6g} s: repeated from the start by {self.method}"]

    def exceeded(self) -> list[str]:
        """Return the time, duration and size of each excess of a law's report over its bound."""
        texts = []
        for report, series in zip(self.controller.outputs, self.w.T, strict=True):
            for word, bound, sign in (("above", report.at_most, 1), ("below", report.at_least, -1)):
                beyond = np.flatnonzero(sign * series > sign * bound)
                if beyond.size:
                    worst = beyond[np.argmax(sign * series[beyond])]
                    texts.append(
                        f"{report.description} is {word} {bound:g} {report.unit} at {beyond.size} of {len(self.t)} "
                        f"samples from t = {self.t[beyond[0]]:.6g} s to {self.t[beyond[-1]]:.6g} s, "
                        f"most at t = {self.t[worst]:.6g} s: {series[worst]:.6g} {report.unit}"
                    )
        return texts


def simulate(
    model: Model | str | os.PathLike[str],
    controller: str | LawFunction | PythonLaw | None,
    scenario: str | None = None,
    parameters: Mapping[str, object] | None = None,
    initial: Mapping[str, object] | None = None,
    *,
    inputs: Mapping[str, object] | xarray.Dataset | None = None,
    interpolation: str | None = None,
    period: float | None = None,
    memory: ArrayLike | None = None,
    progress: Progress | None = None,
    law: Law | None = None,
    origin: str = "the call",
    **settings: object,
) -> Run:
    """Integrate a closed loop.

    Parameters
    ----------
    model : Model, str or path
        A loaded model, or an argument of `load`.
    controller : str or callable
        The control law: one of the model by name, or a function law(t, x) -> u, with a memory law(t, x, z) ->
        (u, z_next). None for an open loop.
    scenario : str, optional
        Default: the model's first scenario.
    parameters : mapping, optional
        Values of plant, law and scenario parameters by name.
    initial : mapping, optional
        Initial states that differ from the scenario's.
    inputs : mapping or xarray.Dataset, optional
        Without a controller: inputs by name, each a number, arrays (t, values) or a function of t; or the result of
        an earlier run.
    interpolation : {"hold", "linear"}, optional
        Meaning of arrays of inputs between their instants; default: "hold".
    period : float, optional
        Time between two evaluations of a function, s; default: continuous.
    memory : array_like, optional
        Memory of a function before its first sample.
    progress : callable, optional
        Called now and then with the time reached and the end time.
    law : callable, optional
        Evaluates a sampled law elsewhere, such as on a board: (x, r, v, z) -> (u, z_next) like the generated function,
        with the measured state and the input v applied over the last period. Needs the C backend.
    origin : str
        Origin of these arguments in error messages.
    **settings : float or str
        Options of the run, as in `t_end=5.0` (`RunOptions` has them all), choices of the model, as in
        `plant="reduced"`, and further parameters by name, as in `disturbance=0.001`.

    Returns
    -------
    Run
        The run, also if it ended early; see its status.

    Raises
    ------
    InputError
        If a name is unknown, a value is out of bounds, or a start is infeasible; the message names the value's origin.
    LawError
        If a function fails during the run or returns an invalid input; the message has the time.
    """
    check_arguments("text", "the call", origin=origin)
    check_arguments("text", origin, scenario=scenario)
    check_arguments("mapping", origin, parameters=parameters, initial=initial)
    check_arguments("function", origin, progress=progress, law=law)
    options, others = read_options(settings, "run", origin)
    loaded = model if isinstance(model, Model) else shared_model(model, options.backend)
    if options.backend not in (None, loaded.backend):
        raise bad_value("backend", options.backend, f"{loaded.backend!r}, as the model was loaded", origin)
    manifest = loaded.manifest
    case = manifest.scenario(scenario)
    end = options.t_end or case.duration
    controlled, own = law_of(manifest, controller, inputs, interpolation, period, memory, end, origin)
    if own is not None and options.hold is not None:
        raise bad_value(
            "hold", options.hold, "left out: hold applies to laws of the model; use period for other laws", origin
        )
    started = time.perf_counter()
    loaded.evaluator.prepare()
    compile_seconds = time.perf_counter() - started

    choices = {name: others.pop(name) for name in manifest.choices if name in others}
    suffix = variant_suffix(manifest, choices, origin)
    known = [q.name for q in all_parameters(manifest, controlled)]
    values = elements(merged(parameters or {}, others, origin), known, origin)
    given_values = dict(values)
    if controlled.delay:
        values.setdefault(controlled.delay, options.delay)
    names = (*OPTIONS, *manifest.choices)
    resolved = resolve(manifest, loaded.functions, controlled, case, values, origin, names)
    if controlled.delay and controlled.delay not in given_values and "delay" not in settings:
        resolved = replace(resolved, origins={**resolved.origins, controlled.delay: "default"})
    texts = advice(loaded.functions, controlled, resolved)
    for text in texts:
        warnings.warn(text, stacklevel=2)
    x0 = _start(loaded, case, resolved, initial or {}, origin)
    given = {name: value for name, value in settings.items() if name in OPTIONS}
    problem = problem_of(loaded, controlled, case, resolved, x0, options, given, suffix, progress, origin, own)
    check_read(manifest, controlled, suffix, problem.hold is not None, given_values, initial or {}, origin)
    if law is not None:
        problem = _with_callback(problem, law, origin)
    started = time.perf_counter()
    trajectory = _integrate(problem)
    run_seconds = time.perf_counter() - started
    return Run(
        manifest=manifest,
        controller=controlled,
        scenario=case,
        backend=problem.model.backend,
        **vars(trajectory),
        w=_reports(problem, trajectory),
        reason=_reason(problem, trajectory),
        hold=problem.hold,
        parameters=resolved,
        advice=texts,
        options=_effective(problem),
        changed={
            **{name: str(word) for name, word in choices.items() if word != manifest.choices[name].values[0]},
            **_changed_values(manifest, controlled, case, given_values, resolved),
            **_changed_options(case, options),
            **{name: float(x0[loaded.state_names.index(name)]) for name in initial or {}},
            **_named_inputs(loaded.input_names, inputs),
        },
        events=tuple((t, problem.events[k].name) for t, k in trajectory.crossings),
        method=problem.method if math.isnan(trajectory.t_stiff) else STIFF,
        compile_seconds=compile_seconds,
        run_seconds=run_seconds,
    )


def _reports(problem: Problem, trajectory: Trajectory) -> FloatArray:
    """Return the law's reports at each sample."""
    model, law, values = problem.model, problem.controller, problem.parameters
    if not law.outputs:
        return np.empty((len(trajectory.t), 0))
    r = model.functions["reference"](trajectory.t, values.p, values.s)
    outputs = model.functions[f"{identifier(law.name)}_outputs"]
    memory = (trajectory.z,) if reads_memory(outputs.function) else ()
    return np.asarray(outputs(trajectory.x, r, *memory, values.p, values.c), dtype=np.float64)


def _integrate(problem: Problem) -> Trajectory:
    """Integrate a loop; repeat a stiff one from the start with another method."""
    trajectory = _attempt(problem)
    if math.isnan(trajectory.t_stiff):
        return trajectory
    return replace(_attempt(replace(problem, method=STIFF, stiff_test=False)), t_stiff=trajectory.t_stiff)


def _attempt(problem: Problem) -> Trajectory:
    with KeptInterrupts() as kept:
        return loop.run(problem, kept.check)


def _with_callback(problem: Problem, law: Law, origin: str) -> Problem:
    """Return a problem whose law is a function in C or Python, called once per sample."""
    if problem.own is not None or problem.hold is None or problem.model.backend != "c":
        raise bad_value("law", law, "left out unless a sampled law runs on the C backend", origin)
    if problem.stiff_test:
        raise bad_value(
            "method", AUTO, "another method: auto may repeat the run, but this law is evaluated once per sample", origin
        )
    if (real := problem.options.real) != "double":
        raise bad_value("real", real, "left out with law: the given law determines its precision", origin)
    z0 = start_memory(problem.model, problem.controller, problem.parameters, problem.x0, getattr(law, "real", "double"))
    return replace(problem, law=law, z0=z0)


def _start(
    model: Model, scenario: Scenario, resolved: Resolved, initial: Mapping[str, object], origin: str
) -> FloatArray:
    """Return the initial state; refuse one that is not finite or violates a limit."""
    others = [q.name for q in model.manifest.scenario_parameters]
    values = named_values(model.state_names, f"state of {model.name} in initial", initial, origin, others)
    x0 = np.array(model.functions["initial"](resolved.p, resolved.s))
    for name, value in values.items():
        x0[model.state_names.index(name)] = value
    parameters = (*model.manifest.parameters, *model.manifest.scenario_parameters)
    read = {q.name for q in parameters if any(r == "limits" or r.startswith("initial") for r in q.readers)}
    given = ", ".join(
        [*values, *(name for name, place in resolved.origins.items() if place == origin and name in read)]
    )
    place = f"scenario {scenario.name}" + (f" with {given} from {origin}" if given else "")
    for name, value in zip(model.state_names, x0, strict=True):
        if not math.isfinite(value):
            raise bad_value(f"initial state {name}", float(value), "a finite number", place)
    check_manifold(model.manifest, model.functions, x0, resolved.p, f"the initial state (from {place})")
    if not model.manifest.limits:
        return x0
    margins = model.functions["limits"](x0, np.zeros(len(model.input_names)), resolved.p)
    for message, margin in zip(model.manifest.limits, margins, strict=True):
        if not margin > 0:
            text = say(message, {**resolved.values, **dict(zip(model.state_names, x0, strict=True))})
            raise InputError(f"the initial state (from {place}) is outside the limits: {text}")
    return x0


def _reason(problem: Problem, trajectory: Trajectory) -> str:
    """Return the reason for the end of a run in words."""
    model, at = problem.model, f"at t = {trajectory.t_stop:.6g} s"
    if trajectory.status is Status.DONE:
        return "end time reached"
    if trajectory.status is Status.LIMIT:
        last = dict(zip(model.state_names, trajectory.x_stop, strict=True))
        message = model.manifest.limits[trajectory.violated]
        return f"{say(message, {**problem.parameters.values, **last})} ({at})"
    if trajectory.status.by_event:
        return _ending(problem, trajectory, at)
    if trajectory.crossings and trajectory.status is Status.CHATTERING:
        name = problem.events[trajectory.crossings[-1][1]].name
        return f"the event {name} happens again and again without progress in time {at}"
    if trajectory.status is Status.NOT_FINITE:
        broken = np.flatnonzero(~np.isfinite(trajectory.u_cmd[-1]))
        name = model.input_names[broken[0]] if broken.size else ""
        what = f"the input {name} of {problem.controller.name}" if name else "the state derivative"
        return f"{what} is not finite {at}"
    if trajectory.status is Status.STEP_UNDERFLOW:
        return f"the tolerance needs a step below the resolution of time {at}"
    return f"more than {problem.options.max_steps} steps from one sample to the next {at}"


def _ending(problem: Problem, trajectory: Trajectory, at: str) -> str:
    """Return the event that ended a run in words."""
    last = [problem.events[k] for t, k in trajectory.crossings if t == trajectory.t_stop]
    ends = [event for event in last if event.ends]
    event = next((event for event in ends if event.ends == "failure"), ends[0])
    begins = trajectory.t_stop == problem.t[0]
    word = "failure" if trajectory.status is Status.FAILURE else event.ends
    how = "" if word == "run" else f" as a {word}"
    return f"the event {event.name} ends the run{how} {at}{': its guard is past zero at the start' if begins else ''}"


def _changed_values(
    manifest: Manifest, law: Controller, case: Scenario, given: Mapping[str, object], resolved: Resolved
) -> dict[str, float]:
    """Return the given parameters that differ from the scenario."""
    defaults = {q.name: q.default for q in all_parameters(manifest, law)}
    plain = {**defaults, **case.values, **case.controllers.get(law.name, {})}
    return {name: resolved.values[name] for name in given if resolved.values[name] != plain[name]}


def _changed_options(case: Scenario, options: RunOptions) -> dict[str, float | str]:
    """Return options that differ from defaults and scenario, except backend and step limit."""
    plain = {"t_end": case.duration, "dt_out": case.step}
    others = ("backend", "max_steps")
    return {name: v for name, v in options.changes().items() if name not in others and v != plain.get(name)}


def _named_inputs(names: Sequence[str], inputs: Mapping[str, object] | xarray.Dataset | None) -> dict[str, float | str]:
    """Return inputs for a title: numbers, else "given"."""
    if not inputs:
        return {}
    values = {name: inputs[name] for name in names if name in inputs}
    named = {f"u_{name}": float(v) if isinstance(v, Real) else "given" for name, v in values.items()}
    return named or {"inputs": "of a run"}


def _effective(problem: Problem) -> dict[str, float | str]:
    options: dict[str, float | str] = {"t_end": float(problem.t[-1]), "dt_out": problem.dt}
    if problem.hold is not None:
        options |= {"hold": problem.hold, "delay": problem.options.delay}
    options |= {"method": AUTO if problem.stiff_test else problem.method}
    if problem.method in FIXED:
        return options | {"step": problem.step}
    return options | {"rtol": problem.options.rtol, "atol": problem.options.atol}
