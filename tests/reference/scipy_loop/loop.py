# SPDX-License-Identifier: Apache-2.0
"""Closed loops by SciPy's integrators over the generated NumPy module.

The results agree with those of the native loop. A continuous loop with an adaptive method takes the integrator's
own steps and reads samples from its dense output; all other loops stop at every tick.
"""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from mehvar.base.names import identifier
from mehvar.runtime.model.functions import FloatArray, PythonBackend
from mehvar.runtime.run.calls import jacobian_name
from mehvar.runtime.run.options import FIXED, IMPLICIT, SMALLEST_RTOL
from mehvar.runtime.run.problem import Problem, Status, Trajectory

from .margins import Margins
from .noise import Draws, Stream
from .watch import Watch

_PROGRESS_SECONDS = 0.1
_DENSE = 0.01
"""Factor of the tolerances where samples come from the dense output, which is less accurate than the steps.

For a smooth closed loop at tolerance 1e-8 and a hundred samples a second, samples are off by 2e-9 with dop853 and 1e-8
with dopri5; without the factor by 1e-7 and 2e-6. Those of rodas5p are as accurate as its steps. The native loop, which
steps to every sample, is off by 4e-8. Half the factor takes 0.9 and 2.3 times the evaluations.
"""

_NEWTON_STEPS, _SETTLED = 10, 0.1
"""Newton steps and tolerance as in native/step/implicit.h."""

_Slope = Callable[[float, FloatArray], FloatArray]


class _EndOfRun(Exception):  # noqa: N818 - an early end is a result, not an error
    """The run ends early."""

    def __init__(
        self, status: Status, t: float, violated: int = -1, x: FloatArray | None = None, t_stiff: float = math.nan
    ) -> None:
        super().__init__(status.text)
        self.status, self.t, self.violated, self.x, self.t_stiff = status, t, violated, x, t_stiff


def run(problem: Problem, _: Callable[[], None]) -> Trajectory:
    """Integrate a closed loop."""
    backend = PythonBackend(problem.model.manifest)
    loop = _Loop(problem, backend)
    end = _EndOfRun(Status.DONE, float(problem.t[-1]))
    with np.errstate(all="ignore"):
        try:
            if problem.hold_every is not None:
                _run_sampled(loop)
            elif problem.method in FIXED or problem.own is not None or problem.events:
                _run_stopping(loop)
            else:
                _run_dense(loop)
        except _EndOfRun as early:
            end = early
    t, x, u, u_cmd, y, z = (np.stack(column) for column in zip(*loop.rows, strict=True))
    x_stop = x[-1] if end.x is None else end.x
    return Trajectory(
        t=t,
        x=x,
        u=u,
        u_cmd=u_cmd,
        y=y,
        z=z,
        status=end.status,
        violated=end.violated,
        t_stop=float(end.t),
        x_stop=x_stop,
        statistics=loop.statistics,
        t_stiff=end.t_stiff,
        crossings=tuple(loop.happened),
    )


class _Loop:
    """The generated functions with the parameters of one problem, and the rows recorded so far."""

    def __init__(self, problem: Problem, backend: PythonBackend) -> None:
        manifest, law = problem.model.manifest, identifier(problem.controller.name)
        raw, self.continuous, own = backend.raw, problem.hold_every is None, problem.own
        charted = self.continuous and own is None  # a law in Python returns the input in the chart of the state
        self.problem = problem
        self.rhs, self.outputs = raw(f"rhs{problem.suffix}"), raw("outputs")
        self.limits = raw("limits") if manifest.limits else None
        self.to_coordinates = raw("to_coordinates") if charted and "to_coordinates" in manifest.functions else _same
        self._own_states = len(problem.controller.memory) if charted else 0
        self.law = None if own else raw(law)
        self.actuate, self.measure, project = (
            raw(name) if name in manifest.functions else None for name in ("actuate", "measure", "project")
        )
        self._project = project if charted or "to_coordinates" not in manifest.functions else None
        self._of_manifold = (problem.parameters.p,) if manifest.projects_by_parameters else ()
        self.mass = raw("mass_diagonal")(problem.parameters.p) if manifest.algebraic else None
        self._loop = raw(f"{law}_loop{problem.suffix}") if charted else None
        self._observe = raw(f"{law}_observe") if charted else None
        self._jacobian = None
        if problem.method in IMPLICIT and not (self.continuous and own):
            self._jacobian = raw(jacobian_name(manifest, problem.controller, problem.suffix, not self.continuous))
        self.u = self.u_cmd = np.zeros(len(manifest.inputs))
        self.z = problem.z0
        self.rows: list[tuple[FloatArray, ...]] = []
        self.statistics = {"steps": 0, "evaluations": 0}
        self._reference = raw("reference")
        self._constant = self._reference_at(0.0) if manifest.reference_constant else None
        self._no_memory = np.empty(0)
        self._diffuse = raw("diffuse") if manifest.wiener else None
        self._jump = raw("jump") if manifest.random_step and not self.continuous else None
        self._wiener = Draws(problem.options.seed, problem.options.run, Stream.WIENER_PROCESSES, len(manifest.wiener))
        self._steps = Draws(problem.options.seed, problem.options.run, Stream.RANDOM_STEPS, len(manifest.random_step))
        self._diffused = 0
        self._reported = time.perf_counter()
        self.happened: list[tuple[float, int]] = []
        self._guards = raw(f"{law}_guards" if charted else "guards") if problem.events else None
        self._guards_of_loop = charted
        self._resets = raw("resets") if "resets" in manifest.functions else None
        self.watch = Watch(self.guards, problem.events, float(problem.t[-1])) if problem.events else None

    def guards(self, t: float, q: FloatArray) -> FloatArray:
        """Return the guards, whose zero crossings are events."""
        assert self._guards is not None
        if self._guards_of_loop:
            values = self._guards(q, self.reference(t), self.problem.parameters.p, self.problem.parameters.c)
        else:
            values = self._guards(q, self._input(t, q), self.problem.parameters.p)
        return np.asarray(values, dtype=np.float64)

    def _input(self, t: float, q: FloatArray) -> FloatArray:
        return self.observed(t, q)[1] if self.continuous else self.u

    def happen(self, t: float, q: FloatArray, fires: Sequence[int]) -> FloatArray:
        """Apply events; return the coordinates after them."""
        assert self.watch is not None
        before = q
        for event in fires:
            self.happened.append((float(t), event))
            if self.problem.events[event].resets:
                assert self._resets is not None
                q = np.asarray(
                    self._resets(q, self._input(t, q), self.problem.parameters.p, np.float64(event)), dtype=np.float64
                )
        past = self.watch.settle(t, before, q, fires)
        if not any(self.problem.events[event].ends for event in fires):
            self.happened += [(float(t), event) for event in past]
        if self.watch.stalled:
            raise _EndOfRun(Status.CHATTERING, t)
        return q

    def begin(self, t: float, q: FloatArray) -> None:
        """Evaluate the guards at the start of a step; end a run that has passed an event that ends it."""
        if self.watch is None:
            return
        begins = self.watch.begins
        past = self.watch.begin(t, q)
        if not self.watch.finite:
            raise _EndOfRun(Status.NOT_FINITE, t)
        self.happened += [(float(t), event) for event in past]
        self.end_at(t, q, begins)

    def end_at(self, t: float, q: FloatArray, begins: bool = False) -> None:
        """End the run at an event that ends it; record a sample unless there is one."""
        ends = {self.problem.events[event].ends for at, event in self.happened if at == t} - {""}
        if not ends:
            return
        if self.rows[-1][0] != t:
            held = (q, self.u, self.u_cmd, self.z)
            self._write(t, *((*self.observed(t, q), self.own_states(q)) if self.continuous else held))
        failed = "failure" in ends or (begins and "run" in ends)
        raise _EndOfRun(Status.FAILURE if failed else Status.EVENT, t)

    def diffused(self, q: FloatArray, slope: FloatArray, h: float) -> FloatArray:
        """Return the increment of process noise over a step from q, as in native/step/random.h."""
        change = np.zeros(len(q))
        if self._diffuse is None:
            return change
        n, p, root = len(self.problem.x0), self.problem.parameters.p, math.sqrt(h)
        dw = root * self._wiener(self._diffused)
        self._diffused += 1
        change[:n] = self._diffuse(q[:n], dw, p)
        for j, along in enumerate(np.eye(len(dw)) if self.problem.method == "platen" else ()):
            support = q[:n] + h * slope[:n] + self._diffuse(q[:n], root * along, p)
            pair = (dw[j] * dw - h * along) / 2
            change[:n] += (self._diffuse(support, pair, p) - self._diffuse(q[:n], pair, p)) / root
        return change

    def stepped(self, x: FloatArray, evaluation: int) -> FloatArray:
        """Return the state after the random step of a sample."""
        if self._jump is None:
            return x
        return np.asarray(self._jump(x, self._steps(evaluation), self.problem.parameters.p), dtype=np.float64)

    def reference(self, t: float) -> FloatArray:
        """Return r(t)."""
        return self._reference_at(t) if self._constant is None else self._constant

    def _reference_at(self, t: float) -> FloatArray:
        return np.asarray(
            self._reference(np.float64(t), self.problem.parameters.p, self.problem.parameters.s), dtype=np.float64
        )

    def closed(self, t: float, q: FloatArray) -> FloatArray:
        """Return q' of the continuous closed loop."""
        if self._loop is None:
            x, u, _ = self.observed(t, q)
            return np.asarray(self.rhs(x, u, self.problem.parameters.p), dtype=np.float64)
        slope: FloatArray = self._loop(q, self.reference(t), self.problem.parameters.p, self.problem.parameters.c)
        return slope

    def held(self, _t: float, x: FloatArray) -> FloatArray:
        """Return x' under the currently held input."""
        slope: FloatArray = self.rhs(x, self.u, self.problem.parameters.p)
        return slope

    @property
    def closed_jacobian(self) -> _Slope | None:
        """The Jacobian of `closed`; unknown for a loop with a law in Python."""
        if self._jacobian is None:
            return None
        function, problem = self._jacobian, self.problem

        def jacobian(t: float, q: FloatArray) -> FloatArray:
            result = function(q, self.reference(t), problem.parameters.p, problem.parameters.c)
            return np.asarray(result[0] if isinstance(result, tuple) else result, dtype=np.float64)

        return jacobian

    def held_jacobian(self, _t: float, x: FloatArray) -> FloatArray:
        """Return the Jacobian of `held`."""
        assert self._jacobian is not None
        return np.asarray(self._jacobian(x, self.u, self.problem.parameters.p), dtype=np.float64)

    def observed(self, t: float, q: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return state, input and commanded input of the continuous closed loop."""
        if self._observe is None:
            assert self.problem.own is not None
            command, _ = self.problem.own.command(float(t), q, self.reference(t), self._no_memory)
            return q, command if self.actuate is None else self.actuate(q, command, self.problem.parameters.p), command
        x, u, *command = self._observe(q, self.reference(t), self.problem.parameters.p, self.problem.parameters.c)
        return x, u, command[0] if command else u

    def projected(self, q: FloatArray) -> FloatArray:
        """Return coordinates projected onto their manifold."""
        if self._project is None:
            return q
        plant = self._project(q[: len(q) - self._own_states], *self._of_manifold)
        return np.concatenate((plant, self.own_states(q)))

    def own_states(self, q: FloatArray) -> FloatArray:
        """Return the memory of a continuous law, the last of the integrated coordinates."""
        return q[len(q) - self._own_states :]

    def start(self) -> FloatArray:
        """Return the integrated coordinates of a continuous loop at the start."""
        plant = np.asarray(self.to_coordinates(self.problem.x0), dtype=np.float64)
        return np.concatenate((plant, self.problem.z0[: self._own_states]))

    def record_continuous(self, tick: int, q: FloatArray) -> None:
        """Record a sample of a continuous loop."""
        self.record(tick, *self.observed(self.problem.t[tick], q), self.own_states(q))

    def record(
        self,
        tick: int,
        x: FloatArray,
        u: FloatArray,
        u_cmd: FloatArray,
        z: FloatArray | None = None,
        violated: int | None = None,
    ) -> None:
        """Record a sample if one is due; end a run that is not finite or violates a limit."""
        t = float(self.problem.t[tick])
        healthy = all(bool(np.all(np.isfinite(v))) for v in (x, u_cmd, u))
        last = tick + 1 == len(self.problem.t) or not healthy or violated is not None
        if tick % self.problem.record_every == 0 or last:
            self._write(t, x, u, u_cmd, self._no_memory if z is None else z)
        if not healthy:
            raise _EndOfRun(Status.NOT_FINITE, t)
        if violated is not None:
            raise _EndOfRun(Status.LIMIT, t, violated, x)
        if self.problem.progress and time.perf_counter() - self._reported > _PROGRESS_SECONDS:
            self._reported = time.perf_counter()
            self.problem.progress(t, float(self.problem.t[-1]))

    def _write(self, t: float, x: FloatArray, u: FloatArray, u_cmd: FloatArray, z: FloatArray) -> None:
        y = self.outputs(x, u, self.reference(t), self.problem.parameters.p)
        self.rows.append(tuple(np.array(v, dtype=np.float64) for v in (t, x, u, u_cmd, y, z)))

    def check(self, t: float, q: FloatArray) -> None:
        """End a continuous loop that violates a limit at a sample within a step."""
        if self.limits is None:
            return
        x, u, _ = self.observed(t, q)
        violated = self.violated(x, u)
        if violated is not None:
            raise _EndOfRun(Status.LIMIT, t, violated, x)

    def margins(self, t: float, q: FloatArray) -> FloatArray:
        """Return the margins, which stay positive along a run."""
        assert self.limits is not None
        of_state = not self.continuous or self.problem.model.manifest.limits_of_state
        x, u = (q[: len(self.problem.x0)], self.u_cmd) if of_state else self.observed(t, q)[:2]
        return np.asarray(self.limits(x, u, self.problem.parameters.p), dtype=np.float64)

    def end_beyond(self, limit: int, t: float, q: FloatArray) -> None:
        """End the run at a violated limit."""
        raise _EndOfRun(Status.LIMIT, t, limit, self.observed(t, q)[0] if self.continuous else q)

    def violated(self, x: FloatArray, u: FloatArray) -> int | None:
        """Return the first violated limit."""
        if self.limits is None:
            return None
        indices = np.flatnonzero(~(self.limits(x, u, self.problem.parameters.p) > 0))
        return int(indices[0]) if indices.size else None


def _same(x: FloatArray) -> FloatArray:
    return x


def _run_dense(loop: _Loop) -> None:
    """Run a continuous closed loop in the integrator's own steps."""
    t, solver = loop.problem.t, _Solver(loop, loop.closed, loop.closed_jacobian)
    q = loop.start()
    loop.record_continuous(0, q)
    tick, tighter = 1, 1.0 if loop.problem.method in IMPLICIT else _DENSE
    for step in solver.steps(t[0], q, t[-1], None, tighter):
        dense = step.dense_output()
        solver.project(step)
        while tick < len(t) and t[tick] <= step.t:
            at_tick = dense(t[tick]) if t[tick] < step.t else step.y
            loop.check(t[tick], at_tick)
            loop.record_continuous(tick, at_tick)
            solver.trials = 0
            tick += 1


def _run_stopping(loop: _Loop) -> None:
    """Run a continuous closed loop from tick to tick: in fixed steps, or where longer steps may miss something."""
    t, solver = loop.problem.t, _Solver(loop, loop.closed, loop.closed_jacobian)
    q = loop.start()
    for tick in range(len(t)):
        loop.record_continuous(tick, q)
        if tick + 1 < len(t):
            q = solver.advance(t[tick], q, t[tick + 1])


def _run_sampled(loop: _Loop) -> None:
    """Run a sampled law with a held and possibly delayed input."""
    problem, t = loop.problem, loop.problem.t
    assert problem.hold_every is not None
    x, z = problem.x0, problem.z0
    solver = _Solver(loop, loop.held, loop.held_jacobian)
    u = u_cmd = loop.u
    queue, sent = deque([u] * problem.options.delay), deque([u] * max(problem.input_delays, default=0))
    for tick in range(len(t)):
        memory = z
        if tick % problem.hold_every == 0:
            u_cmd, z = _command(loop, tick, x, u, z)
            queue.append(u_cmd)
            u = queue.popleft()
            if problem.input_delays:
                sent.append(u)
                u = np.array([sent[-1 - late][i] for i, late in enumerate(problem.input_delays)])
                sent.popleft()
            u = u if loop.actuate is None else loop.actuate(x, u, problem.parameters.p)
        loop.record(tick, x, u, u_cmd, memory, loop.violated(x, u_cmd))
        if tick + 1 < len(t):
            loop.u, loop.u_cmd, loop.z = u, u_cmd, z
            x = x if loop.mass is None else _settled(loop, x)
            x = solver.advance(t[tick], x, t[tick + 1])
            if (tick + 1) % problem.hold_every == 0:
                x = loop.stepped(x, (tick + 1) // problem.hold_every)


def _settled(loop: _Loop, x: FloatArray) -> FloatArray:
    """Return the state with algebraic states solved for the held input, as in native/step/implicit.h."""
    problem, moving = loop.problem, np.asarray(loop.mass) != 0
    for _ in range(_NEWTON_STEPS):
        slope = np.where(moving, 0.0, loop.held(0.0, x))
        matrix = np.where(moving[:, None], np.eye(len(x)), -loop.held_jacobian(0.0, x))
        try:
            change = np.linalg.solve(matrix, slope)
        except np.linalg.LinAlgError:
            return x
        x = x + change
        if not np.sqrt(np.mean((change / (problem.options.atol + problem.options.rtol * np.abs(x))) ** 2)) > _SETTLED:
            break
    return x


def _command(
    loop: _Loop, tick: int, x: FloatArray, applied: FloatArray, z: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the command of a sampled law at a tick, and its memory afterwards."""
    problem = loop.problem
    assert problem.hold_every is not None
    r = loop.reference(problem.t[tick])
    x_seen = (
        x if loop.measure is None else loop.measure(x, problem.noise[tick // problem.hold_every], problem.parameters.p)
    )
    if problem.law is not None:
        return problem.law(np.asarray(x_seen, dtype=np.float64), r, applied, z)
    assert loop.law is not None
    if not problem.controller.memory:
        return loop.law(x_seen, r, problem.parameters.p, problem.parameters.c), z
    u_cmd, z_next = loop.law(x_seen, r, applied, z, problem.parameters.p, problem.parameters.c)
    return u_cmd, z_next


@dataclass
class _Cut:
    """A step that ends at an event, with the interface of a SciPy solver; `y` is the state after the event."""

    t: float
    y: FloatArray
    h_abs: float
    dense: Callable[[float], FloatArray]
    fires: tuple[int, ...]
    f: FloatArray | None = None

    def dense_output(self) -> Callable[[float], FloatArray]:
        """Return the coordinates within the step."""
        return self.dense


class _Solver:
    """Steps of one method; the step size carries over from one interval to the next."""

    def __init__(self, loop: _Loop, slope: _Slope, jacobian: _Slope | None) -> None:
        from .solvers import StiffTest

        self.trials = 0
        self._loop = loop
        self._slope = slope
        self._jacobian = jacobian
        self._h: float | None = None
        self._stiff_test = StiffTest() if loop.problem.stiff_test else None
        self._last_finite = True
        problem = loop.problem
        self._margins = (
            Margins(
                loop.margins,
                slope,
                touches=not loop.continuous or problem.model.manifest.limits_of_state,
                fixed=problem.method in FIXED,
                end=float(problem.t[-1]),
            )
            if loop.limits
            else None
        )

    def advance(self, t: float, x: FloatArray, end: float) -> FloatArray:
        """Integrate to `end` exactly, and check the limits after every step."""
        self.trials = 0
        if self._loop.problem.method in FIXED:
            return self._advance_fixed(t, x, end)
        for step in self.steps(t, x, end, self._h):
            self._h, x = step.h_abs, self.project(step)
        return x

    def steps(self, t: float, x: FloatArray, end: float, h: float | None, tighter: float = 1.0) -> Any:
        """Yield SciPy's solver after every accepted step."""
        from scipy.integrate import DOP853, RK45

        from .solvers import Rock4, Rodas5P

        problem, statistics = self._loop.problem, self._loop.statistics
        self._loop.begin(t, x)
        if not np.all(np.isfinite(self._evaluate(t, x))):
            raise _EndOfRun(Status.NOT_FINITE, t)
        implicit = {"jac": self._jacobian, "mass": self._loop.mass} if problem.method in IMPLICIT else {}
        method = {"dop853": DOP853, "dopri5": RK45, "rock4": Rock4, "rodas5p": Rodas5P}[problem.method]
        first = None if h is None else min(h, end - t)
        rtol = max(problem.options.rtol * tighter, SMALLEST_RTOL)
        tolerances = {"rtol": rtol, "atol": problem.options.atol * tighter}
        solver = method(self._evaluate, t, x, end, **tolerances, first_step=first, **implicit)
        self._begin(t, x)
        while solver.status == "running":
            if self.trials == problem.options.max_steps:
                raise _EndOfRun(Status.TOO_MANY_STEPS, solver.t)
            self.trials += 1
            before = solver.t, solver.y.copy()
            solver.step()
            if solver.status == "failed":
                status = Status.STEP_UNDERFLOW if self._last_finite else Status.NOT_FINITE
                raise _EndOfRun(status, solver.t)
            shorter = self._shorter(*before, solver.t - before[0], self._loop.projected(solver.y))
            if shorter is not None:
                solver = method(self._evaluate, *before, end, **tolerances, first_step=shorter, **implicit)
                continue
            statistics["steps"] += 1
            if self._stiff_test and self._stiff_test.is_stiff_after(solver):
                raise _EndOfRun(Status.DONE, solver.t, t_stiff=float(solver.t))
            cut = self._cut(solver) if self._loop.watch else None
            yield solver if cut is None else cut
            if cut is None:
                self._end_beyond(solver.t, solver.y)
            else:
                self._loop.end_at(cut.t, cut.y)
                if end - cut.t <= 2 * np.spacing(end):
                    return
                solver = method(self._evaluate, cut.t, cut.y, end, **tolerances, **implicit)
                self._begin(cut.t, cut.y)

    def _begin(self, t: float, x: FloatArray) -> None:
        if self._margins:
            self._margins.begin(t, x)
            self._end_beyond(t, x)

    def _shorter(self, t: float, x: FloatArray, h: float, y: FloatArray) -> float | None:
        """Return the length at which to repeat a step that violates a limit; None to keep it."""
        return self._margins.shorter(t, x, h, y) if self._margins else None

    def _end_beyond(self, t: float, x: FloatArray) -> None:
        if self._margins and self._margins.broken is not None:
            self._loop.end_beyond(self._margins.broken, t, x)

    def _cut(self, solver: Any) -> _Cut | None:
        """Return the part of a step up to an event, after applying the event."""
        assert self._loop.watch is not None
        t, h, dense = solver.t_old, solver.t - solver.t_old, solver.dense_output()
        self._check_guards(solver.t, solver.y)

        def within(part: float) -> FloatArray:
            return np.asarray(dense(t + part * h) if part < 1 else solver.y, dtype=np.float64)

        crossing = self._loop.watch.crossing(t, h, within)
        if crossing is None:
            return None
        instant = min(crossing.t, float(solver.t))
        q = self._loop.projected(within(crossing.part))
        return _Cut(instant, self._loop.happen(instant, q, crossing.fires), h, dense, crossing.fires)

    def _check_guards(self, t: float, x: FloatArray) -> None:
        """End a run whose guard has no value at the end of a step."""
        if not np.all(np.isfinite(self._loop.guards(t, x))):
            raise _EndOfRun(Status.NOT_FINITE, t)

    def project(self, step: Any) -> FloatArray:
        """Project a SciPy solver's state and slope onto the manifold."""
        moved = self._loop.projected(step.y)
        if moved is not step.y:
            step.y, step.f = moved, self._evaluate(step.t, moved)
        return moved

    def _evaluate(self, t: float, x: FloatArray) -> FloatArray:
        self._loop.statistics["evaluations"] += 1
        slope = np.asarray(self._slope(t, x), dtype=np.float64)
        self._last_finite = bool(np.all(np.isfinite(slope)))
        return slope

    def _advance_fixed(self, t: float, x: FloatArray, end: float) -> FloatArray:
        pieces = float(end - t) / self._loop.problem.step * (1 - 1e-12)
        if pieces > self._loop.problem.options.max_steps:
            raise _EndOfRun(Status.TOO_MANY_STEPS, t)
        count = math.ceil(pieces)
        h = (end - t) / count
        self._begin(t, x)
        for i in range(count):
            now, before = t + i * h, x
            x = self._fixed_step(now, x, h) if self._loop.watch is None else self._past_events(now, x, h)
            self._loop.statistics["steps"] += 1
            self._shorter(now, before, h, x)
            self._end_beyond(now + h, x)
        return x

    def _fixed_step(self, t: float, x: FloatArray, h: float) -> FloatArray:
        y = self._rk4(t, x, h) if self._loop.problem.method == "rk4" else self._euler(t, x, h)
        if not np.all(np.isfinite(y)):
            raise _EndOfRun(Status.NOT_FINITE, t)
        return self._loop.projected(y)

    def _rk4(self, t: float, x: FloatArray, h: float) -> FloatArray:
        k1 = self._evaluate(t, x)
        k2 = self._evaluate(t + h / 2, x + h / 2 * k1)
        k3 = self._evaluate(t + h / 2, x + h / 2 * k2)
        k4 = self._evaluate(t + h, x + h * k3)
        return x + h * (k1 / 6 + k2 / 3 + k3 / 3 + k4 / 6)

    def _euler(self, t: float, x: FloatArray, h: float) -> FloatArray:
        slope = self._evaluate(t, x)
        return x + h * slope + self._loop.diffused(x, slope, h)

    def _past_events(self, t: float, x: FloatArray, h: float) -> FloatArray:
        """Take a fixed step, divided at each event in it."""
        watch, end = self._loop.watch, t + h
        assert watch is not None
        self._loop.begin(t, x)
        while end - t > 2 * np.spacing(end):
            begin, span, start = t, end - t, x

            def within(part: float, begin: float = begin, span: float = span, start: FloatArray = start) -> FloatArray:
                return self._fixed_step(begin, start, part * span) if part else start

            self._check_guards(end, within(1.0))
            crossing = watch.crossing(t, span, within)
            if crossing is None:
                return within(1.0)
            t = crossing.t
            x = self._loop.happen(t, within(crossing.part), crossing.fires)
            self._loop.end_at(t, x)
        return x
