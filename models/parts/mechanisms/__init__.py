# SPDX-License-Identifier: Apache-2.0
"""Mechanisms: rotors, joints, flexible modes, pendulums, chains of bodies, draining tanks, engines, tethers."""

from .bobs import Bob
from .chains import Chain, Link
from .engines import Engine
from .joints import Hinge, Joint, Slider
from .modes import Mode, Modes
from .pendulums import Pendulum, SprungMass
from .rotors import ControlMomentGyro, UnbalancedWheel
from .tanks import Tank
from .tethers import Cable, Rod, Tether
from .wheels import Wheel

__all__ = [
    "Bob",
    "Cable",
    "Chain",
    "ControlMomentGyro",
    "Engine",
    "Hinge",
    "Joint",
    "Link",
    "Mode",
    "Modes",
    "Pendulum",
    "Rod",
    "Slider",
    "SprungMass",
    "Tank",
    "Tether",
    "UnbalancedWheel",
    "Wheel",
]
