# SPDX-License-Identifier: Apache-2.0
"""The slosh model's functions for the tests, evaluated by CasADi without writing any file."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass

import casadi as ca
import numpy as np

from mehvar.codegen.functions.lower import to_casadi
from mehvar.codegen.functions.requests import Request, bindings, requests
from mehvar.models.slosh import system
from mehvar.models.system import Parameter, System
from tests.reference import reference_slosh as reference

CONVENTIONS = ("paper", "hinge", "ball")


class Functions:
    """CasADi functions by name, built at first use."""

    def __init__(self, model: System) -> None:
        self._model = model
        self._requests = {request.name: request for request in requests(model)}
        self._graphs: dict[str, ca.Function] = {}

    def graph(self, name: str) -> ca.Function:
        if name not in self._graphs:
            self._graphs[name] = lowered(self._model, self._requests[name])
        return self._graphs[name]

    def __getitem__(self, name: str) -> Callable[..., np.ndarray]:
        return _call(self.graph(name))


def lowered(model: System, request: Request) -> ca.Function:
    """Build the CasADi function of a request."""
    vectors = [ca.SX.sym(group.name, len(group)) for group in request.arguments]
    groups = zip(request.arguments, vectors, strict=True)
    symbols = {symbol: vector[i] for group, vector in groups for i, symbol in enumerate(group.symbols)}
    bound = {s: e for s, e in bindings(model, request).items() if s not in symbols}
    results = [to_casadi(exprs, symbols, model.definitions | bound) for _, exprs in request.results]
    return ca.Function(request.name, vectors, ca.cse([ca.vertcat(*result) for result in results]))


@dataclass(frozen=True, eq=False)
class Slosh:
    """A derived structure with its functions and samples of what they receive."""

    system: System

    @functools.cached_property
    def functions(self) -> Functions:
        return Functions(self.system)

    @property
    def convention(self) -> str:
        return self.system.structure["inertia"]

    @property
    def count(self) -> int:
        return int(self.system.structure["pendulums"])

    @property
    def p(self) -> np.ndarray:
        return defaults(self.system.parameters)

    def parameters(self, **values: float) -> np.ndarray:
        return with_values(self.system.parameters, values)

    def law(self, name: str) -> np.ndarray:
        group = next(law.parameters for law in self.system.controllers if law.name == name)
        return defaults(group)

    def index(self, name: str) -> int:
        return [q.name for q in self.system.states].index(name)

    def position(self, name: str) -> int:
        return [q.name for q in self.system.parameters].index(name)

    def sample(self, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return a random state on its manifold, an input and parameters around the defaults."""
        x = rng.uniform(-1.3, 1.3, len(self.system.states))
        x[:3] = rng.uniform(-60, 60, 3)
        if self.convention == "ball":
            for k in range(self.count):
                at = self.index(f"s{k + 1}x")
                s = x[at : at + 3] / np.linalg.norm(x[at : at + 3])
                x[at : at + 3] = s
                x[at + 3 : at + 6] -= s * (s @ x[at + 3 : at + 6])
        if self.system.structure["attitude"] == "quaternion":
            at = self.index("q0")
            x[at : at + 4] /= np.linalg.norm(x[at : at + 4])
        u = np.array([*rng.uniform(-800, 800, 3), *rng.uniform(-0.7, 0.7, 2)])
        p = self.p * rng.uniform(0.6, 1.6, len(self.p))
        return x, u, p

    def motion(self, x: np.ndarray) -> reference.Motion:
        """Convert a state for the reference."""
        if self.convention == "ball":
            rows = x[self.index("s1x") :].reshape(-1, 6)
            return reference.Motion(x[:3], x[3:6], rows[:, :3], rows[:, 3:])
        at = self.index("phi1")
        angles = x[at : at + 2 * self.count].reshape(-1, 2)
        return reference.Motion(x[:3], x[3:6], angles, x[at + 2 * self.count :].reshape(-1, 2))

    def accelerations(self, x: np.ndarray, u: np.ndarray, p: np.ndarray) -> np.ndarray:
        """Return a of O, Omega' and the pendulums' accelerations of the right-hand side."""
        dx = self.functions["rhs"](x, u, p)
        a = dx[:3] + np.cross(x[3:6], x[:3])
        joint = self.convention == "ball"
        own = dx[self.index("s1x") :].reshape(-1, 6)[:, 3:] if joint else dx[self.index("phi1_dot") :]
        return np.concatenate([a, dx[3:6], np.ravel(own)])


def defaults(group: object) -> np.ndarray:
    return np.array([q.default for q in group if isinstance(q, Parameter)], dtype=float)


def with_values(group: object, values: dict[str, float]) -> np.ndarray:
    names = [q.name for q in group]
    found = defaults(group)
    for name, value in values.items():
        found[names.index(name)] = value
    return found


@functools.cache
def slosh(pendulums: str = "2", inertia: str = "paper", attitude: str = "angles") -> Slosh:
    """Derive a structure."""
    return Slosh(system(pendulums=pendulums, inertia=inertia, attitude=attitude))


def _call(graph: ca.Function) -> Callable[..., np.ndarray]:
    """Call a function with one value or many: vectors, or arrays with a leading axis."""

    def call(*arguments: np.ndarray) -> np.ndarray:
        many = any(np.ndim(a) == 2 for a in arguments)
        columns = [np.atleast_2d(a).T for a in arguments]
        results = graph.call([ca.DM(c) if c.size else ca.DM(0, 1) for c in columns])
        values = [np.array(r).T for r in results]
        values = values if many else [v[0] for v in values]
        return values[0] if len(values) == 1 else np.concatenate(values, axis=-1)

    return call


@functools.cache
def implicit(pendulums: str = "2", inertia: str = "paper") -> ca.Function:
    """Return (x, u, p) -> (matrix, rest) of the derived equations: matrix @ rates + rest = 0."""
    model = slosh(pendulums, inertia).system
    rates, equations = model.rates, model.residual
    groups = (model.states, model.inputs, model.parameters)
    vectors = [ca.SX.sym(g.name, len(g)) for g in groups]
    unknown = ca.SX.sym("rates", len(rates))
    symbols = {s: v[i] for g, v in zip(groups, vectors, strict=True) for i, s in enumerate(g.symbols)}
    symbols |= {s: unknown[i] for i, s in enumerate(rates.values())}
    residual = ca.vertcat(*to_casadi(equations, symbols))
    rest = ca.substitute(residual, unknown, ca.SX.zeros(len(rates)))
    return ca.Function("implicit", vectors, [ca.jacobian(residual, unknown), rest])


def rate_positions(model: Slosh) -> list[int]:
    """Return the places of the derived rates in the right-hand side."""
    return [model.index(name) for name in model.system.rates]
