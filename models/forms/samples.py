# SPDX-License-Identifier: Apache-2.0
"""Times counted in samples: intervals between commands, delays of inputs.

A law that commands only at every n-th sample, but updates its memory at each, is converted: its memory also stores
the last command and the samples since then. Every backend and board that runs laws with memory can run the result.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

import sympy as sp

from ..quantities import Group, Located, Quantity
from ..system import Condition, Controller, Expr, System

HELD_FOR = Quantity("held_for", "1", "samples since the last new command")
_Part = TypeVar("_Part", bound=Located)
_WHOLE = sp.Rational(1, 10**9)
"""Tolerance for decimals that should be whole numbers, as in runtime/run/ticks.py."""


def with_samples(system: System) -> System:
    """Return a system whose laws command at each sample and whose delays must be whole numbers of samples."""
    if system.delays:
        counts = dict.fromkeys(system.delays.values())
        whole = (
            _whole(q.symbol, q.name, f"an input acts {q.name} samples later")
            for q in system.parameters
            if q.name in counts
        )
        system = _located(replace(system, constraints=(*system.constraints, *whole)), system)
    if not any(law.every for law in system.controllers):
        return system
    laws = tuple(_located(_held(system, law), law) if law.every else law for law in system.controllers)
    return _located(replace(system, controllers=laws), system)


def _located(part: _Part, original: _Part) -> _Part:
    """Return a derived part with the origin of its source, for messages."""
    object.__setattr__(part, "origin", original.origin)
    return part


def _held(system: System, law: Controller) -> Controller:
    """Return a law that commands once in `every` samples and keeps its command in memory meanwhile."""
    commanded = system.actuator.commanded if system.actuator else system.inputs
    held = tuple(Quantity(f"{q.name}_held", q.unit, f"{q.description}, held") for q in commanded)
    every = next(q.symbol for q in law.parameters if q.name == law.every)
    new = HELD_FOR.symbol < sp.Rational(1, 2)
    last = HELD_FOR.symbol + sp.Rational(3, 2) > every
    command = tuple(sp.Piecewise((entry, new), (q.symbol, True)) for entry, q in zip(law.command, held, strict=True))
    whole = _whole(every, law.every, f"the law commands once in {law.every} samples")
    return replace(
        law,
        memory=Group("z", (*law.memory.quantities, *held, HELD_FOR)),
        command=command,
        start=(*law.start, *(sp.S.Zero for _ in held), sp.S.Zero),
        update=(*law.update, *commanded.symbols, sp.Piecewise((sp.S.Zero, last), (HELD_FOR.symbol + 1, True))),
        constraints=(*law.constraints, whole),
        every="",
    )


def _whole(count: sp.Symbol, name: str, reason: str) -> Condition:
    return Condition(whole_number_margin(count), f"{name} = {{{name}:g}} must be a whole number: {reason}")


def whole_number_margin(count: Expr) -> Expr:
    """Return an expression that is positive if a value is a whole number."""
    return _WHOLE - sp.Abs(count - sp.floor(count + sp.Rational(1, 2)))
