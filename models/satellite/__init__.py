# SPDX-License-Identifier: Apache-2.0
"""Three-axis satellite attitude in orbit, under sampled adaptive control and PD."""

from .system import STRUCTURE, system

__all__ = ["STRUCTURE", "system"]
