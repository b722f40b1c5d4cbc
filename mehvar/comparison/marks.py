# SPDX-License-Identifier: Apache-2.0
"""Textual differences of two forms of an expression, for marks on pages that show both.

This module compares only the form; `mehvar.codegen.diff` decides if and why the value changed.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from fractions import Fraction

from mehvar.codegen.equations.formula import Nodes, Path

_COMMUTATIVE = {"add", "mul", "min", "max", "and", "or"}
_ALIKE = Fraction(1, 2)
"""Share of common parts above which two terms count as the same term before and after an edit."""


class Alignment:
    """Two graphs with equal numbers for equal parts, regardless of the order of operands.

    Parameters
    ----------
    old, new : sequence
        The graphs.
    renamed : mapping
        New names of old symbols.
    """

    def __init__(self, old: Nodes, new: Nodes, renamed: Mapping[str, str]) -> None:
        self._graphs = (old, new)
        table: dict[tuple[object, ...], int] = {}
        self._content = (_contents(old, table, renamed), _contents(new, table, {}))

    def marks(self, old: int, new: int) -> tuple[frozenset[Path], frozenset[Path]]:
        """Return the paths of the smallest differing parts in both expressions."""
        places: tuple[set[Path], set[Path]] = (set(), set())
        self._compare((old, ()), (new, ()), places)
        return frozenset(places[0]), frozenset(places[1])

    def _compare(self, old: _Place, new: _Place, places: _Places) -> None:
        """Add the places at which two parts differ, as far inside as they have the same operation."""
        if self._same(old, new):
            return
        operations = {self._operation(0, old), self._operation(1, new)}
        for operation in ("add", "mul"):
            if operation in operations:
                self._compare_parts(operation, old, new, places)
                return
        before, after = self._operands(0, old), self._operands(1, new)
        if len(operations) == 1 and before and len(before) == len(after):
            for pair in zip(before, after, strict=True):
                self._compare(*pair, places)
            return
        _mark(places, [old], [new])

    def _compare_parts(self, operation: str, old: _Place, new: _Place, places: _Places) -> None:
        """Add the places of differing terms or factors; of those that are alike, the places inside."""
        before, after = self._parts(0, operation, old), self._parts(1, operation, new)
        before, after = self._without_common(before, after)
        if operation == "mul" and any(self._is_number(side, p) for side, ps in enumerate((before, after)) for p in ps):
            _mark(places, [old], [new])
            return
        for place in list(before):
            likeness, best = max(
                ((self._likeness(operation, place, p), -k) for k, p in enumerate(after)), default=(0, 0)
            )
            if likeness >= _ALIKE:
                partner = after.pop(-best)
                before.remove(place)
                self._compare(place, partner, places)
        if operation == "mul":  # a factor that only one side has: on the other side the product as a whole is different
            before, after = before or [old][: len(after)], after or [new][: len(before)]
        _mark(places, before, after)

    def _without_common(self, before: list[_Place], after: list[_Place]) -> tuple[list[_Place], list[_Place]]:
        """Return the parts of each side that the other side lacks; a part counts as often as it occurs."""
        contents = [[self._content[side][node] for node, _ in places] for side, places in enumerate((before, after))]
        common = Counter(contents[0]) & Counter(contents[1])
        rest = []
        for places, content in zip((before, after), contents, strict=True):
            left, others = Counter(common), []
            for place, number in zip(places, content, strict=True):
                if left[number]:
                    left[number] -= 1
                else:
                    others.append(place)
            rest.append(others)
        return rest[0], rest[1]

    def _likeness(self, operation: str, old: _Place, new: _Place) -> Fraction:
        """Return the similarity of two terms or factors, from 0 to 1."""
        kinds = {self._operation(0, old), self._operation(1, new)}
        if len(kinds) == 1 and not kinds & {"add", "mul", "pow"}:
            return Fraction(1)
        if operation == "mul" and len(kinds) > 1:
            return Fraction(0)
        inner = "mul" if operation == "add" else kinds.pop()
        before = Counter(self._content[0][node] for node, _ in self._parts(0, inner, old))
        after = Counter(self._content[1][node] for node, _ in self._parts(1, inner, new))
        return Fraction((before & after).total(), max(before.total(), after.total()))

    def _same(self, old: _Place, new: _Place) -> bool:
        return self._content[0][old[0]] == self._content[1][new[0]]

    def _operation(self, side: int, place: _Place) -> str:
        return str(self._graphs[side][place[0]][0])

    def _is_number(self, side: int, place: _Place) -> bool:
        return self._operation(side, place) == "num"

    def _operands(self, side: int, place: _Place) -> list[_Place]:
        operands = self._graphs[side][place[0]][1:]
        return [(node, (*place[1], k)) for k, node in enumerate(operands) if isinstance(node, int)]

    def _parts(self, side: int, operation: str, place: _Place) -> list[_Place]:
        return self._operands(side, place) if self._operation(side, place) == operation else [place]


_Place = tuple[int, Path]
_Places = tuple[set[Path], set[Path]]


def _mark(places: _Places, old: Sequence[_Place], new: Sequence[_Place]) -> None:
    places[0].update(path for _, path in old)
    places[1].update(path for _, path in new)


def _contents(nodes: Nodes, table: dict[tuple[object, ...], int], renamed: Mapping[str, str]) -> list[int]:
    numbers: list[int] = []
    for operation, *operands in nodes:
        parts: list[object] = [numbers[o] if isinstance(o, int) else renamed.get(o, o) for o in operands]
        if operation in _COMMUTATIVE:
            parts.sort(key=str)
        numbers.append(table.setdefault((operation, *parts), len(table)))
    return numbers
