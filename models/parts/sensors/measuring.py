# SPDX-License-Identifier: Apache-2.0
"""Measurements of all sensors of a craft, and the changes of their states at samples."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import sympy as sp

from ...derivation import Expr
from ...quantities import Group, Quantity
from ...system import Controller, RandomStep, Sensor
from ..part import Mounted, Part
from ..terms import Jump, State
from .instruments import HALF, Instrument

Noise = dict[str, Quantity]
"""Random numbers by their names, in the order of use."""


def measuring(parts: Sequence[tuple[Part, Mounted]]) -> Sensor | None:
    """Return the measurements of laws; None for a craft without sensors, whose laws receive the state."""
    noise: Noise = {}
    measured: list[Expr] = []
    seen: list[Quantity] = []
    for part, at in parts:
        if isinstance(part, Instrument):
            queue = part.queue()
            measured += [q.symbol for q in queue[-1]] if queue else _measurement(part, at, noise)
            seen += part.shown()
    return Sensor(Group("e", tuple(noise.values())), tuple(measured), Group("seen", tuple(seen))) if seen else None


def _measurement(part: Instrument, at: Mounted, noise: Noise) -> list[Expr]:
    """Return what a sensor shows at a sample without delay, and add its random numbers to `noise`."""
    labels = [f"{part.name}_e{k + 1}" for k in range(len(part.errors(at)))]
    sizes = dict(zip(labels, part.errors(at), strict=True))
    drawn = {n: Quantity(n, "1", f"error of {part.name}") for n, size in sizes.items() if size != 0}
    noise |= drawn
    errors = [size * drawn[n].symbol if n in drawn else size for n, size in sizes.items()]
    values = list(part.measured(at, errors))
    if part.steady:
        return values
    noise |= {q.name: q for q in part.lots}
    new = at.define("now", sp.Piecewise((1, part.measures(at)), (0, True)), part.new.description, "1")
    return [new, *(sp.Piecewise((value, new > HALF), (0, True)) for value in values)]


def drifting(parts: Sequence[tuple[Part, Mounted]], states: Sequence[State]) -> RandomStep | None:
    """Return the changes of the parts' states at a sample; None without such states."""
    noise: Noise = {}
    after: dict[sp.Symbol, Expr] = {}
    for part, at in parts:
        after |= {jump.state.symbol: _changed(jump, noise) for jump in part.jumps(at)}
        if isinstance(part, Instrument) and (queue := part.queue()):
            newest = [e.xreplace(after) for e in _measurement(part, at, noise)]
            older = [q.symbol for row in queue[:-1] for q in row]
            after |= dict(zip((q.symbol for row in queue for q in row), (*newest, *older), strict=True))
    symbols = [state.quantity.symbol for state in states]
    return RandomStep(Group("e", tuple(noise.values())), tuple(after.get(s, s) for s in symbols)) if after else None


def _changed(jump: Jump, noise: Noise) -> Expr:
    """Return the value of a state after a sample, and add its random number to `noise`."""
    if jump.size == 0:
        return jump.after
    q = Quantity(f"{jump.state.name}_e", "1", f"change of the {jump.state.description}")
    noise[q.name] = q
    return jump.after + jump.size * q.symbol


def watching(sensor: Sensor, parts: Sequence[Part], inputs: int, period: str) -> Controller:
    """Return the law without commands that stores the sensors' last measurements."""
    count = Quantity("samples", "1", "samples so far")
    flags = {q: part.new for part in parts if isinstance(part, Instrument) and not part.steady for q in part.seen()}
    kept = Group("z", (*(replace(q, name=f"{q.name}_shown") for q in sensor.seen), count))
    none = (sp.S.Zero,)
    last = [
        sp.Piecewise((q.symbol, flags[q].symbol > HALF), (k.symbol, True)) if q in flags else q.symbol
        for q, k in zip(sensor.seen, kept, strict=False)
    ]
    return Controller(
        "watch", "commands nothing, keeps what the sensors show", Group("c", ()), none * inputs, period=period,
        memory=kept, start=none * len(kept), update=(*last, count.symbol + 1),
    )  # fmt: skip
