# SPDX-License-Identifier: Apache-2.0
"""Edits of an expression: a single edit if one explains the change, else edits of paired terms."""

from __future__ import annotations

from collections.abc import Sequence

from ..equations.document import reached
from . import costs
from .changes import Change
from .edits import Edits
from .report import Kind, Path

_MOST = 40
"""Largest number of unmatched terms that are paired with each other; 40 on each side give 1600 searches."""


class Account(Edits):
    """Explanation of the difference between two expressions."""

    def explain(self, old: int, new: int) -> list[Change]:
        """Return edits that turn the old expression into the new one; empty if there are none."""
        self._atoms = self._atoms_of(old, new)
        self._parts = self._values_of(new)
        self._written = frozenset(reached(self.pool.nodes, [new]))
        return self._explain(old, new, ()) or [self.whole(old, new)]

    def whole(self, old: int, new: int) -> Change:
        """Return the edit that replaces the old expression as a whole."""
        return self._rewritten(old, new, ())

    def _explain(self, old: int, new: int, path: Path) -> list[Change]:
        """Return the likely edits of a pair of parts: one edit unless several inside it are less costly together."""
        required = self.new(new)
        if old == new or (required is not None and self.old(old) == required):
            return []
        before, after = self.pool.constant(old), self.pool.constant(new)
        if before is not None and after is not None:
            return [Change(Kind.COEFFICIENT, path, old, new, new, f"{before} became {after}", costs.NUMBER)]
        single = None
        if required is not None and self.old(old) is not None:
            single = min(self.walk(old, required, path), key=lambda c: (c.cost, len(c.path), c.says), default=None)
            if single is not None and single.cost < costs.ENOUGH:
                return [single]
        several = self._by_structure(old, new, path)
        if single is not None and (not several or single.cost <= sum(change.cost for change in several)):
            return [single]
        return several

    def _by_structure(self, old: int, new: int, path: Path) -> list[Change]:
        """Return the edits inside two parts with the same operation; empty if their operands do not correspond."""
        operations = {self.pool.nodes[old][0], self.pool.nodes[new][0]}
        if "add" in operations:
            return self._terms(old, new, path)
        if operations == {"mul"}:
            return self._factors_of(old, new, path)
        before, after = self.pool.operands(old), self.pool.operands(new)
        if len(operations) != 1 or len(before) != len(after) or not before:
            return []
        order = self._aligned(old, before, after)
        changes: list[Change] = []
        for k, (a, b) in enumerate(zip(before, order, strict=True)):
            if a != b:
                inner = self._explain(a, b, (*path, k))
                if not inner and self.old(a) != self.new(b):
                    inner = [self._rewritten(a, b, (*path, k))]
                changes += inner
        exchanged = self.pool.nodes[old][0] == "atan2" and len(changes) > 1
        return [] if exchanged else changes

    def _aligned(self, node: int, before: Sequence[int], after: Sequence[int]) -> list[int]:
        """Order the operands of a commutative function so that equal ones correspond."""
        if self.pool.nodes[node][0] not in ("max", "min", "and", "or"):
            return list(after)
        left = list(after)
        order: list[int | None] = []
        for a in before:
            same = next((b for b in left if b == a or (self.old(a) is not None and self.old(a) == self.new(b))), None)
            order.append(same)
            if same is not None:
                left.remove(same)
        return [left.pop(0) if b is None else b for b in order]

    def _terms(self, old: int, new: int, path: Path) -> list[Change]:
        """Return the edits of two sums, whose equal terms are left out; empty if too many terms remain."""
        before, after = self._summands(old, path), [node for node, _ in self._summands(new, ())]
        before, after = self._without_equal(before, after)
        if len(before) == 1 and len(after) == 1:
            (node, place), (other,) = before[0], after
            if (node, other) == (old, new):
                return []
            return self._explain(node, other, place) or [self._rewritten(node, other, place)]
        if len(before) > _MOST or len(after) > _MOST:
            return []
        return self._paired(before, after, path)

    def _summands(self, node: int, path: Path) -> list[tuple[int, Path]]:
        if self.pool.nodes[node][0] != "add":
            return [(node, path)]
        return [(operand, (*path, k)) for k, operand in enumerate(self.pool.operands(node))]

    def _without_equal(
        self, before: list[tuple[int, Path]], after: list[int]
    ) -> tuple[list[tuple[int, Path]], list[int]]:
        """Return the operands of both sides without pairs of equal value."""
        left, rest = list(after), []
        for node, place in before:
            value = self.old(node)
            same = next((b for b in left if b == node or (value is not None and value == self.new(b))), None)
            if same is None:
                rest.append((node, place))
            else:
                left.remove(same)
        return rest, left

    def _paired(self, before: list[tuple[int, Path]], after: list[int], path: Path) -> list[Change]:
        """Pair unmatched terms by the cheapest edit; the rest were lost or added."""
        options: list[tuple[float, int, int, Change]] = []
        for i, (node, place) in enumerate(before):
            for j, other in enumerate(after):
                required = self.new(other)
                if required is None:
                    continue
                change = min(self.walk(node, required, place), key=lambda c: c.cost, default=None)
                if change is not None and change.cost < costs.PAIR:
                    options.append((change.cost, i, j, change))
        changes = []
        lost, gained = set(range(len(before))), set(range(len(after)))
        for _, i, j, change in sorted(options, key=lambda option: option[:3]):
            if i in lost and j in gained:
                lost.remove(i)
                gained.remove(j)
                changes.append(change)
        for i in sorted(lost):
            node, place = before[i]
            changes.append(Change(Kind.TERM_REMOVED, place, node, None, None, "term lost", costs.LOST_TERM))
        for j in sorted(gained):
            changes.append(Change(Kind.TERM_ADDED, path, None, after[j], after[j], "term added", costs.ADDED_TERM))
        return changes

    def _factors_of(self, old: int, new: int, path: Path) -> list[Change]:
        """Return the edits of two products without their equal factors; empty if the others do not correspond."""
        before = [(operand, (*path, k)) for k, operand in enumerate(self.pool.operands(old))]
        before, after = self._without_equal(before, list(self.pool.operands(new)))
        if len(before) == 1 and len(after) == 1:
            (node, place), (other,) = before[0], after
            return self._explain(node, other, place) or [self._rewritten(node, other, place)]
        if len(before) == len(after) <= 3:
            changes = []
            for (node, place), other in zip(before, after, strict=True):
                if self.pool.nodes[node][0] != self.pool.nodes[other][0]:
                    return []
                changes += self._explain(node, other, place) or [self._rewritten(node, other, place)]
            return changes
        return []
