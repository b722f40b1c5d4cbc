# SPDX-License-Identifier: Apache-2.0
"""Comparison of a model as a document of blocks, which text, Markdown and HTML print alike."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from mehvar.codegen.diff.report import EquationChange, Part

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Words:
    """A line of words; a strong one states a change."""

    kind: ClassVar[str] = "words"
    text: str
    strong: bool = False


@dataclass(frozen=True)
class Table:
    """A table; the columns "old" and "new" stand beside each other."""

    kind: ClassVar[str] = "table"
    title: str
    heads: Sequence[str]
    rows: Sequence[Sequence[str]]


@dataclass(frozen=True)
class EditLines:
    """An edit: its place and words, and both parts unless the words have them."""

    title: str
    old: Part | None
    new: Part | None


@dataclass(frozen=True)
class Card:
    """An equation with its edits and remarks; a page adds both formulas."""

    kind: ClassVar[str] = "card"
    title: str
    equation: EquationChange
    edits: Sequence[EditLines]
    remarks: Sequence[str]


@dataclass(frozen=True)
class Drawing:
    """A picture, drawn by pages alone; None if it cannot be drawn."""

    kind: ClassVar[str] = "drawing"
    title: str
    draw: Callable[[], Figure | None]


@dataclass(frozen=True)
class Group:
    """Blocks under a heading.

    Attributes
    ----------
    title : str
        The heading.
    blocks : sequence of Block
        Its content.
    folded : bool
        True for content that pages fold. Text has one line with the names instead, and no line without names.
    names : sequence of str
        Names of the folded blocks that are not mentioned before.
    """

    kind: ClassVar[str] = "group"
    title: str
    blocks: Sequence[Block]
    folded: bool = False
    names: Sequence[str] = ()


Block = Words | Table | Card | Drawing | Group


def limited(tables: Mapping[str, Table], count: int, rest: str) -> Iterator[Block]:
    """Yield the first tables; fold the others under a heading with their number and names."""
    names, blocks = list(tables), list(tables.values())
    yield from blocks[:count]
    if others := blocks[count:]:
        yield Group(f"{len(others)} more {rest}", others, True, names[count:])
