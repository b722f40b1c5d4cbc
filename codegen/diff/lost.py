# SPDX-License-Identifier: Apache-2.0
"""Definitions that were changed and inlined at once, so that the new side lacks them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from ..equal import field
from ..equal.field import Undefined
from ..equal.meaning import Expression, Meaning
from .changes import Change, Values, replaced
from .terms import Account
from .versions import Item, Versions

_POINTS = 2
"""Number of field points, as in `explain`."""


@dataclass(frozen=True)
class Lost:
    """A definition of the old side whose edit explains all changes of its users."""

    item: Item
    change: Change
    users: tuple[Item, ...]


def lost_definitions(versions: Versions, changed: Iterable[Item]) -> list[Lost]:
    """Return the removed definitions for which one edit on the old side reproduces all changed users."""
    changed = list(changed)
    lost = []
    for removed in versions.removed:
        users = [item for item in changed if removed.row.named and _uses(versions, versions.partner[item.key], removed)]
        change = _edit(versions, removed, users) if len(users) > 1 else None
        if change is not None:
            lost.append(Lost(removed, change, tuple(users)))
            changed = [item for item in changed if item not in users]
    return lost


def _uses(versions: Versions, item: Item, removed: Item) -> bool:
    return any(child.key == removed.key for child in versions.children(item, "old"))


def _edit(versions: Versions, removed: Item, users: Sequence[Item]) -> Change | None:
    """Return the edit of a removed definition that gives all its users their new values; None without one."""
    pool = versions.pool
    required = _required(versions, removed, users[0])
    if required is None:
        return None
    worlds = [versions.equality.field[k][versions.before] for k in range(_POINTS)]
    account = Account(pool, worlds, worlds)
    for change in account.single(removed.root, required):
        meaning = _with(versions, removed, replaced(pool, removed.root, [change]))
        if all(_explains(versions, meaning, user) for user in users):
            return change
    return None


def _explains(versions: Versions, meaning: Meaning, user: Item) -> bool:
    old = versions.partner[user.key]
    return bool(versions.equality.decide((meaning, old.root), (versions.across, user.root)).equal)


def _with(versions: Versions, removed: Item, root: int | None) -> Meaning:
    """Return the old meanings with one name redefined or free."""

    def targets(name: str) -> Expression | None:
        if name == removed.name:
            return None if root is None else (versions.before, root)
        target = versions.before.targets(name)
        return None if target is None else (meaning, target[1])

    meaning = Meaning(versions.pool, targets)
    return meaning


def _required(versions: Versions, removed: Item, user: Item) -> Values | None:
    """Return the value of a definition that gives a row its new value; the row must be affine in the definition."""
    free = _with(versions, removed, None)
    old = versions.partner[user.key]
    try:
        return tuple(
            _solved(
                versions.equality.field[k][versions.across].value(user.root),
                [
                    versions.equality.field.at(k, fixed={removed.name: number})[free].value(old.root)
                    for number in range(3)
                ],
            )
            for k in range(_POINTS)
        )
    except Undefined:
        return None


def _solved(required: field.Element, values: Sequence[field.Element]) -> field.Element:
    """Solve values[0] + c (values[1] - values[0]) = required for c."""
    slope = field.sub(values[1], values[0])
    if field.sub(values[2], values[1]) != slope:
        raise Undefined("not affine")
    return field.mul(field.sub(required, values[0]), field.inverse(slope))
