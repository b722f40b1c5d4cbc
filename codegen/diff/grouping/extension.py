# SPDX-License-Identifier: Apache-2.0
"""Additional equal parts on one side: their rows, and texts that only gain their terms."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from ...equal.pool import Pool
from ...equations.document import Document
from ..versions import Item, Versions

_NAME = re.compile(r"[A-Za-z_][A-Za-z_0-9]*")
_SUMS = frozenset(("add", "and", "or", "min", "max"))
"""Operations over equal parts; more parts add operands."""


@dataclass(frozen=True)
class Extension:
    """Equal parts, such as pendulums, that one side lacks.

    Attributes
    ----------
    old, new : int
        Number of equal parts on either side.
    names : frozenset of str
        Symbols and definitions of the additional parts.
    """

    old: int
    new: int
    names: frozenset[str]

    @property
    def says(self) -> str:
        """Description of the change in the number of equal parts."""
        word = "extended" if self.new > self.old else "shortened"
        return f"family {word}, {self.old} -> {self.new} members"

    def holds(self, text: str) -> bool:
        """Return True if a name or message refers to one of the added parts."""
        return any(word in self.names for word in _NAME.findall(text))


def extension(old: Document, new: Document) -> Extension | None:
    """Return the added parts; None if both sides have the same parts or differ in several ways."""
    before, after = _members(old), _members(new)
    moved = [family for family in after if family in before and before[family] != after[family]]
    pairs = {(frozenset(before[family]), frozenset(after[family])) for family in moved}
    if len(pairs) != 1:
        return None
    ((few, many),) = pairs
    if not (few < many or many < few):
        return None
    longer, extra = (new, many - few) if few < many else (old, few - many)
    symbols = {symbol.name for symbol in longer.symbols if symbol.family in moved and symbol.index in extra}
    rows = {row.name for row in longer.definitions if row.family and row.index in extra}
    return Extension(len(few), len(many), frozenset(symbols | rows))


def _members(document: Document) -> dict[str, set[int]]:
    members: dict[str, set[int]] = {}
    for symbol in document.symbols:
        if symbol.family:
            members.setdefault(symbol.family, set()).add(symbol.index)
    return members


class Extended:
    """Test of two texts for equality up to terms of added parts."""

    def __init__(self, versions: Versions, extension: Extension) -> None:
        self._pool: Pool = versions.pool
        self._longer_is_new = extension.new > extension.old
        self._extra = naming(versions.pool, extension.names)

    def __call__(self, old: Item, new: Item) -> bool:
        """Return True if a text equals the other after terms of added parts are inserted into its sums."""
        few, many = (old.root, new.root) if self._longer_is_new else (new.root, old.root)
        return few != many and self._extends(few, many)

    def _extends(self, few: int, many: int) -> bool:
        """Return True if the longer text equals the shorter one, except for added parts in sums."""
        if few == many:
            return True
        (operation, *_), (other, *_) = self._pool.nodes[few], self._pool.nodes[many]
        if {operation, other} & _SUMS and many in self._extra:
            kind = other if other in _SUMS else operation
            return self._rest(self._terms(few, kind), self._terms(many, kind), True)
        if operation != other or many not in self._extra:
            return False
        return self._rest(self._pool.operands(few), self._pool.operands(many), False)

    def _terms(self, node: int, kind: str) -> Sequence[int]:
        return self._pool.operands(node) if self._pool.nodes[node][0] == kind else (node,)

    def _rest(self, few: Sequence[int], many: Sequence[int], is_sum: bool) -> bool:
        """Return True if each operand of the shorter text has a partner and all others belong to added parts."""
        left = [node for node in many if node not in few]
        for node in few:
            if node in many:
                continue
            partner = next((other for other in left if self._extends(node, other)), None)
            if partner is None:
                return False
            left.remove(partner)
        return not left or (is_sum and all(node in self._extra for node in left))


def naming(pool: Pool, names: Iterable[str]) -> frozenset[int]:
    """Return the nodes that contain one of these names, directly or indirectly."""
    wanted, below = set(names), set()
    for node, (operation, *operands) in enumerate(pool.nodes):
        if operation == "sym":
            if operands[0] in wanted:
                below.add(node)
        elif any(operand in below for operand in pool.operands(node)):
            below.add(node)
    return frozenset(below)
