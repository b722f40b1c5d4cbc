# SPDX-License-Identifier: Apache-2.0
"""Parts of a spacecraft, the assembled spacecraft, and the base class for parts of your own."""

from .bobs import Bob
from .control import AttitudeFilter, Law
from .craft import Spacecraft
from .environment import (
    Dipole,
    Drag,
    Eclipse,
    GravityGradient,
    GroundStation,
    Magnetorquer,
    Orbit,
    SunGravity,
    SunPressure,
    ThirdBody,
)
from .frame import point_inertia
from .hub import ExternalForce, Hub, PointMass, Thruster, Torquer
from .joints import Hinge, Joint, Slider
from .mechanisms import (
    Cable,
    Chain,
    ControlMomentGyro,
    Engine,
    Link,
    Pendulum,
    Rod,
    SprungMass,
    Tank,
    Tether,
    UnbalancedWheel,
)
from .modes import Mode, Modes
from .part import Aggregates, Contribution, Coordinate, Load, Mounted, Part
from .sensors import Accelerometer, Gyro, Instrument, Magnetometer, StarTracker, SunSensor, Tachometer
from .values import Number, Tensor, Value, Vector, direction, place, scalar, tensor, vector
from .wheels import Wheel

__all__ = [
    "Accelerometer",
    "Aggregates",
    "AttitudeFilter",
    "Bob",
    "Cable",
    "Chain",
    "Contribution",
    "ControlMomentGyro",
    "Coordinate",
    "Dipole",
    "Drag",
    "Eclipse",
    "Engine",
    "ExternalForce",
    "GravityGradient",
    "GroundStation",
    "Gyro",
    "Hinge",
    "Hub",
    "Instrument",
    "Joint",
    "Law",
    "Link",
    "Load",
    "Magnetometer",
    "Magnetorquer",
    "Mode",
    "Modes",
    "Mounted",
    "Number",
    "Orbit",
    "Part",
    "Pendulum",
    "PointMass",
    "Rod",
    "Slider",
    "Spacecraft",
    "SprungMass",
    "StarTracker",
    "SunGravity",
    "SunPressure",
    "SunSensor",
    "Tachometer",
    "Tank",
    "Tensor",
    "Tether",
    "ThirdBody",
    "Thruster",
    "Torquer",
    "UnbalancedWheel",
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
