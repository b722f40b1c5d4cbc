# SPDX-License-Identifier: Apache-2.0
"""Vector width of this processor in doubles, with the compiler flags for it."""

from __future__ import annotations

import functools
import platform
from pathlib import Path

_WIDTHS = (
    (8, ("avx512f", "avx512dq", "avx512vl", "avx512bw", "avx2", "fma")),
    (4, ("avx2", "fma")),
)
"""Numbers of lanes and their instruction sets, of which the widest supported one is used."""


@functools.cache
def widest() -> int:
    """Return the number of doubles in the widest supported registers: 8, 4 or 2."""
    instructions = _instructions()
    return next((lanes for lanes, needed in _WIDTHS if instructions.issuperset(needed)), 2)


@functools.cache
def vector_flags() -> tuple[str, ...]:
    """Return compiler flags for this processor's instructions; none for an unknown one."""
    names = dict(_WIDTHS).get(widest(), ())
    wide = ("-mprefer-vector-width=512",) if widest() == 8 else ()
    return (*(f"-m{name}" for name in names), *wide)


def _instructions() -> frozenset[str]:
    """Return the processor's features as reported by the operating system; empty if unknown."""
    if platform.machine().lower() not in ("x86_64", "amd64"):
        return frozenset()
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return frozenset()
    lines = [line.partition(":")[2].split() for line in text.splitlines() if line.startswith("flags")]
    return frozenset.intersection(*map(frozenset, lines)) if lines else frozenset()
