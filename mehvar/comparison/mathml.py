# SPDX-License-Identifier: Apache-2.0
"""Expression graphs as MathML, which browsers render without a script, with chosen parts marked.

A part is named by its path: the positions of operands on the way from the root to it.
"""

from __future__ import annotations

import functools
import re
from collections.abc import Iterable, Mapping, Sequence, Set
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from html import escape
from math import prod
from typing import Any

Nodes = Sequence[Sequence[Any]]
Path = tuple[int, ...]
Marks = Set[Path]
_Place = tuple[int, Path]

_SUM, _PRODUCT, _ATOM = range(3)
_TIMES, _APPLY = (
    '<mo>&#x2062;</mo><mspace width="0.12em"></mspace>',
    '<mo>&#x2061;</mo><mspace width="0.12em"></mspace>',
)
_MINUS, _PLUS = '<mo form="infix">−</mo>', '<mo form="infix">+</mo>'
_RELATIONS = {
    "strictgreaterthan": "&gt;", "greaterthan": "≥", "strictlessthan": "&lt;", "lessthan": "≤",
    "equality": "=", "unequality": "≠", "and": "∧", "or": "∨",
}  # fmt: skip
_FENCES = {"abs": ("|", "|"), "floor": ("⌊", "⌋"), "ceiling": ("⌈", "⌉")}
_FUNCTIONS = {"asin": "arcsin", "acos": "arccos", "atan": "arctan", "sign": "sgn", "log": "ln"}
_INVISIBLE = re.compile(r"<[^>]*>|&[^;]*;|[\d.]")
_LETTER = re.compile(r"&#x(0*(?!0)[0-9A-F]{3,});")
_NAMED = {"sin", "cos", "tan", "sinh", "cosh", "tanh", "asin", "acos", "atan", "log"}
_CONSTANTS = {"pi": "<mi>π</mi>", "True": "<mtext>otherwise</mtext>", "False": "<mtext>never</mtext>"}


@dataclass(frozen=True)
class _Factor:
    """A factor of a product: a base, and its exponent where that is not 1."""

    base: _Place
    exponent: _Place | None
    power: Fraction | None
    paths: tuple[Path, ...]


class Formula:
    """One expression of a graph, ready to be printed.

    Parameters
    ----------
    nodes : sequence
        The graph, as in equations.json: an operation and its operands, which come earlier.
    root : int
        Number of the expression's node.
    latex : mapping
        LaTeX names of symbols; a symbol without one is printed as it is called.
    marks : set, optional
        Paths of the parts that get the class `mark`.
    """

    def __init__(self, nodes: Nodes, root: int, latex: Mapping[str, str], marks: Marks = frozenset()) -> None:
        self._nodes = nodes
        self._root = (root, ())
        self._latex = latex
        self._marks = marks

    def terms(self) -> list[tuple[str, bool]]:
        """Return the summands as whole `math` elements, each with whether it is marked as a whole.

        A formula longer than a line breaks between its terms; MathML itself does not break.
        """
        operation, *operands = self._nodes[self._root[0]]
        if operation != "add":
            return [(math(self._print(self._root)[0]), () in self._marks)]
        terms = self._in_order([(node, (k,)) for k, node in enumerate(operands)])
        return [
            (math(_sign(negative, not k) + text), place[1] in self._marks)
            for k, (place, negative, text) in enumerate(terms)
        ]

    def _print(self, place: _Place) -> tuple[str, int]:
        """Return a part and how tightly it binds."""
        text, binding = self._plain(place)
        return self._marked(text, [place[1]]), binding

    def _marked(self, text: str, paths: Iterable[Path]) -> str:
        return text if self._marks.isdisjoint(paths) else f'<mrow class="mark">{text}</mrow>'

    def _plain(self, place: _Place) -> tuple[str, int]:
        operation, *operands = self._nodes[place[0]]
        if operation == "sym":
            return symbol(operands[0], self._latex.get(operands[0], "")), _ATOM
        if operation == "const":
            return _CONSTANTS.get(operands[0], f"<mi>{escape(operands[0])}</mi>"), _ATOM
        if operation in ("num", "mul", "pow"):
            return self._product(place)
        places = _children(place, operands)
        if operation == "add":
            return self._sum(places), _SUM
        if operation in _RELATIONS:
            sign = f"<mo>{_RELATIONS[operation]}</mo>"
            return sign.join(self._bound(child, _PRODUCT) for child in places), _SUM
        if operation in _FENCES:
            left, right = _FENCES[operation]
            return f"<mo>{left}</mo>{self._print(places[0])[0]}<mo>{right}</mo>", _ATOM
        if operation == "exp":
            return f"<msup><mi>e</mi><mrow>{self._print(places[0])[0]}</mrow></msup>", _ATOM
        if operation == "piecewise":
            return self._piecewise(places), _ATOM
        return self._call(operation, places), _ATOM

    def _sum(self, places: list[_Place]) -> str:
        rows = enumerate(self._in_order(places))
        return "".join(self._marked(_sign(negative, not k) + term, [place[1]]) for k, (place, negative, term) in rows)

    def _in_order(self, places: list[_Place]) -> list[tuple[_Place, bool, str]]:
        """Print terms and sort them by their letters: a changed sign or coefficient leaves a term in its place."""

        def key(term: tuple[_Place, bool, str]) -> tuple[bool, str, str]:
            _, negative, text = term
            letters = _INVISIBLE.sub("", text)
            return negative and not letters, letters, text

        return sorted(((place, *self._term(place)) for place in places), key=key)

    def _term(self, place: _Place) -> tuple[bool, str]:
        """Return whether a summand is subtracted, and the summand without its sign."""
        if self._nodes[place[0]][0] not in ("num", "mul", "pow"):
            text, binding = self._plain(place)
            return False, _fenced(text) if binding == _SUM else text
        return self._fraction(place)

    def _product(self, place: _Place) -> tuple[str, int]:
        negative, text = self._fraction(place)
        if negative:
            return _sign(True, True) + text, _SUM
        alone = self._nodes[place[0]][0] != "mul"
        return text, _ATOM if alone and "<mfrac>" not in text else _PRODUCT

    def _fraction(self, place: _Place) -> tuple[bool, str]:
        """Return whether a product is negative, and its magnitude as a product or a fraction."""
        operation, *operands = self._nodes[place[0]]
        places = _children(place, operands) if operation == "mul" else [place]
        numbers = [p for p in places if self._number(p[0]) is not None]
        coefficient = prod((self._number(p[0]) or Fraction(0) for p in numbers), start=Fraction(1))
        size = abs(coefficient)
        factors = [self._split(p) for p in places if p not in numbers]
        above = [f for f in factors if f.power is None or f.power > 0]
        below = [f for f in factors if f not in above]
        paths = [path for _, path in numbers]
        over, under = (size, Fraction(1)) if _decimal(size) else (Fraction(size.numerator), Fraction(size.denominator))
        top = self._row(above, over, paths, bool(below) or under != 1)
        if not below and under == 1:
            return coefficient < 0, top
        bottom = self._row(below, under, paths, True)
        return coefficient < 0, f"<mfrac>{_row(top)}{_row(bottom)}</mfrac>"

    def _split(self, place: _Place) -> _Factor:
        operation, *operands = self._nodes[place[0]]
        if operation != "pow":
            return _Factor(place, None, Fraction(1), ())
        base, exponent = _children(place, operands)
        return _Factor(base, exponent, self._number(exponent[0]), (place[1], exponent[1]))

    def _number(self, node: int) -> Fraction | None:
        operation, *operands = self._nodes[node]
        return Fraction(operands[0]) if operation == "num" else None

    def _row(self, factors: list[_Factor], number: Fraction, paths: list[Path], over_bar: bool) -> str:
        """Print a number and factors side by side; a lone sum over or under a bar needs no parentheses."""
        if over_bar and number == 1 and len(factors) == 1 and abs(factors[0].power or 0) == 1:
            return self._marked(self._print(factors[0].base)[0], factors[0].paths)
        ranked = sorted((self._rank(f.base, text), text) for f, text in ((f, self._factor(f)) for f in factors))
        rows = [text for _, text in ranked]
        if number != 1 or not rows:
            rows.insert(0, self._marked(_number_text(number), paths))
        return _TIMES.join(rows)

    def _rank(self, base: _Place, text: str) -> tuple[int, str]:
        """Order factors: numbers, symbols, sums, functions; then by their letters."""
        kinds = {"num": 0, "sym": 1, "const": 1, "add": 2, "pow": 2}
        return kinds.get(self._nodes[base[0]][0], 3), _INVISIBLE.sub("", text)

    def _factor(self, factor: _Factor) -> str:
        base, power = factor.base, factor.power
        size = None if power is None else abs(power)
        if size == 1:
            return self._marked(self._bound(base, _PRODUCT), factor.paths)
        if size == Fraction(1, 2):
            return self._marked(f"<msqrt>{self._print(base)[0]}</msqrt>", factor.paths)
        operation, *operands = self._nodes[base[0]]
        if operation in _NAMED and size is not None and size.denominator == 1:
            called = self._call(operation, _children(base, operands), _number_text(size))
            return self._marked(called, [*factor.paths, base[1]])
        raised = (
            self._print(factor.exponent)[0] if size is None and factor.exponent else _number_text(size or Fraction(1))
        )
        return self._marked(f"<msup>{_row(self._bound(base, _ATOM))}{_row(raised)}</msup>", factor.paths)

    def _bound(self, place: _Place, least: int) -> str:
        text, binding = self._print(place)
        return _fenced(text) if binding < least else text

    def _call(self, operation: str, places: list[_Place], raised: str = "") -> str:
        name = f'<mi mathvariant="normal">{escape(_FUNCTIONS.get(operation, operation))}</mi>'
        head = f"<msup>{name}{raised}</msup>" if raised else name
        if len(places) == 1 and self._nodes[places[0][0]][0] == "sym" and operation in _NAMED:
            return head + _APPLY + self._print(places[0])[0]
        return head + _fenced("<mo>,</mo>".join(self._print(place)[0] for place in places))

    def _piecewise(self, places: list[_Place]) -> str:
        rows = ""
        for place in places:
            value, condition = _children(place, self._nodes[place[0]][1:])
            known = self._nodes[condition[0]] == ["const", "True"]
            test = self._print(condition)[0]
            rows += (
                f"<mtr><mtd>{self._print(value)[0]}</mtd>"
                f"<mtd>{'' if known else '<mtext>if&#xA0;</mtext>'}{test}</mtd></mtr>"
            )
        return f"<mo>{{</mo><mtable>{rows}</mtable>"


def math(content: str) -> str:
    """Return a whole `math` element."""
    return f'<math displaystyle="true">{content}</math>'


@functools.cache
def symbol(name: str, latex: str = "") -> str:
    """Return a symbol as MathML, from its LaTeX name or else from its spelling."""
    if latex:
        from latex2mathml.converter import convert

        inner = re.fullmatch(r"<math[^>]*>(.*)</math>", convert(latex), flags=re.DOTALL)
        if inner:
            return f"<mrow>{_LETTER.sub(lambda code: chr(int(code[1], 16)), inner[1])}</mrow>"
    return f"<mi>{escape(name)}</mi>"


def _children(place: _Place, operands: Sequence[int]) -> list[_Place]:
    return [(node, (*place[1], k)) for k, node in enumerate(operands)]


def _sign(negative: bool, first: bool) -> str:
    if first:
        return "<mo>−</mo>" if negative else ""
    return _MINUS if negative else _PLUS


def _decimal(value: Fraction) -> str:
    """Return a number as a decimal where that is exact and reads better than a fraction, else nothing."""
    rest, digits = value.denominator, 0
    for prime in (2, 5):
        while rest % prime == 0:
            rest //= prime
    if rest != 1 or 1 < value.denominator < 20 or (value.denominator == 1 and value < 10**6):
        return ""
    while (value * 10**digits).denominator != 1:
        digits += 1
    text = f"{Decimal(int(value * 10**digits)).scaleb(-digits).normalize():g}"
    return text if len(text) <= 20 else ""


def _number_text(value: Fraction) -> str:
    """Print a number that is not negative: whole, as an exact decimal, or as a fraction."""
    mantissa, _, power = _decimal(value).partition("e")
    if power:
        ten = f"<msup><mn>10</mn><mrow>{_sign(int(power) < 0, True)}<mn>{abs(int(power))}</mn></mrow></msup>"
        return ten if mantissa == "1" else f"<mn>{mantissa}</mn><mo>·</mo>{ten}"
    if mantissa or value.denominator == 1:
        return f"<mn>{mantissa or value.numerator}</mn>"
    return f"<mn>{value.numerator}</mn><mo>/</mo><mn>{value.denominator}</mn>"


def _fenced(text: str) -> str:
    return f"<mrow><mo>(</mo>{text}<mo>)</mo></mrow>"


def _row(text: str) -> str:
    return f"<mrow>{text}</mrow>"
