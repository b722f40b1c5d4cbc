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
        self.u_names = [q.name for q in system.inputs]
        self.p = np.array([float(q.default) for q in system.parameters])
        x, u, p = graphs["rhs"].sx_in()
        dx = graphs["rhs"](x, u, p)
        energy, momentum = graphs["energy"](x, p), graphs["momentum"](x, p)
        rates = ca.jtimes(ca.vertcat(energy, momentum), x, dx)
        self.rhs = ca.Function("rhs", [x, u, p], [dx])
        self.energy = ca.Function("energy", [x, p], [energy])
        self.momentum = ca.Function("momentum", [x, p], [momentum])
        self.rates = ca.Function("rates", [x, u, p], [rates])

    def state(self, rng: np.random.Generator) -> np.ndarray:
        """Return a random state: quaternions and directions have length one, and bobs turn across their rods."""
        x = rng.normal(size=len(self.x_names))
        at = {name: k for k, name in enumerate(self.x_names)}
        if "q0" in at:
            q = [at[f"q{k}"] for k in range(4)]
            x[q] /= np.linalg.norm(x[q])
        for name in (n for n in at if n.endswith("_ex")):
            e, u = ([at[f"{name[:-3]}_{letter}{axis}"] for axis in "xyz"] for letter in "eu")
            x[e] /= np.linalg.norm(x[e])
            x[u] -= x[e] * (x[e] @ x[u])
        return x

    def residuals(self, x: np.ndarray, u: np.ndarray, loads) -> tuple[float, np.ndarray]:
        """Return power less that of `loads`, and momentum's rates less the loads: (6,), relative to their size."""
        pick = lambda *names: np.array([x[self.x_names.index(n)] if n in self.x_names else 0.0 for n in names])  # noqa: E731
        v, w = pick("vx", "vy", "vz"), pick("wx", "wy", "wz")
        force, moment, power = loads(dict(zip(self.u_names, u, strict=True)), dict(zip(self.x_names, x, strict=True)))
        rates = np.array(self.rates(x, u, self.p)).ravel()
        total = np.array(self.momentum(x, self.p)).ravel()
        linear = rates[1:4] + np.cross(w, total[:3]) - force
        angular = rates[4:] + np.cross(w, total[3:]) + np.cross(v, total[:3]) - moment
        size = 1.0 + np.abs(total).max() * (1 + np.abs(w).max() + np.abs(v).max())
        return float(rates[0] - power) / size, np.concatenate([linear, angular]) / size
