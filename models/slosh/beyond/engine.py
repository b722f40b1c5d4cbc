# SPDX-License-Identifier: Apache-2.0
"""The engine on its gimbals: they follow their commands with a lag, within limits of rate and angle."""

from __future__ import annotations

import sympy as sp

from ...system import Derivation, Expr, Group, Quantity
from ..plant.equations import thrust
from ..states import GIMBALS

ANGLES = (
    Quantity("gimbal1", "rad", "gimbal angle of the thrust in the x-z plane as it is", r"g_1"),
    Quantity("gimbal2", "rad", "gimbal angle of the thrust towards y as it is", r"g_2"),
)


def acting(p: Group, d: Derivation) -> sp.Matrix:
    """Define the thrust at the gimbals' angles, N."""
    d.section("Engine")
    at = {q.symbol: angle.symbol for q, angle in zip(GIMBALS, ANGLES, strict=True)}
    return sp.Matrix(
        [
            d.define(f"thrust_{axis}", entry, title=f"thrust, body {axis}", unit="N", latex=rf"\tau_{{t,{axis}}}")
            for axis, entry in zip("xyz", thrust(p).xreplace(at), strict=True)
        ]
    )


def gimbal_rates(p: Group, d: Derivation) -> tuple[Expr, ...]:
    """Return the rates of the gimbal angles for their commands."""
    rates = []
    for k, (command, angle, limit) in enumerate(zip(GIMBALS, ANGLES, (p.delta1_max, p.delta2_max), strict=True), 1):
        target = clip(command.symbol, limit)
        error = d.define(f"gimbal_error{k}", target - angle.symbol, title=f"error of gimbal {k}", unit="rad")
        rates.append(clip(error / p.lag, p.gimbal_rate))
    return tuple(rates)


def clip(value: Expr, limit: Expr) -> Expr:
    """Return a value within -limit and limit."""
    return sp.Max(-limit, sp.Min(limit, value))
