# SPDX-License-Identifier: Apache-2.0
"""Spacecraft with sloshing fuel as spherical pendulums: full and reduced model, two Lyapunov laws."""

from .system import STRUCTURE, system

__all__ = ["STRUCTURE", "system"]
