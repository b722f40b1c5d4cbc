# SPDX-License-Identifier: Apache-2.0
"""Constraints on arrays in every run: increasing points and positive definite matrices."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import replace

import sympy as sp

from ..quantities import Group, Parameter
from ..system import Condition, System
from .kinds import INCREASING, Tensor


def with_arrays(system: System) -> System:
    """Return a system with the constraints of its arrays."""
    shared = [*_conditions(system.parameters), *_conditions(system.scenario_parameters)]
    own = [tuple(_conditions(law.parameters)) for law in system.controllers]
    if not shared and not any(own):
        return system
    laws = (
        replace(law, constraints=(*law.constraints, *more)) for law, more in zip(system.controllers, own, strict=True)
    )
    return replace(system, constraints=(*system.constraints, *shared), controllers=tuple(laws))


def _conditions(group: Group) -> Iterator[Condition]:
    for array in dict.fromkeys(q.array for q in group if isinstance(q, Parameter)):
        if isinstance(array, Tensor) and array.form == INCREASING:
            yield from _increasing(array, group)
        if isinstance(array, Tensor) and array.form == "positive definite":
            matrix = array.of(group)  # Sylvester's criterion: the leading minors are positive
            minors = [matrix[:k, :k].det(method="berkowitz") for k in range(1, matrix.rows + 1)]
            yield Condition(sp.Min(*minors), f"the matrix {array.name} must be positive definite")


def _increasing(array: Tensor, group: Group) -> Iterator[Condition]:
    """Yield one condition per gap; SymPy takes a minute for the Min of fifty gaps."""
    for a, b in itertools.pairwise(group.elements(array.name).values()):
        shown = f"{a.name} = {{{a.name}:g}}, {b.name} = {{{b.name}:g}}"
        yield Condition(b - a, f"the points {array.name} must increase: {shown}")
