# SPDX-License-Identifier: Apache-2.0
"""Inputs of least effort that bring a plant to a given state, computed with CasADi and Ipopt."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mehvar.api import simulate
from mehvar.base.errors import InputError, MehvarError, bad_value, unknown_name
from mehvar.runtime.arguments import check_arguments
from mehvar.runtime.model.model import Model, load
from mehvar.runtime.model.parameters import number_above
from mehvar.runtime.model.tools.replacement import library
from mehvar.runtime.run.options import OPTIONS, Option
from mehvar.runtime.run.problem import sampled_parameters

if TYPE_CHECKING:
    import xarray as xr

FloatArray = NDArray[np.float64]
_INTERVALS = Option("count", "Intervals with a constant input each", least=2, below=100_001, name="n")
_TURN = 0.5
"""Product of a fourth-order step and the largest eigenvalue at the start, with an error of about 1e-4 per radian of
that motion. Half the product doubles the time; `miss` shows if it is needed.
"""
_MOST = 64
"""Largest number of steps in an interval; a motion that needs more is too fast for its intervals."""


class SteeringError(MehvarError):
    """Error if no inputs to the final state were found."""

    exit_status = 3


@dataclass(frozen=True, eq=False)
class Steering:
    """Result of `steer`.

    Attributes
    ----------
    plan : xarray.Dataset
        Planned states and inputs `u_NAME` over `t`; `mehvar.simulate` takes it as `inputs`.
    effort : float
        Integral of the squared inputs, each over its limit or 1, in s.
    miss : mapping of str to float
        Final state of the run minus the desired one, the error of the plan's integration.
    iterations : int
        Number of Ipopt's iterations.
    run : xarray.Dataset
        The plant under the planned inputs, without a law.
    gains : array
        Gains of the regulator about the plan, shape (n, nu, nx).
    period : float
        Length of an interval, s.
    """

    plan: xr.Dataset
    effort: float
    miss: Mapping[str, float]
    iterations: int
    run: xr.Dataset
    gains: FloatArray
    period: float
    _limits: FloatArray
    _names: tuple[tuple[str, ...], tuple[str, ...]]

    @property
    def law(self) -> Callable[[float, Any], FloatArray]:
        """Python law that follows the plan with a linear regulator, sampled at `period`."""
        states, inputs = self._names
        x = np.stack([self.plan[name].values for name in states])
        u = np.stack([self.plan[f"u_{name}"].values for name in inputs])
        gains, limits, period = self.gains, self._limits, self.period

        def follow(t: float, seen: FloatArray) -> FloatArray:
            k = min(round(t / period), len(gains) - 1)
            error = (x[:, k] - np.asarray(seen).T).T
            rows = (u[:, k] + (gains[k] @ error).T).T
            return np.asarray(np.clip(rows.T, -limits, limits).T)

        return follow


def steer(
    model: Model | str | os.PathLike[str],
    to: Mapping[str, float],
    t_end: float,
    *,
    n: int = 50,
    limits: Mapping[str, float] | None = None,
    scenario: str | None = None,
    parameters: Mapping[str, ArrayLike] | None = None,
    initial: Mapping[str, float] | None = None,
) -> Steering:
    """Find the inputs of least effort from the start of a scenario to a final state.

    Each input is constant over an interval (direct multiple shooting). Ipopt uses exact sparse derivatives of the
    generated right-hand side. It finds a local minimum near its first guess, a straight line.

    Parameters
    ----------
    model, scenario, parameters, initial
        As of `mehvar.simulate`: the start and the plant.
    to : mapping of str to float
        Final values of states by name; other states are free.
    t_end : float
        Duration, s.
    n : int
        Number of intervals.
    limits : mapping of str to float, optional
        Largest magnitude of inputs by name.

    Raises
    ------
    InputError
        If a name is unknown, the model is not smooth, or CasADi is missing.
    SteeringError
        If Ipopt finds no inputs.
    """
    check_arguments("mapping", "the call", to=to, limits=limits, parameters=parameters, initial=initial)
    loaded = model if isinstance(model, Model) else load(model)
    n, t_end = int(_INTERVALS.check(n, "the call")), float(OPTIONS["t_end"].check(t_end, "the call"))
    _check(loaded, to, limits or {})
    first: dict[str, Any] = {"t_end": t_end / n, "dt_out": t_end / n}
    if sampled_parameters(loaded.manifest):
        first = {"t_end": t_end}  # of whole periods
    start = simulate(loaded, None, scenario, parameters, initial, inputs={}, **first)
    step = _step(loaded, start, t_end, n)
    problem = _Problem(library("casadi", "casadi", "steer"), loaded, start, to, n, t_end, limits or {})
    states, inputs, iterations = problem.solve()
    plan = problem.plan(states, inputs)
    run = simulate(loaded, None, scenario, parameters, initial, inputs=plan, t_end=t_end, dt_out=step)
    if float(run["t"][-1]) < t_end * (1 - 1e-9):
        raise SteeringError(f"the planned inputs end the run of the plant early: {run.attrs['reason']}")
    return Steering(
        plan=plan,
        effort=float(np.sum((inputs / problem.scale[:, None]) ** 2) * t_end / n),
        miss={name: float(run[name][-1]) - float(value) for name, value in to.items()},
        iterations=iterations,
        run=run,
        gains=problem.gains(states, inputs),
        period=t_end / n,
        _limits=problem.limits,
        _names=(loaded.state_names, loaded.input_names),
    )


def _check(model: Model, to: Mapping[str, float], limits: Mapping[str, float]) -> None:
    """Refuse unknown names, values that are not numbers, and models with jumps or algebraic states."""
    manifest = model.manifest
    if not to:
        raise bad_value("to", dict(to), "at least one final value, by the name of its state", "the call")
    for field, given, names, least in (
        ("to", to, model.state_names, -math.inf),
        ("limits", limits, model.input_names, 0),
    ):
        for name, value in given.items():
            if name not in names:
                raise unknown_name("state" if field == "to" else "input", name, names, field)
            number_above(least, name, value, "a finite number" if field == "to" else "a number > 0", field)
    if manifest.algebraic or any(event.resets for event in manifest.events):
        what = "algebraic states" if manifest.algebraic else "events that reset it"
        raise InputError(
            f"{model.name} cannot be steered: it has {what}, and its rates must be a smooth function of its state"
        )


def _step(model: Model, start: xr.Dataset, t_end: float, n: int) -> float:
    """Return the hold time of planned inputs in a run: an interval, or the period of a sampled actuator."""
    values, length = json.loads(start.attrs["parameters"]), t_end / n
    for name in sampled_parameters(model.manifest):
        count = length / values[name]
        if not math.isclose(count, max(1, round(count)), rel_tol=1e-9):
            allowed = f"a number for which an interval, {length:g} s, is a multiple of {name} = {values[name]:g} s"
            raise bad_value("n", n, allowed, "the call")
        return float(values[name])
    return length


class _Problem:
    """Optimal control problem by multiple shooting over the intervals."""

    def __init__(
        self, casadi: ModuleType, model: Model, start: xr.Dataset, to: Mapping[str, float], n: int, t_end: float,
        limits: Mapping[str, float],
    ) -> None:  # fmt: skip
        self._casadi, self._model, self._n, self._step = casadi, model, n, t_end / n
        values = json.loads(start.attrs["parameters"])
        self._p = model.parameters(**{name: values[name] for name in model.parameter_names})
        self._x0 = np.array([float(start[name][0]) for name in model.state_names])
        self._to = {model.state_names.index(name): float(value) for name, value in to.items()}
        self.limits = np.array([float(limits.get(name, math.inf)) for name in model.input_names])
        self.scale = np.where(np.isfinite(self.limits), self.limits, 1.0)
        self._stages = self._steps()
        self._end = self._interval()

    def _steps(self) -> int:
        """Return the steps per interval needed for the fastest motion at the start."""
        slopes = self._model.jac_x(self._x0, np.zeros(len(self.limits)), self._p)
        fastest = float(np.abs(np.linalg.eigvals(slopes)).max())
        steps: int = max(1, math.ceil(self._step * fastest / _TURN))
        if steps > _MOST:
            least = math.ceil(self._n * steps / _MOST)
            raise bad_value("n", self._n, f"at least {least}: the fastest eigenvalue is {fastest:.3g} 1/s", "the call")
        return steps

    def _interval(self) -> Any:
        """Return the state after an interval, and its derivatives."""
        ca, h = self._casadi, self._step / self._stages
        x, u = ca.SX.sym("x", len(self._x0)), ca.SX.sym("u", len(self.limits))
        rhs, y = self._model.to_casadi("rhs"), x
        for _ in range(self._stages):
            k1 = rhs(y, u, self._p)
            k2 = rhs(y + h / 2 * k1, u, self._p)
            k3 = rhs(y + h / 2 * k2, u, self._p)
            y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + rhs(y + h * k3, u, self._p))
        self._slopes = ca.Function("slopes", [x, u], [ca.jacobian(y, x), ca.jacobian(y, u)])
        return ca.Function("interval", [x, u], [y])

    def solve(self) -> tuple[FloatArray, FloatArray, int]:
        """Return the states at interval ends, the inputs, and the number of iterations."""
        opti = self._casadi.Opti()
        x, u = opti.variable(len(self._x0), self._n + 1), opti.variable(len(self.limits), self._n)
        opti.minimize(self._casadi.sumsqr(u))
        opti.subject_to(x[:, 0] == self._x0)
        scale = self._casadi.repmat(self._casadi.DM(self.scale), 1, self._n)
        opti.subject_to(x[:, 1:] == self._end.map(self._n)(x[:, :-1], scale * u))
        for k, value in self._to.items():
            opti.subject_to(x[k, -1] == value)
        for row in np.flatnonzero(np.isfinite(self.limits)):
            opti.subject_to(opti.bounded(-1, u[int(row), :], 1))
        opti.set_initial(x, self._guess())
        opti.solver("ipopt", {"print_time": False}, {"print_level": 0, "sb": "yes"})
        try:
            solution = opti.solve()
        except RuntimeError as error:
            raise SteeringError(self._failure(opti.stats())) from error
        shape = len(self.limits), self._n
        inputs = np.asarray(solution.value(u), dtype=float).reshape(shape) * self.scale[:, None]
        return np.asarray(solution.value(x), dtype=float), inputs, int(solution.stats()["iter_count"])

    def _failure(self, stats: Mapping[str, Any]) -> str:
        ends = f"{stats['return_status']} after {stats['iter_count']} iterations"
        return (
            f"no inputs found to the final state in {self._step * self._n:g} s ({ends}): give more time or wider limits"
        )

    def _guess(self) -> FloatArray:
        last = self._x0.copy()
        for k, value in self._to.items():
            last[k] = value
        guess: FloatArray = np.linspace(self._x0, last, self._n + 1).T
        return guess

    def plan(self, states: FloatArray, inputs: FloatArray) -> xr.Dataset:
        """Return states and inputs as a dataset; the last input is repeated."""
        import xarray as xr

        model = self._model
        held = np.hstack([inputs, inputs[:, -1:]])
        rows = dict(zip(model.state_names, states, strict=True))
        rows |= {f"u_{name}": row for name, row in zip(model.input_names, held, strict=True)}
        t = self._step * np.arange(self._n + 1)
        return xr.Dataset({name: ("t", row) for name, row in rows.items()}, {"t": ("t", t, {"units": "s"})})

    def gains(self, states: FloatArray, inputs: FloatArray) -> FloatArray:
        """Return the gains of the linear regulator about the plan, by Riccati's recursion from its end.

        The weights are the travel of states with a final value and the limits of inputs; the end has the weight of
        all intervals.
        """
        weight = np.diag(self._weights(np.ptp(states, axis=1)))
        price, after = np.diag(1 / self.scale**2), self._n * weight
        gains = np.empty((self._n, len(inputs), len(states)))
        for k in reversed(range(self._n)):
            a, b = (np.asarray(slope, dtype=float) for slope in self._slopes(states[:, k], inputs[:, k]))
            gains[k] = np.linalg.solve(price + b.T @ after @ b, b.T @ after @ a)
            after = weight + a.T @ after @ (a - b @ gains[k])
            after = (after + after.T) / 2
        return gains

    def _weights(self, travel: FloatArray) -> FloatArray:
        """Return the weights of the states; a state that hardly moves gets a tenth of the others with its unit."""
        units = [q.unit for q in self._model.manifest.states]
        largest = np.array([travel[[unit == other for other in units]].max() for unit in units])
        scale = np.where(largest > 0, np.maximum(travel, 0.1 * largest), 1.0)
        weights: FloatArray = np.zeros(len(travel))
        for k in self._to:
            weights[k] = scale[k] ** -2
        return weights
