# SPDX-License-Identifier: Apache-2.0
"""Measurements of all sensors of a craft, and the random walks of their biases."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import sympy as sp

from ...derivation import Expr
from ...quantities import Group, Quantity
from ...system import Controller, RandomStep, Sensor
from ..part import Mounted, Part, State
from .instruments import HALF, Instrument


def measuring(parts: Sequence[tuple[Part, Mounted]]) -> Sensor | None:
    """Return the measurements of laws; None for a craft without sensors, whose laws receive the state."""
    noise: list[Quantity] = []
    measured: list[Expr] = []
    seen: list[Quantity] = []
    for part, at in parts:
        if isinstance(part, Instrument):
            labels = [f"{part.name}_e{k + 1}" for k in range(len(part.errors(at)))]
            sizes = dict(zip(labels, part.errors(at), strict=True))
            drawn = {n: Quantity(n, "1", f"error of {part.name}") for n, size in sizes.items() if size != 0}
            noise += drawn.values()
            errors = [size * drawn[n].symbol if n in drawn else size for n, size in sizes.items()]
            values = list(part.measured(at, errors))
            if part.steady:
                measured += values
                seen += part.seen()
                continue
            noise += part.lots
            new = at.define("now", sp.Piecewise((1, part.measures(at)), (0, True)), part.new.description, "1")
            measured += [new, *(sp.Piecewise((value, new > HALF), (0, True)) for value in values)]
            seen += (part.new, *part.seen())
    return Sensor(Group("e", tuple(noise)), tuple(measured), Group("seen", tuple(seen))) if seen else None


def drifting(parts: Sequence[tuple[Part, Mounted]], states: Sequence[State]) -> RandomStep | None:
    """Return the random walk of the sensors' biases; None if no bias walks."""
    walks = [w for part, at in parts if isinstance(part, Instrument) for w in part.drifts(at)]
    noise = {q.symbol: Quantity(f"{q.name}_e", "1", f"change of the {q.description}") for q, _ in walks}
    sizes = {q.symbol: size for q, size in walks}
    symbols = [state.quantity.symbol for state in states]
    after = tuple(s + sizes[s] * noise[s].symbol if s in sizes else s for s in symbols)
    return RandomStep(Group("e", tuple(noise.values())), after) if walks else None


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
