# SPDX-License-Identifier: Apache-2.0
"""Parts of an assembled system, as texts by which two versions are compared."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping

from .errors import shortened

Parts = Mapping[str, Mapping[str, str]]
"""Fields of each part as texts, by its name; the field "" is its class, and the part "" the whole assembly."""


_PLAIN = re.compile(r"None|\d{4}-\d\d-\d\d .*")
"""A field's text without a unit: nothing, or a date."""
_QUOTED = re.compile(r"(?<=')\w+(?=')")
"""A name of a part inside of another's field, such as the wheel of a tachometer."""


def renamed_parts(old: Parts, new: Parts) -> dict[str, str]:
    """Return new names by old ones: of parts of one class whose fields agree, or at least half of them.

    Parameters
    ----------
    old, new : Parts
        The assemblies.
    """
    pairs = []
    for i, gone in enumerate(name for name in old if name not in new):
        for k, come in enumerate(name for name in new if name not in old):
            a, b = old[gone], new[come]
            equal, every = sum(b.get(field) == text for field, text in a.items() if field), len({*a, *b}) - 1
            if a.get("") == b.get("") and 2 * equal >= every:
                pairs.append((equal - every, -abs(i - k), -i, gone, come))
    names: dict[str, str] = {}
    for *_, gone, come in sorted(pairs, reverse=True):
        if gone not in names and come not in names.values():
            names[gone] = come
    return names


def exchanged_parts(old: Parts, new: Parts) -> dict[str, str]:
    """Return new names by old ones of parts that both assemblies have, whose fields changed places.

    Parameters
    ----------
    old, new : Parts
        The assemblies.
    """
    shared = [name for name in old if name and old[name] != new.get(name, old[name])]
    names = {name: other for name in shared for other in shared if new[other] == old[name]}
    return names if set(names) == set(names.values()) else {}


def part_changes(
    old: Parts, new: Parts, unit_of: Callable[[str, str], str], names: Mapping[str, str] | None = None
) -> tuple[str, ...]:
    """List the differences of two assemblies part by part, such as "wheel2: axis (1, 0, 0) -> (0, 0, 1)".

    Parameters
    ----------
    old, new : Parts
        The assemblies.
    unit_of : callable
        Unit of a field, by class and name; empty for a field without unit.
    names : mapping of str to str, optional
        New names of parts by old ones; default: those of `renamed_parts`.
    """
    names = renamed_parts(old, new) if names is None else names
    lines = [f"{name}: renamed to {other}" for name, other in names.items()]
    old = {
        names.get(name, name): {
            field: _QUOTED.sub(lambda word: names.get(word[0], word[0]), text) for field, text in part.items()
        }
        for name, part in old.items()
    }
    lines += [f"{name}: removed" for name in old if name not in new]
    shared = [[name for name in one if name and name in other] for one, other in ((old, new), (new, old))]
    if shared[0] != shared[1]:
        lines.append(f"order of parts, and so of arrays: {' -> '.join(', '.join(order) for order in shared)}")
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
                a, b = (side.get(field, "none") for side in (before, part))
                unit = unit_of(part[""], field) if name else ""
                texts = map(shortened, (a, b))
                sides = (text if _PLAIN.fullmatch(text) else f"{text} {unit}".strip() for text in texts)
                lines += [f"{head}{field}{separator} {' -> '.join(sides)}"] * (a != b)
    return tuple(lines)
