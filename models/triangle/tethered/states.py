# SPDX-License-Identifier: Apache-2.0
"""States and inputs of the triangle whose masses hang on tethers: how much tether is out, and how fast reels turn."""

from __future__ import annotations

from ...system import Group, Quantity
from ..dynamic import states as rods

OUT = tuple(
    Quantity(f"s{k}", "m", f"natural length of tether {k} that is out", f"s_{k}", positive=True) for k in (1, 2, 3)
)
REELS = tuple(Quantity(f"u_s{k}", "m/s", f"rate at which reel {k} pays out", f"s_{k}'") for k in (1, 2, 3))
STATES = Group("x", (*rods.STATES, *OUT, *REELS))
WINDING = tuple(
    Quantity(f"reel{k}", "m/s", f"rate that reel {k} is asked for, positive where it pays out", f"w_{k}")
    for k in (1, 2, 3)
)
INPUTS = Group("u", WINDING + rods.THRUST)
TENSIONS = tuple(Quantity(f"T{k}", "N", f"tension of tether {k}", f"T_{k}") for k in (1, 2, 3))

out = tuple(q.symbol for q in OUT)
reels = tuple(q.symbol for q in REELS)
winding = tuple(q.symbol for q in WINDING)
