# SPDX-License-Identifier: Apache-2.0
"""Sensors of a spacecraft."""

from .instruments import Gyro, Instrument, Magnetometer, StarTracker, SunSensor, Tachometer
from .measuring import drifting, measuring, watching

__all__ = [
    "Gyro", "Instrument", "Magnetometer", "StarTracker", "SunSensor", "Tachometer", "drifting", "measuring", "watching",
]  # fmt: skip
