# SPDX-License-Identifier: Apache-2.0
"""Parts of an assembled system, as texts by which two versions are compared."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping

from .errors import shortened

Parts = Mapping[str, Mapping[str, str]]
"""Fields of each part as texts, by its name; the field "" is its class, and the part "" the whole assembly."""


_TEXT = r"""(?:'(?:[^'\\]|\\.)*'|"(?:[^"\\]|\\.)*")"""
_VALUE = re.compile(rf"Value\(default=([^,()]+), bounds={_TEXT}, source={_TEXT}\)")
"""A number with bounds and source, which the equations have with its parameter."""


def part_changes(old: Parts, new: Parts, unit_of: Callable[[str, str], str]) -> tuple[str, ...]:
    """List the differences of two assemblies part by part, such as "wheel2: axis (1, 0, 0) -> (0, 0, 1)".

    Parameters
    ----------
    old, new : Parts
        The assemblies.
    unit_of : callable
        Unit of a field, by class and name; empty for a field without unit.
    """
    lines = [f"{name}: removed" for name in old if name not in new]
    for name, part in new.items():
        before = old.get(name)
        head = f"{name}: " if name else ""
        if before is None:
            lines.append(f"{name}: added, a {part['']}")
        elif part.get("") != before.get(""):
            lines.append(f"{name}: a {before['']} -> a {part['']}")
        else:
            separator = ":" if not name else ""
            for field in {**before, **part}:
                a, b = (_VALUE.sub(r"\1", side.get(field, "none")) for side in (before, part))
                unit = unit_of(part[""], field) if name else ""
                sides = (text if text == "None" else f"{text} {unit}".strip() for text in map(shortened, (a, b)))
                lines += [f"{head}{field}{separator} {' -> '.join(sides)}"] * (a != b)
    return tuple(lines)
