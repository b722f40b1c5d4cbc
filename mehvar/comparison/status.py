# SPDX-License-Identifier: Apache-2.0
"""What became of a model between two versions."""

from __future__ import annotations

from enum import StrEnum


class ModelStatus(StrEnum):
    """What became of a model, in one word."""

    SAME = "same"
    PARAMETERS = "parameters changed"
    UNDECIDED = "undecided"
    CHANGED = "changed"
    ADDED = "added"
    REMOVED = "removed"
