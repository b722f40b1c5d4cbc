# SPDX-License-Identifier: Apache-2.0
"""Conversion of LaTeX to MathML by latex2mathml; browsers display it without scripts."""

from __future__ import annotations

import functools
import re

_LETTER = re.compile(r"&#x(0*(?!0)[0-9A-F]{3,});")
"""Pattern of a character reference beyond Latin-1, which excludes escaped characters of markup."""

_WORD = re.compile(r'(?:<mi mathvariant="normal">[A-Za-z]</mi>){2,}')
"""Letters of an upright word, which the library writes one by one."""

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
    return inner


def element(content: str) -> str:
    """Return a `math` element that has the same size within a line as on its own line."""
    return f'<math displaystyle="true">{content}</math>'


def mathml(latex: str) -> str:
    """Return LaTeX as a `math` element within a line."""
    return element(f"<mrow>{content(latex)}</mrow>")
