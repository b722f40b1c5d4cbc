# SPDX-License-Identifier: Apache-2.0
"""Parts of a spacecraft, and the spacecraft that is assembled from them."""

from .bobs import Bob
from .craft import Spacecraft
from .hub import ExternalForce
from .hub import Hub
from .hub import PointMass
from .hub import Torquer
from .joints import Hinge, Slider
from .modes import Mode
from .modes import Modes
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
    "Torquer",
    "Value",
    "Wheel",
]
