# SPDX-License-Identifier: Apache-2.0
"""Sensors of a spacecraft."""

from .inertial import Accelerometer, Gyro
from .instruments import Instrument, Magnetometer, StarTracker, SunSensor, Tachometer
from .measuring import drifting, measuring, watching

__all__ = [
    "Accelerometer", "Gyro", "Instrument", "Magnetometer", "StarTracker", "SunSensor", "Tachometer", "drifting",
    "measuring", "watching",
]  # fmt: skip
