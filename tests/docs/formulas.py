# SPDX-License-Identifier: Apache-2.0
"""Faults of a rendered formula."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator

MATH = re.compile(r"<math\b.*?</math>", re.DOTALL)
TOKENS = ("mi", "mn", "mo", "mtext")
MARKUP = re.compile(r"[\\&$]|\b(begin|end|left|right|frac|mathrm|quad|aligned|cases)\b")
"""Markup of LaTeX, which must not be visible."""
ARITY = {"mfrac": 2, "msup": 2, "msub": 2, "mover": 2, "munder": 2, "msubsup": 3, "munderover": 3}


def faults(math: str) -> Iterator[str]:
    """Yield the faults of a `math` element: not well-formed, visible LaTeX, unmatched parts."""
    try:
        tree = ET.fromstring(math)
    except ET.ParseError as error:
        yield f"not well-formed: {error}"
        return
    parents = {child: parent for parent in tree.iter() for child in parent}
    for part in tree.iter():
        if part.tag in TOKENS:
            yield from _token_faults(part, parents[part].tag)
        elif (part.text or "").strip() or any((child.tail or "").strip() for child in part):
            yield f"text outside of tokens in <{part.tag}>"
        if part.get("linebreak"):
            yield "a line that ends outside of a table"
        if len(part) != ARITY.get(part.tag, len(part)):
            yield f"<{part.tag}> of {len(part)} parts"
    for table in tree.iter("mtable"):
        if len({len(row) for row in table if len(row)}) > 1:
            yield "rows of different length"
    text = "".join(tree.itertext())
    for opening, closing in ("()", "⌊⌋", "⌈⌉"):
        if text.count(opening) != text.count(closing):
            yield f"{text.count(opening)} {opening} and {text.count(closing)} {closing}"


def _token_faults(token: ET.Element, parent: str) -> Iterator[str]:
    text = token.text or ""
    if MARKUP.search(text):
        yield f"LaTeX shows: {text!r}"
    if re.search(r"[{}]", text) and token.tag != "mo":
        yield f"a brace that is no fence: {text!r}"
    if "^" in text and parent != "mover":
        yield "a power sign that is no hat"
    if text == "_" and parent not in ("mrow", "mpadded"):
        yield "a subscript sign"
