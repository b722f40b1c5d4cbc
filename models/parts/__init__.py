# SPDX-License-Identifier: Apache-2.0
"""Parts of a spacecraft, the spacecraft that is assembled from them, and what a part of one's own is made of."""

from .bobs import Bob
from .control import Law
from .craft import Spacecraft
from .environment import Dipole, Drag, GravityGradient, Magnetorquer, Orbit, SunPressure
from .frame import point_inertia
from .hub import ExternalForce, Hub, PointMass, Thruster, Torquer
from .joints import Hinge, Slider
from .modes import Mode, Modes
from .part import Aggregates, Contribution, Coordinate, Load, Mounted, Part
from .sensors import Gyro, Instrument, Magnetometer, StarTracker, SunSensor, Tachometer
from .values import Number, Tensor, Value, Vector, direction, place, scalar, tensor, vector
from .wheels import Wheel

__all__ = [
    "Aggregates",
    "Bob",
    "Contribution",
    "Coordinate",
    "Dipole",
    "Drag",
    "ExternalForce",
    "GravityGradient",
    "Gyro",
    "Hinge",
    "Hub",
    "Instrument",
    "Law",
    "Load",
    "Magnetometer",
    "Magnetorquer",
    "Mode",
    "Modes",
    "Mounted",
    "Number",
    "Orbit",
    "Part",
    "PointMass",
    "Slider",
    "Spacecraft",
    "StarTracker",
    "SunPressure",
    "SunSensor",
    "Tachometer",
    "Tensor",
    "Thruster",
    "Torquer",
    "Value",
    "Vector",
    "Wheel",
    "direction",
    "place",
    "point_inertia",
    "scalar",
    "tensor",
    "vector",
]
