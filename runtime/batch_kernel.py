# SPDX-License-Identifier: Apache-2.0
"""Many runs of one closed loop at once, summed up while they run."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from .backend import CBackend, FloatArray, Real
from .c_loop import run as run_alone
from .errors import bad_value
from .manifest import Controller, identifier
from .metrics import evaluate
from .model import Model
from .noise import normals
from .posing import SMALLEST_ATOL, SMALLEST_RTOL, check_law, checked_method, variant_suffix
from .problem import Method, Problem, Status
from .ticks import count, positive, ticks_of, tolerance

Profile = Literal["portable", "fast"]


@dataclass(frozen=True)
class Block:
    """What is kept of n runs, one row each.

    Attributes
    ----------
    final : array, (n, nx)
        State at `t_stop`.
    minimum, maximum : array, (n, variables)
        Of the recorded samples; NaN where one is NaN.
    metrics : array, (n, metrics)
        In the manifest's order.
    status : array of uint8, (n,)
        A `Status` each.
    violated : array of int32, (n,)
        Index of the limit that ended the run, or -1.
    t_stop : array, (n,)
        Last instant reached, s.
    error : array, (n,)
        Largest estimated error of an accepted step over its tolerance.
    steps : array of int64, (n,)
        Accepted steps.
    series : array, (n, samples, variables)
        Samples on the grid that was asked for, NaN after the run's end; no samples unless asked for.
    """

    final: FloatArray
    minimum: FloatArray
    maximum: FloatArray
    metrics: FloatArray
    status: NDArray[np.uint8]
    violated: NDArray[np.int32]
    t_stop: FloatArray
    error: FloatArray
    steps: NDArray[np.int64]
    series: FloatArray


def compile_kernel(
    model: Model,
    controller: str,
    choices: Mapping[str, object] | None = None,
    *,
    method: Method = "dop853",
    profile: Profile = "portable",
    lanes: int | None = None,
    real: Real = "double",
    hold: float | None = None,
    delay: int = 0,
    rtol: float = 1e-11,
    atol: float = 1e-11,
    step: float | None = None,
    max_steps: int = 100_000,
    origin: str = "the call",
) -> Kernel:
    """Compile, or load from the cache, the loop of a model under a law.

    Parameters
    ----------
    model : Model
        On the C backend.
    controller : str
        The control law.
    choices : mapping, optional
        Choices of the model, as in {"plant": "reduced"}.
    profile : {"portable", "fast"}
        Whether a run is the same bits on every machine, or may contract products and sums where the processor can.
    lanes : int, optional
        Runs worked on at once by one thread: 1, 2, 4 or 8; what the processor has registers for unless given.
    method, real, hold, delay, rtol, atol, step, max_steps
        As for `simulate`.
    origin : str
        How error messages call these arguments.

    Raises
    ------
    InputError
        For anything unknown or out of bounds.
    BuildError
        If compilation fails.
    """
    law = model.manifest.controller(controller)
    suffix = variant_suffix(model.manifest, choices or {}, origin)
    held = None if hold is None else positive("hold", hold, origin)
    delay = count("delay", delay, 0, origin)
    sampled = held is not None or law.period is not None
    check_law(model, law, 1.0 if sampled else None, delay, origin)
    if profile not in ("portable", "fast"):
        raise bad_value("profile", profile, "portable or fast", origin)
    return Kernel(
        model=model,
        controller=law,
        suffix=suffix,
        method=checked_method(method, origin),
        profile=profile,
        lanes=lanes or 1,
        real=real,
        hold=held,
        delay=delay,
        rtol=tolerance("rtol", rtol, SMALLEST_RTOL, origin),
        atol=tolerance("atol", atol, SMALLEST_ATOL, origin),
        step=None if step is None else positive("step", step, origin),
        max_steps=count("max_steps", max_steps, 1, origin),
        origin=origin,
    )


@dataclass(frozen=True)
class Kernel:
    """A compiled loop; `compile_kernel` makes it."""

    model: Model
    controller: Controller
    suffix: str
    method: Method
    profile: Profile
    lanes: int
    real: Real
    hold: float | None
    delay: int
    rtol: float
    atol: float
    step: float | None
    max_steps: int
    origin: str

    @property
    def variables(self) -> tuple[str, ...]:
        """Names of what is recorded, in the order of the columns: as in a result file."""
        manifest = self.model.manifest
        names = [q.name for q in manifest.states]
        names += [f"u_{q.name}" for q in manifest.inputs]
        if self.sampled or "actuate" in manifest.functions:
            names += [f"u_cmd_{q.name}" for q in manifest.inputs]
        return (*names, *(q.name for q in manifest.outputs), *(q.name for q in self.controller.memory))

    @property
    def sampled(self) -> bool:
        """Whether the law is evaluated at instants of its own and its input held in between."""
        return self.hold is not None or self.controller.period is not None

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
        """Integrate n runs.

        Parameters
        ----------
        first_run, seed : int
            Number of the first run, and the seed: what the noise depends on.
        p, c, s : array, (n, parameters)
            Parameters of plant, law and scenario. The law's period is the same in all runs.
        x0 : array, (n, nx)
            Initial states, finite and within the limits.
        t_end, dt : float
            End time and sampling step, s.
        save_every : float, optional
            Step of the series, a multiple of `dt`; none are kept unless given.
        threads : int
            How many to use.
        stop : callable, optional
            Asked now and then whether to give up.

        Returns
        -------
        Block, or None when told to stop
        """
        manifest = self.model.manifest
        n, names = len(p), list(manifest.metrics)
        period = self.controller.period
        hold = self.hold
        if hold is None and period is not None:
            hold = float(p[0, [q.name for q in manifest.parameters].index(period)])
        ticks, record_every, hold_every = ticks_of(t_end, dt, hold, self.origin)
        every = 1 if save_every is None else round(save_every / dt)
        rows = [] if save_every is None else range(0, int(t_end / dt * (1 + 1e-9)) + 1, every)
        width = len(self.variables)
        found = Block(
            final=np.empty((n, len(manifest.states))),
            minimum=np.empty((n, width)),
            maximum=np.empty((n, width)),
            metrics=np.empty((n, len(names))),
            status=np.zeros(n, np.uint8),
            violated=np.full(n, -1, np.int32),
            t_stop=np.empty(n),
            error=np.zeros(n),
            steps=np.zeros(n, np.int64),
            series=np.full((n, len(rows), width), np.nan),
        )
        evaluations = 0 if hold_every is None else (len(ticks) - 1) // hold_every + 1
        for i in range(n):
            if stop is not None and stop():
                return None
            z0 = np.empty(0)
            if self.controller.memory:
                r = self.model.functions["reference"](0.0, p[i], s[i])
                z0 = np.array(self.model.functions[f"{identifier(self.controller.name)}_start"](x0[i], r, p[i], c[i]))
            problem = Problem(
                model=self.model, controller=self.controller, p=p[i], c=c[i], s=s[i], x0=x0[i], z0=z0,
                noise=normals(seed, first_run + i, evaluations, len(manifest.noise)),
                suffix=self.suffix, real=self.real, t=ticks, dt=dt, hold=hold, record_every=record_every,
                hold_every=hold_every, delay=self.delay, method=self.method, rtol=self.rtol, atol=self.atol,
                step=self.step or min(dt, hold or dt), max_steps=self.max_steps, progress=None,
            )  # fmt: skip
            assert isinstance(self.model.evaluator, CBackend)
            one = run_alone(problem, self.model.evaluator)
            parts = [one.x, one.u, *([one.u_cmd] if self.sampled or "actuate" in manifest.functions else [])]
            series = np.concatenate([*parts, one.y, one.z], axis=1)
            columns = dict(zip(self.variables, series.T, strict=True))
            found.final[i] = one.x_stop
            found.minimum[i], found.maximum[i] = series.min(axis=0), series.max(axis=0)
            found.metrics[i] = [evaluate(m, one.t, columns) for m in manifest.metrics.values()]
            found.status[i], found.t_stop[i], found.steps[i] = one.status, one.t_stop, one.statistics["steps"]
            found.violated[i] = one.violated if one.status is Status.LIMIT else -1
            kept = [k for k in rows if k < len(series)]
            found.series[i, : len(kept)] = series[kept]
        return found
