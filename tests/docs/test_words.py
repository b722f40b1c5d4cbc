# SPDX-License-Identifier: Apache-2.0
"""One word a concept: the synonyms that the glossary excludes stand on no page, in no message and in no docstring."""

from __future__ import annotations

import ast
import functools
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
ROOMS = ("mehvar", "models", "codegen", "runtime", "papers", "benchmarks", "tests", "docs")
EXCLUDED = [
    word.strip()
    for row in re.findall(
        r"^\| (.+?) \|",
        (ROOT / "docs" / "glossary.md").read_text(encoding="utf-8").partition("| avoid | write |\n|---|---|\n")[2],
        re.MULTILINE,
    )
    for word in row.split(",")
]
HABITS = ["what there is", "so many", "in nobody's way", "an int"]
"""Phrases that readers had to read twice."""
STACKED = ["nobody", "one's own", "what becomes", "that there are", "that there is", "cannot be told", "does not tell",
           "is there already", "is meant", "must go with", "bits do not mix"]  # fmt: skip
"""More of them, in pages and in the product: tests and papers may quote them."""


def phrases(words: list[str]) -> re.Pattern[str]:
    """Return a pattern of whole words."""
    return re.compile(r"\b(" + "|".join(map(re.escape, words)) + r")\b", re.IGNORECASE)


PATTERN = phrases([*EXCLUDED, *HABITS])
PRODUCT = phrases([*EXCLUDED, *HABITS, *STACKED])
QUESTION = re.compile(r"(What|Whether|Who|Which|Where|How|When|Why)\b")


def sources() -> Iterator[Path]:
    for room in ROOMS:
        yield from sorted((ROOT / room).rglob("*.py"))


@functools.cache
def texts(path: Path) -> list[tuple[int, str, bool]]:
    """Return line and text of each string of a module, and whether it stands alone, as a docstring does."""
    nodes = list(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))
    alone = {id(node.value) for node in nodes if isinstance(node, ast.Expr)}
    strings = (node for node in nodes if isinstance(node, ast.Constant) and isinstance(node.value, str))
    return [(node.lineno, str(node.value), id(node) in alone) for node in strings]


def pages() -> list[Path]:
    """Return the pages; the glossary has the words themselves."""
    own = [page for page in (ROOT / "docs").rglob("*.md") if page.name != "glossary.md"]
    return sorted([ROOT / "README.md", ROOT / "CONTRIBUTING.md", *own])


def test_the_glossary_excludes_words() -> None:
    assert {"to the bit", "held against", "what a law sees"} <= set(EXCLUDED)
    assert PATTERN.search("Equal to the bit.")
    assert not PRODUCT.search("bit-identical, an integer")
    assert PRODUCT.search("Return what becomes of commands.")


@pytest.mark.parametrize("page", pages(), ids=lambda page: str(page.relative_to(ROOT)))
def test_a_page_uses_the_words_of_the_glossary(page: Path) -> None:
    prose = re.sub(r"`[^`\n]*`", "", page.read_text(encoding="utf-8"))
    assert not PRODUCT.findall(" ".join(prose.split()))


def test_code_uses_the_words_of_the_glossary() -> None:
    """In docstrings and messages."""
    faults = []
    for path in sources():
        if path == Path(__file__):
            continue
        pattern = PRODUCT if path.relative_to(ROOT).parts[0] in ROOMS[:4] else PATTERN
        for line, text, _ in texts(path):
            faults += [(str(path), line, word) for word in pattern.findall(" ".join(text.split()))]
    assert not faults


def test_a_docstring_names_its_thing() -> None:
    """It answers "what is this" and does not ask it, beside a function, a class, a module or a value."""
    asking = []
    for path in sources():
        for _, text, alone in texts(path):
            if alone and QUESTION.match(text.strip()):
                asking.append(f"{path.relative_to(ROOT)}: {text.strip().splitlines()[0]}")
    assert not asking


WRITTEN = {
    "docs/numbers.md": "docs.site.numbers",
    "docs/reference/capabilities.md": "docs.site.capabilities",
    "docs/reference/mistakes.md": "docs.site.mistakes",
    "docs/reference/options.md": "docs.site.options",
    "docs/reference/targets.md": "tests.runtime.board.everywhere",
}
"""Pages that a program writes: tables of measurements, and texts of commands that count where they stand."""
TABLE = re.compile(r"<!-- (?:table|summary): written by .+ -->\n+(?:\|.*\n)+")
"""A table that a program writes into a page."""


def test_the_pages_keep_to_fifty_thousand_words() -> None:
    """As `wc -w` counts: code, comments and the bars of tables too."""
    texts = {
        str(page.relative_to(ROOT)): page.read_text(encoding="utf-8")
        for page in (ROOT / "README.md", *(ROOT / "docs").rglob("*.md"))
    }
    assert set(texts) > set(WRITTEN)
    assert all((ROOT / f"{name.replace('.', '/')}.py").is_file() for name in WRITTEN.values())
    counted = (TABLE.sub("", text) for page, text in texts.items() if page not in WRITTEN)
    assert sum(len(text.split()) for text in counted) <= 50_000
