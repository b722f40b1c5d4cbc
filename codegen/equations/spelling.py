# SPDX-License-Identifier: Apache-2.0
"""Notations of formulas: plain text, LaTeX, and LaTeX for pages."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import ClassVar

from mehvar.base.names import typeset

Case = tuple[str, str, bool]
"""A value, its condition, and True if the condition is a word such as "otherwise"."""
_NAMED = {
    "sin": r"\sin", "cos": r"\cos", "tan": r"\tan", "exp": r"\exp", "log": r"\ln", "asin": r"\arcsin",
    "acos": r"\arccos", "atan": r"\arctan", "sinh": r"\sinh", "cosh": r"\cosh", "tanh": r"\tanh", "max": r"\max",
    "min": r"\min", "sign": r"\mathrm{sgn}", "mod": r"\mathrm{mod}", "atan2": r"\mathrm{atan2}",
}  # fmt: skip
_WORDS = {"True": "otherwise", "False": "never"}
_MOST_FACTORS = 12
"""Number of factors above which thin spaces separate a product, which LaTeX otherwise shows as one word."""


class Spelling:
    """Notation that combines printed parts; unless overridden, plain text on one line.

    Attributes
    ----------
    plus, minus : str
        Signs between terms.
    negative : str
        Sign in front of the first term.
    bar : str
        Text by which a fraction with a bar is recognised; sums above and below a bar need no parentheses.
    coefficient : str
        Template of a numeric fraction in front of factors; empty if its parts join numerator and denominator.
    relations : dict of str to str
        Signs by operation.
    """

    plus = " + "
    minus = " - "
    negative = "-"
    bar = ""
    coefficient = ""
    relations: ClassVar[Mapping[str, str]] = {
        "strictgreaterthan": ">", "greaterthan": ">=", "strictlessthan": "<", "lessthan": "<=", "equality": "==",
        "unequality": "!=", "and": "and", "or": "or",
    }  # fmt: skip

    def name(self, name: str, latex: str) -> str:  # noqa: ARG002
        """Return a symbol: its name, or its LaTeX name in other notations."""
        return name

    def constant(self, name: str) -> str:
        """Return pi or a truth value; the latter as a word."""
        return _WORDS.get(name, name)

    def number(self, number: str) -> str:
        """Return a positive number: whole, decimal, with a power of ten (`1e-09`), or a fraction (`3/2`)."""
        return number

    def product(self, factors: Sequence[str]) -> str:
        """Return factors separated by spaces."""
        return " ".join(factors)

    def fraction(self, above: str, below: str) -> str:
        """Return a quotient with a slash; the denominator has parentheses if needed."""
        return f"{above}/{below}"

    def root(self, inside: str) -> str:
        """Return a call of sqrt."""
        return f"sqrt({inside})"

    def power(self, base: str, exponent: str) -> str:
        """Return a power with a caret."""
        return f"{base}^{exponent}" if exponent.isdecimal() else f"{base}^({exponent})"

    def fenced(self, inside: str) -> str:
        """Return a part in parentheses."""
        return f"({inside})"

    def call(self, function: str, arguments: Sequence[str], exponent: str, bare: bool) -> str:  # noqa: ARG002
        """Return a function call with an optional exponent; other notations omit parentheses if `bare` is true."""
        return f"{function}{f'^{exponent}' if exponent else ''}({', '.join(arguments)})"

    def conditional(self, value: str, condition: str) -> str:
        """Return the value followed by its condition."""
        return f"{value} if {condition}"

    def cases(self, rows: Sequence[Case]) -> str:
        """Return values with their conditions, in braces."""
        return "{" + "; ".join(v if word else self.conditional(v, c) for v, c, word in rows) + "}"

    def braced(self, symbol: str) -> str:
        """Return a symbol, in braces if an exponent needs them."""
        return symbol

    def letters(self, part: str) -> str:
        """Return the sort key of a part."""
        return part

    def mark(self, part: str) -> str:
        """Return a part marked as edited."""
        return part


class Latex(Spelling):
    """LaTeX in the subset that GitHub and GitLab display."""

    bar = r"\frac"
    coefficient = r"\tfrac{%s}{%s}"
    space = " "
    relations: ClassVar = {
        "strictgreaterthan": ">", "greaterthan": r"\ge", "strictlessthan": "<", "lessthan": r"\le", "equality": "=",
        "unequality": r"\ne", "and": r"\land", "or": r"\lor",
    }  # fmt: skip
    _fences: ClassVar = {
        "abs": (r"\left\lvert", r"\right\rvert"), "floor": (r"\left\lfloor", r"\right\rfloor"),
        "ceiling": (r"\left\lceil", r"\right\rceil"),
    }  # fmt: skip

    def name(self, name: str, latex: str) -> str:
        """Return the LaTeX name, or the name in upright letters."""
        return latex or typeset(name)

    def constant(self, name: str) -> str:
        """Return the LaTeX command of a constant."""
        return rf"\text{{{_WORDS[name]}}}" if name in _WORDS else {"pi": r"\pi"}.get(name, name)

    def number(self, number: str) -> str:
        """Return a number with powers of ten in LaTeX."""
        mantissa, _, power = number.partition("e")
        ten = f"10^{{{int(power)}}}" if power else ""
        return number if not ten else ten if mantissa == "1" else rf"{mantissa} \cdot {ten}"

    def product(self, factors: Sequence[str]) -> str:
        """Return a product, with thin spaces if it has many factors."""
        return (r" \, " if len(factors) > _MOST_FACTORS else self.space).join(factors)

    def fraction(self, above: str, below: str) -> str:
        """Return a fraction."""
        return rf"\frac{{{above}}}{{{below}}}"

    def root(self, inside: str) -> str:
        """Return a root."""
        return rf"\sqrt{{{inside}}}"

    def power(self, base: str, exponent: str) -> str:
        """Return a superscript."""
        return rf"{base}^{{{exponent}}}"

    def fenced(self, inside: str) -> str:
        """Return parentheses of matching size."""
        return rf"\left({inside}\right)"

    def call(self, function: str, arguments: Sequence[str], exponent: str, bare: bool) -> str:
        """Return a function in mathematical notation."""
        if function in self._fences:
            left, right = self._fences[function]
            return f"{left} {arguments[0]} {right}"
        if function == "exp":
            return f"e^{{{arguments[0]}}}"
        name = _NAMED.get(function, rf"\mathrm{{{function}}}") + (f"^{{{exponent}}}" if exponent else "")
        return f"{name}{self.space}{arguments[0]}" if bare else name + self.fenced(", ".join(arguments))

    def cases(self, rows: Sequence[Case]) -> str:
        """Return cases after a brace."""
        lines = (f"{v} & {c}" if word else rf"{v} & \text{{if }} {c}" for v, c, word in rows)
        return r"\begin{cases} " + r" \\ ".join(lines) + r" \end{cases}"

    def braced(self, symbol: str) -> str:
        """Enclose a symbol with dot or superscript in braces, so that an exponent can follow."""
        return f"{{{symbol}}}" if symbol.startswith(r"\dot") or "^" in symbol else symbol


class Page(Latex):
    """LaTeX for `mathml`, with marks, and with spaces that TeX adds by itself."""

    plus = r" \class{infix}{+} "
    minus = r" \class{infix}{-} "
    space = r" \, "

    def letters(self, part: str) -> str:
        """Return the part without marks and braces, so that sorting ignores marks."""
        return re.sub(r"\\class\{mark\}|[{}]", "", part)

    def mark(self, part: str) -> str:
        """Return a part with the class of edited parts."""
        return rf"\class{{mark}}{{{part}}}"


TEXT, LATEX, PAGE = Spelling(), Latex(), Page()
