# SPDX-License-Identifier: Apache-2.0
"""Rates and balances of an assembly at random states, by its generated functions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import casadi as ca
import numpy as np

from mehvar.codegen.functions.graphs import generate_functions
from mehvar.models.check import check
from mehvar.models.parts import Part, Spacecraft
from mehvar.models.system import System


def assembled(parts: Sequence[Part], checked: bool = True, **options: str) -> Balances:
    """Assemble a craft, check it unless its parts are in another craft, and return its functions."""
    craft = Spacecraft("craft", **options)
    for part in parts:
        craft.add(part)
    system = craft.system()
    if checked:
        check(system)
    return Balances(system)


class Balances:
    """Numerical functions of an assembly.

    Parameters
    ----------
    system : System
        Of a spacecraft.
    """

    def __init__(self, system: System) -> None:
        graphs = {g.name: g.graph for g in generate_functions(system)}
        self.system = system
        self.x_names = [q.name for q in system.states]
        self.u_names = [q.name for q in system.inputs]
        self.p = np.array([float(q.default) for q in system.parameters])
        self._rhs = graphs["rhs"]
        x, u, p = self._rhs.sx_in()
        read = ca.vertcat(graphs["energy"](x, p), graphs["momentum"](x, p))
        rates = ca.jtimes(read, x, self._rhs(x, u, p))
        supply = ca.vertcat(graphs["power"](x, u, p), graphs["loads"](x, u, p))
        self._sides = ca.Function("sides", [x, u, p], [rates, supply, read])

    def rhs(self, x: np.ndarray, u: np.ndarray, p: np.ndarray | None = None) -> np.ndarray:
        """Return the rates of the states."""
        return np.array(self._rhs(x, u, self.p if p is None else p)).ravel()

    def rates(
        self, x: Mapping[str, float], u: Mapping[str, float], p: Mapping[str, float] | None = None
    ) -> dict[str, float]:
        """Return the rates of the states by name; parameters that are not given have their defaults."""
        values = [(p or {}).get(q.name, float(q.default)) for q in self.system.parameters]
        rates = self.rhs(np.array([x[n] for n in self.x_names]), np.array([u[n] for n in self.u_names]), values)
        return dict(zip(self.x_names, rates, strict=True))

    def sample(self, rng: np.random.Generator) -> tuple[dict[str, float], dict[str, float]]:
        """Return a random state and a random input by name."""
        u = rng.normal(size=len(self.u_names))
        return dict(zip(self.x_names, self.state(rng), strict=True)), dict(zip(self.u_names, u, strict=True))

    def state(self, rng: np.random.Generator) -> np.ndarray:
        """Return a random state: quaternions and directions have length one, bobs turn across their rods."""
        x = rng.normal(size=len(self.x_names))
        at = {name: k for k, name in enumerate(self.x_names)}
        for name in at:
            if name.endswith("q0"):
                q = [at[f"{name[:-1]}{k}"] for k in range(4)]
                x[q] /= np.linalg.norm(x[q])
            if name.endswith("_fuel"):
                x[at[name]] = abs(x[at[name]])
            if name.endswith("_ex"):
                e, u = ([at[f"{name[:-3]}_{letter}{axis}"] for axis in "xyz"] for letter in "eu")
                x[e] /= np.linalg.norm(x[e])
                x[u] -= x[e] * (x[e] @ x[u])
        return x

    def readings(self, x: Mapping[str, float], u: Mapping[str, float]) -> np.ndarray:
        """Return energy, momentum and angular momentum of a state and an input by name."""
        given = [x[n] for n in self.x_names], [u[n] for n in self.u_names]
        return np.array(self._sides(*given, self.p)[2]).ravel()

    def power(self, x: np.ndarray, u: np.ndarray) -> float:
        """Return the power of loads, motors and dampers, W."""
        return float(self._sides(x, u, self.p)[1][0])

    def residual(self, x: np.ndarray, u: np.ndarray) -> float:
        """Return the largest error of the power and momentum balances, relative to the size of the terms."""
        v, w = (
            np.array([x[self.x_names.index(n)] if n in self.x_names else 0.0 for n in (f"{letter}{a}" for a in "xyz")])
            for letter in "vw"
        )
        rates, supply, read = (np.array(side).ravel() for side in self._sides(x, u, self.p))
        linear, angular = read[1:4], read[4:]
        rates[1:4] += np.cross(w, linear)
        rates[4:] += np.cross(w, angular) + np.cross(v, linear)
        size = 1.0 + np.abs(read).max() * (1 + np.abs(w).max() + np.abs(v).max())
        return float(np.abs(rates - supply).max() / size)
