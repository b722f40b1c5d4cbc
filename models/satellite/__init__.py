# SPDX-License-Identifier: Apache-2.0
"""Three-axis satellite attitude in orbit, under sampled adaptive control and PD."""

from .structure import STRUCTURE
from .system import system

__all__ = ["STRUCTURE", "system"]
