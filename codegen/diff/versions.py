# SPDX-License-Identifier: Apache-2.0
"""Two documents in one pool of expressions, with matched rows."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from mehvar.base.manifest import Manifest

from ..equal.equality import EqualityTest
from ..equal.meaning import Expression, Meaning
from ..equal.pool import Pool
from ..equal.sampler import PointSampler
from ..equations.document import Document, Row, Symbol
from .parameters import event_of

Key = tuple[str, str, int]
Limits = tuple[Fraction | None, Fraction | None]
_RENAMED = frozenset(("definition", "equation", "limit", "constraint", "warning"))
"""Kinds of rows that may have been renamed."""


@dataclass(frozen=True)
class Item:
    """A row of the old or the new version, with its expression."""

    row: Row
    key: Key
    root: int

    @property
    def name(self) -> str:
        """Name of the row."""
        return self.row.name


class Versions:
    """Rows of two versions, and the meanings of their names.

    Attributes
    ----------
    olds, news : tuple of Item
        Rows in order.
    before, after : Meaning
        Meanings of names on the old and on the new side.
    across : Meaning
        Names of the new side, with definitions replaced by their partners on the old side, for equal children.
    free : tuple of Meaning
        Meanings of old and new texts in which partners are free names.
    """

    def __init__(self, old: Document, new: Document) -> None:
        self.old, self.new = old, new
        self.pool = Pool()
        self.olds = _items(old, self.pool.copy(old.nodes))
        self.news = _items(new, self.pool.copy(new.nodes))
        self._old_named = {item.name: item for item in self.olds if item.row.named}
        self._new_named = {item.name: item for item in self.news if item.row.named}
        self.partner: dict[Key, Item] = {}
        """Old rows by the key of the new row."""
        self.before = Meaning(self.pool, lambda name: _target(self.before, self._old_named.get(name)))
        self.after = Meaning(self.pool, lambda name: _target(self.after, self._new_named.get(name)))
        self.across = Meaning(self.pool, self._partner_of)
        self.free_old = Meaning(self.pool, lambda _: None)
        self.free_new = Meaning(self.pool, self._free)
        self.declared: dict[str, list[Symbol]] = defaultdict(list)
        """Declarations of both sides; a name that two laws declare has several."""
        for symbol in (*old.symbols, *new.symbols):
            self.declared[symbol.name].append(symbol)
        self.equality = EqualityTest(self.pool, self._positive, self._sampler())
        self._match()

    def _positive(self, name: str) -> bool:
        """Return True if all declarations of a name are positive."""
        return {symbol.sign for symbol in self.declared.get(name, ())} == {"positive"}

    def may_be(self, name: str, value: Fraction) -> bool:
        """Return True if some declaration of a name allows a value, or if none declares it."""
        symbols = self.declared.get(name, ())
        return not symbols or any(
            float(value) in symbol.interval and (value > 0 or symbol.sign != "positive") for symbol in symbols
        )

    def _sampler(self) -> PointSampler:
        """Return a sampler that respects every declaration's bounds and units."""
        defaults = _defaults(self.old.manifest) | _defaults(self.new.manifest)
        return PointSampler(
            {name: (*_hull(map(_bounds, every)), defaults.get(name)) for name, every in self.declared.items()},
            frozenset(name for name, every in self.declared.items() if all(symbol.unit == "rad" for symbol in every)),
        )

    def _partner_of(self, name: str) -> Expression | None:
        item = self._new_named.get(name)
        if item is None:
            return None
        partner = self.partner.get(item.key)
        return (self.across, item.root) if partner is None else (self.before, partner.root)

    def _free(self, name: str) -> Expression | None:
        item = self._new_named.get(name)
        if item is None:
            return None
        partner = self.partner.get(item.key)
        if partner is None:
            return self.free_new, item.root
        return None if partner.name == name else (self.free_old, self.pool.intern("sym", partner.name))

    def children(self, item: Item, side: str = "new") -> list[Item]:
        """Return the definitions that a text uses directly or through definitions without partner."""
        named = self._new_named if side == "new" else self._old_named
        children: dict[Key, Item] = {}
        stack = [item]
        while stack:
            for name in self._names(stack.pop().root):
                child = named.get(name)
                if child is None or child.key in children:
                    continue
                children[child.key] = child
                if side == "new" and child.key not in self.partner:
                    stack.append(child)
        return list(children.values())

    def _names(self, root: int) -> list[str]:
        """Return the symbols in an expression; their order, which is fixed, is that of the report."""
        nodes = self.pool.nodes
        seen, stack, names = set(), [root], []
        while stack:
            node = stack.pop()
            if node in seen:
                continue
            seen.add(node)
            if nodes[node][0] == "sym":
                names.append(nodes[node][1])
            stack.extend(self.pool.operands(node))
        return names

    # Matching

    def _match(self) -> None:
        """Find each row's partner: by name and value, by value, by name, by text, then by its place in users."""
        left = {item.key: item for item in self.olds}
        self._values: dict[tuple[bool, Key], Any] = {}
        self._new_keys = {item.key: item for item in self.news}
        for item in self.news:
            same = left.get(item.key)
            if same is not None and self._value(False, same) == self._value(True, item):
                self.partner[item.key] = left.pop(item.key)
        self._match_values(left)
        for item in self.news:
            if item.key not in self.partner and item.key in left:
                self.partner[item.key] = left.pop(item.key)
        self._match_local(left)
        self._match_used(left)
        self.removed = list(left.values())

    def _value(self, new: bool, item: Item) -> Any:
        key = (new, item.key)
        if key not in self._values:
            self._values[key] = self.equality.field.values(self.after if new else self.before, item.root)
        return self._values[key]

    def _match_values(self, left: dict[Key, Item]) -> None:
        """Match rows with equal meanings and different names."""
        by_value: dict[Any, list[Item]] = defaultdict(list)
        for item in left.values():
            if item.row.kind in _RENAMED:
                by_value[item.row.kind, self._value(False, item)].append(item)
        for item in self.news:
            if item.key in self.partner or item.row.kind not in _RENAMED:
                continue
            values = self._value(True, item)
            candidates = [o for o in by_value.get((item.row.kind, values), ()) if self._may_be_renamed(o, item, left)]
            if candidates and _is_enough(values):
                best = min(candidates, key=lambda o: (o.row.number, o.row.title) != (item.row.number, item.row.title))
                by_value[item.row.kind, values].remove(best)
                self.partner[item.key] = left.pop(best.key)

    def _may_be_renamed(self, old: Item, new: Item, left: Mapping[Key, Item]) -> bool:
        """Return True if one side lacks a name: two rows that exchanged their values have both changed."""
        return old.key not in self._new_keys or new.key not in left

    def _match_local(self, left: dict[Key, Item]) -> None:
        """Match rows with different names and values whose texts are equal once their children are matched."""
        for item in self.news:
            if item.key in self.partner or item.row.kind != "definition":
                continue
            value = self.equality.field.values(self.across, item.root)
            for old in left.values():
                if (
                    old.row.kind == "definition"
                    and sum(v is not None for v in value) > 1
                    and value == self._value(False, old)
                ):
                    self.partner[item.key] = left.pop(old.key)
                    break

    def _match_used(self, left: dict[Key, Item]) -> None:
        """Match renamed and changed definitions by their positions in equal texts of their users."""
        alone = [item for item in self.news if item.key not in self.partner and item.row.kind == "definition"]
        for item in reversed(alone):  # users come after their definitions
            users = [user for user in self.news if user.key in self.partner and item.name in self._names(user.root)]
            for old in left.values():
                if old.row.kind == "definition" and users and all(self._is_in_place(item, old, user) for user in users):
                    self.partner[item.key] = left.pop(old.key)
                    break

    def _is_in_place(self, new: Item, old: Item, user: Item) -> bool:
        """Return True if one replaced name turns a user's old text into its new one."""
        partner = self.partner[user.key]
        if old.name not in self._names(partner.root):
            return False
        instead = (self.free_old, self.pool.intern("sym", old.name))
        meaning = Meaning(self.pool, lambda name: instead if name == new.name else self._free(name))
        values = self.equality.field.values(meaning, user.root)
        return _is_enough(values) and bool(values == self.equality.field.values(self.free_old, partner.root))


def _is_enough(values: Sequence[Any]) -> bool:
    return sum(value is not None for value in values) > 1


def _target(meaning: Meaning, item: Item | None) -> Expression | None:
    return None if item is None else (meaning, item.root)


def _items(document: Document, numbers: Sequence[int]) -> tuple[Item, ...]:
    seen: Counter[tuple[str, str]] = Counter()
    items = []
    for row in document.rows:
        label = _label(row)
        seen[row.kind, label] += 1
        items.append(Item(row, (row.kind, label, seen[row.kind, label]), numbers[row.node]))
    return tuple(items)


def _label(row: Row) -> str:
    """Return the label that identifies a row; the label of a guard is its event without direction and effect."""
    if row.kind == "equation":
        return f"{row.name} {row.number} {row.title}"
    return event_of(row.name)[0] if row.kind == "guard" else row.name


def _hull(limits: Iterable[Limits]) -> Limits:
    lows, highs = zip(*limits, strict=True)
    return None if None in lows else min(lows), None if None in highs else max(highs)


def _bounds(symbol: Symbol) -> Limits:
    lower, upper = (Fraction(v) if abs(v) < 1e300 else None for v in (symbol.interval.lower, symbol.interval.upper))
    return Fraction(0) if lower is None and symbol.sign == "positive" else lower, upper


def _defaults(manifest: Manifest | None) -> dict[str, Fraction]:
    if manifest is None:
        return {}
    laws = (law.parameters for law in manifest.controllers.values())
    rows = (row for group in (manifest.parameters, manifest.scenario_parameters, *laws) for row in group)
    return {row.name: Fraction(row.default) for row in rows if row.default is not None}
