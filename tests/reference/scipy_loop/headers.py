# SPDX-License-Identifier: Apache-2.0
"""Numbers of the headers in native, by which the loop in C goes."""

from __future__ import annotations

import re

from mehvar.runtime.compiling.library import NATIVE

_NUMBER = re.compile(r"^#define (\w+) ([\d.e+-]+)$", re.MULTILINE)


def numbers(header: str) -> dict[str, float]:
    """Return a header's numeric macros by name."""
    return {name: float(value) for name, value in _NUMBER.findall((NATIVE / header).read_text(encoding="utf-8"))}
