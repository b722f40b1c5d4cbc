# SPDX-License-Identifier: Apache-2.0
"""Parts that move in ways of their own: rotors, pendulums, chains of bodies, draining tanks, engines, tethers."""

from .chains import Chain, Link
from .engines import Engine
from .pendulums import Pendulum, SprungMass
from .rotors import ControlMomentGyro, UnbalancedWheel
from .tanks import Tank
from .tethers import Rod, Tether

__all__ = [
    "Chain",
    "ControlMomentGyro",
    "Engine",
    "Link",
    "Pendulum",
    "Rod",
    "SprungMass",
    "Tank",
    "Tether",
    "UnbalancedWheel",
]
