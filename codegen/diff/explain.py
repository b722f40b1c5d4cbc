# SPDX-License-Identifier: Apache-2.0
"""Explanation of a changed row: edits, verified by applying them, and a simple point where both sides differ."""

from __future__ import annotations

import re
from collections import ChainMap
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import chain

from ..equal.meaning import Expression
from ..equal.points import Worlds, differ, one_exists
from ..equal.sampler import Point
from ..equal.values import FieldWorld
from ..equal.verdicts import VISIBLE, Counterexample, shown, simplified
from ..equations.formula import Printer, SymbolNames, rank_of
from ..equations.spelling import LATEX
from .changes import Change, replaced
from .points.allowed import CONDITIONS, Allowed, Test
from .report import Edit, Kind, Part, Path
from .terms import Account
from .versions import Item, Versions

_POINTS = 2
"""Number of field points of the search. A wrong edit fits all with probability 2^-178; further points check it."""
_ROOTED = 16
"""Number of field points for expressions with even roots, whose signs are random in the field. An edit that is wrong
for half of the signs passes two points in one of four cases, and all of these points in one of 65 000.
"""
_TRIED = 60
"""Largest number of points that are tried to find valid ones; further points would hardly succeed."""
_VISITED = 20_000
"""Largest number of positions that are searched for marks; shared nodes can occur at very many positions."""
_LARGEST_CONE = 400
"""Largest expression, in nodes, whose counterexample is simplified; each name costs several evaluations."""


@dataclass(frozen=True)
class Explanation:
    """Explanation of a change."""

    edits: tuple[Edit, ...]
    replayed: bool
    counterexample: Counterexample | None


class Explainer:
    """Explainer of the changed rows of two versions."""

    def __init__(self, versions: Versions) -> None:
        self.versions = versions
        self.equality = versions.equality
        self._allowed = Allowed(versions)
        names = _names(versions)
        self._text = Printer(versions.pool.nodes, names)
        self._latex = Printer(versions.pool.nodes, names, LATEX)
        self._changes: dict[tuple[int, int], tuple[list[Change], bool]] = {}

    def explain(self, old: Item, new: Item, point: Point | None = None) -> Explanation:
        """Return the edits that turn the old text into the new one, with equal values of their children.

        `point` is a known point where both sides differ, if any.
        """
        versions = self.versions
        before, across = (versions.before, old.root), (versions.across, new.root)
        changes, replayed = self.changes(old, new)
        return Explanation(
            tuple(self.edit(change, old.root, new.root) for change in changes),
            replayed,
            self._counterexample(before, across, point, anywhere=new.row.kind in CONDITIONS),
        )

    def changes(self, old: Item, new: Item) -> tuple[list[Change], bool]:
        """Return the edits of a row whose children are equal, and True if the edits reproduce the new text."""
        key = (old.root, new.root)
        if key not in self._changes:
            self._changes[key] = self.account((self.versions.before, old.root), (self.versions.across, new.root))
        return self._changes[key]

    def account(self, old: Expression, new: Expression) -> tuple[list[Change], bool]:
        """Return edits, and True if the edits reproduce the new expression."""
        pool = self.versions.pool
        olds, news = self._worlds(old, new)
        account = Account(pool, olds, news)
        changes = account.explain(old[1], new[1])
        made = self.equality.decide((old[0], replaced(pool, old[1], changes)), new)
        if made.equal is False and len(changes) == 1:
            return [account.whole(old[1], new[1])], True
        return changes, bool(made.equal)

    def _worlds(self, old: Expression, new: Expression) -> tuple[list[FieldWorld], list[FieldWorld]]:
        """Return evaluations of both sides at points where both have values."""
        pairs = [(self.versions.before, self.versions.across), (self.versions.free_old, self.versions.free_new)]
        if old[0] is not self.versions.before:
            pairs = [(old[0], new[0])]
        count = _ROOTED if self.equality.field.is_rooted(old, new) else _POINTS
        for first, second in pairs:
            points = []
            for number in range(_TRIED):
                worlds = self.equality.field[number]
                if worlds[first].defined(old[1]) is not None and worlds[second].defined(new[1]) is not None:
                    points.append((worlds[first], worlds[second]))
                if len(points) == count:
                    return [a for a, _ in points], [b for _, b in points]
        worlds = self.equality.field[0]
        return [worlds[pairs[-1][0]]], [worlds[pairs[-1][1]]]

    # Words

    def edit(self, change: Change, old: int, new: int | None = None) -> Edit:
        """Return an edit in words, with the positions of its new part in the new expression."""
        return Edit(
            change.kind,
            tuple(dict.fromkeys(self._text.text(node) for node in self._way(old, change))),
            self._part(change.old, (change.path,) if change.old is not None else (), change.new),
            self._part(change.new, () if new is None else tuple(self._places(new, change.new))),
            self.words(change.says),
        )

    def words(self, says: str) -> str:
        """Return a text with each {number} replaced by that node's text."""
        text = self._text.text
        says = re.sub(r"\{(\d+)\}(?= became \{(\d+)\})", lambda pair: self._apart(*map(int, pair.groups())), says)
        return re.sub(r"\{(\d+)\}", lambda match: text(int(match[1])), says)

    def _apart(self, old: int, new: int | None) -> str:
        """Return the text of an old part, which names definitions anew if the text of the new part is the same."""
        text = self._text.text(old)
        if new is None or text != self._text.text(new):
            return text
        return re.sub(r"\w+", lambda word: self._anew.get(word[0], word[0]), text)

    @cached_property
    def _anew(self) -> dict[str, str]:
        """New names of definitions by old ones."""
        partner = self.versions.partner
        pairs = ((partner[item.key].name, item.name) for item in self.versions.news if item.key in partner)
        return {old: new for old, new in pairs if old != new}

    def _part(self, node: int | None, places: tuple[Path, ...], new: int | None = None) -> Part | None:
        return None if node is None else Part(self._apart(node, new), self._latex.text(node), places)

    def _way(self, root: int, change: Change) -> Iterator[int]:
        """Yield the terms around the edited part, from outside to inside, then the part itself."""
        pool, node = self.versions.pool, root
        for k in change.path:
            parent, node = node, int(pool.nodes[node][1 + k])
            if pool.nodes[parent][0] == "add":
                yield node
            elif pool.nodes[parent][0] not in ("mul", "pow", "exprcondpair"):
                yield parent
        if change.path and change.kind is not Kind.TERM_ADDED:
            yield node

    def _places(self, root: int, part: int | None) -> Iterator[Path]:
        """Yield the positions of a part in the new expression."""
        if part is None:
            return
        stack: list[tuple[int, Path]] = [(root, ())]
        visited = 0
        while stack and visited < _VISITED:
            node, path = stack.pop()
            visited += 1
            if node == part:
                yield path
                continue
            operands = self.versions.pool.nodes[node][1:]
            stack += [(o, (*path, k)) for k, o in enumerate(operands) if isinstance(o, int)]

    # Counterexample

    def _counterexample(
        self, old: Expression, new: Expression, known: Point | None, anywhere: bool
    ) -> Counterexample | None:
        """Return a simple point where both sides differ, which if possible fulfils the conditions of a version."""
        allowed = (lambda _: True) if anywhere else self._allowed.test(old, new)
        mine = () if known is None else (self.equality.real.at(known),)
        points = chain(self.equality.real.where([old, new], 40), mine, self.equality.real.extremes(old, new))
        worlds, fails = _first(allowed, (w for w in points if differ(w, old, new))), self._fails
        if worlds is None:
            worlds = next((w for w in mine if one_exists(w, old, new)), None)
            fails = self._is_alone
        if worlds is None:
            return None
        base = next(iter(worlds)).point
        point = {name: base[name] for name in {*old[0].free(old[1]), *new[0].free(new[1])}}
        if len(old[0].cone(old[1])) + len(new[0].cone(new[1])) <= _LARGEST_CONE:
            keep = allowed if allowed(worlds) else lambda _: True
            point = simplified(
                point,
                self._candidates,
                lambda trial: fails(trial, old, new) and keep(self.equality.real.at(ChainMap({**trial}, base))),
            )
            worlds = self.equality.real.at(point)
        named = tuple((name, _written(value)) for name, value in sorted(point.items()) if value)
        return Counterexample(named, *shown(worlds, old, new))

    def _candidates(self, name: str, value: Fraction) -> Iterator[Fraction]:
        return (simple for simple in self.equality.sampler.simple(name, value) if self.versions.may_be(name, simple))

    def _is_alone(self, point: Mapping[str, Fraction], old: Expression, new: Expression) -> bool:
        """Return True if only one side has a value at a point. At coordinates of zero a domain may end."""
        return 0 not in point.values() and one_exists(self.equality.real.at(point), old, new)

    def _fails(self, point: Mapping[str, Fraction], old: Expression, new: Expression) -> bool:
        worlds = self.equality.real.at(point)
        a, b = worlds[old[0]].defined(old[1]), worlds[new[0]].defined(new[1])
        if a is None or b is None or isinstance(a, bool | tuple):
            return False
        return bool(abs(a - b) > VISIBLE * (abs(a) + abs(b)) and differ(worlds, old, new))


def _first(allowed: Test, points: Iterator[Worlds]) -> Worlds | None:
    """Return the first allowed point, else the first point; None without points."""
    first = next(points, None)
    return first if first is None or allowed(first) else next(filter(allowed, points), first)


def _written(value: Fraction) -> str:
    if 1 < value.denominator <= 1000:
        return str(value)
    short = f"{float(value):.6g}"
    # beside a threshold every digit counts; elsewhere simple numbers were found
    return short if Fraction(short) == value or value.denominator < 2**20 else repr(float(value))


def _names(versions: Versions) -> SymbolNames:
    latex: dict[str, str] = {}
    rank: dict[str, int] = {}
    for document in (versions.new, versions.old):
        latex |= document.latex
        rank |= {symbol.name: rank_of(symbol.role) for symbol in document.symbols}
        rank |= dict.fromkeys(document.named, rank_of("definition"))
    return SymbolNames(latex, rank)
