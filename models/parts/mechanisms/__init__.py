# SPDX-License-Identifier: Apache-2.0
"""Parts that move in ways of their own: rotors, pendulums, chains of bodies, draining tanks, tethers."""

from .chains import Chain, Link
from .pendulums import Pendulum, SprungMass
from .rotors import ControlMomentGyro, UnbalancedWheel
from .tanks import Tank
from .tethers import Rod, Tether

__all__ = ["Chain", "ControlMomentGyro", "Link", "Pendulum", "Rod", "SprungMass", "Tank", "Tether", "UnbalancedWheel"]
