# SPDX-License-Identifier: Apache-2.0
"""Documents of a comparison as Markdown for a pull request, with tables, edits as diffs, and folded details."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from html import escape

from .document import Block, Card, Group, Table, Words
from .result import Diff

_LONGEST = 60_000
"""Largest number of characters; GitHub refuses comments above 65 536, and a sender may add some lines."""


def markdown(diff: Diff) -> str:
    """Return the comment as text."""
    paragraphs = [f"## Equations: {_code(diff.old)} → {_code(diff.new)}"]
    for model in diff.parts:
        paragraphs += (f"### {model.name}: {model.status.headline}", model.counts, *_paragraphs(model.blocks))
    text = "\n\n".join(filter(None, paragraphs)) + "\n"
    if len(text) <= _LONGEST:
        return text
    kept = text[: text.rindex("\n\n", 0, _LONGEST)]
    closed = "\n```\n" if kept.count("\n```") % 2 else ""
    closed += "\n</details>\n" * (kept.count("<details>") - kept.count("</details>"))
    return f"{kept}\n{closed}\nCut here: `mehvar diff --out page.html` has all of it.\n"


def _paragraphs(blocks: Iterable[Block]) -> Iterator[str]:
    """Yield the paragraphs of blocks."""
    for block in blocks:
        match block:
            case Words():
                yield f"**{_plain(block.text)}**" if block.strong else _plain(block.text)
            case Table():
                yield f"**{_plain(block.title)}**"
                if block.rows:
                    yield "\n".join(map(_row, (block.heads, ["---"] * len(block.heads), *block.rows)))
            case Card():
                yield from _card(block)
            case Group(folded=True):
                yield f"<details><summary>{escape(block.title)}</summary>"
                yield from _paragraphs(block.blocks)
                yield "</details>"
            case Group():
                yield f"#### {_plain(block.title)}"
                yield from _paragraphs(block.blocks)


def _card(card: Card) -> Iterator[str]:
    """Yield verdict and title of an equation, its edits as a diff, and its remarks as a list."""
    yield f"**{card.equation.verdict}** {_code(card.title)}"
    parts = [(f"# {e.title}", e.old and f"- {e.old.text}", e.new and f"+ {e.new.text}") for e in card.edits]
    if parts:
        yield "\n".join(("```diff", *(line for lines in parts for line in lines if line), "```"))
    yield "\n".join(f"- {_plain(remark)}" for remark in card.remarks)


def _row(cells: Sequence[str]) -> str:
    return f"| {' | '.join(map(_plain, cells))} |"


def _code(text: str) -> str:
    return f"`{text.replace('`', chr(39))}`"


def _plain(text: str) -> str:
    """Escape a text for Markdown with HTML and formulas."""
    return "".join(f"\\{letter}" if letter in "\\`*_<>#|[]&~$" else letter for letter in text)
