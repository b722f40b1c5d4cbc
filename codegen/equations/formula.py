# SPDX-License-Identifier: Apache-2.0
"""Expression graphs as LaTeX and as plain text, in an order that does not depend on how they are stored.

Factors stand in the order: number, parameters, definitions, states, rates, roots and functions; terms in the order of
their factors, positive ones first where that avoids a leading minus.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from math import prod
from typing import Any

Nodes = Sequence[Sequence[Any]]
Path = tuple[int, ...]
Wrap = Callable[[Path, str], str]

_SUM, _PRODUCT, _POWER, _ATOM = range(4)
_ROLES = ("parameter", "scenario", "law", "definition", "state", "reference", "input", "rate")
_NAMED = {
    "sin": r"\sin", "cos": r"\cos", "tan": r"\tan", "exp": r"\exp", "log": r"\ln", "asin": r"\arcsin",
    "acos": r"\arccos", "atan": r"\arctan", "sinh": r"\sinh", "cosh": r"\cosh", "tanh": r"\tanh", "max": r"\max",
    "min": r"\min", "sign": r"\mathrm{sgn}", "mod": r"\mathrm{mod}", "atan2": r"\mathrm{atan2}",
}  # fmt: skip
_FENCES = {
    "abs": (r"\left\lvert", r"\right\rvert"), "floor": (r"\left\lfloor", r"\right\rfloor"),
    "ceiling": (r"\left\lceil", r"\right\rceil"),
}  # fmt: skip
_RELATIONS = {
    "strictgreaterthan": (">", ">"), "greaterthan": (r"\ge", ">="), "strictlessthan": ("<", "<"),
    "lessthan": (r"\le", "<="), "equality": ("=", "=="), "unequality": (r"\ne", "!="), "and": (r"\land", "and"),
    "or": (r"\lor", "or"),
}  # fmt: skip
_POWERED = frozenset(("sin", "cos", "tan", "sinh", "cosh", "tanh"))
_Key = tuple[tuple[int, str], ...]


@dataclass(frozen=True)
class Names:
    """How names are printed and sorted.

    Attributes
    ----------
    latex : mapping of str to str
        LaTeX of a name; a name without one is printed upright.
    rank : mapping of str to int
        Where a name stands in a product; see `rank_of`.
    """

    latex: Mapping[str, str] = field(default_factory=dict)
    rank: Mapping[str, int] = field(default_factory=dict)


def rank_of(role: str) -> int:
    """Return the place in a product of a name with this role."""
    first = role.split(" ")[0]
    return _ROLES.index(first) if first in _ROLES else len(_ROLES)


@dataclass(frozen=True)
class _Factor:
    """A factor of a product without the sign of its exponent."""

    key: tuple[int, str]
    text: str
    below: bool
    alone: str


class Printer:
    """Prints expressions of one graph.

    Parameters
    ----------
    nodes : sequence
        The graph, as in equations.json.
    names : Names
        How its names are printed.
    latex : bool
        LaTeX, or plain text.
    wrap : callable, optional
        Gets the path of each part, positions of operands from the root, and its text; returns the text to use instead,
        to mark it.
    line : int
        Break sums in parentheses and fractions that are wider than this, as `width` measures; 0: never.
    """

    def __init__(
        self,
        nodes: Nodes,
        names: Names | None = None,
        latex: bool = False,
        wrap: Wrap | None = None,
        line: int = 0,
    ) -> None:
        self.nodes = nodes
        self._line = line
        self.names = names or Names()
        self.latex = latex
        self._wrap = wrap
        self._memo: dict[int, tuple[str, int]] = {}

    def text(self, root: int) -> str:
        """Return an expression in one line."""
        return self._print(root, ())[0]

    def terms(self, root: int) -> list[str]:
        """Return the summands of an expression in order, each with its sign; one entry if it is no sum."""
        if self.nodes[root][0] != "add":
            return [self.text(root)]
        return [
            sign + text
            for sign, text in self._signed([self._term(o, (k,)) for k, o in enumerate(self.nodes[root][1:])])
        ]

    def _print(self, node: int, path: Path) -> tuple[str, int]:
        if self._wrap is None:
            if node not in self._memo:
                self._memo[node] = self._plain(node, path)
            return self._memo[node]
        text, binding = self._plain(node, path)
        return self._wrap(path, text), binding

    def _plain(self, node: int, path: Path) -> tuple[str, int]:
        operation, *operands = self.nodes[node]
        if operation == "sym":
            return self._name(operands[0]), _ATOM
        if operation == "const":
            return self._constant(operands[0]), _ATOM
        if operation == "add":
            signed = self._signed([self._term(o, (*path, k)) for k, o in enumerate(operands)])
            text = "".join(sign + text for sign, text in signed)
            if self._line and path and width(text) > self._line:
                text = aligned("", broken([sign + text for sign, text in signed], self._line))
            return text, _SUM
        if operation in ("num", "mul", "pow"):
            negative, text, _ = self._term(node, path)
            loose = _SUM if negative else _POWER if operation == "pow" and r"\frac" not in text else _PRODUCT
            if operation == "num" and not negative and text.isdecimal():
                loose = _ATOM
            return ("-" + text if negative else text), loose
        if operation in _RELATIONS:
            sign = f" {_RELATIONS[operation][0 if self.latex else 1]} "
            return sign.join(self._bound(o, (*path, k), _PRODUCT) for k, o in enumerate(operands)), _SUM
        if operation == "piecewise":
            return self._piecewise(operands, path), _ATOM
        return self._call(operation, operands, path), _ATOM

    def _name(self, name: str) -> str:
        if not self.latex:
            return name
        return self.names.latex.get(name) or rf"\mathrm{{{name}}}".replace("_", r"\_")

    def _constant(self, name: str) -> str:
        if self.latex:
            return {"pi": r"\pi", "True": r"\text{otherwise}", "False": r"\text{never}"}.get(name, name)
        return {"True": "otherwise", "False": "never"}.get(name, name)

    def _signed(self, terms: list[tuple[bool, str, _Key]]) -> list[tuple[str, str]]:
        """Order the terms of a sum and put their signs in front."""
        terms = sorted(terms, key=lambda term: (term[2], term[1]))
        first = next((k for k, term in enumerate(terms) if not term[0]), 0)
        terms.insert(0, terms.pop(first))
        plus, minus = (" + ", " - ")
        signs = [minus if negative else plus for negative, _, _ in terms]
        signs[0] = "-" if terms[0][0] else ""
        return [(sign, text) for sign, (_, text, _) in zip(signs, terms, strict=True)]

    def _term(self, node: int, path: Path) -> tuple[bool, str, _Key]:
        """Return whether a summand is subtracted, its magnitude, and what it is sorted by."""
        operation, *operands = self.nodes[node]
        parts = [(o, (*path, k)) for k, o in enumerate(operands)] if operation == "mul" else [(node, path)]
        numbers = [Fraction(self.nodes[o][1]) for o, _ in parts if self.nodes[o][0] == "num"]
        coefficient = prod(numbers, start=Fraction(1))
        factors = sorted(
            (self._factor(o, p) for o, p in parts if self.nodes[o][0] != "num"), key=lambda factor: factor.key
        )
        key = tuple(factor.key for factor in factors) or ((len(_ROLES) + 3, ""),)
        text = self._fraction(abs(coefficient), factors)
        if self._wrap is not None and operation != "num" and parts != [(node, path)]:
            text = self._wrap(path, text)
        return coefficient < 0, text, key

    def _fraction(self, size: Fraction, factors: list[_Factor]) -> str:
        above = [f for f in factors if not f.below]
        below = [f for f in factors if f.below]
        number = decimal(size)
        over, under = (number, "1") if number else (str(size.numerator), str(size.denominator))
        if self.latex and "e" in over:
            mantissa, _, power = over.partition("e")
            over = f"10^{{{int(power)}}}"
            over = over if mantissa == "1" else rf"{mantissa} \cdot {over}"
        top, bottom = self._row(over, above), self._row(under, below)
        if bottom == "1":
            return top
        if self.latex:
            if not below and above:
                return rf"\tfrac{{{over}}}{{{under}}} {self._row('1', above)}"
            return rf"\frac{{{self._row(over, above, True)}}}{{{self._row(under, below, True)}}}"
        return f"{top}/{self._row(under, below, True)}" if self._simple(under, below) else f"{top}/({bottom})"

    @staticmethod
    def _simple(number: str, factors: list[_Factor]) -> bool:
        return len(factors) + (number != "1") == 1 and not (
            factors and " " in factors[0].text[1:-1] and factors[0].text[0] != "("
        )

    def _row(self, number: str, factors: list[_Factor], alone: bool = False) -> str:
        if alone and self.latex and number == "1" and len(factors) == 1:
            return factors[0].alone
        texts = [factor.text for factor in factors]
        if number != "1" or not texts:
            texts.insert(0, number)
        return r" \, ".join(texts) if self.latex and len(texts) > 12 else " ".join(texts)

    def _factor(self, node: int, path: Path) -> _Factor:
        operation, *operands = self.nodes[node]
        exponent = Fraction(1)
        base, place = node, path
        if operation == "pow" and self.nodes[operands[1]][0] == "num":
            exponent = Fraction(self.nodes[operands[1]][1])
            base, place = operands[0], (*path, 0)
        size = abs(exponent)
        text = self._powered(base, place, size)
        plain = size == 1 and self.nodes[base][0] != "pow"
        alone = self._print(base, place)[0] if plain else text
        if operation == "pow" and self._wrap is not None:
            text, alone = self._wrap(path, text), self._wrap(path, alone)
        return _Factor((self._rank(base), alone), text, exponent < 0, alone)

    def _powered(self, base: int, path: Path, size: Fraction) -> str:
        operation, *operands = self.nodes[base]
        if operation == "pow" and self.nodes[operands[1]][0] != "num":
            inner, outer = self._bound(operands[0], (*path, 0), _ATOM), self._print(operands[1], (*path, 1))[0]
            return rf"{inner}^{{{outer}}}" if self.latex else f"{inner}^({outer})"
        if size == 1:
            return self._bound(base, path, _PRODUCT)
        if size == Fraction(1, 2):
            inside = self._print(base, path)[0]
            return rf"\sqrt{{{inside}}}" if self.latex else f"sqrt({inside})"
        shown = str(size) if size.denominator == 1 else f"({size})"
        if operation in _POWERED and size.denominator == 1:
            return self._call(operation, operands, path, shown)
        raised = rf"^{{{size}}}" if self.latex else f"^{shown}"
        inner = self._bound(base, path, _ATOM)
        if self.latex and operation == "sym" and (inner.startswith(r"\dot") or "^" in inner):
            inner = f"{{{inner}}}"
        return inner + raised

    def _rank(self, node: int) -> int:
        operation, *operands = self.nodes[node]
        if operation == "sym":
            return self.names.rank.get(operands[0], len(_ROLES))
        return {"num": -2, "const": -1, "add": len(_ROLES) + 1}.get(operation, len(_ROLES) + 2)

    def _bound(self, node: int, path: Path, least: int) -> str:
        text, binding = self._print(node, path)
        if binding >= least:
            return text
        return rf"\left({text}\right)" if self.latex else f"({text})"

    def _call(self, operation: str, operands: Sequence[int], path: Path, raised: str = "") -> str:
        texts = [self._print(o, (*path, k))[0] for k, o in enumerate(operands)]
        if operation == "exprcondpair":
            return f"{texts[0]} if {texts[1]}"
        if not self.latex:
            power = f"^{raised}" if raised else ""
            return f"{operation}{power}({', '.join(texts)})"
        if operation in _FENCES:
            left, right = _FENCES[operation]
            return f"{left} {texts[0]} {right}"
        if operation == "exp":
            return f"e^{{{texts[0]}}}"
        name = _NAMED.get(operation, rf"\mathrm{{{operation}}}") + (f"^{{{raised}}}" if raised else "")
        if operation in _POWERED and self.nodes[operands[0]][0] == "sym":
            return f"{name} {texts[0]}"
        return rf"{name}\left({', '.join(texts)}\right)"

    def _piecewise(self, operands: Sequence[int], path: Path) -> str:
        rows = []
        for k, pair in enumerate(operands):
            value, condition = (self._print(o, (*path, k, j))[0] for j, o in enumerate(self.nodes[pair][1:]))
            rows.append((value, condition))
        if not self.latex:
            return "{" + "; ".join(v if c == "otherwise" else f"{v} if {c}" for v, c in rows) + "}"
        lines = (f"{v} & {c}" if c.startswith(r"\text{") else rf"{v} & \text{{if }} {c}" for v, c in rows)
        return r"\begin{cases} " + r" \\ ".join(lines) + r" \end{cases}"


def width(latex: str) -> int:
    """Return about how many characters wide a formula is when it is printed; of several lines, the widest."""
    return max(_width(line) for line in latex.split(r"\\"))


def _width(latex: str) -> int:
    plain = re.sub(
        r"\\(left|right|quad|tfrac|frac|mathrm|text|dot|ddot|hat|tilde|begin\{\w+\}|end\{\w+\}|,)", "", latex
    )
    plain = re.sub(r"\\[A-Za-z]+", "x", plain)
    return len(re.sub(r"[{}^_&\s]", "", plain)) + 2 * (plain.count(" + ") + plain.count(" - "))


def broken(terms: Sequence[str], line: int, first: int = 0) -> list[str]:
    """Distribute the terms of a sum over lines; `first` is how much of the first line is taken."""
    lines, room = [""], line - first
    for term in terms:
        if lines[-1] and width(term) > room:
            lines.append("")
            room = line
        lines[-1] += term if lines[-1] else term.lstrip()
        room -= width(term)
    return lines


def aligned(left: str, lines: Sequence[str]) -> str:
    """Return a formula of several lines."""
    rows = [f"{left}& {lines[0]}".lstrip(), *(rf"& \quad {text}" for text in lines[1:])]
    return "\\begin{aligned}\n" + " \\\\\n".join(rows) + "\n\\end{aligned}"


def decimal(value: Fraction) -> str:
    """Return a number as a decimal where that is exact, short and more usual than a fraction; else nothing."""
    if value.denominator == 1:
        return str(value.numerator) if value < 10**6 else _scientific(value)
    if value.denominator < 20 and value.denominator not in (10,):
        return ""
    rest = value.denominator
    for prime in (2, 5):
        while rest % prime == 0:
            rest //= prime
    return _scientific(value) if rest == 1 else ""


def _scientific(value: Fraction) -> str:
    shown = repr(float(value))
    return shown if Fraction(shown) == value and len(shown) <= 20 else ""
