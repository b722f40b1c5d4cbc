# SPDX-License-Identifier: Apache-2.0
"""Orbit of a spacecraft, and its environment: gravity, magnetic field, air and sunlight."""

from .bodies import ThirdBody
from .loads import Dipole, Drag, GravityGradient, Magnetorquer, SunPressure
from .orbit import Orbit, Sky, sky

__all__ = ["Dipole", "Drag", "GravityGradient", "Magnetorquer", "Orbit", "Sky", "SunPressure", "ThirdBody", "sky"]
