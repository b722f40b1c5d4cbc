# SPDX-License-Identifier: Apache-2.0
"""The models that come with the package, derived once for all tests."""

from __future__ import annotations

import functools

from mehvar.physics.machine import Machine
from tests.derived import system
from tests.sampling import RANGES


@functools.cache
def machine(model: str, *structure: tuple[str, str]) -> Machine:
    """Derive a model; the structure as pairs of choice and value."""
    return Machine(system(model, **dict(structure)), RANGES[model])
