# SPDX-License-Identifier: Apache-2.0
"""Parts of a spacecraft, and the spacecraft that is assembled from them."""

from .bobs import Bob
from .craft import Spacecraft
from .hub import ExternalForce, Hub, PointMass, Thruster, Torquer
from .joints import Hinge, Slider
from .modes import Mode, Modes
from .values import Value
from .wheels import Wheel

__all__ = [
    "Bob",
    "ExternalForce",
    "Hinge",
    "Hub",
    "Mode",
    "Modes",
    "PointMass",
    "Slider",
    "Spacecraft",
    "Thruster",
    "Torquer",
    "Value",
    "Wheel",
]
