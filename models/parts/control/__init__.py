# SPDX-License-Identifier: Apache-2.0
"""Symbolic laws of a spacecraft, and allocation of torques to actuators."""

from .filter import AttitudeFilter
from .law import Law, LawText

__all__ = ["AttitudeFilter", "Law", "LawText"]
