# SPDX-License-Identifier: Apache-2.0
"""Parts of a spacecraft, and the spacecraft that is assembled from them."""

from .bobs import Bob as Bob
from .craft import Spacecraft as Spacecraft
from .hub import ExternalForce as ExternalForce
from .hub import Hub as Hub
from .hub import PointMass as PointMass
from .hub import Torquer as Torquer
from .modes import Mode as Mode
from .modes import Modes as Modes
from .values import Value as Value
from .wheels import Wheel as Wheel
