# SPDX-License-Identifier: Apache-2.0
"""Laws of a spacecraft, written in symbols, and how they share a torque among its actuators."""

from .filter import AttitudeFilter
from .law import Law, LawText

__all__ = ["AttitudeFilter", "Law", "LawText"]
