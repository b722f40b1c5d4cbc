# SPDX-License-Identifier: Apache-2.0
"""Rates and balances of a craft from parts, at random states."""

from __future__ import annotations

from collections.abc import Mapping

import casadi as ca
import numpy as np

from mehvar.codegen.generate import prepared
from mehvar.models.system import Group, Parameter, System
from mehvar.physics.machine import Array, Machine


class Balances:
    """Numerical functions of a craft, with the exact rates of its energy and momentum.

    Parameters
    ----------
    system : System
        Of a spacecraft.

    Attributes
    ----------
    x_names, u_names : list of str
        States and inputs.
    p : array
        Defaults of the parameters.
    """

    def __init__(self, system: System) -> None:
        self.system = prepared(system)
        self.x_names = [q.name for q in self.system.states]
        self.u_names = [q.name for q in self.system.inputs]
        self.p, scenario = (_defaults(group) for group in (self.system.parameters, self.system.scenario_parameters))
        self._machine = machine = Machine(self.system, {})
        self.start = self._one("initial", self.p, scenario)
        x, u, p, weights = machine.graph("rhs").sx_in()
        energy, momentum = (machine.graph(name)(x, p, weights) for name in ("energy", "momentum"))
        power, loads = (machine.graph(name)(x, u, p, weights) for name in ("power", "loads"))
        read, supply = ca.vertcat(energy, momentum), ca.vertcat(power, loads)
        rates = ca.jtimes(read, x, machine.graph("rhs")(x, u, p, weights))
        self._sides = ca.Function("sides", [x, u, p], [rates, supply, read])

    def _one(self, name: str, *arguments: Array) -> Array:
        """Evaluate a function at one point; an empty vector has one unused number."""
        result: Array = self._machine(name, *(a[None] if len(a) else np.zeros((1, 1)) for a in arguments))[0]
        return result

    def _vectors(self, x: Mapping[str, float], u: Mapping[str, float]) -> tuple[Array, Array]:
        return np.array([x[n] for n in self.x_names]), np.array([u[n] for n in self.u_names])

    def rates(
        self, x: Mapping[str, float], u: Mapping[str, float], p: Mapping[str, float] | None = None
    ) -> dict[str, float]:
        """Return the rates of the states by name; parameters that are not given have their defaults."""
        values = np.array([(p or {}).get(q.name, d) for q, d in zip(self.system.parameters, self.p, strict=True)])
        rates = map(float, self._one("rhs", *self._vectors(x, u), values))
        return dict(zip(self.x_names, rates, strict=True))

    def sample(self, rng: np.random.Generator) -> tuple[dict[str, float], dict[str, float]]:
        """Return a random state and a random input by name."""
        u = rng.normal(size=len(self.u_names))
        return dict(zip(self.x_names, self._state(rng), strict=True)), dict(zip(self.u_names, u, strict=True))

    def _state(self, rng: np.random.Generator) -> Array:
        """Return a random state on its manifold. States that are zero at the start are near one, others near it."""
        spread = rng.normal(size=len(self.start))
        return self._projected(np.where(self.start == 0, spread, self.start * (1 + 0.1 * spread)))

    def opposite(self, x: Mapping[str, float]) -> dict[str, float]:
        """Return a state with the other sign of each quantity that is zero at the start, as all speeds are."""
        values = np.array([x[name] for name in self.x_names])
        opposite = self._projected(np.where(self.start == 0, -values, values))
        return dict(zip(self.x_names, map(float, opposite), strict=True))

    def _projected(self, x: Array) -> Array:
        """Return the state on its manifold that is near another."""
        if "project" not in self._machine.requests:
            return x
        return self._one("project", *[x, self.p][: len(self._machine.requests["project"].arguments)])

    def readings(self, x: Mapping[str, float], u: Mapping[str, float]) -> Array:
        """Return energy, momentum and angular momentum."""
        return np.array(self._sides(*self._vectors(x, u), self.p)[2]).ravel()

    def power(self, x: Mapping[str, float], u: Mapping[str, float]) -> float:
        """Return the power of loads, motors and dampers, W."""
        return float(self._sides(*self._vectors(x, u), self.p)[1][0])

    def errors(self, x: Mapping[str, float], u: Mapping[str, float]) -> tuple[float, float]:
        """Return the errors of the balances of energy and of momentum, relative to the size of the terms."""
        v, w = (np.array([x.get(f"{letter}{axis}", 0.0) for axis in "xyz"]) for letter in "vw")
        rates, supply, read = (np.array(side).ravel() for side in self._sides(*self._vectors(x, u), self.p))
        linear, angular = read[1:4], read[4:]
        rates[1:4] += np.cross(w, linear)
        rates[4:] += np.cross(w, angular) + np.cross(v, linear)
        size = 1.0 + np.abs(read).max() * (1 + np.abs(w).max() + np.abs(v).max())
        energy, *momentum = np.abs(rates - supply) / size
        return float(energy), float(max(momentum))


def _defaults(group: Group) -> Array:
    return np.array([float(q.default) for q in group if isinstance(q, Parameter)])


def apart(a: Mapping[str, float], b: Mapping[str, float]) -> float:
    """Return the largest difference of rates, relative to the largest rate."""
    return max(abs(a[name] - b[name]) for name in b) / max(1.0, *map(abs, b.values()))
