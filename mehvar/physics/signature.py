# SPDX-License-Identifier: Apache-2.0
"""Search for idle parameters, whose small change affects no result of any function."""

from __future__ import annotations

import numpy as np

from mehvar.base.names import identifier
from mehvar.codegen.functions.requests import Request
from mehvar.physics.machine import Machine, draw

CHANGE = 0.01
"""Relative change of a parameter, far above rounding and small enough for its bounds."""
NOISE = 1e-12
"""Relative change of a result that counts as rounding; each operation contributes about 1e-15."""
_GROUPS = ("p", "s", "c")
_SIZES = (40, 1500)
"""Numbers of points that are tried one after the other."""


def idle_parameters(subject: Machine) -> list[str]:
    """Return the parameters of plant, scenario and laws that have no effect at random points.

    Most parameters show an effect at a few points, but those of switches need many. In a sampled adaptive law with a
    dead zone and a floor, four parameters seem idle at 40 points, two at 750 and none at 1500. A law's period only
    affects runs.
    """
    everything: set[str] = set()
    active = {law.period for law in subject.system.controllers}
    for n in _SIZES:
        for request in filter(_counts, subject.requests.values()):
            for place, group in enumerate(request.arguments):
                if group.name in _GROUPS:
                    owner = _owner(subject, request, group.name)
                    names = [f"{owner}{q.name}" for q in group]
                    everything |= set(names)
                    waiting = {k: name for k, name in enumerate(names) if name not in active}
                    active |= _active(subject, request, place, waiting, n)
    return sorted(everything - active)


def _counts(request: Request) -> bool:
    """Return True if a function affects a run; constraints only refuse runs."""
    return request.name == "limits" or all(name != "margin" for name, _ in request.results)


def _active(subject: Machine, request: Request, place: int, waiting: dict[int, str], n: int) -> set[str]:
    """Return the elements of an argument that change the function's result."""
    if not waiting:
        return set()
    rng = np.random.default_rng(sum(map(ord, request.name)))
    values = [draw(subject.ranges, group, n, rng) for group in request.arguments]
    before, active = subject(request.name, *values), set()
    for k, name in waiting.items():
        changed = [v.copy() for v in values]
        changed[place][:, k] *= 1 + CHANGE
        if np.any(np.abs(subject(request.name, *changed) - before) > NOISE * np.abs(before)):
            active.add(name)
    return active


def _owner(subject: Machine, request: Request, group: str) -> str:
    """Return the law of a parameter, whose name other laws may use too."""
    if group != "c":
        return ""
    tags = {identifier(law.name): law.name for law in subject.system.controllers}
    longest = max((tag for tag in tags if request.name.startswith(tag)), key=len)
    return f"{tags[longest]}: "
