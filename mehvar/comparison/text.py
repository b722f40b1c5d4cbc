# SPDX-License-Identifier: Apache-2.0
"""Document of a comparison as indented text, coloured and wrapped on a terminal."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from rich.text import Text

from mehvar.base.errors import first_names
from mehvar.codegen.diff.report import EquationVerdict
from mehvar.terminal import Line

from .document import Block, Card, Group, Table, Words

_ROWS = 8
"""Number of printed rows of a table; a page has all."""
_NAMED = 12
"""Number of names in a line."""
_BEFORE = {"new": " -> ", "unit": " "}
"""Separators before the cells of a column."""


def lines(blocks: Iterable[Block], indent: int) -> Iterator[Line]:
    """Yield the lines of blocks."""
    for block in blocks:
        match block:
            case Words():
                yield indent, Text(block.text, "bold" if block.strong else "")
            case Table():
                yield indent, Text(block.title)
                kept = block.rows if len(block.rows) <= _ROWS + 1 else block.rows[:_ROWS]
                yield from ((indent + 2, Text(_row(dict(zip(block.heads, row, strict=True))))) for row in kept)
                if len(block.rows) > len(kept):
                    yield indent + 2, Text(f"and {len(block.rows) - len(kept)} more")
            case Card():
                yield from _card(block, indent)
            case Group(folded=True):
                if block.names:
                    yield indent, Text(f"{block.title}: {first_names(block.names, _NAMED, spare=1)}")
            case Group():
                yield indent, Text(block.title, "bold")
                yield from lines(block.blocks, indent + 2)


def _row(cells: dict[str, str]) -> str:
    """Return the cells of a row that are not empty."""
    text, last = "", ""
    for head, cell in cells.items():
        if cell:
            alone = head == "new" and last != "old"
            text += ("  " if alone else _BEFORE.get(head, "  ")) * bool(text) + cell
            last = head
    return text


def _card(card: Card, indent: int) -> Iterator[Line]:
    """Yield the lines of an equation: verdict and title, edits with their parts, remarks."""
    undecided = card.equation.verdict is EquationVerdict.UNDECIDED
    style = "yellow" if undecided else "red" if card.equation.matters else "cyan"
    yield indent, Text.assemble((card.equation.verdict.value, style), " ", (card.title, "bold"))
    for edit in card.edits:
        yield indent + 2, Text(edit.title)
        for sign, part, style in (("-", edit.old, "red"), ("+", edit.new, "green")):
            if part:
                yield indent + 4, Text(f"{sign} {part.text}", style)
    for remark in card.remarks:
        yield indent + 2, Text(remark, "dim")
