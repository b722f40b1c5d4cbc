# SPDX-License-Identifier: Apache-2.0
"""Mechanisms: rotors, pendulums, chains of bodies, draining tanks, engines, tethers."""

from .chains import Chain, Link
from .engines import Engine
from .pendulums import Pendulum, SprungMass
from .rotors import ControlMomentGyro, UnbalancedWheel
from .tanks import Tank
from .tethers import Cable, Rod, Tether

__all__ = [
    "Cable",
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
