# SPDX-License-Identifier: Apache-2.0
"""Check that a system has no features that exclude one another."""

from __future__ import annotations

from collections.abc import Iterator

from mehvar.base.capabilities import (
    ACTUATOR,
    ALGEBRAIC,
    CHART,
    CHOICES,
    DERIVED_RATES,
    EVENTS,
    EXCLUSIONS,
    INTEGRATED,
    MASS,
    PROCESS_NOISE,
    RESETS,
    SEEN,
    Feature,
    Names,
)

from ..forms import algebraic_rows, has_rates
from ..quantities import Located, ModelError
from ..system import System


def check_beside(system: System) -> None:
    """Refuse features that cannot stand beside one another."""
    present = {feature: (part.origin, feature.listed(names)) for feature, part, names in _features(system) if names}
    for one, other, reason in EXCLUSIONS:
        if one in present and other in present:
            origin, words = present[one]
            raise ModelError(f"{origin}: {words} cannot stand beside {other.name}: {reason}")


def _features(system: System) -> Iterator[tuple[Feature, Located, Names]]:
    """Yield features, the part of the system that declares each, and the names of what has it, if any."""
    events = [*system.events, *(event for law in system.controllers for event in law.events)]
    continuous = any(not law.period for law in system.controllers)
    sensor, actuator, diffusion = system.sensor or system, system.actuator or system, system.diffusion or system
    yield MASS, system, system.mass is not None
    yield ALGEBRAIC, system, [system.states.quantities[k].name for k in algebraic_rows(system)]
    yield DERIVED_RATES, system, bool(system.residual or system.rates) and not has_rates(system)
    yield EVENTS, events[0] if events else system, [event.name for event in events]
    yield RESETS, system, [event.name for event in events if event.reset]
    yield PROCESS_NOISE, diffusion, system.diffusion is not None
    yield CHART, system.coordinates or system, system.coordinates is not None
    yield ACTUATOR, actuator, continuous and system.actuator is not None
    yield SEEN, sensor, continuous and system.seen is not system.states
    yield CHOICES, system, [choice.name for choice in system.choices]
    yield INTEGRATED, system, [law.name for law in system.controllers if law.rates]
