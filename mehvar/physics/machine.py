# SPDX-License-Identifier: Apache-2.0
"""Functions of a system in CasADi's virtual machine, with arguments by quantity name, and random points for them.

Each additive term may have a weight, by default 1. With other weights the same functions evaluate a mutant.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np
import sympy as sp
from numpy.typing import NDArray

from mehvar.codegen.functions.lower import to_casadi
from mehvar.codegen.functions.requests import Request, bindings, requests
from mehvar.models.arrays import INCREASING, Tensor
from mehvar.models.forms import with_mass
from mehvar.models.system import TIME, Group, Parameter, Quantity, System, scalar

Array = NDArray[np.float64]
Ranges = Mapping[str, tuple[float, float]]
"""Plausible ranges of quantities by name."""

_STENCIL = ((1, 3 / 4), (2, -3 / 20), (3, 1 / 60))
"""Coefficients of sixth-order central differences."""
_STEP = 3e-3
"""Step of the differences for a motion of speed one. Gate errors are 1e-13 to 1.2e-12 at this step, up to twice that
at half the step, 3e-12 at twice and 2e-10 at four times.
"""


class Machine:
    """Functions of a system, built at first use.

    Parameters
    ----------
    system : System
        As derived.
    ranges : mapping of str to (float, float)
        Ranges of random values; see `draw` for quantities without a range.
    weights : sequence of Symbol
        Symbols of the system that are neither quantities nor definitions; attribute `weights` holds their values.
    """

    def __init__(self, system: System, ranges: Ranges, weights: Sequence[sp.Symbol] = ()) -> None:
        self.system = system = with_mass(system)
        self.ranges = ranges
        listing = (*requests(system), *_chart(system), *_derived(system))
        self.requests = {request.name: request for request in listing}
        self.weights = np.ones(len(weights))
        self._symbols = tuple(weights)
        self._graphs: dict[str, ca.Function] = {}

    def __call__(self, name: str, *arguments: Array) -> Array:
        """Evaluate at n points: arguments and result have shape (n, size)."""
        return np.asarray(self.graph(name)(*(ca.DM(a.T) for a in arguments), ca.DM(self.weights))).T

    def graph(self, name: str) -> ca.Function:
        """Return a function as a graph, whose last argument are the weights."""
        if name not in self._graphs:
            self._graphs[name] = self._lowered(self.requests[name])
        return self._graphs[name]

    def _lowered(self, request: Request) -> ca.Function:
        """Return a request as a CasADi function of its vectors and of weights; all results form one column."""
        vectors = [ca.SX.sym(group.name, max(len(group), 1)) for group in request.arguments]
        weights = ca.SX.sym("weights", len(self._symbols))
        symbols = {s: weights[k] for k, s in enumerate(self._symbols)}
        for group, vector in zip(request.arguments, vectors, strict=True):
            symbols |= {s: vector[k] for k, s in enumerate(group.symbols)}
        bound = {s: e for s, e in bindings(self.system, request).items() if s not in symbols}
        results = to_casadi([e for _, es in request.results for e in es], symbols, self.system.definitions | bound)
        whole = ca.cse([ca.densify(ca.vertcat(*results)) if results else ca.SX(0, 1)])
        return ca.Function(request.name, [*vectors, weights], whole)


def _chart(system: System) -> list[Request]:
    """Return functions of the regular coordinates that are not generated functions."""
    chart = system.coordinates
    if chart is None:
        return []
    q, n = Group("q", chart.states.quantities), Group("n", chart.inputs.quantities)
    return [
        Request("chart_rhs", "rates of the coordinates", (q, n, system.parameters), (("dq", chart.rhs),)),
        Request("chart_inputs", "inputs of the chart", (system.states, system.inputs), (("n", n.symbols),)),
    ]


def _derived(system: System) -> list[Request]:
    """Return the residuals of the derived equations of motion, zero for correct rates."""
    if not system.residual:
        return []
    units = {q.name: f"{q.unit}/s" for q in system.states}
    rates = Group("rates", tuple(Quantity(s.name, units[state], "rate") for state, s in system.rates.items()))
    groups = (system.states, system.inputs, system.parameters, rates)
    return [Request("residual", "derived equations of motion", groups, (("left", system.residual),))]


@dataclass(frozen=True)
class Points:
    """Values of all arguments of a plant's functions, at n points.

    Attributes
    ----------
    machine : Machine
        Machine to which the points belong.
    values : mapping of str to array
        By name of the group, shape (n, size).
    """

    machine: Machine
    values: Mapping[str, Array]

    def __getitem__(self, name: str) -> Array:
        """Return a quantity by its name, shape (n,)."""
        group, k = self._place(name)
        return self.values[group][:, k]

    def vector(self, *names: str) -> Array:
        """Return several quantities, shape (n, number)."""
        return np.stack([self[name] for name in names], axis=-1)

    def moved(self, **changes: Array | float) -> Points:
        """Return the points with some quantities replaced."""
        values = {name: array.copy() for name, array in self.values.items()}
        for name, value in changes.items():
            group, k = self._place(name)
            values[group][:, k] = value
        return dataclasses.replace(self, values=values)

    def at(self, **groups: Array) -> Points:
        """Return the points with some vectors replaced."""
        return dataclasses.replace(self, values={**self.values, **groups})

    def call(self, function: str) -> Array:
        """Evaluate a function at the points."""
        arguments = self.machine.requests[function].arguments
        return self.machine(function, *(self._argument(group) for group in arguments))

    def result(self, function: str, *names: str) -> Array:
        """Return selected elements of a function's result, by name."""
        values = self.call(function)
        places = [self._result_names(function).index(name) for name in names]
        return values[:, places]

    def along(self, quantity: Callable[[Points], Array], flow: str = "rhs") -> Array:
        """Return the derivative of a quantity along the motion, by differences of sixth order."""
        rate = self.call(flow)
        step = _STEP / np.maximum(1, np.abs(rate).max(axis=1, keepdims=True))
        total: Array | float = 0.0
        for count, weight in _STENCIL:
            ahead, behind = (quantity(self.at(x=self.values["x"] + sign * count * step * rate)) for sign in (1, -1))
            total = total + weight * (ahead - behind)
        return np.asarray(total / step)

    def _argument(self, group: Group) -> Array:
        if group.name in self.values:
            return self.values[group.name]
        return self.vector(*(q.name for q in group))

    def _place(self, name: str) -> tuple[str, int]:
        for group in groups(self.machine.system):
            names = [q.name for q in group]
            if group.name in self.values and name in names:
                return group.name, names.index(name)
        raise KeyError(name)

    def _result_names(self, function: str) -> list[str]:
        system = self.machine.system
        if function.startswith("rhs"):
            return [q.name for q in system.states]
        if function == "outputs":
            return [q.name for q in system.outputs]
        own = {f.name: [q.name for q, _ in f.results] for f in system.functions}
        return own[function]


def groups(system: System) -> tuple[Group, ...]:
    """Return the vectors whose values the points have."""
    own = (system.states, system.inputs, system.parameters, system.references, system.scenario_parameters)
    return (*own, scalar(TIME))


def points(subject: Machine, n: int = 12, seed: int = 0) -> Points:
    """Draw random points; project the states to their manifold."""
    rng = np.random.default_rng(seed)
    system = subject.system
    values = {group.name: draw(subject.ranges, group, n, rng) for group in groups(system)}
    drawn = Points(subject, values)
    return drawn.at(x=drawn.call("project")) if "project" in subject.requests else drawn


def draw(ranges: Ranges, group: Group, n: int, rng: np.random.Generator) -> Array:
    """Draw n random vectors of a group, shape (n, size); an empty group gets one unused number.

    Values without a range are around the default, or else in [0.1, 1]; the points of a table increase.
    """
    if not len(group):
        return np.zeros((n, 1))
    values = np.stack([rng.uniform(*_range(ranges, q), size=n) for q in group], axis=-1)
    arrays = [q.array if isinstance(q, Parameter) else None for q in group]
    for array in dict.fromkeys(arrays):
        if isinstance(array, Tensor) and array.form == INCREASING:
            columns = [k for k, other in enumerate(arrays) if other == array]
            values[:, columns] = np.sort(values[:, columns], axis=1)
    return values


def _range(ranges: Ranges, quantity: Quantity) -> tuple[float, float]:
    if quantity.name in ranges:
        return ranges[quantity.name]
    if isinstance(quantity, Parameter) and isinstance(quantity.default, float) and quantity.default:
        low, high = sorted((0.8 * quantity.default, 1.25 * quantity.default))
        return low, high
    return 0.1, 1.0
