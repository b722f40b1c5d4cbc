# SPDX-License-Identifier: Apache-2.0
"""Print random sentences of the pages, docstrings and messages, for a reader who checks the style.

`python -m docs.site.sample SEED` prints forty of each; the same seed and text give the same sample.
"""

from __future__ import annotations

import ast
import random
import re
import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[2]
ROOMS = ("mehvar", "models", "codegen", "runtime")
WRITTEN = ("numbers", "capabilities", "mistakes", "options", "targets")
"""Pages that programs write."""


COMPOSED = {"unknown_name": "unknown {} NAME; known: NAMES", "self._refused": "FIELD = VALUE: must be {}"}
"""Messages that a function composes of several texts."""


def sentences() -> Iterator[str]:
    """Yield the sentences of paragraphs and lists."""
    for page in sorted((ROOT / "README.md", *(ROOT / "docs").rglob("*.md"))):
        if page.stem in WRITTEN:
            continue
        text = re.sub(
            r"^(`{3,}).*?^\1\s*$|<!--.*?-->", "", page.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE
        )
        for block in re.split(r"\n\s*\n|\n(?=- )", text):
            if not re.match(r"\s*[#|<!]", block):
                words = re.sub(r"\]\([^)]*\)", "]", " ".join(block.split())).removeprefix("- ")
                yield from (s for s in re.split(r"(?<=[.:?]) (?=[A-Z`\[*])", words) if len(s.split()) > 3)


def texts() -> Iterator[ast.AST]:
    """Yield every node of the product's code."""
    for room in ROOMS:
        for path in sorted((ROOT / room).rglob("*.py")):
            yield from ast.walk(ast.parse(path.read_text(encoding="utf-8")))


def docstrings() -> Iterator[str]:
    """Yield the first paragraph of each docstring, of modules, classes, functions and values."""
    for node in texts():
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            yield " ".join(node.value.value.split("\n\n")[0].split())


def messages() -> Iterator[str]:
    """Yield the message of each raised error, with values as words in capitals."""
    for node in texts():
        if isinstance(node, ast.Raise) and isinstance(node.exc, ast.Call) and node.exc.args:
            words = literal(node.exc.args[0])
            if len(re.findall(r"\b[a-z]+\b", words)) > 3:
                yield COMPOSED.get(ast.unparse(node.exc.func), "FIELD{}" if words[0] in ": " else "{}").format(words)


def literal(node: ast.AST) -> str:
    """Return a text with its values as words in capitals; empty for anything but a text."""
    match node:
        case ast.Constant(value=str(text)):
            return text
        case ast.JoinedStr(values=parts):
            return "".join(map(literal, parts))
        case ast.FormattedValue(value=value):
            return capitals(value)
    return ""


def capitals(node: ast.AST) -> str:
    """Return the word in capitals for a value of a message, from the last name in its expression."""
    match node:
        case ast.Call(func=ast.Attribute(attr="join"), args=[joined, *_]):
            return f"{capitals(joined)}, ..."
        case ast.Call(func=ast.Name(id="suggestion" | "origin_text" | "_origins")):
            return ""
        case ast.Call(args=[first, *_]):
            return capitals(first)
        case ast.IfExp(body=value):
            return capitals(value)
        case ast.Subscript(value=value) | ast.GeneratorExp(elt=value) | ast.Starred(value=value):
            return capitals(value)
        case ast.Attribute(attr=name) | ast.Name(id=name):
            return name.strip("_").upper()
    return "VALUE"


def sample(seed: int, number: int = 40) -> Iterator[str]:
    """Yield a sample of each kind, below its name."""
    for kind in (sentences, docstrings, messages):
        yield f"\n{kind.__name__}, seed {seed}:"
        yield from random.Random(f"{seed} {kind.__name__}").sample(sorted(set(kind())), number)


if __name__ == "__main__":
    print("\n".join(sample(int(sys.argv[1]))))
