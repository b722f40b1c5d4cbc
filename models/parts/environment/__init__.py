# SPDX-License-Identifier: Apache-2.0
"""Orbit of a spacecraft, and its environment: gravity, magnetic field, air and sunlight."""

from .bodies import SunGravity, ThirdBody
from .loads import Dipole, Drag, GravityGradient, Magnetorquer, SunPressure
from .orbit import Orbit, Sky, sky
from .sights import Eclipse, GroundStation

__all__ = [
    "Dipole", "Drag", "Eclipse", "GravityGradient", "GroundStation", "Magnetorquer", "Orbit", "Sky", "SunGravity",
    "SunPressure", "ThirdBody", "sky",
]  # fmt: skip
