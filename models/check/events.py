# SPDX-License-Identifier: Apache-2.0
"""Check of events: unique names, guards with a zero crossing, resets of states only."""

from __future__ import annotations

from collections.abc import Iterable

from mehvar.base.manifest import ENDS

from ..events import Event
from ..quantities import ModelError
from ..system import System
from .names import check_name, check_text


def check_events(system: System) -> None:
    """Refuse events that cannot occur, and resets of anything but states."""
    for event in system.events:
        _check_reset(system, event)
    for law in system.controllers:
        for event in law.events:
            where = f"{event.origin}: event {event.name!r} of law {law.name!r}"
            if law.period:
                raise ModelError(f"{where} would be ignored: a sampled law switches only at its samples")
            if event.reset or event.ends:
                raise ModelError(
                    f"{where}: an event of a law can neither reset states nor end the run; "
                    "declare it among the system's events"
                )
        _check_distinct((*system.events, *law.events))
    _check_distinct(system.events)


def _check_reset(system: System, event: Event) -> None:
    where = f"{event.origin}: event {event.name!r}"
    states = {q.symbol: q.name for q in system.states}
    for symbol in event.reset:
        if symbol not in states:
            raise ModelError(
                f"{where}: reset of {symbol!r}: must be the symbol of a state: {', '.join(states.values())}"
            )


def _check_distinct(events: Iterable[Event]) -> None:
    """Refuse events with an invalid direction, end, name or title, and names that occur twice."""
    seen: set[str] = set()
    for event in events:
        where = f"{event.origin}: event {event.name!r}"
        if event.outcome not in ENDS or event.ends == "":
            raise ModelError(f"{where}: ends = {event.ends!r}: must be False, True, 'failure' or 'success'")
        check_name(event.name, f"{event.origin}: event")
        if event.name in seen:
            raise ModelError(f"{where} is defined twice")
        check_text(event.title, f"{where}: title")
        seen.add(event.name)
