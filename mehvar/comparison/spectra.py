# SPDX-License-Identifier: Apache-2.0
"""Linearisation points of two versions, and the eigenvalues of plant and loops that differ at them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from mehvar.base.errors import InputError
from mehvar.base.manifest import Controller
from mehvar.base.names import identifier
from mehvar.estimation.margins import is_unstable, orbit_modes
from mehvar.estimation.turns import in_turns
from mehvar.runtime.model.functions import FloatArray
from mehvar.runtime.model.linear import LinearSystem, modes
from mehvar.runtime.model.model import Model
from mehvar.runtime.model.parameters import vector

Pairs = tuple[tuple[complex, complex], ...]

_STEPS = 20
"""Number of Gauss-Newton steps; near an equilibrium each step doubles the number of correct digits."""
_AT_REST = 1e-6
"""Largest rate at an equilibrium, relative to the start. A search without an equilibrium stops far above it."""
_FAR = 10.0
"""Largest distance of an equilibrium from the start, relative to the start: farther away from a planet, gravity merely
vanishes."""
_ROUNDING = 1e-9
"""Bound relative to a state, below which values print as zero."""


@dataclass(frozen=True)
class Loop:
    """Eigenvalues of a closed loop that changed.

    Attributes
    ----------
    law : str
        Name of the law.
    period : float or None
        Sampling period of the new law, s, for eigenvalues of the map over a period. None for continuous time.
    point : tuple of (str, float)
        Linearisation point of the old loop: the first scenario's start with the law's initial memory, without zeros.
    eigenvalues : tuple of (complex, complex)
        Pairs of old and new eigenvalues, without conjugates.
    old_period : float or None
        Sampling period of the old law.
    new_point : tuple of (str, float)
        Linearisation point of the new loop, likewise.
    lost : bool
        True if the new loop is unstable there, and the old one is not.
    """

    law: str
    period: float | None
    point: tuple[tuple[str, float], ...]
    eigenvalues: Pairs
    old_period: float | None = None
    new_point: tuple[tuple[str, float], ...] = ()
    lost: bool = False


def start(model: Model) -> FloatArray:
    """Return the initial state of the first scenario's defaults."""
    state: FloatArray = model.functions["initial"](model.parameters(), vector(model.manifest.scenario_parameters, {}))
    return state


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


def named(names: Iterable[str], x: FloatArray) -> tuple[tuple[str, float], ...]:
    """Return the nonzero elements of a point by name."""
    return tuple((name, float(value)) for name, value in zip(names, x, strict=True) if abs(value) > _ROUNDING)


def moved(old: FloatArray, new: FloatArray) -> Pairs:
    """Return the eigenvalues of two matrices that differ beyond their errors, in pairs, one for each conjugate pair.

    An eigenvalue below its error is zero.
    """
    from scipy.optimize import linear_sum_assignment  # half a second that an unchanged model need not wait

    if not (np.all(np.isfinite(old)) and np.all(np.isfinite(new))):
        return ()
    (first, first_errors), (second, second_errors) = modes(old), modes(new)
    distance = np.abs(first[:, None] - second[None, :])
    least = first_errors[:, None] + second_errors[None, :]
    first, second = (
        np.where(np.abs(first) > first_errors, first, 0),
        np.where(np.abs(second) > second_errors, second, 0),
    )
    matched = zip(*linear_sum_assignment(distance), strict=True)
    pairs = [(complex(first[i]), complex(second[j])) for i, j in matched if distance[i, j] > least[i, j]]
    return tuple(pair for pair in pairs if max(value.imag for value in pair) >= 0)


def loops(before: Model, after: Model, names: Mapping[str, str]) -> tuple[tuple[Loop, ...], tuple[str, ...]]:
    """Return the loops whose eigenvalues differ, and the reasons why others could not be compared.

    Loops are compared for laws that both versions have with the same number of states; `names` has new names by old.
    """
    changed: list[Loop] = []
    refused: list[str] = []
    formers = {names.get(name, name): law for name, law in before.manifest.controllers.items()}
    for name, law in after.manifest.controllers.items():
        former = formers.get(name)
        if former is None or not (differentiable(before, former) and differentiable(after, law)):
            continue
        try:
            sides = _closed(before, former), _closed(after, law)
        except InputError as error:
            refused.append(f"{name}: {error}")
            continue
        old, new = (side.A for side in sides)
        pairs = moved(old, new) if old.shape == new.shape else ()
        if pairs:
            points = (
                named((names.get(state, state) for state in before.state_names), start(before)),
                named(after.state_names, start(after)),
            )
            periods = _period(before, former), _period(after, law)
            first, second = (
                is_unstable(in_turns(model.manifest, side, x := start(model)).A, period, orbit_modes(model, x))
                for model, side, period in zip((before, after), sides, periods, strict=True)
            )
            changed.append(Loop(name, periods[1], points[0], pairs, periods[0], points[1], second and not first))
    return tuple(changed), tuple(refused)


def _period(model: Model, law: Controller) -> float | None:
    """Return the default period of a law, s; None in continuous time."""
    places = [q.name for q in model.manifest.parameters]
    return float(model.parameters()[places.index(law.period)]) if law.period else None


def undifferentiated(models: Sequence[Model]) -> bool:
    """Return True for a folder from a version of mehvar without derivatives of laws."""
    return any(not differentiable(model, law) for model in models for law in model.manifest.controllers.values())


def differentiable(model: Model, law: Controller) -> bool:
    """Return True for a law with generated derivatives."""
    return f"{identifier(law.name)}_jvp" in model.functions


def _closed(model: Model, law: Controller) -> LinearSystem:
    """Return a closed loop at the first scenario's start, with default parameters."""
    p = model.parameters()
    r = model.functions["reference"](0.0, p, vector(model.manifest.scenario_parameters, {}))
    return model.linearize(start(model), None, p, r=r, controller=law.name)
