# SPDX-License-Identifier: Apache-2.0
"""Eigenvalues of plant and loops that differ between two versions."""

from __future__ import annotations

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

from .sides import Point, Side, Sides, shared

Pairs = tuple[tuple[complex, complex], ...]


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
    point: Point
    eigenvalues: Pairs
    old_period: float | None = None
    new_point: Point = ()
    lost: bool = False


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


def loops(sides: Sides) -> tuple[tuple[Loop, ...], str]:
    """Return the loops whose eigenvalues differ, and why others could not be compared.

    Loops are compared for laws that both versions have with the same number of states.
    """
    changed: list[Loop] = []
    refused: list[str] = []
    if not all(differentiable(side.model, law) for side in sides for law in side.laws.values()):
        refused.append("one of the versions has no derivatives of its laws")
    points = [side.point(side.start) for side in sides]
    for name, laws in shared(*(side.laws for side in sides)).items():
        pairs = list(zip(sides, laws, strict=True))
        if not all(differentiable(side.model, law) for side, law in pairs):
            continue
        try:
            closed = [_closed(side, law) for side, law in pairs]
        except InputError as error:
            refused.append(f"{name}: {error}")
            continue
        old, new = (loop.A for loop in closed)
        if eigenvalues := moved(old, new) if old.shape == new.shape else ():
            periods = [_period(side.model, law) for side, law in pairs]
            first, second = map(_is_unstable, sides, closed, periods)
            changed.append(Loop(name, periods[1], points[0], eigenvalues, periods[0], points[1], second and not first))
    return tuple(changed), f"loops and margins not compared: {'; '.join(refused)}" if refused else ""


def _is_unstable(side: Side, loop: LinearSystem, period: float | None) -> bool:
    matrix = in_turns(side.model.manifest, loop, side.start).A
    return is_unstable(matrix, period, orbit_modes(side.model, side.start))


def _period(model: Model, law: Controller) -> float | None:
    """Return the default period of a law, s; None in continuous time."""
    places = [q.name for q in model.manifest.parameters]
    return float(model.parameters()[places.index(law.period)]) if law.period else None


def differentiable(model: Model, law: Controller) -> bool:
    """Return True for a law with generated derivatives, which older versions of mehvar did not generate."""
    return f"{identifier(law.name)}_jvp" in model.functions


def _closed(side: Side, law: Controller) -> LinearSystem:
    """Return a closed loop at the first scenario's start, with default parameters."""
    p = side.model.parameters()
    r = side.model.functions["reference"](0.0, p, vector(side.model.manifest.scenario_parameters, {}))
    return side.model.linearize(side.start, None, p, r=r, controller=law.name)
