# SPDX-License-Identifier: Apache-2.0
"""The paper's circular orbit.

Orbit axes: x along the motion, y opposite to the orbit normal, z to nadir.
"""

from __future__ import annotations

import sympy as sp

from ..mechanics import frame_turn
from ..system import Expr, Group, Quantity

LATITUDE = Quantity("latitude", "rad", "argument of latitude, the satellite's place on its orbit", r"\nu")


def circular_turning(omega0: Expr) -> sp.Matrix:
    """Return the rate of the orbit axes in their own components: about -y, as z is nadir and x is velocity."""
    return sp.Matrix([0, -omega0, 0])


def from_inertial() -> sp.Matrix:
    """Return the matrix from inertial to orbit axes, which coincide at latitude zero."""
    return frame_turn(1, -LATITUDE.symbol)


def magnetic_field(plant: Group) -> sp.Matrix:
    """Return the field of a dipole along the Earth's axis, in orbit axes, Wb/m^2."""
    latitude, tilt = LATITUDE.symbol, plant.inclination
    strength = plant.field_moment / plant.orbit_radius**3
    parts = (sp.cos(latitude) * sp.sin(tilt), -sp.cos(tilt), 2 * sp.sin(latitude) * sp.sin(tilt))
    return sp.Matrix([strength * part for part in parts])


def sun(plant: Group) -> sp.Matrix:
    """Return the direction of the Sun in orbit axes; it is fixed, and never eclipsed."""
    along, up = plant.sun_latitude - LATITUDE.symbol, plant.sun_elevation
    return sp.Matrix([sp.cos(up) * sp.sin(along), -sp.sin(up), -sp.cos(up) * sp.cos(along)])
