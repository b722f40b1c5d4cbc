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
    """Return new names by old ones, also of parts with names of their own, if a part took the name of another.

    Parameters
    ----------
    old, new : Parts
        The assemblies.
    """
    names: dict[str, str] = {}
    for with_names in (False, True):  # what a part names, such as its wheel, is renamed before the part
        names |= _moved(_rewritten(old, names), new, names, with_names)
    gone = {name: part for name, part in _rewritten(old, names).items() if name not in (*names, *new)}
    names |= renamed_parts(gone, {name: part for name, part in new.items() if name not in (*names.values(), *old)})
    while kept := {name for name, other in names.items() if other in old and other not in names}:
        names = {name: other for name, other in names.items() if name not in kept}  # two parts would have a name
    return names if any(other in old for other in names.values()) else {}


def _moved(old: Parts, new: Parts, names: Mapping[str, str], with_names: bool) -> dict[str, str]:
    """Match parts without a name up to now whose fields occur under another name."""
    moved: dict[str, str] = {}
    for name, part in old.items():
        if name in ("", *names) or part == new.get(name) or (not with_names and _named_in(part)):
            continue
        taken = {*names.values(), *moved.values()}
        other = next((n for n in new if n not in taken and new[n] == part and old.get(n) != part), None)
        moved |= {name: other} if other else {}
    return moved


def _named_in(part: Mapping[str, str]) -> bool:
    return any(map(_QUOTED.search, part.values()))


def _rewritten(parts: Parts, names: Mapping[str, str]) -> dict[str, dict[str, str]]:
    """Return parts whose fields have the new names of other parts."""
    return {
        name: {field: _QUOTED.sub(lambda word: names.get(word[0], word[0]), text) for field, text in part.items()}
        for name, part in parts.items()
    }


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
    old = {names.get(name, name): part for name, part in _rewritten(old, names).items()}
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
