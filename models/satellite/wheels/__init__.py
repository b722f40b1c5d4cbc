# SPDX-License-Identifier: Apache-2.0
"""Reaction wheels, along the body axes or in other directions, balanced or not."""

from .imbalance import accelerations, extra_energy, extra_momentum
from .sets import FEWEST, MOMENTA, TORQUES, Wheels, along_any, along_axes, has_lengths, spanning, unbalanced

__all__ = [
    "FEWEST",
    "MOMENTA",
    "TORQUES",
    "Wheels",
    "accelerations",
    "along_any",
    "along_axes",
    "extra_energy",
    "extra_momentum",
    "has_lengths",
    "spanning",
    "unbalanced",
]
