# SPDX-License-Identifier: Apache-2.0
"""LaTeX handed over to latex2mathml: MathML, which browsers draw without a script."""

from __future__ import annotations

import functools
import re

_LETTER = re.compile(r"&#x(0*(?!0)[0-9A-F]{3,});")
"""A letter beyond Latin-1 as a number; signs of markup, which stay escaped, have smaller ones."""


@functools.cache
def content(latex: str) -> str:
    """Return the content of a `math` element.

    The library lacks `aligned`, of which it would print the alignment marks; it has `split`, which is the same.
    """
    from latex2mathml.converter import convert  # a tenth of a second that comparing equations need not wait

    element = convert(latex.strip().replace("{aligned}", "{split}"))
    inner = element[element.index(">") + 1 : element.rindex("</math>")]
    return _LETTER.sub(lambda code: chr(int(code[1], 16)), inner)


def element(content: str) -> str:
    """Return a whole `math` element, as large within a line as on a line of its own."""
    return f'<math displaystyle="true">{content}</math>'


def mathml(latex: str) -> str:
    """Return LaTeX as a whole `math` element within a line."""
    return element(f"<mrow>{content(latex)}</mrow>")
