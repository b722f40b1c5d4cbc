# SPDX-License-Identifier: Apache-2.0
"""Pictures of runs and batches in a common style: figures, axis labels, colours."""

from __future__ import annotations

from .style import (
    BLACK,
    BLUE,
    COLORS,
    GREEN,
    GREY,
    LIGHT,
    ORANGE,
    PURPLE,
    SKY,
    VERMILLION,
    headline,
    label,
    new_figure,
    time_axis,
)

__all__ = [
    "BLACK",
    "BLUE",
    "COLORS",
    "GREEN",
    "GREY",
    "LIGHT",
    "ORANGE",
    "PURPLE",
    "SKY",
    "VERMILLION",
    "headline",
    "label",
    "new_figure",
    "time_axis",
]
