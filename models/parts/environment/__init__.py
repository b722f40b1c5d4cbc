# SPDX-License-Identifier: Apache-2.0
"""The orbit of a spacecraft, and what gravity, the Earth's field, air and sunlight do to it."""

from .loads import Dipole, Drag, GravityGradient, Magnetorquer, SunPressure
from .orbit import Orbit, Sky, sky

__all__ = ["Dipole", "Drag", "GravityGradient", "Magnetorquer", "Orbit", "Sky", "SunPressure", "sky"]
