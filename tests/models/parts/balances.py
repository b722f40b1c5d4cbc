# SPDX-License-Identifier: Apache-2.0
"""Balances of energy and momentum of an assembly at random states, through the functions that are generated for it."""

from __future__ import annotations

import casadi as ca
import numpy as np

from mehvar.codegen.functions.graphs import generate_functions
from mehvar.models.system import System


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
        self.p = np.array([float(q.default) for q in system.parameters])
        self._rhs = graphs["rhs"]
        x, u, p = self._rhs.sx_in()
        read = ca.vertcat(graphs["energy"](x, p), graphs["momentum"](x, p))
        rates = ca.jtimes(read, x, self._rhs(x, u, p))
        supply = ca.vertcat(graphs["power"](x, u, p), graphs["loads"](x, u, p))
        self._sides = ca.Function("sides", [x, u, p], [rates, supply, read])

    def rhs(self, x: np.ndarray, u: np.ndarray) -> np.ndarray:
        """Return the rates of the states."""
        return np.array(self._rhs(x, u, self.p)).ravel()

    def state(self, rng: np.random.Generator) -> np.ndarray:
        """Return a random state: quaternions and directions have length one, and bobs turn across their rods."""
        x = rng.normal(size=len(self.x_names))
        x = np.array([abs(value) if name.endswith("_fuel") else value for name, value in zip(self.x_names, x, strict=True)])
        at = {name: k for k, name in enumerate(self.x_names)}
        if "q0" in at:
            q = [at[f"q{k}"] for k in range(4)]
            x[q] /= np.linalg.norm(x[q])
        for q in ([at[n], *(at[f"{n[:-1]}{k}"] for k in (1, 2, 3))] for n in at if n.endswith("_q0")):
            x[q] /= np.linalg.norm(x[q])
        for name in (n for n in at if n.endswith("_ex")):
            e, u = ([at[f"{name[:-3]}_{letter}{axis}"] for axis in "xyz"] for letter in "eu")
            x[e] /= np.linalg.norm(x[e])
            x[u] -= x[e] * (x[e] @ x[u])
        return x

    def residual(self, x: np.ndarray, u: np.ndarray) -> float:
        """Return the largest misfit of power and of momentum's rates, relative to the size of the terms."""
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
