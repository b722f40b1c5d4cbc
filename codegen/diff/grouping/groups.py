# SPDX-License-Identifier: Apache-2.0
"""Groups of related rows: equal parts with the same edit, or a changed convention that its users compensate."""

from __future__ import annotations

import itertools
import re
from collections.abc import Mapping, Sequence

from ..report import EXTENDED, MEMBER, PICTURE, UNEQUAL, EquationChange, EquationGroup, EquationVerdict
from ..versions import Versions
from .extension import Extension

_AXIS = re.compile(
    r"(?<![A-Za-z0-9])[xyz](?![A-Za-z0-9])|(?<=_)[xyz123](?![A-Za-z0-9])|(?<=[a-z_])[xyz](?![A-Za-z0-9_])"
)
"""Pattern of an axis: a word, as in "torque about x", or the end of a name, as in I_y or wx."""
_SIGN = re.compile(r"(?<![\w)])-(?=\d)")
"""Pattern of a number's sign, which varies between the axes of a cross product."""


def groups(
    versions: Versions,
    equations: tuple[EquationChange, ...],
    extension: Extension | None = None,
    told: Sequence[EquationGroup] = (),
) -> tuple[EquationGroup, ...]:
    """Return all groups of compared rows, including rows with a common cause."""
    own = tuple(equation for equation in equations if not (equation.extended or equation.cause))
    return (
        *_extended(equations, extension),
        *_families(versions, own),
        *_symmetric(own),
        *told,
        *_conventions(versions, equations),
        *_recombined(equations),
    )


def _extended(equations: tuple[EquationChange, ...], extension: Extension | None) -> list[EquationGroup]:
    longer = sum(equation.how == EXTENDED for equation in equations)
    own = sum(equation.how == MEMBER for equation in equations)
    if extension is None or not longer + own:
        return []
    says = f"{extension.says}: {longer} equations differ only by terms of these members, {own} belong to these members"
    return [EquationGroup("extended", says, tuple(sorted(extension.names)))]


def _families(versions: Versions, equations: Sequence[EquationChange]) -> list[EquationGroup]:
    """Return groups of rows that differ only in the number of their equal part, with equal edits."""
    indexed = _indexed(versions)
    stories: dict[tuple[str, ...], list[EquationChange]] = {}
    for equation in equations:
        if equation.verdict not in (EquationVerdict.CHANGED, EquationVerdict.ADDED, EquationVerdict.REMOVED):
            continue
        edits = [f"{edit.kind} {' > '.join(edit.path)} {edit.says}" for edit in equation.edits]
        story = tuple(_generic(text, indexed) for text in (equation.verdict, equation.kind, equation.name, *edits))
        stories.setdefault(story, []).append(equation)
    families = []
    for (_, _, name, *_), members in stories.items():
        names = tuple(dict.fromkeys(equation.name for equation in members))
        if len(names) > 1 and "_i" in name:
            says = "; ".join(_generic(edit.says, indexed) for edit in members[0].edits) or members[0].verdict.value
            families.append(EquationGroup("family", f"for every i: {says}", names))
    return families


def _symmetric(equations: tuple[EquationChange, ...]) -> list[EquationGroup]:
    """Return groups of rows, one per vector or matrix, whose entries have equal edits up to signs."""
    stories: dict[tuple[object, ...], list[EquationChange]] = {}
    for equation in equations:
        if equation.verdict is EquationVerdict.CHANGED and equation.edits and equation.kind != "equation":
            edits = frozenset((edit.kind, any_axis(edit.says)) for edit in equation.edits)
            about = equation.kind, any_axis(equation.name), any_axis(equation.title), edits
            stories.setdefault(about, []).append(equation)
    symmetric = []
    for members in stories.values():
        names = tuple(dict.fromkeys(equation.name for equation in members))
        if len(names) > 1:
            says = "; ".join(dict.fromkeys(_unsigned(edit.says) for edit in members[0].edits))
            symmetric.append(EquationGroup("symmetric", f"{_titles(members)}: {says}", names))
    return symmetric


def any_axis(text: str) -> str:
    """Return a text without signs and with one letter for every axis."""
    return _AXIS.sub("_", _unsigned(text))


def _unsigned(text: str) -> str:
    return _SIGN.sub("", text)


def _titles(members: Sequence[EquationChange]) -> str:
    """Return the common part of several equations' titles, followed by the differing parts."""
    titles = list(dict.fromkeys(equation.title for equation in members))
    if len(titles) == 1:
        return titles[0]
    words = zip(*(title.split() for title in titles), strict=False)
    stem = " ".join(word for word, *others in itertools.takewhile(lambda same: len(set(same)) == 1, words))
    return f"{stem} {', '.join(title.removeprefix(stem).strip() for title in titles)}".strip()


def _indexed(versions: Versions) -> Mapping[str, str]:
    """Return the generic names of quantities that exist once per equal part."""
    names: dict[str, str] = {}
    for document in (versions.old, versions.new):
        names |= {symbol.name: f"{symbol.family}_i" for symbol in document.symbols if symbol.family}
        names |= {row.name: f"{row.family}_i" for row in document.definitions if row.family}
    return names


def _generic(text: str, indexed: Mapping[str, str]) -> str:
    return re.sub(r"[A-Za-z_][A-Za-z_0-9]*", lambda word: indexed.get(word[0], word[0]), text)


def _conventions(versions: Versions, equations: tuple[EquationChange, ...]) -> list[EquationGroup]:
    """Return changed definitions whose users have equal values."""
    uses = {item.name: [child.name for child in versions.children(item)] for item in versions.news}
    drawn = {equation.name for equation in equations if equation.kind == PICTURE and equation.verdict in UNEQUAL}
    for name in reversed(uses):  # users come after what they use
        drawn |= {*uses[name]} if name in drawn else set()
    conventions = []
    for equation in equations:
        if equation.verdict is not EquationVerdict.CHANGED or equation.matters or equation.name in drawn:
            continue
        users = tuple(
            other.name
            for other in equations
            if other.verdict is EquationVerdict.REARRANGED and equation.name in uses.get(other.name, ())
        )
        what = "sign" if len(equation.edits) == 1 and equation.edits[0].kind == "sign" else "convention"
        says = f"the {what} of {equation.name} changed; {', '.join(users) or 'its users'} compensate"
        conventions.append(EquationGroup("convention", says, (equation.name, *users)))
    return conventions


def _recombined(equations: tuple[EquationChange, ...]) -> list[EquationGroup]:
    names = tuple(equation.name for equation in equations if equation.how.startswith("recombined"))
    return (
        [EquationGroup("recombined", "equations of motion were combined; the accelerations are equal", names)]
        if names
        else []
    )
