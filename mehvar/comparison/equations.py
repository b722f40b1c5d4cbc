# SPDX-License-Identifier: Apache-2.0
"""Equations of a comparison as blocks of the document: causes with edits and evidence, the others folded."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from mehvar.base.errors import first_names
from mehvar.codegen.diff.parameters import PARTS
from mehvar.codegen.diff.report import (
    PICTURE,
    Comparison,
    Edit,
    EquationChange,
    EquationGroup,
    EquationVerdict,
    handle,
    label,
)

from .document import Block, Card, EditLines, Group, Table, Words

_CONDITIONS = ("constraint", "limit", "warning")
"""Kinds of rows whose name is a message."""
_PLACE = re.compile(r"(?:\b(\w+) = )?\{(\w*)(?::[^{}]*)?\}")
"""Place of a number in a message, as in "m = {m:g} kg"."""
_ALIKE = ("family", "symmetric")
"""Kinds of groups that are reported once, by their first member."""
_CAUSAL = ("follows", "solved")
"""Kinds of groups that follow their cause in the report."""
_NAMED = 12
"""Number of equations that a remark names: two lines of a terminal."""
_WHOLE = 8
"""Number of causes that are not folded."""
_CAUSES = (EquationVerdict.CHANGED, EquationVerdict.ADDED, EquationVerdict.REMOVED, EquationVerdict.UNDECIDED)
"""Verdicts of causes."""
_FOLDED = {
    EquationVerdict.CHANGED: "changed: following from a change above, or the same but for a family's other members",
    EquationVerdict.ADDED: "added: used by other equations or of a family's new members",
    EquationVerdict.REMOVED: "removed: were used by other equations or of a family's former members",
    EquationVerdict.INHERITED: "inherited: other values, because of the changes above",
    EquationVerdict.REARRANGED: "rearranged: written differently, equal",
    EquationVerdict.RENAMED: "renamed, equal",
    EquationVerdict.SCALED: "scaled: the same equation, multiplied by something",
}


def counted(comparison: Comparison) -> str:
    """Return the numbers of equations by verdict, as in "1 changed, 6 inherited, 40 unchanged"."""
    words = {EquationVerdict.SAME.value: "unchanged"}
    return ", ".join(
        f"{count} {words.get(verdict, verdict)}" for verdict, count in comparison.counts().items() if count
    )


class Equations:
    """Builder of the blocks about equations, names and numbers."""

    def __init__(self, comparison: Comparison) -> None:
        self._comparison = comparison
        self._ordered = [e for verdict in EquationVerdict for e in comparison.of(verdict)]
        self._families = {name: group for group in comparison.groups if group.kind in _ALIKE for name in group.names}
        self._shortest = {e.name: label(e) for e in reversed(comparison.equations)}

    def blocks(self) -> Iterator[Block]:
        """Yield structural choices, common reasons, the causes, the other equations folded, and the numbers."""
        for name, old, new in self._comparison.structure:
            yield Words(f"structure {name}: {old} -> {new}")
        for group in self._comparison.groups:
            if group.kind not in _ALIKE + _CAUSAL:
                yield Words(group.says, strong=True)
            elif group.kind == "solved":
                yield Words(f"{group.says}: {_many(group.names)}", strong=True)
        causes = list(self._causes())
        whole = [e for e in causes if e.kind != PICTURE][:_WHOLE]
        yield from map(self._card, whole)
        folds: dict[str, list[EquationChange]] = {}
        for e in self._ordered:
            if e not in whole and (heading := self._heading(e, e in causes)):
                folds.setdefault(heading, []).append(e)
        for heading, equations in folds.items():
            names = [name for e in equations if e in causes or not _mentioned(e) for name in self._names(e)]
            count = len({name for e in equations for name in self._members(e)})
            yield Group(f"{count} {heading}", [*map(self._card, equations)], True, names)
        yield from self._numbers()

    def _causes(self) -> Iterator[EquationChange]:
        """Yield the equations with cards of their own; the first stands for all equal parts, or for equal messages."""
        messages = set()
        for e in self._ordered:
            quiet = not e.matters and e.verdict in (EquationVerdict.ADDED, EquationVerdict.REMOVED)
            first = e.name not in self._families or self._family(e)
            if e.verdict not in _CAUSES or quiet or e.extended or e.cause or not first:
                continue
            if e.kind not in _CONDITIONS or e.edits or (e.verdict, e.title) not in messages:
                yield e
            messages.add((e.verdict, e.title))

    def _family(self, equation: EquationChange) -> EquationGroup | None:
        """Return the equal parts that an equation stands for as the first of them."""
        group = self._families.get(equation.name)
        return group if group and group.names[0] == equation.name else None

    def _members(self, equation: EquationChange) -> Sequence[str]:
        """Return the names of the equations that share a card."""
        group = self._family(equation)
        return group.names if group else [equation.name]

    def _heading(self, equation: EquationChange, is_cause: bool) -> str:
        """Return the heading of the fold with an equation; empty for one that shares the card of an equal part."""
        if is_cause and equation.kind == PICTURE:
            return "of the picture only"
        if is_cause:
            return f"more of {equation.section or equation.kind}, {equation.verdict}"
        if equation.verdict is EquationVerdict.CHANGED and not (equation.extended or equation.cause):
            return ""
        how = f" ({equation.how})" if equation in self._comparison.equivalent else ""
        return _FOLDED.get(equation.verdict, "") + how

    def _names(self, equation: EquationChange) -> Sequence[str]:
        if group := self._family(equation):
            return group.names
        if equation.verdict is EquationVerdict.RENAMED:
            return [f"{equation.old_name} -> {label(equation)}"]
        return [title(equation) if equation.kind in _CONDITIONS else label(equation)]

    def _numbers(self) -> Iterator[Block]:
        """Yield the names and numbers, the first of equal parts for all; parts are reported by themselves."""
        others = {*self._comparison.extended(), PARTS}
        rows = []
        for change in self._comparison.parameters:
            if change.name.split(".")[-1] not in others:
                none = "" if change.what in ("added", "removed") else "none"
                sides = change.old or none, change.new or none
                rows.append((change.role, change.name, change.what, *sides, change.unit))
        if rows:
            yield Table("names and numbers", ("role", "name", "what", "old", "new", "unit"), rows)

    def _card(self, equation: EquationChange) -> Card:
        group = self._family(equation)
        names, remarks = (group.names, [group.says]) if group else ((), [])
        remarks += self._remarks(equation)
        return Card(title(equation, names), equation, [*map(_edit, equation.edits)], remarks)

    def _remarks(self, equation: EquationChange) -> Iterator[str]:
        """Yield the remarks below an equation: example, evidence, users, causes and what follows."""
        if where := example(equation):
            yield where
        replayed = equation.replayed and equation.edits
        yield equation.how + "; the edits, applied to the old form, give the new one" * bool(replayed)
        if equation.users:
            yield f"inherited by {self._labels(equation.users)}"
        for group in self._comparison.groups:
            if group.kind == "follows" and group.names[0] == handle(equation):
                yield f"and what follows from it, {group.says}: {_many(group.names[1:])}"
        if equation.cause:
            source = next((title(e) for e in self._comparison if handle(e) == equation.cause), equation.cause)
            yield f"follows from {source}"
        if equation.via:
            yield f"because of {self._labels(equation.via)}"
        if equation.verdict is EquationVerdict.CHANGED and not equation.matters and equation.kind != PICTURE:
            conventions = {group.names[0] for group in self._comparison.groups if group.kind == "convention"}
            why = "what uses it compensates" if equation.name in conventions else "only the picture uses it"
            yield f"{why}: no equation or result has another value because of it"

    def _labels(self, names: Sequence[str]) -> str:
        """Return the shortest unambiguous names of equations, without duplicates."""
        labels = dict.fromkeys(self._shortest.get(name, name) for name in names)
        return first_names(list(labels), _NAMED, spare=1)


def _mentioned(equation: EquationChange) -> bool:
    """Return True for an equation that remarks or common reasons name."""
    return equation.extended or equation.verdict in (EquationVerdict.CHANGED, EquationVerdict.INHERITED)


def title(equation: EquationChange, names: Sequence[str] = ()) -> str:
    """Return the name of an equation, or the names for equal parts, with number and title."""
    about = " ".join(part for part in (equation.number, equation.title) if part)
    if equation.kind == "equation" and about:  # its name is a left side, often just zero
        return about
    if equation.kind in _CONDITIONS:
        return f"{equation.kind}: {_PLACE.sub(lambda place: place[1] or place[2], equation.title)}"
    was = f" (was {equation.old_name})" if equation.old_name not in ("", equation.name) else ""
    return "  ".join(part for part in (", ".join(names or [equation.name + was]), about) if part)


def example(equation: EquationChange) -> str:
    """Return the counterexample in one line; empty without one."""
    point = equation.counterexample
    if not point:
        return ""
    at = ", ".join(f"{name} = {value}" for name, value in point.at)
    held = f", with {first_names(equation.held, _NAMED, spare=1)} as before" if equation.held else ""
    return f"at {at or 'zero'}{', the rest 0' if at else ''}{held}: {point.left} became {point.right}"


def _many(names: Sequence[str]) -> str:
    return f"{len(names)} equation{'s' * (len(names) > 1)}: {first_names(names, _NAMED, spare=1)}"


def _edit(edit: Edit) -> EditLines:
    """Return the lines of an edit, without a position that equals the edited part."""
    where = " > ".join(place for place in edit.path if edit.old is None or place != edit.old.text)
    parts = edit.old, edit.new
    complete = all(part is None or part.text in edit.says for part in parts)
    return EditLines(f"in {where}: {edit.says}" if where else edit.says, *((None, None) if complete else parts))
