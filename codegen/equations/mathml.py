# SPDX-License-Identifier: Apache-2.0
"""Conversion of LaTeX to MathML by latex2mathml; browsers display it without scripts."""

from __future__ import annotations

import functools
import re
import xml.etree.ElementTree as ET
from itertools import pairwise

_LETTER = re.compile(r"&#x(0*(?!0)[0-9A-F]{3,});")
"""Pattern of a character reference beyond Latin-1, which excludes escaped characters of markup."""

_WORD = re.compile(r'(<mi mathvariant="normal">)[A-Za-z]</mi>(?:\1[A-Za-z]</mi>|<mn>\d+</mn>)+')
"""Letters and digits of an upright word, which the library writes one by one."""

_BOX = re.compile(r"<mrow>(<m([in])\b[^<>]*>[^<>]*</m\2>)</mrow>")
"""Row of one name or number."""

_INFIX = re.compile(r'<mrow class="infix"><mo>([^<>]*</mo>)</mrow>')
"""Sign of a term, which stands between two terms also where a row begins with it."""


@functools.cache
def content(latex: str) -> str:
    """Return the content of a `math` element.

    The library supports `split` but not the equivalent `aligned`, which is replaced.
    """
    from latex2mathml.converter import convert  # a tenth of a second that comparing equations need not wait

    element = convert(latex.strip().replace("{aligned}", "{split}"))
    inner = element[element.index(">") + 1 : element.rindex("</math>")]
    inner = _LETTER.sub(lambda code: chr(int(code[1], 16)), inner)
    inner = _WORD.sub(lambda word: f"<mi>{re.sub('<[^>]*>', '', word[0])}</mi>", inner)
    inner = _INFIX.sub(r'<mo form="infix">\1', inner)
    while (bare := _BOX.sub(r"\1", inner)) != inner:
        inner = bare
    tree = ET.fromstring(f"<math>{inner}</math>")
    for over in tree.iter("mover"):
        if over[-1].tag == "mo":
            over.set("accent", "true")  # browsers draw the sign as small as an exponent otherwise
    for row in tree.iter("mrow"):
        _set_words_apart(row)
    return "".join(ET.tostring(part, encoding="unicode") for part in tree)


def _set_words_apart(row: ET.Element) -> None:
    """Insert thin spaces between factors of which one is a word, as TeX does around the names of functions."""
    parts = list(row)
    for place, (left, right) in reversed(list(enumerate(pairwise(parts), 1))):
        if _is_factor(left) and _is_factor(right) and (_is_word(right) or (_is_word(left) and not _is_fenced(right))):
            row.insert(place, ET.Element("mspace", width="0.167em"))


def _is_factor(part: ET.Element) -> bool:
    return part.tag not in ("mo", "mspace", "mtext")


def _is_fenced(part: ET.Element) -> bool:
    return part.tag == "mrow" and len(part) > 0 and part[0].tag == "mo"


def _is_word(part: ET.Element) -> bool:
    """Return True for a name of several letters, also with indices, an exponent or a digit."""
    while len(part) and part.tag in ("mrow", "msub", "msup", "msubsup", "mover"):
        part = part[0]
    return part.tag == "mi" and len(part.text or "") > 1


def element(content: str) -> str:
    """Return a `math` element that has the same size within a line as on its own line."""
    return f'<math displaystyle="true">{content}</math>'


def mathml(latex: str) -> str:
    """Return LaTeX as a `math` element within a line."""
    return element(f"<mrow>{content(latex)}</mrow>")
