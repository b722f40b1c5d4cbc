# SPDX-License-Identifier: Apache-2.0
"""The two versions of a model that run, both in the names of the new version."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from mehvar.base.manifest import Controller
from mehvar.runtime.model.functions import FloatArray, displacement
from mehvar.runtime.model.model import Model
from mehvar.runtime.model.parameters import vector

_STEPS = 20
"""Number of Gauss-Newton steps; near an equilibrium each step doubles the number of correct digits."""
_AT_REST = 1e-6
"""Largest rate at an equilibrium, relative to the start. A search without an equilibrium stops far above it."""
_FAR = 10.0
"""Largest distance of an equilibrium from the start, relative to the start: farther away from a planet, gravity merely
vanishes."""
_ROUNDING = 1e-9
"""Bound relative to a state, below which values print as zero."""
Point = tuple[tuple[str, float], ...]
T = TypeVar("T")


@dataclass(frozen=True)
class Side:
    """One version of a model, with its default parameters.

    Attributes
    ----------
    model : Model
        The model, with its own names.
    names : mapping of str to str
        New names by own ones; empty for the new version.
    """

    model: Model
    names: Mapping[str, str]

    def name(self, own: str) -> str:
        """Return the new name of a state, input, parameter, law or scenario."""
        return self.names.get(own, own)

    @property
    def states(self) -> list[str]:
        """Names of the states."""
        return [*map(self.name, self.model.state_names)]

    @property
    def inputs(self) -> list[str]:
        """Names of the inputs."""
        return [*map(self.name, self.model.input_names)]

    @property
    def laws(self) -> dict[str, Controller]:
        """Laws by name."""
        return {self.name(name): law for name, law in self.model.manifest.controllers.items()}

    @property
    def scenarios(self) -> dict[str, str]:
        """The model's own names of scenarios by name."""
        return {self.name(name): name for name in self.model.manifest.scenarios}

    @property
    def start(self) -> FloatArray:
        """Initial state of the first scenario's defaults."""
        none = vector(self.model.manifest.scenario_parameters, {})
        state: FloatArray = self.model.functions["initial"](self.model.parameters(), none)
        return state

    def rates(self, x: FloatArray, u: FloatArray | None = None) -> FloatArray:
        """Return the rates of the states; without inputs by default."""
        return self.model.rhs(x, np.zeros(len(self.inputs)) if u is None else u, self.model.parameters())

    def slope(self, x: FloatArray) -> FloatArray:
        """Return the Jacobian of the rates without inputs."""
        return self.model.jac_x(x, np.zeros(len(self.inputs)), self.model.parameters())

    def project(self, x: FloatArray) -> FloatArray:
        """Return the nearest possible state."""
        change = displacement(self.model.manifest, self.model.functions, x, self.model.parameters())
        return x + change if change.size else x

    def rest(self) -> FloatArray:
        """Search for an equilibrium without inputs from the zero state, or the scenario's start if zero has no rates.

        Gauss-Newton steps of minimum norm, each followed by the projection, find a zero of the rates. Return the start
        if there is none, as for a craft in orbit.
        """
        first = np.asarray(self.model.state())
        if not (np.all(np.isfinite(self.rates(first))) and np.all(np.isfinite(self.slope(first)))):
            first = self.start
        x = first
        for _ in range(_STEPS):
            matrix = self.slope(x)
            if not np.all(np.isfinite(matrix)):
                break
            following = self.project(x + np.linalg.lstsq(matrix, -self.rates(x), rcond=None)[0])
            if not np.linalg.norm(self.rates(following)) < np.linalg.norm(self.rates(x)):
                break
            x = following
        largest, initial = (np.max(np.abs(self.rates(state)), initial=0.0) for state in (x, first))
        is_near = np.linalg.norm(x - first) <= _FAR * (1 + np.linalg.norm(first))
        return x if largest <= _AT_REST * initial and is_near else first

    def point(self, x: FloatArray) -> Point:
        """Return the nonzero elements of a state by name."""
        return tuple((name, float(v)) for name, v in zip(self.states, x, strict=True) if abs(v) > _ROUNDING)


Sides = tuple[Side, Side]


def shared(old: Mapping[str, T], new: Mapping[str, T]) -> dict[str, tuple[T, T]]:
    """Return old and new values by the names that both versions have, in the order of the new one."""
    return {name: (old[name], new[name]) for name in new if name in old}
