# SPDX-License-Identifier: Apache-2.0
"""Comparison of two documents: a verdict on each row, and edits of changed rows."""

from __future__ import annotations

import functools
from collections.abc import Iterator, Sequence, Set
from dataclasses import replace

from ..equal.verdicts import Verdict
from ..equations.document import Document, Row
from .changes import Change
from .explain import Explainer
from .grouping.causes import MOTION, causes, solving, turns
from .grouping.extension import Extended, extension
from .grouping.groups import groups
from .implicit import recombined, scale
from .lost import Lost, lost_definitions
from .names import Renaming, exchange, renaming
from .parameters import parameter_changes
from .points.allowed import CONDITIONS, Allowed
from .points.modes import Modes
from .points.opinion import check_in_double
from .report import (
    EXTENDED,
    MEMBER,
    PICTURE,
    UNEQUAL,
    Comparison,
    EquationChange,
    EquationGroup,
    EquationVerdict,
    handle,
)
from .versions import Item, Key, Versions

_EQUAL = frozenset((EquationVerdict.SAME, EquationVerdict.REARRANGED, EquationVerdict.RENAMED, EquationVerdict.SCALED))

_PROOFS = ("node identity", "same expression of equal names")
"""Reasons for equality that need no evaluation."""


def compare(old: Document, new: Document) -> Comparison:
    """Compare the equations of two versions of a model.

    Parameters
    ----------
    old, new : Document
        As read by `Document.read`; with a manifest, numbers are compared too.

    Returns
    -------
    Comparison
        A verdict on every definition, shown equation and result.
    """
    if names := exchange(old, new):
        result = _compare(old, new, names)
        if all(equation.verdict in _EQUAL for equation in result.equations):
            return result
    return _compare(old, new, renaming(old, new))


def _compare(old: Document, new: Document, names: Renaming) -> Comparison:
    """Compare two versions, of which the old one receives new names."""
    former = names.document(old, new)
    verdicts = _Verdicts(Versions(former, new))
    structure = sorted({*old.structure, *new.structure})
    return Comparison(
        new.model,
        verdicts.equations,
        parameter_changes(former, new, names),
        groups(verdicts.versions, verdicts.equations, verdicts.extension, verdicts.stories),
        tuple(
            (name, old.structure.get(name, "default"), new.structure.get(name, "default"))
            for name in structure
            if old.structure.get(name) != new.structure.get(name)
        ),
        old.nodes,
        new.nodes,
        tuple(old.latex.items()),
        tuple(new.latex.items()),
        tuple({**names.names, **names.wholes}.items()),
    )


class _Verdicts:
    """Verdicts on rows in order: definitions come before the rows that use them."""

    def __init__(self, versions: Versions) -> None:
        self.versions = versions
        self.verdict: dict[Key, tuple[EquationVerdict, Verdict]] = {}
        self.sources: dict[Key, dict[Key, None]] = {}
        """For each row with a different value, the rows that cause the difference."""
        self.names = {item.key: item.name for item in versions.news}
        self._overruled: dict[Key, Verdict] = {}
        self._modes = Modes(versions)
        self._allowed = Allowed(versions)
        self._decide_all()
        self._ask_again()
        self.lost: dict[Key, Lost] = {}
        self.extension = extension(versions.old, versions.new)
        self._extended = self._extensions()
        if any(judged[0] in UNEQUAL for judged in self.verdict.values()):
            self._recombined()
            self._lost()
        self.stories: list[EquationGroup] = []
        self._cause = self._causes()

    def _decide_all(self) -> None:
        for item in self.versions.news:
            partner = self.versions.partner.get(item.key)
            if partner is None:
                self.verdict[item.key] = (EquationVerdict.ADDED, Verdict(None, "no such equation before"))
            else:
                self.verdict[item.key] = self._at_modes(partner, item, *self._decide(partner, item))

    def _at_modes(
        self, old: Item, new: Item, fate: EquationVerdict, verdict: Verdict
    ) -> tuple[EquationVerdict, Verdict]:
        """Return the verdict on a row; "different" if the sides differ for some value of a mode."""
        if fate not in _EQUAL or verdict.how in _PROOFS:
            return fate, verdict
        sides = (self.versions.before, old.root), (self.versions.after, new.root)
        other = self._modes.at_thresholds(*sides)
        if other is None and fate is not EquationVerdict.SCALED:  # whose sides differ by a factor
            other = self._modes.at_start(*sides)
        if other is None:
            return fate, verdict
        causes = [child.key for child in self.versions.children(new) if self._differs(child)]
        self.sources[new.key] = {key: None for cause in causes for key in self.sources.get(cause, {})} or {
            new.key: None
        }
        if other.equal is None:
            return EquationVerdict.UNDECIDED, other
        return (EquationVerdict.INHERITED if causes else EquationVerdict.CHANGED), other

    def _ask_again(self) -> None:
        """Check verdicts "equal" with a second method, and decide again if the methods disagree."""
        tested = [item for item in self.versions.news if self._is_tested(item)]
        if not tested:
            return
        before, after, partner = self.versions.before, self.versions.after, self.versions.partner
        pairs = [((before, partner[item.key].root), (after, item.root)) for item in tested]
        verdicts, count = check_in_double(self.versions.equality, pairs)
        self._overruled = {tested[number].key: verdict for number, verdict in verdicts.items()}
        if self._overruled:
            self.sources.clear()
            self._decide_all()
        for item in tested:
            fate, verdict = self.verdict[item.key]
            if fate in _EQUAL:
                self.verdict[item.key] = fate, replace(verdict, how=f"{verdict.how}; {count} points in double")

    def _is_tested(self, item: Item) -> bool:
        fate, verdict = self.verdict[item.key]
        return fate in _EQUAL - {EquationVerdict.SCALED} and verdict.how not in _PROOFS

    # One row

    def _decide(self, old: Item, new: Item) -> tuple[EquationVerdict, Verdict]:
        """Return the verdict on a pair of rows: by their texts if these and all definitions agree, else by values."""
        versions = self.versions
        children = versions.children(new)
        unequal = [child for child in children if self._differs(child)]
        text = self._same_text(old, new)
        if text and not unequal:
            how = _PROOFS[any(self.verdict[child.key][1].how != "node identity" for child in children)]
            return self._equal(old, new, EquationVerdict.SAME), Verdict(True, how)
        local = Verdict(True, "node identity") if text else self._local(old, new)
        if local.equal and not unequal:
            return self._equal(old, new, EquationVerdict.REARRANGED), local
        whole = self._whole(old, new, local, unequal)
        if whole.equal:
            return self._equal(old, new, EquationVerdict.SAME if text else EquationVerdict.REARRANGED), whole
        if local.equal:
            self.sources[new.key] = {key: None for child in unequal for key in self.sources.get(child.key, {})}
            return self._follower(unequal, whole)
        self.sources[new.key] = {new.key: None}
        if new.row.implicit:
            scaled = scale(versions, old, new)
            if scaled:
                del self.sources[new.key]
                return EquationVerdict.SCALED, Verdict(True, scaled)
        if local.equal is False and new.row.kind not in CONDITIONS:
            local = self._allowed.where_allowed(local, (versions.before, old.root), (versions.across, new.root))
        return (EquationVerdict.UNDECIDED if local.equal is None else EquationVerdict.CHANGED), local

    def _local(self, old: Item, new: Item) -> Verdict:
        """Compare old and new text with equal values of their children."""
        versions = self.versions
        if new.key in self._overruled:
            return self._overruled[new.key]
        pair = (versions.before, old.root), (versions.across, new.root)
        free = (versions.free_old, old.root), (versions.free_new, new.root)
        for sides in (pair, free):
            if versions.equality.field.same(*sides):
                return versions.equality.where_defined(Verdict(True, versions.equality.field.how(*sides)), *pair)
        decision = versions.equality.decide(*pair)
        if decision.equal is None:
            by_text = versions.equality.decide(*free)
            if by_text.equal is False:  # definitions may hide the difference, such as a root of a negative number
                return replace(decision, how=f"{decision.how}; they differ if its names are free")
        return decision

    def _whole(self, old: Item, new: Item, local: Verdict, unequal: list[Item]) -> Verdict:
        """Compare two rows by their values if the rows that they use differ."""
        if not unequal:
            return local
        equality, pair = self.versions.equality, ((self.versions.before, old.root), (self.versions.after, new.root))
        if local.equal:
            return equality.where_defined(Verdict(bool(equality.field.same(*pair)), equality.field.how(*pair)), *pair)
        return equality.decide(*pair)

    def _follower(self, unequal: list[Item], whole: Verdict) -> tuple[EquationVerdict, Verdict]:
        """Return the verdict on a row whose own text is equal and whose definitions differ."""
        undecided = [child.name for child in unequal if self.verdict[child.key][0] is EquationVerdict.UNDECIDED]
        if len(undecided) == len(unequal):
            return EquationVerdict.UNDECIDED, Verdict(None, f"{', '.join(undecided)} may be equal")
        return (EquationVerdict.UNDECIDED if undecided and whole.equal is None else EquationVerdict.INHERITED), whole

    def _same_text(self, old: Item, new: Item) -> bool:
        partners = ((child, self.versions.partner.get(child.key)) for child in self.versions.children(new))
        return old.root == new.root and all(partner and partner.name == child.name for child, partner in partners)

    def _equal(self, old: Item, new: Item, verdict: EquationVerdict) -> EquationVerdict:
        return EquationVerdict.RENAMED if old.name != new.name and new.row.named else verdict

    def _differs(self, item: Item) -> bool:
        return self.verdict[item.key][0] in UNEQUAL

    def _recombined(self) -> None:
        """Mark implicit equations that were combined but describe the same motion."""
        motions = [item for item in self.versions.news if item.row.kind == "motion"]
        if any(self._differs(item) for item in motions) and recombined(self.versions):
            for item in motions:
                if self._differs(item):
                    self.sources.pop(item.key, None)
                    self.verdict[item.key] = (
                        EquationVerdict.SCALED,
                        Verdict(True, "recombined: the same accelerations"),
                    )

    def _extensions(self) -> set[Key]:
        """Return the rows that changed only by terms of added or removed equal parts, such as pendulums."""
        if self.extension is None:
            return set()
        extended, partner = Extended(self.versions, self.extension), self.versions.partner
        return {item.key for item in self._changed() if extended(partner[item.key], item)}

    def _changed(self, without: Set[Key] = frozenset()) -> list[Item]:
        return [
            item
            for item in self.versions.news
            if self.verdict[item.key][0] is EquationVerdict.CHANGED and item.key not in without
        ]

    def _lost(self) -> None:
        """Attribute a change to a removed definition instead of the rows that use it."""
        for lost in lost_definitions(self.versions, self._changed(self._extended)):
            self.lost[lost.item.key] = lost
            self.names[lost.item.key] = lost.item.name
            for user in lost.users:
                self.verdict[user.key] = (EquationVerdict.INHERITED, self.verdict[user.key][1])
                self._blame(user.key, lost.item.key)

    def _causes(self) -> dict[Key, str]:
        """Return for each changed row the name of the row that explains it, if any."""
        changed = self._changed(self._extended)
        solved = solving(self.versions, changed)
        explained: dict[Key, str] = {}
        unsolved = [item for item in changed if item not in solved]
        every = causes(self.versions, unsolved)
        known = {item.key for cause in every for item in (cause.source, *cause.followers)}
        unexplained = [item for item in unsolved if item.key not in known]
        every += turns(unexplained, self._edits_of, self.versions.pool) if len(unexplained) > 1 else []
        for cause in every:
            explained |= dict.fromkeys((item.key for item in cause.followers), handle(cause.source.row))
            self.stories.append(_story("follows", self.explainer.words(cause.says), [cause.source, *cause.followers]))
        if solved:
            says = "the form that is solved for the rates follows the equations of motion, as generation ensures"
            self.stories.append(_story("solved", says, solved))
        return {**explained, **dict.fromkeys((item.key for item in solved), MOTION)}

    def _edits_of(self, item: Item) -> Sequence[Change]:
        return self.explainer.changes(self.versions.partner[item.key], item)[0]

    @functools.cached_property
    def explainer(self) -> Explainer:
        """Explanations of changed rows."""
        return Explainer(self.versions)

    def _blame(self, old: Key, new: Key) -> None:
        for key, sources in self.sources.items():
            self.sources[key] = {new if source == old else source: None for source in sources}

    # The report

    @functools.cached_property
    def equations(self) -> tuple[EquationChange, ...]:
        """All rows of both sides in the new order."""
        return (*map(self._equation, self.versions.news), *map(self._deletion, self.versions.removed))

    @functools.cached_property
    def _users(self) -> dict[Key, dict[str, None]]:
        """For each source, the names of the rows that inherit from it."""
        users: dict[Key, dict[str, None]] = {}
        for item in self.versions.news:
            if self.verdict[item.key][0] in (EquationVerdict.INHERITED, EquationVerdict.UNDECIDED):
                for source in self.sources.get(item.key, {}):
                    if source != item.key:
                        users.setdefault(source, {})[item.name] = None
        return users

    @functools.cached_property
    def _mattering(self) -> set[Key]:
        """Changed equations and results of the physics, their definitions, and unused definitions."""
        versions = self.versions
        used = {child.key for item in versions.news for child in versions.children(item)}
        mattering: set[Key] = set()
        for item in reversed(versions.news):
            if not self._differs(item) or item.row.kind == PICTURE:
                continue
            if not item.row.named or item.key in mattering or item.key not in used:
                mattering.add(item.key)
                mattering |= {child.key for child in versions.children(item) if self._differs(child)}
        return mattering

    def _equation(self, item: Item) -> EquationChange:
        """Return the entry of a row of the new side, with its edits unless another row is the cause."""
        versions, row = self.versions, item.row
        partner = versions.partner.get(item.key)
        verdict, decision = self.verdict[item.key]
        explained = verdict is EquationVerdict.CHANGED and item.key not in {*self._extended, *self._cause}
        explanation = self.explainer.explain(partner, item, decision.point) if partner and explained else None
        return EquationChange(
            name=row.name,
            old_name=partner.row.name if partner else "",
            kind=row.kind,
            section=row.section,
            number=row.number,
            title=row.title,
            unit=row.unit,
            latex=row.latex,
            verdict=verdict,
            how=EXTENDED if item.key in self._extended else self._of_member(item) or decision.how,
            matters=item.key in self._mattering or (verdict is EquationVerdict.ADDED and _is_physics(row)),
            edits=explanation.edits if explanation else (),
            replayed=explanation.replayed if explanation else False,
            counterexample=explanation.counterexample if explanation else None,
            held=tuple(self._held(item)) if explanation and explanation.counterexample else (),
            via=tuple(self.names[k] for k in self.sources.get(item.key, {}) if k != item.key),
            users=tuple(self._users.get(item.key, ())),
            cause=self._cause.get(item.key, ""),
            old_node=partner.row.node if partner else None,
            new_node=row.node,
        )

    def _held(self, item: Item) -> Iterator[str]:
        """Yield the names of the changed definitions whose old values the explanation of a row uses."""
        for child in self.versions.children(item):
            if child.key in self.versions.partner and self._differs(child):
                yield child.name

    def _deletion(self, item: Item) -> EquationChange:
        """Return the entry of a removed row; of a definition "changed" if one edit of it explains all its users."""
        row, lost = item.row, self.lost.get(item.key)
        removed = EquationChange(
            row.name, row.name, row.kind, row.section, row.number, row.title, row.unit, row.latex,
            EquationVerdict.REMOVED, self._of_member(item) or "no such equation any more",
            matters=_is_physics(row), old_node=row.node,
        )  # fmt: skip
        if lost is None:
            return removed
        return replace(
            removed,
            verdict=EquationVerdict.CHANGED,
            how="written out in its users, which this edit reproduces",
            matters=True,
            edits=(self.explainer.edit(lost.change, item.root),),
            replayed=True,
            users=tuple(self._users.get(item.key, ())),
        )

    def _of_member(self, item: Item) -> str:
        """Return a note for a row that belongs to an added or removed part, such as a pendulum; else an empty text."""
        alone = item.key not in self.versions.partner and self.extension is not None
        return MEMBER if alone and self.extension and self.extension.holds(item.name) else ""


def _is_physics(row: Row) -> bool:
    """Return True for an equation or a result, except points of the picture."""
    return not row.named and row.kind != PICTURE


def _story(kind: str, says: str, items: list[Item]) -> EquationGroup:
    return EquationGroup(kind, says, tuple(dict.fromkeys(handle(item.row) for item in items)))
