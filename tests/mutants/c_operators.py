# SPDX-License-Identifier: Apache-2.0
"""Mutation operators for the runtime's C, which has no templates, few casts and one statement a line.

The usual tools parse C after the preprocessor; the runtime is written in macros of lanes (SELECT, LT, K), which are
what must be mutated. So the operators work on text: comments, strings and directives are left alone.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

_SKIPPED = re.compile(r'/\*.*?\*/|"(?:\\.|[^"\\])*"|^[ \t]*#[^\n]*(?:\\\n[^\n]*)*', re.DOTALL | re.MULTILINE)
_SWAPS = (
    # compared with the neighbour that differs at equality, and negated
    (r"(?<![<>=!-])<=(?!=)", "<"),
    (r"(?<![<>=!-])>=(?!=)", ">"),
    (r"(?<![<-])<(?![<=])", "<="),
    (r"(?<![>-])>(?![>=])", ">="),
    (r"==", "!="),
    (r"!=", "=="),
    (r"&&", "||"),
    (r"\|\|", "&&"),
    # the same for lanes
    (r"\bLT\(", "LE("),
    (r"\bLE\(", "LT("),
    (r"\bAND\(", "OR("),
    (r"\bOR\(", "AND("),
    (r"\bNOT\(", "("),
    (r"\bmv_min\(", "mv_max("),
    (r"\bmv_max\(", "mv_min("),
    # arithmetic: spaces tell a binary operator from a sign or a pointer
    (r"(?<= )\+(?= )", "-"),
    (r"(?<= )-(?= )", "+"),
    (r"(?<= )\*(?= )", "/"),
    (r"(?<= )/(?= )", "*"),
    (r"(?<= )%(?= )", "*"),
    (r"\+=", "-="),
    (r"-=", "+="),
    (r"\*=", "/="),
    (r"(?<= )<<(?= )", ">>"),
    (r"(?<= )>>(?= )", "<<"),
    (r"(?<= )&(?= )", "|"),
    (r"(?<= )\|(?= )", "&"),
    (r"(?<= )\^(?= )", "|"),
)
_NUMBER = re.compile(r"(?<![\w.])(?:0x[0-9A-Fa-f]+(?:\.[0-9A-Fa-f]*p[+-]?\d+)?|\d+\.?\d*(?:[eE][+-]?\d+)?)u?(?![\w.])")
_STATEMENT = re.compile(r"(?<=\n)([ \t]+)((?:[\w.\[\]>*-]+(?: [-+*|&^]?= |\())[^;{}\n]*;)(?=\n)")
_TERMS = re.compile(r"\b(?:if|while) \((?!!)([^\n]*?)\)(?= [^\n]*;|\n| \{)")


def places(text: str) -> Iterator[tuple[int, str, tuple[int, int, str]]]:
    """Yield the line, the change and (start, end, replacement) of every mutant of a C text."""
    for start, end, other in _places(text):
        yield text.count("\n", 0, start) + 1, f"{text[start:end]} -> {other}", (start, end, other)


def _places(text: str) -> Iterator[tuple[int, int, str]]:
    closed = [match.span() for match in _SKIPPED.finditer(text)]

    def free(match: re.Match[str]) -> bool:
        return not any(start < match.end() and match.start() < end for start, end in closed)

    for pattern, other in _SWAPS:
        for match in filter(free, re.finditer(pattern, text)):
            yield *match.span(), other
    for match in filter(free, _NUMBER.finditer(text)):
        yield *match.span(), _other_number(match[0])
    for match in filter(free, _STATEMENT.finditer(text)):
        if not match[2].startswith(("return", "const ", "static ")):
            yield *match.span(2), ";"
    for match in filter(free, _TERMS.finditer(text)):
        if match[1].count("(") == match[1].count(")"):
            yield *match.span(1), f"!({match[1]})"


def mutate(_text: str, place: tuple[int, int, str]) -> tuple[int, int, str]:
    """Return (start, end, replacement) of one mutant."""
    return place


def _other_number(literal: str) -> str:
    """Return zero for one, one for zero, twice a fraction, and one more otherwise."""
    if literal.rstrip("u") in ("0", "1"):
        return literal.translate(str.maketrans("01", "10"))
    if any(mark in literal for mark in ".ep") and not literal.startswith("0x"):
        return f"(2 * {literal})" if float(literal) else "1.0"
    return f"({literal} + 1)"
