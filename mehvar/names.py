# SPDX-License-Identifier: Apache-2.0
"""How a name such as `lyapunov-v1` stands in code."""

from __future__ import annotations

import re

RESULT_NAMES = frozenset(
    {"t", "run", "state", "variable", "final", "minimum", "maximum", "t_stop", "error", "steps", "violated", "status"}
)
"""What results and stores call their own variables and axes; no variable of a model has such a name."""


def identifier(name: str) -> str:
    """Return the C and Python identifier of a name: what is neither letter, digit nor underscore becomes one."""
    return re.sub(r"\W", "_", name, flags=re.ASCII)
