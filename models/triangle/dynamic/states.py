# SPDX-License-Identifier: Apache-2.0
"""Names of the states and inputs of the dynamic triangle."""

from __future__ import annotations

import sympy as sp

from ...system import Group, Quantity
from ..dynamics import LENGTHS, RATES

HEADING = Quantity("psi", "rad", "direction of rod 3, from mass 1 to mass 2, counter-clockwise", r"\psi")
MOMENTUM = Quantity("H", "kg m^2/s", "angular momentum about the centre of mass", "H")
ANOMALY = Quantity("nu", "rad", "true anomaly: direction of the triangle from the Earth", r"\nu")
DRIFT = (
    Quantity("vx", "m/s", "velocity along x that thrust has given the centre of mass", "v_x"),
    Quantity("vy", "m/s", "velocity along y that thrust has given the centre of mass", "v_y"),
)
COSTS = (
    Quantity("work", "J", "work of the rods' drives, with either sign counted", "W"),
    Quantity("impulse", "N s", "impulse of the thrusters, with either sign counted", "J"),
)
STATES = Group("x", (*LENGTHS, HEADING, *RATES, MOMENTUM, ANOMALY, *DRIFT, *COSTS))

FORCES = tuple(Quantity(f"F{k}", "N", f"force of rod {k}, positive where it pushes", f"F_{k}") for k in (1, 2, 3))
THRUST = tuple(
    Quantity(f"f{i}{axis}", "N", f"thrust on mass {i}, {way} rod 3", f"f_{{{i}{axis}}}")
    for i in (1, 2, 3)
    for axis, way in (("x", "along"), ("y", "across"))
)
INPUTS = Group("u", FORCES + THRUST)

lengths = tuple(q.symbol for q in LENGTHS)
rates = tuple(q.symbol for q in RATES)
forces = sp.Matrix([q.symbol for q in FORCES])
thrust = tuple(sp.Matrix([THRUST[2 * i].symbol, THRUST[2 * i + 1].symbol]) for i in range(3))
