# SPDX-License-Identifier: Apache-2.0
"""The two versions of a model that run, both in the names of the new version."""

from __future__ import annotations

from collections.abc import Callable, Mapping
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

    def rest(self) -> FloatArray:
        """Search for an equilibrium without inputs, starting at the zero state or a scenario's start."""
        x = np.asarray(self.model.state())
        if not (np.all(np.isfinite(self.rates(x))) and np.all(np.isfinite(self.slope(x)))):
            x = self.start

        def projection(state: FloatArray) -> FloatArray:
            change = displacement(self.model.manifest, self.model.functions, state, self.model.parameters())
            return state + change if change.size else state

        return rest(self.rates, self.slope, projection, x)

    def point(self, x: FloatArray) -> Point:
        """Return the nonzero elements of a state by name."""
        return tuple((name, float(v)) for name, v in zip(self.states, x, strict=True) if abs(v) > _ROUNDING)


Sides = tuple[Side, Side]


def shared(old: Mapping[str, T], new: Mapping[str, T]) -> dict[str, tuple[T, T]]:
    """Return old and new values by the names that both versions have, in the order of the new one."""
    return {name: (old[name], new[name]) for name in new if name in old}


def rest(
    rate: Callable[[FloatArray], FloatArray],
    slope: Callable[[FloatArray], FloatArray],
    projection: Callable[[FloatArray], FloatArray],
    x: FloatArray,
) -> FloatArray:
    """Search for a zero of the rates by Gauss-Newton steps of minimum norm, each followed by the projection.

    Return the start if there is none, as for a craft in orbit.
    """
    first = x
    for _ in range(_STEPS):
        matrix = slope(x)
        if not np.all(np.isfinite(matrix)):
            break
        step = np.linalg.lstsq(matrix, -rate(x), rcond=None)[0]
        following = projection(x + step)
        if not np.linalg.norm(rate(following)) < np.linalg.norm(rate(x)):
            break
        x = following
    slow = np.max(np.abs(rate(x)), initial=0.0) <= _AT_REST * np.max(np.abs(rate(first)), initial=0.0)
    return x if slow and np.linalg.norm(x - first) <= _FAR * (1 + np.linalg.norm(first)) else first
