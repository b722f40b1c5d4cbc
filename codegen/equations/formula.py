# SPDX-License-Identifier: Apache-2.0
"""Printer of expression graphs as LaTeX and plain text, in an order independent of storage.

Factors are ordered: number, parameters, definitions, states, rates, roots and functions. Terms are ordered by their
factors; a positive term comes first if that avoids a leading minus.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass, field
from fractions import Fraction
from math import prod
from typing import Any

from .spelling import TEXT, Spelling

Nodes = Sequence[Sequence[Any]]
Path = tuple[int, ...]
"""Positions of operands along the path from an expression's root to one of its parts."""
Marks = Set[Path]

_SUM, _PRODUCT, _POWER, _ATOM = range(4)
"""Binding strengths of parts, weakest first."""
_ROLES = ("parameter", "scenario", "law", "definition", "state", "reference", "input", "rate")
_POWERED = frozenset(("sin", "cos", "tan", "sinh", "cosh", "tanh"))
"""Functions that are printed with the exponent after the name and without parentheses around a symbol."""
_Key = tuple[tuple[int, str], ...]


@dataclass(frozen=True)
class SymbolNames:
    """Printed form and order of names.

    Attributes
    ----------
    latex : mapping of str to str
        LaTeX of names; other names are printed unchanged.
    rank : mapping of str to int
        Position of a name in a product; see `rank_of`.
    """

    latex: Mapping[str, str] = field(default_factory=dict)
    rank: Mapping[str, int] = field(default_factory=dict)


def rank_of(role: str) -> int:
    """Return a role's position in the order of a product's factors."""
    first = role.split(" ")[0]
    return _ROLES.index(first) if first in _ROLES else len(_ROLES)


@dataclass(frozen=True)
class _Factor:
    """A factor of a product, with a positive exponent; `alone` is its text as the only factor."""

    key: tuple[int, str]
    text: str
    below: bool
    alone: str


@dataclass(frozen=True)
class _Term:
    """A summand without its sign, with its sort key."""

    negative: bool
    text: str
    key: _Key
    path: Path


class Printer:
    """Prints expressions of one graph.

    Parameters
    ----------
    nodes : sequence
        The graph, as in equations.json.
    names : Names
        Printed form of its names.
    spelling : Spelling
        Plain text, LaTeX, or LaTeX for pages.
    marks : set of Path
        Parts to mark.
    line : int
        Break sums in parentheses and fractions that are wider than this in the measure of `width`; 0: never.
    """

    def __init__(
        self,
        nodes: Nodes,
        names: SymbolNames | None = None,
        spelling: Spelling = TEXT,
        marks: Marks = frozenset(),
        line: int = 0,
    ) -> None:
        self.nodes = nodes
        self.names = names or SymbolNames()
        self.spelling = spelling
        self._marks = marks
        self._line = line
        self._memo: dict[int, tuple[str, int]] = {}

    def text(self, root: int) -> str:
        """Return an expression on one line."""
        return self._print(root, ())[0]

    def terms(self, root: int) -> list[str]:
        """Return the summands of an expression in order, with their signs."""
        return [text for text, _ in self.parts(root)]

    def parts(self, root: int) -> list[tuple[str, bool]]:
        """Return the summands, each with True if it is marked as a whole.

        If a marked part of a summand is not printed, such as a factor of -1, the whole summand is marked.
        """
        if self.nodes[root][0] != "add":
            text = self._plain(root, ())[0]
            return [(text, self._is_marked(text, ()))]
        return [(sign + term.text, self._is_marked(term.text, term.path)) for sign, term in self._signed(root, ())]

    def _is_marked(self, text: str, path: Path) -> bool:
        begin = self.spelling.mark("\0").partition("\0")[0]
        within = any(place[: len(path)] == path for place in self._marks)
        return path in self._marks or (within and begin not in text)

    def _print(self, node: int, path: Path) -> tuple[str, int]:
        """Return a part with its binding strength."""
        if self._marks:
            text, binding = self._plain(node, path)
            return self._marked(text, path), binding
        if node not in self._memo:
            self._memo[node] = self._plain(node, path)
        return self._memo[node]

    def _marked(self, text: str, *paths: Path) -> str:
        return text if self._marks.isdisjoint(paths) else self.spelling.mark(text)

    def _plain(self, node: int, path: Path) -> tuple[str, int]:
        """Return a part without mark, with its binding strength."""
        operation, *operands = self.nodes[node]
        if operation == "sym":
            return self.spelling.name(operands[0], self.names.latex.get(operands[0], "")), _ATOM
        if operation == "const":
            return self.spelling.constant(operands[0]), _ATOM
        if operation == "add":
            return self._sum(node, path), _SUM
        if operation in ("num", "mul", "pow"):
            term = self._term(node, path)
            return (self.spelling.negative + term.text if term.negative else term.text), self._binding(node, term)
        if operation in self.spelling.relations:
            sides = [self._bound(o, (*path, k), _PRODUCT) for k, o in enumerate(operands)]
            return f" {self.spelling.relations[operation]} ".join(sides), _SUM
        if operation == "piecewise":
            return self._piecewise(operands, path), _ATOM
        return self._call(operation, operands, path), _ATOM

    def _sum(self, node: int, path: Path) -> str:
        signed = self._signed(node, path)
        text = "".join(self._marked(sign + term.text, term.path) for sign, term in signed)
        if self._line and path and width(text) > self._line:
            return aligned("", broken([sign + term.text for sign, term in signed], self._line))
        return text

    def _binding(self, node: int, term: _Term) -> int:
        operation, *operands = self.nodes[node]
        if term.negative:
            return _SUM
        if operation == "num" and decimal(Fraction(operands[0])).isdecimal():
            return _ATOM
        fraction = self.spelling.bar and self.spelling.bar in term.text
        return _POWER if operation == "pow" and not fraction else _PRODUCT

    def _signed(self, node: int, path: Path) -> list[tuple[str, _Term]]:
        """Return the ordered terms of a sum, joined with their signs."""
        terms = [self._term(o, (*path, k)) for k, o in enumerate(self.nodes[node][1:])]
        terms = sorted(terms, key=lambda term: (term.key, self.spelling.letters(term.text)))
        first = next((k for k, term in enumerate(terms) if not term.negative), 0)
        terms.insert(0, terms.pop(first))
        signs = [self.spelling.minus if term.negative else self.spelling.plus for term in terms]
        signs[0] = self.spelling.negative if terms[0].negative else ""
        return list(zip(signs, terms, strict=True))

    def _term(self, node: int, path: Path) -> _Term:
        """Return a summand; the sum sets its mark, which includes the sign."""
        operation, *operands = self.nodes[node]
        parts = [(o, (*path, k)) for k, o in enumerate(operands)] if operation == "mul" else [(node, path)]
        numbers = [(Fraction(self.nodes[o][1]), p) for o, p in parts if self.nodes[o][0] == "num"]
        coefficient = prod((number for number, _ in numbers), start=Fraction(1))
        factors = sorted(
            (self._factor(o, p, p != path) for o, p in parts if self.nodes[o][0] != "num"),
            key=lambda factor: factor.key,
        )
        key = tuple(factor.key for factor in factors) or ((len(_ROLES) + 3, ""),)
        text = self._fraction(abs(coefficient), [p for _, p in numbers if p != path], factors)
        return _Term(coefficient < 0, text, key, path)

    def _fraction(self, size: Fraction, places: Sequence[Path], factors: Sequence[_Factor]) -> str:
        """Return a product without its sign; `places` are the positions of its numeric factors."""
        above = [f for f in factors if not f.below]
        below = [f for f in factors if f.below]
        number = decimal(size)
        over, under = (number, "1") if number else (str(size.numerator), str(size.denominator))
        if not below and under == "1":
            return self._row(over, above, places)
        if above and not below and self.spelling.coefficient:
            number = self._marked(self.spelling.coefficient % (over, under), *places)
            return f"{number} {self._row('1', above)}"
        bars = bool(self.spelling.bar)
        top, bottom = self._row(over, above, places, bars), self._row(under, below, places, bars)
        return self.spelling.fraction(top, bottom if bars or self._is_simple(under, below) else f"({bottom})")

    @staticmethod
    def _is_simple(number: str, factors: Sequence[_Factor]) -> bool:
        return len(factors) + (number != "1") == 1 and not (
            factors and " " in factors[0].text[1:-1] and factors[0].text[0] != "("
        )

    def _row(self, number: str, factors: Sequence[_Factor], places: Sequence[Path] = (), alone: bool = False) -> str:
        if alone and number == "1" and len(factors) == 1:
            return factors[0].alone
        texts = [factor.text for factor in factors]
        if number != "1" or not texts:
            texts.insert(0, self._marked(self.spelling.number(number), *places))
        return self.spelling.product(texts)

    def _factor(self, node: int, path: Path, inner: bool) -> _Factor:
        """Return a factor, without a mark if it is a whole term, which has its own."""
        operation, *operands = self.nodes[node]
        own = (path,) if inner else ()
        if operation != "pow":
            part = self._print(node, path) if inner else self._plain(node, path)
            return _Factor(self._key(node, part[0]), self._enclosed(part, _PRODUCT), False, part[0])
        base, raised = operands
        if self.nodes[raised][0] != "num":
            text = self.spelling.power(self._bound(base, (*path, 0), _ATOM), self._print(raised, (*path, 1))[0])
            text = self._marked(text, *own)
            return _Factor(self._key(node, text), text, False, text)
        exponent = Fraction(self.nodes[raised][1])
        text = alone = self._powered(base, (*path, 0), abs(exponent))
        if abs(exponent) == 1 and self.nodes[base][0] != "pow":
            alone = self._print(base, (*path, 0))[0]
        text, alone = (self._marked(part, *own, (*path, 1)) for part in (text, alone))
        return _Factor(self._key(base, alone), text, exponent < 0, alone)

    def _powered(self, base: int, path: Path, size: Fraction) -> str:
        """Return a base with a positive exponent; half is a root, and functions take the exponent at their name."""
        operation, *operands = self.nodes[base]
        part = self._print(base, path)
        if size == 1:
            return self._enclosed(part, _PRODUCT)
        if size == Fraction(1, 2):
            return self.spelling.root(part[0])
        exponent = self.spelling.number(str(size))
        if operation in _POWERED and size.denominator == 1:
            return self._marked(self._call(operation, operands, path, exponent), path)
        inner = self._enclosed(part, _ATOM)
        return self.spelling.power(self.spelling.braced(inner) if operation == "sym" else inner, exponent)

    def _key(self, node: int, text: str) -> tuple[int, str]:
        return self._rank(node), self.spelling.letters(text)

    def _rank(self, node: int) -> int:
        operation, *operands = self.nodes[node]
        if operation == "sym":
            return self.names.rank.get(operands[0], len(_ROLES))
        return {"num": -2, "const": -1, "add": len(_ROLES) + 1}.get(operation, len(_ROLES) + 2)

    def _bound(self, node: int, path: Path, least: int) -> str:
        return self._enclosed(self._print(node, path), least)

    def _enclosed(self, part: tuple[str, int], least: int) -> str:
        text, binding = part
        return text if binding >= least else self.spelling.fenced(text)

    def _call(self, operation: str, operands: Sequence[int], path: Path, raised: str = "") -> str:
        texts = [self._print(o, (*path, k))[0] for k, o in enumerate(operands)]
        if operation == "exprcondpair":
            return self.spelling.conditional(*texts)
        bare = operation in _POWERED and self.nodes[operands[0]][0] == "sym"
        return self.spelling.call(operation, texts, raised, bare)

    def _piecewise(self, operands: Sequence[int], path: Path) -> str:
        rows = []
        for k, pair in enumerate(operands):
            (value, condition), places = self.nodes[pair][1:], ((*path, k, 0), (*path, k, 1))
            texts = self._print(value, places[0])[0], self._print(condition, places[1])[0]
            rows.append((*texts, self.nodes[condition][0] == "const"))
        return self.spelling.cases(rows)


def width(latex: str) -> int:
    """Return the approximate printed width of a formula's widest line, in characters."""
    return max(_width(line) for line in latex.split(r"\\"))


def _width(latex: str) -> int:
    plain = re.sub(
        r"\\(left|right|quad|tfrac|frac|mathrm|text|dot|ddot|hat|tilde|begin\{\w+\}|end\{\w+\}|,)", "", latex
    )
    plain = re.sub(r"\\[A-Za-z]+", "x", plain)
    return len(re.sub(r"[{}^_&\s]", "", plain)) + 2 * (plain.count(" + ") + plain.count(" - "))


def broken(terms: Sequence[str], line: int, first: int = 0) -> list[str]:
    """Distribute a sum's terms over lines; `first` is the used width of the first line."""
    lines, room = [""], line - first
    for term in terms:
        if lines[-1] and width(term) > room:
            lines.append("")
            room = line
        lines[-1] += term if lines[-1] else term.lstrip()
        room -= width(term)
    return lines


def aligned(left: str, lines: Sequence[str]) -> str:
    """Return a formula of several aligned lines."""
    rows = [f"{left}& {lines[0]}".lstrip(), *(rf"& \quad {text}" for text in lines[1:])]
    return "\\begin{aligned}\n" + " \\\\\n".join(rows) + "\n\\end{aligned}"


def decimal(value: Fraction) -> str:
    """Return a number as a decimal if that is exact, short and customary, else an empty text."""
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
    if abs(value) > sys.float_info.max:
        return ""
    shown = repr(float(value))
    return shown if Fraction(shown) == value and len(shown) <= 20 else ""
