# SPDX-License-Identifier: Apache-2.0
"""Gradient-based minimisation of a mean cost over dispersed runs with common random numbers."""

from __future__ import annotations

import json
import math
import os
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from mehvar.api import stored_batch
from mehvar.base.errors import InputError, bad_value, unknown_name
from mehvar.runtime.arguments import check_arguments
from mehvar.runtime.batch.evaluation.conditions import Number
from mehvar.runtime.batch.evaluation.statistics import column, design_of, notes, scalars
from mehvar.runtime.batch.plan import CAMPAIGN_OPTIONS
from mehvar.runtime.batch.store.layout import STATUS
from mehvar.runtime.batch.store.store import Store
from mehvar.runtime.model.model import Model, load
from mehvar.runtime.model.parameters import all_parameters
from mehvar.runtime.run.problem import COMPLETE

from .fit import free_names

if TYPE_CHECKING:
    from scipy.optimize import OptimizeResult

FloatArray = NDArray[np.float64]
_STEP = 3e-6
"""Relative step of a difference. Common random numbers leave only the integration error, about 1e-11, so the square
root balances both errors."""
_CURVE = 1e-3
"""Relative step between gradients whose difference is a row of the Hessian matrix: the root of their error."""
_FEW = 16
"""Runs of the first search. Four gains then need 4000 runs instead of 14 000 for n = 256."""
_TOLERANCE = 1e-4
"""Possible decrease at which the second search stops, relative to the improvement by the first one: a hundredth of the
usual width of the interval."""
_WITHOUT_EFFECT = {"success", "until", "require", "confidence", "save", "out", "resume"}
"""Arguments of a batch that only affect what is stored or reported."""


@dataclass(frozen=True)
class Tuning:
    """Result of `tune`.

    Attributes
    ----------
    start, gains : mapping of str to float
        The free parameters before and after.
    cost : tuple of float
        Mean cost over the runs of the search, before and after.
    held_out : tuple of float
        Mean cost over runs of another seed, before and after.
    gain, low, high : float
        Mean reduction of this cost, and its 95 % interval by Student's distribution of the differences per run. With
        few runs the interval assumes normally distributed differences.
    runs : int
        Number of runs in the search.
    converged : bool
        False if the search ended before a minimum.
    bounded : tuple of str
        Gains that ended at a bound of their parameter.
    """

    start: Mapping[str, float]
    gains: Mapping[str, float]
    cost: tuple[float, float]
    held_out: tuple[float, float]
    gain: float
    low: float
    high: float
    runs: int
    converged: bool
    bounded: tuple[str, ...] = ()

    @property
    def answer(self) -> Literal["better", "worse", "undecided"]:
        """Verdict on the new gains from separate test runs."""
        return "better" if self.low > 0 else "worse" if self.high < 0 else "undecided"

    def __repr__(self) -> str:
        lines = [f"{name}: {self.start[name]:.6g} -> {value:.6g}" for name, value in self.gains.items()]
        lines.append(f"cost {self.cost[0]:.6g} -> {self.cost[1]:.6g} in {self.runs} runs")
        lines += [] if self.converged else ["the search ended before it was at a minimum"]
        lines += [f"{name} is at a bound" for name in self.bounded]
        lines.append(f"held-out runs: {self.answer}, {self.held_out[0]:.6g} -> {self.held_out[1]:.6g}, ")
        return "\n".join(lines)[:-2] + f", reduction {self.gain:.4g} [{self.low:.4g}, {self.high:.4g}]"


def tune(
    model: Model | str | os.PathLike[str],
    controller: str,
    free: Sequence[str],
    cost: str,
    *,
    vary: Mapping[str, str] | None = None,
    n: int = 256,
    seed: int = 0,
    parameters: Mapping[str, float] | None = None,
    **batch: Any,
) -> Tuning:
    """Search gains with a small mean cost over dispersed runs.

    All trials use the same random numbers, so the mean cost is smooth if the cost of each run is. SciPy's L-BFGS-B
    finds a local minimum near the start, of 16 runs if n is 64 or more. From there, SLSQP finds the minimum of all
    runs. Gains that must be positive are scaled logarithmically. Runs with another seed test if the new gains are
    better.

    Parameters
    ----------
    model, controller, vary, n, seed, parameters
        As of `mehvar.batch`; `vary` may be left out for a model with noise.
    free : sequence of str
        Parameters to tune. `parameters` gives the start, by default a formula or the scenario.
    cost : str
        A number of a run, as in conditions of success: "final(roll) * final(roll) + 100 * final(wx) * final(wx)".
        Units of weights are not checked. A cost with jumps, such as a settling time on a grid, has no gradient there.
    **batch
        Further arguments of `mehvar.batch` that affect a cost.

    Raises
    ------
    InputError
        If a name is unknown, or runs with the start values end early or have no cost.
    """
    check_arguments("mapping", "the call", vary=vary, parameters=parameters)
    check_arguments("text", "the call", controller=controller, cost=cost)
    free = free_names(free, "parameters")
    for name in _WITHOUT_EFFECT & batch.keys():
        raise bad_value(name, batch[name], "left out: it has no effect on the cost")
    CAMPAIGN_OPTIONS["seed"].check(seed, "the call")
    loaded = model if isinstance(model, Model) else load(model, "c")
    number = Number(cost, "cost")
    trials = 0

    def runs(gains: Mapping[str, float], first: int, n: int = n) -> Store:
        nonlocal trials
        values = {**(parameters or {}), **gains}
        store = stored_batch(loaded, controller=controller, n=n, vary=vary, seed=first, parameters=values, **batch)
        trials += store.n
        return store

    if listed := [name for name, values in (vary or {}).items() if not isinstance(values, str)]:
        raise bad_value(
            f"vary[{listed[0]!r}]", (vary or {})[listed[0]], "a distribution: listed values allow no verdict"
        )
    if not vary and not loaded.manifest.random(True):
        raise bad_value("vary", vary, "given: without dispersions or noise all runs are the same")
    store = runs({}, seed)
    if (design := design_of(store.attributes)) != "random":
        raise InputError(
            f"vary, sampling: a {design} design has dependent runs, which allow no verdict: use sampling = random"
        )
    number.check_names(scalars(store), notes(store))
    nominal = json.loads(store.attributes["nominal"])
    for name in free:
        if name not in nominal:
            raise unknown_name("parameter", name, nominal, "free")
        if name == loaded.manifest.controller(controller).period:
            raise bad_value("free", name, "other than the period of the law, which decides when it commands")
    start = np.array([float(nominal[name]) for name in free])
    before = _costs(store, number)
    if not np.isfinite(before).all():
        bad = int(np.argmax(~np.isfinite(before)))
        raise InputError(f"cost = {cost!r}: with the first gains, run {bad} ended early or lacks a number of the cost")
    unit = float(np.abs(before).mean()) or 1.0  # SciPy's tolerance of a gradient is absolute
    scale, low, high = _scales(loaded, controller, free, start)
    worst = 10 * float(np.abs(before).max()) + unit  # exceeds every cost that the search accepts

    def mean_cost(point: FloatArray, n: int) -> float:
        if not np.isfinite(scale.gains(point)).all():
            raise InputError(f"cost = {cost!r}: has no minimum: it falls until {', '.join(free)} are infinite")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # advice about gains that are only tried; the last runs give it
            costs = _costs(runs(dict(zip(free, map(float, scale.gains(point)), strict=True)), seed, n), number)
        return float(np.where(np.isfinite(costs), costs, worst).mean()) / unit

    from scipy.stats import t

    solution = _minimum(mean_cost, n, float(before.mean()) / unit, low, high)
    gains = dict(zip(free, map(float, scale.gains(solution.x)), strict=True))
    took = trials
    old, new = (_costs(runs(values, seed ^ 1), number) for values in ({}, gains))
    difference = old - new
    mean, half = float(difference.mean()), math.inf
    if len(difference) > 1:
        error = float(difference.std(ddof=1)) / math.sqrt(len(difference))
        half = float(t.ppf(0.975, len(difference) - 1)) * error
    return Tuning(
        dict(zip(free, map(float, start), strict=True)),
        gains,
        (float(before.mean()), float(solution.fun) * unit),
        (float(old.mean()), float(new.mean())),
        mean,
        mean - half,
        mean + half,
        took,
        bool(solution.success),
        tuple(
            name
            for name, x, *ends in zip(free, solution.x, low, high, strict=True)
            if np.isclose(x, ends, 0, _STEP).any()
        ),
    )


class _Cost:
    """Mean cost of the first n runs, with gradient and Hessian matrix by one-sided differences within bounds."""

    def __init__(self, mean: Callable[[FloatArray, int], float], n: int, low: FloatArray, high: FloatArray) -> None:
        self._mean, self._n, self.low, self.high = mean, n, low, high
        self._known: dict[bytes, float] = {}

    def __call__(self, point: FloatArray) -> float:
        if (key := point.tobytes()) not in self._known:
            self._known[key] = self._mean(point, self._n)
        return self._known[key]

    def gradient(self, point: FloatArray) -> FloatArray:
        return self._slopes(self, point, _STEP)

    def hessian(self, point: FloatArray) -> FloatArray:
        rows = self._slopes(self.gradient, point, _CURVE)
        return (rows + rows.T) / 2

    def _slopes(self, value: Callable[[FloatArray], Any], point: FloatArray, step: float) -> FloatArray:
        """Return the differences of a value, towards lower values at an upper bound."""
        steps = np.where(point + step <= self.high, step, -step)
        return np.array([(value(point + h) - value(point)) / h.sum() for h in np.diag(steps)])


def _minimum(
    mean: Callable[[FloatArray, int], float], n: int, first: float, low: FloatArray, high: FloatArray
) -> OptimizeResult:
    """Return the minimum of a mean cost, from the minimum for few runs if it is lower than the start.

    Parameters
    ----------
    mean : callable
        Cost at a point, a mean over the first runs, whose number is the second argument.
    n : int
        Number of all runs.
    first : float
        Cost of all runs at the start, which is the origin.
    low, high : array
        Bounds of the point.
    """
    from scipy.optimize import minimize

    start, bounds = np.zeros(len(low)), list(zip(low, high, strict=True))
    cost, few = _Cost(mean, n, low, high), _Cost(mean, _FEW, low, high)
    if n >= 4 * _FEW:
        near = minimize(few, start, jac=few.gradient, bounds=bounds, method="L-BFGS-B").x
        if cost(near) < first:
            return _newton(cost, near, few.hessian(near), _TOLERANCE * (first - cost(near)))
    return minimize(cost, start, jac=cost.gradient, bounds=bounds, method="L-BFGS-B")


def _newton(cost: _Cost, near: FloatArray, hessian: FloatArray, tolerance: float) -> OptimizeResult:
    """Return the minimum by SLSQP in coordinates in which a Hessian matrix is the identity, its own first estimate."""
    from scipy.optimize import LinearConstraint, minimize

    size, axes = np.linalg.eigh(hessian)
    size = np.maximum(np.abs(size), _CURVE * np.abs(size).max())
    basis = axes / np.sqrt(size)

    def point(y: FloatArray) -> FloatArray:
        inside: FloatArray = np.clip(near + basis @ y, cost.low, cost.high)  # rounding may step over a bound
        return inside

    within = np.isfinite(cost.low) | np.isfinite(cost.high)
    limits = LinearConstraint(basis[within], (cost.low - near)[within], (cost.high - near)[within])
    solution = minimize(
        lambda y: cost(point(y)),
        np.zeros(len(near)),
        jac=lambda y: basis.T @ cost.gradient(point(y)),
        method="SLSQP",
        constraints=[limits] if within.any() else [],
        options={"ftol": tolerance},
    )
    solution.x = point(solution.x)
    return solution


def _costs(store: Store, number: Number) -> FloatArray:
    """Return the cost of each run; infinite for a run that ended early or has no value."""
    costs = number(lambda name: column(store, name))
    return np.where(np.isin(store.read(STATUS), COMPLETE) & np.isfinite(costs), costs, math.inf)


@dataclass(frozen=True)
class _Scales:
    """Map from points of the search, which starts at zero, to gains."""

    start: FloatArray
    logarithmic: NDArray[np.bool_]
    lower: FloatArray
    upper: FloatArray

    def gains(self, point: FloatArray) -> FloatArray:
        linear = self.start + point * np.where(self.start != 0, np.abs(self.start), 1.0)
        gains = np.where(self.logarithmic, self.start * np.exp(point), linear)
        return np.clip(gains, self.lower, self.upper)  # rounding may step over a bound


def _scales(
    model: Model, controller: str, free: Sequence[str], start: FloatArray
) -> tuple[_Scales, FloatArray, FloatArray]:
    """Return scales and bounds of the search, one difference step away from an excluded bound."""
    law = model.manifest.controllers[controller]
    rows = {q.name: q for q in all_parameters(model.manifest, law)}
    logarithmic = np.array([rows[name].lower >= 0 and value > 0 for name, value in zip(free, start, strict=True)])
    low, high = [], []
    for name, value, by_logarithm in zip(free, start, logarithmic, strict=True):
        row, size = rows[name], abs(value) or 1.0
        below, above = (
            (math.log(end / value) if end > 0 else -math.inf) if by_logarithm else (end - value) / size
            for end in (row.lower, row.upper)
        )
        low.append(min(below + _STEP * row.lower_open, 0.0))
        high.append(max(above - _STEP * row.upper_open, 0.0))
    ends = (np.array([getattr(rows[name], end) for name in free]) for end in ("lower", "upper"))
    return _Scales(start, logarithmic, *ends), np.array(low), np.array(high)
