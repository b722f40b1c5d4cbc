# SPDX-License-Identifier: Apache-2.0
"""Result of a comparison as frozen values, for pages, terminals and tests."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import Any

from ..equal.verdicts import Counterexample
from ..equations.document import Row

Path = tuple[int, ...]
"""Positions of operands along the path from an expression's root to one of its parts."""


PICTURE = "geometry"
"""Kind of the results that are points of the picture."""
EXTENDED = "the same expression with terms of further members of a family"
MEMBER = "of a member of a family that the other version lacks"
"""Reason for a change that has no other cause than a new number of equal parts, such as pendulums."""


class ModelStatus(StrEnum):
    """State of a model in two versions, in one word."""

    SAME = "same"
    NAMES = "names changed"
    PARAMETERS = "parameters changed"
    PICTURE = "picture changed"
    UNDECIDED = "undecided"
    CHANGED = "changed"
    ADDED = "added"
    REMOVED = "removed"

    @property
    def headline(self) -> str:
        """Status as the first line of a report."""
        return _HEADLINES.get(self, self.value.upper())


_HEADLINES = {
    ModelStatus.SAME: "physics the SAME",
    ModelStatus.NAMES: "physics the SAME, names or order CHANGED",
    ModelStatus.PARAMETERS: "equations the SAME, numbers or names CHANGED",
    ModelStatus.PICTURE: "physics the SAME, picture CHANGED",
    ModelStatus.UNDECIDED: "physics UNDECIDED",
    ModelStatus.CHANGED: "physics CHANGED",
}


class EquationVerdict(StrEnum):
    """Verdict on an equation in two versions.

    `SAME`: the same text. `REARRANGED`: different text, equal value. `RENAMED`: equal value under another name.
    `SCALED`: an equation `0 = ...` was multiplied by a nonzero factor. `CHANGED`: its own text has another meaning.
    `INHERITED`: its value differs only because a definition it uses has changed. `ADDED`, `REMOVED`: on one side only.
    `UNDECIDED`: neither equality nor a difference could be shown; never counts as the same.
    """

    CHANGED = "changed"
    ADDED = "added"
    REMOVED = "removed"
    UNDECIDED = "undecided"
    INHERITED = "inherited"
    REARRANGED = "rearranged"
    RENAMED = "renamed"
    SCALED = "scaled"
    SAME = "same"


UNEQUAL = frozenset((EquationVerdict.CHANGED, EquationVerdict.INHERITED, EquationVerdict.UNDECIDED))
"""Verdicts on equations of both sides whose values differ or may differ."""


class Kind(StrEnum):
    """Kind of an edit of a term."""

    SIGN = "sign"
    COEFFICIENT = "coefficient"
    FACTOR = "factor"
    EXPONENT = "exponent"
    SYMBOL = "symbol"
    FUNCTION = "function"
    TERM_ADDED = "term added"
    TERM_REMOVED = "term removed"
    REWRITTEN = "rewritten"


@dataclass(frozen=True)
class Part:
    """Part of an expression as text.

    Attributes
    ----------
    text, latex : str
        The part as plain text and as LaTeX.
    places : tuple of Path
        Its places in the expression on its own side, for marking; empty if it does not occur there as written.
    """

    text: str
    latex: str
    places: tuple[Path, ...] = ()


@dataclass(frozen=True)
class Edit:
    """One change inside an expression.

    Attributes
    ----------
    kind : Kind
        Kind of the edit.
    path : tuple of str
        Its place: the term, then the factor, from outside to inside, as plain text of the old side.
    old, new : Part or None
        The part before and after; None for a term that was added or removed.
    says : str
        The edit in words, such as "sign flipped: + became -".
    """

    kind: Kind
    path: tuple[str, ...]
    old: Part | None
    new: Part | None
    says: str


@dataclass(frozen=True)
class EquationChange:
    """Comparison of the old and the new form of a definition, a shown equation or a result.

    Attributes
    ----------
    name : str
        Its name on the new side; on the old side if it was removed.
    old_name : str
        Its name on the old side; empty if it was added.
    kind : str
        "definition", "equation", or the kind of a result: "rhs", "output", "law", ...
    section, number, title, unit, latex : str
        As in the model; `latex` is its left side.
    verdict : EquationVerdict
        Its fate.
    how : str
        Reason for the verdict: "node identity", "3 points of a 154-bit field, seed 5", "64 points", "50 digits", ...
    matters : bool
        True if the physics differs. False for a definition that was added, removed or changed while every equation and
        result that uses it is equal, a change of name or convention; and for points of the picture.
    edits : tuple of Edit
        For a source of change: its edits, term by term.
    replayed : bool
        True if applying these edits to the old side was tested to give the new side.
    counterexample : Counterexample or None
        A point where the old (left) and the new side differ.
    held : tuple of str
        The changed definitions that keep their old values in the counterexample, so that it shows this change alone.
    via : tuple of str
        For an inherited change: the names of its sources.
    users : tuple of str
        For a source: the names that inherit its change.
    cause : str
        For a change that follows from another text: the name of that text, or "equations of motion".
    old_node, new_node : int or None
        Its expression: numbers of nodes in `Comparison.old_nodes` and `Comparison.new_nodes`.
    """

    name: str
    old_name: str
    kind: str
    section: str
    number: str
    title: str
    unit: str
    latex: str
    verdict: EquationVerdict
    how: str
    matters: bool = False
    edits: tuple[Edit, ...] = ()
    replayed: bool = False
    counterexample: Counterexample | None = None
    held: tuple[str, ...] = ()
    via: tuple[str, ...] = ()
    users: tuple[str, ...] = ()
    cause: str = ""
    old_node: int | None = None
    new_node: int | None = None

    @property
    def extended(self) -> bool:
        """True if another number of equal parts explains the change."""
        return self.how in (EXTENDED, MEMBER)


def label(row: Row | EquationChange) -> str:
    """Return the shortest name of an equation; for a shown equation, its number."""
    return row.number or row.title or row.name if row.kind == "equation" else row.name


def handle(row: Row | EquationChange) -> str:
    """Return a unique name of an equation: its left side, or its number if the left side is 0."""
    return label(row) if row.latex == "0" and row.kind == "equation" else row.name


@dataclass(frozen=True)
class EquationGroup:
    """Group of related changes with a common description.

    Attributes
    ----------
    kind : str
        "family": the same edit for every member of a family. "convention": a definition changed and its users
        compensate. "recombined": implicit equations differ individually, but have the same solution. "extended":
        families have more members on one side; the names are those of the members. "symmetric": the same edit in every
        axis. "follows": a cause, listed first, and its consequences. "solved": solutions of equations of motion that
        changed.
    says : str
        The description in one line.
    names : tuple of str
        Its equations, sources first.
    """

    kind: str
    says: str
    names: tuple[str, ...]


@dataclass(frozen=True)
class ParameterChange:
    """Difference in the names of a model, or in the numbers of its manifest.

    Attributes
    ----------
    name : str
        The parameter, state or input; "law.name" for a parameter of a law, "scenario NAME.name" for its values.
    role : str
        "state", "input", "parameter", "law ...", "scenario", ...
    what : str
        "value", "unit", "bounds", "source", "sign", "direction", "ends", "added", "removed" or "renamed".
    old, new : str
        Before and after; empty if there is no value.
    unit : str
        Unit of a value or of bounds; empty without one.
    """

    name: str
    role: str
    what: str
    old: str
    new: str
    unit: str = ""

    @property
    def only_names(self) -> bool:
        """True for a new name, and for a new order of vectors; the order of scenarios and events affects runs."""
        return self.what == "renamed" or (self.what == "order" and self.name not in ("scenarios", "events"))


@dataclass(frozen=True)
class Comparison:
    """Comparison of two versions of a model's equations.

    Attributes
    ----------
    model : str
        Its name.
    equations : tuple of EquationChange
        Every definition, shown equation and result of either side, in the order of the new side.
    parameters : tuple of ParameterChange
        Names, units, bounds, sources and numbers that differ.
    groups : tuple of Story
        Groups of related equations.
    structure : tuple of (str, str, str)
        Structural choices that differ: name, old and new value.
    old_nodes, new_nodes : tuple
        Expression graphs that the nodes of `equations` refer to, as in equations.json.
    old_latex, new_latex : tuple of (str, str)
        LaTeX names of the symbols of either side.
    renamed : tuple of (str, str)
        Old and new names of parts, laws, scenarios, symbols and definitions; everything else has the new names.
    """

    model: str
    equations: tuple[EquationChange, ...]
    parameters: tuple[ParameterChange, ...] = ()
    groups: tuple[EquationGroup, ...] = ()
    structure: tuple[tuple[str, str, str], ...] = ()
    old_nodes: tuple[tuple[Any, ...], ...] = ()
    new_nodes: tuple[tuple[Any, ...], ...] = ()
    old_latex: tuple[tuple[str, str], ...] = ()
    new_latex: tuple[tuple[str, str], ...] = ()
    renamed: tuple[tuple[str, str], ...] = ()

    def extended(self) -> frozenset[str]:
        """Return the names of the equal parts that one side lacks."""
        return frozenset(name for group in self.groups if group.kind == "extended" for name in group.names)

    @property
    def sources(self) -> tuple[EquationChange, ...]:
        """Equations with a changed meaning of their own text: the causes of other changes."""
        return self.of(EquationVerdict.CHANGED)

    @property
    def changed(self) -> tuple[EquationChange, ...]:
        """Equations whose value changed or is undecided, by their own text or through definitions."""
        return tuple(equation for equation in self.of(*UNEQUAL) if equation.matters)

    @property
    def added(self) -> tuple[EquationChange, ...]:
        """Equations of the new side only."""
        return self.of(EquationVerdict.ADDED)

    @property
    def removed(self) -> tuple[EquationChange, ...]:
        """Equations of the old side only."""
        return self.of(EquationVerdict.REMOVED)

    @property
    def equivalent(self) -> tuple[EquationChange, ...]:
        """Equations with a different text or name but the same meaning."""
        return self.of(EquationVerdict.REARRANGED, EquationVerdict.RENAMED, EquationVerdict.SCALED)

    @property
    def differs(self) -> bool:
        """True if the physics differs or is undecided, including parameters and structural choices."""
        return bool(self.parameters or self.structure or self.renamed) or any(
            equation.matters for equation in self.equations
        )

    @property
    def pictured(self) -> tuple[EquationChange, ...]:
        """Points of the picture that differ."""
        verdicts = *UNEQUAL, EquationVerdict.ADDED, EquationVerdict.REMOVED
        return tuple(equation for equation in self.of(*verdicts) if equation.kind == PICTURE)

    def of(self, *verdicts: EquationVerdict) -> tuple[EquationChange, ...]:
        """Return the equations with one of these verdicts."""
        return tuple(equation for equation in self if equation.verdict in verdicts)

    def counts(self) -> dict[str, int]:
        """Count the equations by verdict."""
        return {verdict.value: len(self.of(verdict)) for verdict in EquationVerdict}

    def __iter__(self) -> Iterator[EquationChange]:
        return iter(self.equations)

    def __getitem__(self, name: str) -> EquationChange:
        """Return the first equation with this name.

        Raises
        ------
        KeyError
            If there is none.
        """
        for equation in self.equations:
            if equation.name == name:
                return equation
        raise KeyError(name)

    def to_json(self) -> dict[str, Any]:
        """Return everything except the graphs as plain lists, dicts and strings."""
        graphs = ("old_nodes", "new_nodes", "old_latex", "new_latex")
        plain = {key: value for key, value in asdict(self).items() if key not in graphs}
        for equation in plain["equations"]:
            if point := equation["counterexample"]:  # schema 1 calls the sides old and new
                equation["counterexample"] = {"at": point["at"], "old": point["left"], "new": point["right"]}
        return {"counts": self.counts(), **plain}
