# SPDX-License-Identifier: Apache-2.0
"""Documents of a comparison as a self-contained HTML page with old and new formulas side by side in MathML."""

from __future__ import annotations

import re
from base64 import b64encode
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import groupby
from typing import Any

from mehvar.codegen.diff.report import PICTURE, Edit, EquationVerdict, ModelStatus
from mehvar.codegen.equations.formula import Marks, Nodes, Path, Printer, SymbolNames
from mehvar.codegen.equations.mathml import mathml
from mehvar.codegen.equations.spelling import LATEX, PAGE
from mehvar.html import page, quantities
from mehvar.pictures.files import pixels, small_png

from .document import Card, Drawing
from .result import Diff, ModelDiff

_LONG, _SHORT = 3500, 700
"""Characters of MathML of a formula that is shown whole, some 25 factors, and of terms that dots would not shorten."""
_DOTS = mathml(r"+ \cdots")
_MARK = 'class="mark"'
_KINDS = dict.fromkeys((ModelStatus.SAME, ModelStatus.NAMES, ModelStatus.PICTURE), "same")
_KINDS[ModelStatus.UNDECIDED] = "maybe"
_ORDER = ("changed", "maybe", "same")


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


def html_page(diff: Diff) -> str:
    """Return the page as text."""
    sheets = sorted(map(_Sheet, diff.parts), key=lambda sheet: _ORDER.index(sheet.kind))
    title = f"What changed in {', '.join(model.model for model in diff.models)}"
    filters: dict[str, Callable[..., Any]] = {"set": _set, "image": _image}
    return page("diff.html.j2", filters, title=title, old=diff.old, new=diff.new, sheets=sheets) + "\n"


def _set(line: str) -> str:
    """Return words with arrows and numbers as pages set them."""
    return quantities(line.replace("->", "→"))


def _image(drawing: Drawing) -> _Image | None:
    """Return a picture for the page."""
    figure = drawing.draw()
    if figure is None:
        return None
    png = small_png(figure, 32)
    return _Image(drawing.title, "data:image/png;base64," + b64encode(png).decode(), *pixels(png))


class _Sheet:
    """Content of the page about one model."""

    def __init__(self, model: ModelDiff) -> None:
        self.model = model
        self.blocks = model.blocks
        self.kind = _KINDS.get(model.status, "changed")
        self.anchor = model.name.replace(" ", "-")
        comparison = model.comparison
        names = {e.old_name: e.name for e in comparison.of(EquationVerdict.RENAMED)} | dict(comparison.renamed)
        self._nodes = comparison.old_nodes, comparison.new_nodes
        self._latex = dict(comparison.old_latex), dict(comparison.new_latex)
        old = [(kind, names.get(of[0], of[0])) if kind == "sym" else (kind, *of) for kind, *of in comparison.old_nodes]
        self._printers = Printer(old), Printer(comparison.new_nodes)

    def sides(self, card: Card) -> list[_Side | None]:
        """Return both formulas; pictures, added parts and inherited changes have none."""
        equation = card.equation
        if equation.extended or equation.kind == PICTURE or equation.verdict is EquationVerdict.INHERITED:
            return []
        roots = equation.old_node, equation.new_node
        names = equation.old_name or equation.name, equation.name
        edits = [edit for edit in equation.edits if not _turns(edit)]
        places = [
            [place for edit in edits if (part := getattr(edit, side)) for place in part.places if place]
            for side in ("old", "new")
        ]
        texts = [self._texts(k, root) for k, root in enumerate(roots)]
        lacking = [_lacking(texts[k], texts[1 - k]) for k in (0, 1)]
        edited = [[place for place in places[k] if any(map(partial(_within, place), lacking[k]))] for k in (0, 1)]
        if len(edited[1]) > max(len(edited[0]), 1):
            edited[1] = []  # an expression that takes the place of another may occur elsewhere too
        sides: list[_Side | None] = []
        for k, root in enumerate(roots):
            if root is None:
                sides.append(None)
                continue
            marks = frozenset(_marks(lacking[k], edited[k]))
            latex = self._latex[k]
            spelled = equation.latex if equation.kind == "equation" else latex.get(names[k], equation.latex)
            left = mathml(f"{LATEX.name(names[k], spelled)} =")
            sides.append(_Side(left, _terms(self._nodes[k], root, latex, marks)))
        return sides

    def _texts(self, side: int, root: int | None) -> dict[Path, str]:
        """Return the terms of an expression by their paths, with the new names of symbols."""
        if root is None:
            return {}
        kind, *operands = self._nodes[side][root]
        nodes = {(k,): node for k, node in enumerate(operands)} if kind == "add" else {(): root}
        return {path: self._printers[side].text(node) for path, node in nodes.items()}


def _turns(edit: Edit) -> bool:
    """Return True for numbers of opposite signs: the sign stands before the term, which is marked as a whole."""
    numbers = [re.match(r"(-?)[\d./e-]+$", part.text) for part in (edit.old, edit.new) if part]
    return len({number[1] for number in numbers if number}) > 1


def _lacking(own: Mapping[Path, str], other: Mapping[Path, str]) -> list[Path]:
    """Return the paths of the terms that the other side lacks."""
    return [path for path, text in own.items() if other and text not in other.values()]


def _within(place: Path, path: Path) -> bool:
    """Return True for a place in the part at a path."""
    return place[: len(path)] == path


def _marks(terms: Sequence[Path], edited: Sequence[Path]) -> Iterator[Path]:
    """Yield the paths to mark: the edited parts of each term; without such parts, the term."""
    for path in terms:
        yield from [place for place in edited if _within(place, path)] or [path]


def _terms(nodes: Nodes, root: int, latex: Mapping[str, str], marks: Marks) -> list[tuple[str, bool]]:
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
