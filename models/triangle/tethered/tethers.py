# SPDX-License-Identifier: Apache-2.0
"""Tether tensions: linear in strain and its rate when taut, zero when slack.

Strain of a tether of natural length s is l/s - 1. Its rate times s, what the damping sees, is l' - (l/s) s': a reel
that pays out lets go without loss. With reels at rest it is the rate of the length.
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from ...system import Derivation, Event, Expr, Group
from ..dynamic.states import lengths, rates
from .states import out, reels


@dataclass(frozen=True)
class Tethers:
    """Quantities of three tethers.

    Attributes
    ----------
    demands : tuple of Expr
        Tensions by strain and its rate; a tether is slack while its value is negative.
    tensions : tuple of Expr
        Actual tensions.
    speeds : tuple of Expr
        Rates at which stretched tether leaves the reels.
    energy : Expr
        Elastic energy of the tethers that are longer than their natural lengths.
    """

    demands: tuple[Expr, ...]
    tensions: tuple[Expr, ...]
    speeds: tuple[Expr, ...]
    energy: Expr


def tethers(p: Group, d: Derivation) -> Tethers:
    """Derive tension and energy."""
    d.section("Tethers")
    stretches = [
        d.define(
            f"stretch{k}",
            length / natural,
            title=f"length of tether {k} over its natural length",
            latex=rf"\lambda_{k}",
        )
        for k, (length, natural) in enumerate(zip(lengths, out, strict=True), 1)
    ]
    speeds = tuple(stretch * reel for stretch, reel in zip(stretches, reels, strict=True))
    demands = tuple(
        d.define(
            f"demand{k}",
            p.stiffness * (stretch - 1) + p.damping * (rate - speed),
            title=f"tension of tether {k} where positive",
            unit="N",
            latex=rf"T_{{{k},0}}",
        )
        for k, (stretch, rate, speed) in enumerate(zip(stretches, rates, speeds, strict=True), 1)
    )
    tensions = tuple(
        d.define(f"tension{k}", sp.Max(0, demand), title=f"tension of tether {k}", unit="N", latex=rf"T_{k}")
        for k, demand in enumerate(demands, 1)
    )
    each = (natural * sp.Max(0, stretch - 1) ** 2 for natural, stretch in zip(out, stretches, strict=True))
    return Tethers(demands, tensions, speeds, p.stiffness * sp.Add(*each) / 2)


def turns_slack_or_taut(tethers: Tethers) -> tuple[Event, ...]:
    """Return the surfaces on which a tether becomes slack or taut: no step of an integration crosses one."""
    return tuple(
        Event(f"tether{k}", demand, title=f"tether {k} becomes slack or taut")
        for k, demand in enumerate(tethers.demands, 1)
    )
