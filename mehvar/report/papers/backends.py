# SPDX-License-Identifier: Apache-2.0
"""Comparison of mehvar's generated C with CasADi's: every function at random points, and whole runs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mehvar.base.names import identifier
from mehvar.runtime.model.model import load
from mehvar.runtime.run.metrics import metrics
from mehvar.runtime.run.simulate import simulate

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from mehvar.base.manifest import Array, Function
    from mehvar.reproduction.runs import Runs
    from mehvar.runtime.model.model import Model
    from mehvar.runtime.run.simulate import Run

    FloatArray = NDArray[np.float64]

POINTS = 500
"""Number of random points per function, which take about a second. A wrong operation shows at every point."""
_SPREAD = 0.1
"""Spread of random points around a run, relative to a value and to its series' largest. A larger spread leaves the
functions' domains; a smaller one covers less.
"""
TOLERANCE = 1e-13
"""Tolerance relative to a function's largest result at a point: 450 roundings. At six times as many points the
largest difference was 90 roundings.
"""
_STEADY = TOLERANCE / 4
"""Largest change of a result, when its arguments are rounded, at points that are compared. Two versions of code
differ by several such changes. The largest difference is 2.0e-14 with this value, 4.8e-14 and 1.2e-14 with twice and
half of it, 9.3e-14 with the tolerance itself, where another compiler may fail."""

_NEIGHBOURS = 32
"""Number of rounded neighbours of each point. With one neighbour, three of 500 points near a pole pass; with four or
sixteen, one; with thirty-two, none.
"""


@dataclass(frozen=True)
class FunctionAgreement:
    """Comparison of a function on both backends: number of points, and largest relative difference."""

    name: str
    points: int
    difference: float

    @property
    def same(self) -> bool:
        """True if both agree within rounding error."""
        return self.points > 0 and self.difference <= TOLERANCE


@dataclass(frozen=True)
class RunAgreement:
    """Comparison of a run on both backends: how both ended, and the largest differences of states and metrics.

    Differences are relative to the largest state or the metric, in their units, but at least to 1.
    """

    law: str
    ends: tuple[str, str]
    state: float
    metric: float


@dataclass(frozen=True)
class Agreement:
    """Comparison of both generated codes of a model, by its functions and by runs of its laws."""

    functions: Sequence[FunctionAgreement]
    runs: Sequence[RunAgreement]

    @property
    def different(self) -> list[str]:
        """Functions whose difference exceeds rounding error."""
        return [function.name for function in self.functions if not function.same]

    @property
    def same(self) -> bool:
        """True if every function agrees within rounding error."""
        return not self.different

    @property
    def largest(self) -> float:
        """Largest difference among all functions."""
        return max(function.difference for function in self.functions)


def agreement(runs: Runs) -> Agreement:
    """Compare every function, and each law's run of the first scenario."""
    ours, theirs = runs.model, load(runs.model.manifest.folder, "casadi")
    loops = {law: runs(law, ours.manifest.scenario(None).name) for law in ours.manifest.controllers}
    functions = [compare(ours, theirs, name, _loop_of(name, loops)) for name in theirs.functions]
    return Agreement(functions, [_compare_runs(theirs, run) for run in loops.values()])


def compare(ours: Model, theirs: Model, name: str, run: Run) -> FunctionAgreement:
    """Compare a function at random points near those of a run.

    Points with results that are not finite are skipped. So are ill-conditioned points, such as those near a pole,
    where rounding the arguments changes the result by more than a quarter of the tolerance.
    """
    function = ours.manifest.functions[name]
    values = points(function, run)
    one, other = (_flat(model.functions[name](*values)) for model in (ours, theirs))
    with np.errstate(invalid="ignore"):
        scale = np.abs(one).max(axis=1, initial=0.0)
        steady = np.isfinite(one).all(axis=1)
        for beside in _neighbours(values):
            moved = np.abs(one - _flat(ours.functions[name](*beside))).max(axis=1, initial=0.0)
            steady &= moved <= _STEADY * scale
        apart = np.abs(one - other).max(axis=1, initial=0.0)
    apart, scale = apart[steady], scale[steady]
    relative = np.divide(apart, scale, out=np.where(apart > 0, np.inf, 0.0), where=scale > 0)
    return FunctionAgreement(name, int(steady.sum()), float(relative.max(initial=0.0)))


def _neighbours(values: Sequence[FloatArray]) -> Iterator[list[FloatArray]]:
    """Return the arguments with each number replaced by a neighbouring double, up or down at random."""
    rng = np.random.default_rng(0)
    for _ in range(_NEIGHBOURS):
        yield [np.nextafter(value, rng.choice([-np.inf, np.inf], value.shape)) for value in values]


def points(function: Function, run: Run) -> list[FloatArray]:
    """Return random arguments of a function near the values of the run."""
    rng = np.random.default_rng(sum(map(ord, function.name)))
    rows = rng.integers(len(run.t), size=POINTS)
    known = _series(run)
    return [_drawn(argument, known, rows, rng) for argument in function.arguments]


def _series(run: Run) -> Mapping[str, FloatArray]:
    """Return the values of a run by argument name, one row per sample."""
    constant = {name: np.tile(getattr(run.parameters, name), (len(run.t), 1)) for name in "pcs"}
    rows = {"x": run.x, "q": run.x, "u": run.u, "v": run.u, "u_cmd": run.u_cmd, "z": run.z}
    return constant | rows | {"t": run.t} | run.variables()


def _drawn(
    argument: Array, known: Mapping[str, FloatArray], rows: NDArray[np.int64], rng: np.random.Generator
) -> FloatArray:
    """Return random values of an argument, (POINTS, *shape), around samples of the run if it has the argument."""
    shape = (POINTS, *argument.shape)
    series = known.get(argument.name)
    if series is None:
        return rng.standard_normal(shape)
    largest = np.abs(series).max(axis=0, initial=0.0)
    largest = np.where(largest > 0.0, largest, 1.0)  # what is switched off in the run is switched on
    values: FloatArray = series[rows] * rng.normal(1.0, _SPREAD, shape) + largest * rng.normal(0.0, _SPREAD, shape)
    return values


def _flat(results: FloatArray | tuple[FloatArray, ...]) -> FloatArray:
    several = results if isinstance(results, tuple) else (results,)
    return np.concatenate([np.reshape(result, (POINTS, -1)) for result in several], axis=1)


def _loop_of(function: str, loops: Mapping[str, Run]) -> Run:
    """Return the run of the function's law; for other functions, that of the first law."""
    own = [law for law in loops if f"{function}_".startswith(f"{identifier(law)}_")]
    return loops[max(own, key=len, default=next(iter(loops)))]


def _compare_runs(theirs: Model, run: Run) -> RunAgreement:
    again = simulate(theirs, run.controller.name, run.scenario.name)
    rows = min(len(run.t), len(again.t))
    one, other = run.x[:rows], again.x[:rows]
    state = np.abs(one - other).max(initial=0.0) / max(1.0, np.abs(one).max(initial=0.0))
    values, others = metrics(run, run.manifest), metrics(again, run.manifest)
    finite = [name for name, value in values.items() if np.isfinite(value)]
    metric = max((abs(values[name] - others[name]) / max(1.0, abs(values[name])) for name in finite), default=0.0)
    return RunAgreement(run.controller.name, (run.reason, again.reason), float(state), float(metric))
