# SPDX-License-Identifier: Apache-2.0
"""Reaction wheels, along the body axes or in other directions, balanced or not."""

from .rotors import speed
from .sets import FEWEST, MOMENTA, TORQUES, Wheels, along_any, along_axes, has_lengths, off_balance, spanning

__all__ = [
    "FEWEST",
    "MOMENTA",
    "TORQUES",
    "Wheels",
    "along_any",
    "along_axes",
    "has_lengths",
    "off_balance",
    "spanning",
    "speed",
]
