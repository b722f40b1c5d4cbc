# SPDX-License-Identifier: Apache-2.0
"""How a name such as `lyapunov-v1` stands in code."""

from __future__ import annotations

import re


def identifier(name: str) -> str:
    """Return the C and Python identifier of a name: what is neither letter, digit nor underscore becomes one."""
    return re.sub(r"\W", "_", name, flags=re.ASCII)
