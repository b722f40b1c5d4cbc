# SPDX-License-Identifier: Apache-2.0
"""Rotations, rates and equations of motion in SymPy, for models and ledgers."""

from __future__ import annotations

from mehvar.models.mechanics import (
    angle_rates,
    angular_velocity,
    frame_turn,
    kirchhoff,
    lagrange,
    matrix_rate,
    planar_cross,
    quaternion_of_turns,
    quaternion_product,
    quaternion_rates,
    quaternion_rotation,
    time_derivative,
)

__all__ = [
    "angle_rates",
    "angular_velocity",
    "frame_turn",
    "kirchhoff",
    "lagrange",
    "matrix_rate",
    "planar_cross",
    "quaternion_of_turns",
    "quaternion_product",
    "quaternion_rates",
    "quaternion_rotation",
    "time_derivative",
]
