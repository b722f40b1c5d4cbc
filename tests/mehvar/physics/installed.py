# SPDX-License-Identifier: Apache-2.0
"""The models that come with the package, derived once for all tests."""

from __future__ import annotations

import functools

from mehvar.codegen.generate import installed_tree, system_of
from mehvar.physics.machine import Machine
from tests.sampling import RANGES


@functools.cache
def machine(model: str, *structure: tuple[str, str]) -> Machine:
    """Derive a model; the structure as pairs of choice and value."""
    return Machine(system_of(installed_tree(), model, dict(structure)), RANGES[model])
