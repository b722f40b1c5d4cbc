# SPDX-License-Identifier: Apache-2.0
"""Three planar masses joined by rods of variable length: attitude control by change of shape."""

from .system import STRUCTURE, system

__all__ = ["STRUCTURE", "system"]
