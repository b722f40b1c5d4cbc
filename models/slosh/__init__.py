# SPDX-License-Identifier: Apache-2.0
"""Spacecraft with sloshing fuel as spherical pendulums, steered by its thrust: full and reduced model, Lyapunov laws."""

from models.slosh.system import STRUCTURE, system

__all__ = ["STRUCTURE", "system"]
