# SPDX-License-Identifier: Apache-2.0
"""Parts of an assembled system, as texts by which two versions are compared."""

from __future__ import annotations

from collections.abc import Mapping

from .errors import shortened

Parts = Mapping[str, Mapping[str, str]]
"""Fields of each part as texts, by its name; the field "" is its class, and the part "" the whole assembly."""


def part_changes(old: Parts, new: Parts) -> tuple[str, ...]:
    """List the differences of two assemblies part by part, such as "wheel2: axis (1, 0, 0) -> (0, 0, 1)"."""
    lines = [f"{name}: removed" for name in old if name not in new]
    for name, part in new.items():
        before = old.get(name)
        head = f"{name}: " if name else ""
        if before is None:
            lines.append(f"{name}: added, a {part['']}")
        elif part.get("") != before.get(""):
            lines.append(f"{name}: a {before['']} -> a {part['']}")
        else:
            pairs = ((field, before.get(field, "none"), part.get(field, "none")) for field in {**before, **part})
            separator = ":" if not name else ""
            lines += (f"{head}{field}{separator} {shortened(a)} -> {shortened(b)}" for field, a, b in pairs if a != b)
    return tuple(lines)
