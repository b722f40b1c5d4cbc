# SPDX-License-Identifier: Apache-2.0
"""Time in a law: its functions receive the reference, so time becomes an element of that."""

from __future__ import annotations

from dataclasses import replace

from .derivation import free_symbols
from .quantities import TIME, Group
from .system import Controller, Expr, System


def with_clock(system: System) -> System:
    """Return a system whose laws find time in the reference; the same system where no law uses time."""
    loops = (entry for variant in system.variants for loop in variant.loops.values() for entry in loop)
    used = free_symbols([*loops, *(e for law in system.controllers for e in _expressions(law))], system.definitions)
    if TIME.symbol not in used or TIME in system.references.quantities:
        return system
    references = Group(system.references.name, (*system.references.quantities, TIME))
    return replace(system, references=references, reference=(*system.reference, TIME.symbol))


def _expressions(law: Controller) -> tuple[Expr, ...]:
    return (*law.command, *law.start, *law.update, *(output.value for output in law.outputs))
