# SPDX-License-Identifier: Apache-2.0
"""Comparison as a self-contained HTML page with old and new formulas side by side in MathML."""

from __future__ import annotations

import importlib.util
from base64 import b64encode
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import groupby
from typing import TYPE_CHECKING, Any

from mehvar.codegen.diff.report import (
    PICTURE,
    Comparison,
    Edit,
    EquationChange,
    EquationGroup,
    EquationVerdict,
    ModelStatus,
    ParameterChange,
    handle,
)
from mehvar.codegen.equations.formula import Marks, Nodes, Printer, SymbolNames
from mehvar.codegen.equations.mathml import mathml
from mehvar.codegen.equations.spelling import LATEX, PAGE
from mehvar.html import page, quantities
from mehvar.pictures.files import pixels, small_png

from .consequences import Consequences
from .marks import Alignment
from .result import Diff, ModelDiff
from .runs import RunChange
from .text import (
    choices,
    counted,
    edit_title,
    evidence,
    example,
    following,
    harmless,
    is_complete,
    joined,
    labels,
    listed_metrics,
    listed_parameters,
    margin_rows,
    number,
    one_by_one,
    outcome,
    place,
    point,
    refused_runs,
    relative,
    same_runs,
    stories,
    title,
    unit,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_FOLDED = (
    (
        EquationVerdict.CHANGED,
        "following from a change above, or the same but for the terms of a family's other members",
    ),
    (EquationVerdict.INHERITED, "inherited: other values, because of the changes above"),
    (EquationVerdict.ADDED, "added, used by other equations or of a family's new members"),
    (EquationVerdict.REMOVED, "removed, were used by other equations or of a family's former members"),
    (EquationVerdict.REARRANGED, "rearranged: written differently, equal"),
    (EquationVerdict.RENAMED, "renamed, equal"),
    (EquationVerdict.SCALED, "scaled: the same equation, multiplied by something"),
)


@dataclass(frozen=True)
class _Side:
    """One side of a formula: its left side and its terms as MathML, with marks on changed terms."""

    left: str
    terms: Sequence[tuple[str, bool]]


@dataclass(frozen=True)
class _Image:
    """A picture as a data URL, with its title and its size in pixels."""

    title: str
    uri: str
    width: int
    height: int


@dataclass(frozen=True)
class _Card:
    """Content of the page about one equation."""

    title: str
    anchor: str
    kind: str
    status: str
    path: str
    edits: Sequence[tuple[str, str]]
    notes: Sequence[str]
    old: _Side | None
    new: _Side | None


@dataclass(frozen=True)
class _Section:
    """Content of the page about one model."""

    name: str
    anchor: str
    kind: str
    status: str
    counted: str
    parts: Sequence[str]
    notes: Sequence[str]
    stories: Sequence[str]
    changed: Sequence[_Card]
    parameters: Sequence[ParameterChange]
    follows: Consequences | None
    same: Sequence[str]
    folded: Sequence[tuple[str, Sequence[_Card]]]
    pictures: Sequence[_Image]

    @property
    def has_content(self) -> bool:
        """True if the section has more than a summary line."""
        return bool(
            self.parts
            or self.notes
            or self.stories
            or self.changed
            or self.parameters
            or self.folded
            or self.follows is not None
        )


_LONG, _SHORT = 3500, 700
"""Characters of MathML of a formula that is shown whole, some 25 factors, and of terms that dots would not shorten."""
_DOTS = mathml(r"+ \cdots")
_MARK = 'class="mark"'
_KINDS = dict.fromkeys((ModelStatus.SAME, ModelStatus.NAMES, ModelStatus.PICTURE), "same")
_KINDS[ModelStatus.UNDECIDED] = "maybe"
_ORDER = {"changed": 0, "maybe": 1, "same": 2}


def html_page(diff: Diff) -> str:
    """Return the page as text."""
    sections = [_Sheet(part).section() for model in diff.models for part in model]
    sections.sort(key=lambda section: _ORDER[section.kind])
    names = ", ".join(model.model for model in diff.models)
    filters: dict[str, Callable[..., Any]] = {
        **{"complex": number, "point": point, "place": place, "unit": unit, "relative": relative},
        **{
            "joined": joined,
            "outcome": outcome,
            "refused_runs": refused_runs,
            "margin_rows": margin_rows,
            "listed": listed_metrics,
            "farthest": _farthest,
            "arrow": _arrow,
        },
    }
    title = f"What changed in {names}"
    return page("diff.html.j2", filters, title=title, old=diff.old, new=diff.new, models=sections) + "\n"


class _Sheet:
    """Builder of the page's content about one model."""

    def __init__(self, model: ModelDiff) -> None:
        self._model = model
        self._comparison: Comparison = model.comparison
        self._old_latex: Mapping[str, str] = dict(self._comparison.old_latex)
        self._new_latex: Mapping[str, str] = dict(self._comparison.new_latex)

    @property
    def _anchor(self) -> str:
        return self._model.name.replace(" ", "-")

    @cached_property
    def _alignment(self) -> Alignment:
        renamed = {e.old_name: e.name for e in self._comparison.of(EquationVerdict.RENAMED)}
        renamed |= dict(self._comparison.renamed)
        return Alignment(self._comparison.old_nodes, self._comparison.new_nodes, renamed)

    def section(self) -> _Section:
        """Return the content of the page about this model."""
        comparison, status = self._comparison, self._model.status
        apart = {equation for equation, _ in one_by_one(comparison)}
        one_each = [(e, self._card(e, group)) for e, group in one_by_one(comparison)]
        folded = [("of the picture only", [card for e, card in one_each if e.kind == PICTURE])]
        folded += [
            (heading, [self._card(equation) for equation in comparison.of(verdict) if self._is_folded(equation, apart)])
            for verdict, heading in _FOLDED
        ]
        return _Section(
            name=self._model.name,
            anchor=self._anchor,
            kind=_KINDS.get(status, "changed"),
            status=status.value,
            counted=counted(comparison),
            parts=self._model.parts,
            notes=[*self._model.notes, *choices(comparison)],
            stories=[*stories(comparison), *filter(None, [following(comparison)])],
            changed=[card for equation, card in one_each if equation.kind != PICTURE],
            parameters=listed_parameters(comparison),
            follows=self._model.consequences,
            same=same_runs(self._model.consequences.runs, comparison) if self._model.consequences else [],
            folded=[(f"{len(cards)} {heading}", cards) for heading, cards in folded if cards],
            pictures=_pictures(self._model),
        )

    @staticmethod
    def _is_folded(equation: EquationChange, apart: set[EquationChange]) -> bool:
        """Return True for an equation that shares the card of an equal part, such as another pendulum."""
        return equation not in apart and (
            equation.verdict is not EquationVerdict.CHANGED or equation.extended or equation.cause != ""
        )

    def _card(self, equation: EquationChange, group: EquationGroup | None = None) -> _Card:
        """Return the card of an equation; pictures, added parts and inherited changes have no formulas."""
        unshown = equation.extended or equation.kind == PICTURE or equation.verdict is EquationVerdict.INHERITED
        old, new = (None, None) if unshown else self._sides(equation)
        kind = "same" if not equation.matters else "changed"
        return _Card(
            title=title(equation, group.names if group else ()),
            anchor=f"{self._anchor}-{equation.name}",
            kind="maybe" if equation.verdict is EquationVerdict.UNDECIDED else kind,
            status=equation.verdict.value,
            path=" > ".join(part for part in (equation.kind, equation.section) if part),
            edits=[(self._part(equation, edit), edit_title(edit)) for edit in equation.edits],
            notes=_notes(self._comparison, equation, group),
            old=old,
            new=new,
        )

    def _sides(self, equation: EquationChange) -> tuple[_Side | None, _Side | None]:
        """Print both forms with the edits marked or, without edits, the textual differences."""
        comparison, old, new = self._comparison, equation.old_node, equation.new_node
        old_marks, new_marks = self._marks(equation)
        before = after = None
        if old is not None:
            left = _left(equation.old_name or equation.name, equation, self._old_latex)
            before = _Side(left, _terms(comparison.old_nodes, old, self._old_latex, old_marks))
        if new is not None:
            left = _left(equation.name, equation, self._new_latex)
            after = _Side(left, _terms(comparison.new_nodes, new, self._new_latex, new_marks))
        return before, after

    def _part(self, equation: EquationChange, edit: Edit) -> str:
        """Print the edited part unless the words of the edit already name it."""
        old = edit.old is not None
        part, root = (edit.old, equation.old_node) if old else (edit.new, equation.new_node)
        if is_complete(edit) or part is None or root is None or not part.places:
            return ""
        nodes = self._comparison.old_nodes if old else self._comparison.new_nodes
        for step in part.places[0]:
            root = int(nodes[root][1 + step])
        return "".join(term for term, _ in _terms(nodes, root, self._old_latex if old else self._new_latex))

    def _marks(self, equation: EquationChange) -> tuple[Marks, Marks]:
        """Return the places to mark on both sides: those of the edits, else the differences of both texts."""
        if equation.old_node is None or equation.new_node is None or equation.verdict is EquationVerdict.SAME:
            return frozenset(), frozenset()
        old, new = (
            frozenset(
                place for edit in equation.edits if (part := getattr(edit, side)) for place in part.places if place
            )
            for side in ("old", "new")
        )  # a mark of the whole would mark no term
        if old and 0 < len(new) <= len(old):  # a symbol that replaces another may occur elsewhere too
            return old, new
        written = self._alignment.marks(equation.old_node, equation.new_node)
        return old or written[0], written[1] if old or not new else new


def _arrow(line: str) -> str:
    """Return a change with its numbers as pages set them."""
    return quantities(line.replace("->", "→"))


def _farthest(runs: Sequence[tuple[RunChange, list[str]]]) -> list[tuple[RunChange, list[str]]]:
    """Return runs in order of their change, largest first."""
    return sorted(runs, key=lambda run: -run[0].size)


def _pictures(model: ModelDiff) -> list[_Image]:
    """Return the overlay of the run that differs most, and the rates and eigenvalues that differ."""
    figures = {
        "The run that differs most, old dashed, new solid": model.overlay.picture(model.name)
        if model.overlay
        else None,
        "What differs of rates and eigenvalues": _effects(model.consequences) if model.consequences else None,
    }
    pngs = {title: small_png(figure, 32) for title, figure in figures.items() if figure is not None}
    return [
        _Image(title, "data:image/png;base64," + b64encode(png).decode(), *pixels(png)) for title, png in pngs.items()
    ]


def _effects(follows: Consequences) -> Figure | None:
    """Return the picture of rates, of the plant's eigenvalues, and of those of the first loop that differs."""
    rates = {f"{rate.name}'": 100 * rate.largest / (rate.typical or rate.largest) for rate in follows.rates}
    spectra = [("eigenvalues without a law", "1/s", follows.eigenvalues)] if follows.eigenvalues else []
    spectra += [
        (
            f"eigenvalues under {loop.law}{', which became unstable' * loop.lost}",
            "1" if loop.period else "1/s",
            loop.eigenvalues,
        )
        for loop in follows.loops[:1]
    ]
    if not (rates or spectra) or importlib.util.find_spec("matplotlib") is None:
        return None
    from mehvar.pictures.overlay import effects_picture
    from mehvar.pictures.style import style

    with style():
        return effects_picture(rates, spectra)


def _terms(nodes: Nodes, root: int, latex: Mapping[str, str], marks: Marks = frozenset()) -> list[tuple[str, bool]]:
    """Return the terms of a formula as separate elements, between which browsers break lines.

    Of a long formula, dots replace the terms without marks, and terms that are long themselves.
    """
    terms = [(mathml(text), marked) for text, marked in Printer(nodes, SymbolNames(latex), PAGE, marks).parts(root)]
    if sum(len(text) for text, _ in terms) < _LONG:
        return terms
    shown: list[tuple[str, bool]] = []
    for changed, group in groupby(terms, lambda term: term[1] or _MARK in term[0]):
        run = list(group)
        if changed:
            shown += [(text, marked) if len(text) < _LONG / 2 else (_DOTS, True) for text, marked in run]
        else:
            shown += run if sum(len(text) for text, _ in run) < _SHORT else [(_DOTS, False)]
    return shown


def _left(name: str, equation: EquationChange, latex: Mapping[str, str]) -> str:
    spelled = equation.latex if equation.kind == "equation" else latex.get(name, equation.latex)
    return mathml(f"{LATEX.name(name, spelled)} =")


def _notes(comparison: Comparison, equation: EquationChange, group: EquationGroup | None) -> list[str]:
    """Return the remarks below an equation: group, example, evidence, users and causes."""
    notes = [group.says if group else "", example(equation), evidence(equation), following(comparison, equation)]
    if equation.users:
        notes.append(f"Inherited by {labels(comparison, equation.users)}.")
    if equation.cause:
        source = next((title(e) for e in comparison.equations if handle(e) == equation.cause), equation.cause)
        notes.append(f"Follows from {source}.")
    if equation.via:
        notes.append(f"Because of {labels(comparison, equation.via)}.")
    if equation.verdict is EquationVerdict.CHANGED and (why := harmless(comparison, equation)):
        notes.append(f"{why[0].upper()}{why[1:]}: no equation or result has another value because of it.")
    return [note for note in notes if note]
