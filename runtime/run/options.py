# SPDX-License-Identifier: Apache-2.0
"""From what a caller asks of a closed loop to a checked problem: sampling, method, variant, noise."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields

import numpy as np

from mehvar.errors import InputError, bad_value

from ..model.functions import FloatArray, Real
from ..model.manifest import Controller, Manifest, Scenario, identifier
from ..model.model import Model
from ..model.parameters import Resolved
from .noise import normals
from .problem import METHODS, Method, Problem, Progress
from .ticks import count, positive, ticks_of, tolerance

SMALLEST_RTOL = 100 * float(np.finfo(np.float64).eps)
SMALLEST_ATOL = float(np.finfo(np.float64).tiny)


@dataclass(frozen=True)
class Asked:
    """How the caller wants a run integrated and sampled, unchecked."""

    t_end: float | None
    dt_out: float | None
    hold: float | None
    delay: int
    seed: int
    run: int
    real: Real
    method: Method
    rtol: float
    atol: float
    step: float | None
    max_steps: int


OPTIONS = tuple(field.name for field in fields(Asked))


def pose(
    model: Model,
    law: Controller,
    scenario: Scenario,
    resolved: Resolved,
    x0: FloatArray,
    asked: Asked,
    suffix: str,
    progress: Progress | None,
    origin: str,
) -> Problem:
    """Check how the run is to be integrated and sampled, and fill in what was not asked for."""
    end = positive("t_end", scenario.duration if asked.t_end is None else asked.t_end, origin)
    dt = positive("dt_out", scenario.step if asked.dt_out is None else asked.dt_out, origin)
    own = None if law.period is None else resolved.values[law.period]
    hold = own if asked.hold is None else positive("hold", asked.hold, origin)
    delay = count("delay", asked.delay, 0, origin)
    check_law(model, law, hold, delay, origin)
    ticks, record_every, hold_every = ticks_of(end, dt, hold, origin)
    return Problem(
        model=model,
        controller=law,
        p=resolved.p,
        c=resolved.c,
        s=resolved.s,
        x0=x0,
        z0=_memory(model, law, resolved, x0),
        noise=_noise(model, len(ticks), hold_every, asked, origin),
        suffix=suffix,
        real=_real(model, asked.real, hold, origin),
        t=ticks,
        dt=dt,
        hold=hold,
        record_every=record_every,
        hold_every=hold_every,
        delay=delay,
        method=checked_method(asked.method, origin),
        rtol=tolerance("rtol", asked.rtol, SMALLEST_RTOL, origin),
        atol=tolerance("atol", asked.atol, SMALLEST_ATOL, origin),
        step=positive("step", min(dt, hold or dt) if asked.step is None else asked.step, origin),
        max_steps=count("max_steps", asked.max_steps, 1, origin),
        progress=progress,
    )


def variant_suffix(manifest: Manifest, chosen: Mapping[str, object], origin: str) -> str:
    """Return what the names of the chosen variant's functions end with."""
    for name, value in chosen.items():
        allowed = manifest.choices[name].values
        if value not in allowed:
            raise bad_value(name, value, " or ".join(map(repr, allowed)), origin)
    values = [str(chosen[c.name]) for c in manifest.choices.values() if chosen.get(c.name, c.values[0]) != c.values[0]]
    suffix = "".join(f"_{value}" for value in values)
    if f"rhs{suffix}" not in manifest.functions:
        raise InputError(f"{manifest.model} has no variant for {' with '.join(values)} (from {origin})")
    return suffix


def _memory(model: Model, law: Controller, resolved: Resolved, x0: FloatArray) -> FloatArray:
    """Return a sampled law's memory before its first sample."""
    if not law.memory:
        return np.empty(0)
    r = model.functions["reference"](0.0, resolved.p, resolved.s)
    return np.array(model.functions[f"{identifier(law.name)}_start"](x0, r, resolved.p, resolved.c))


def _real(model: Model, real: Real, hold: float | None, origin: str) -> Real:
    if real not in ("double", "float"):
        raise bad_value("real", real, "double or float", origin)
    if real == "float" and (hold is None or model.backend != "c"):
        raise bad_value("real", real, "double unless a sampled law runs on the C backend", origin)
    return real


def _noise(model: Model, ticks: int, hold_every: int | None, asked: Asked, origin: str) -> FloatArray:
    """Return standard normal numbers for each evaluation of a sampled law."""
    evaluations = 0 if hold_every is None else (ticks - 1) // hold_every + 1
    seed, run = count("seed", asked.seed, 0, origin), count("run", asked.run, 0, origin)
    return normals(seed, run, evaluations, len(model.manifest.noise), native=model.backend == "c")


def check_law(model: Model, law: Controller, hold: float | None, delay: int, origin: str) -> None:
    """Refuse what a law cannot do: run without samples, or be delayed without them."""
    names = {identifier(name) for name in model.manifest.functions}
    if hold is None and f"{identifier(law.name)}_loop" not in names:
        raise InputError(f"{law.name} is a sampled law without a period of its own: set hold, in seconds")
    if hold is None and delay:
        raise bad_value("delay", delay, f"0 unless hold is set: {law.name} is continuous in time", origin)


def checked_method(method: str, origin: str) -> Method:
    """Return an integration method, or raise InputError."""
    if method not in METHODS:
        raise bad_value("method", method, "dop853, dopri5, rock4 or rk4", origin)
    return method
