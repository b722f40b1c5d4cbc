# SPDX-License-Identifier: Apache-2.0
"""Search for a single edit that gives an expression the required values.

For each part of the old expression, the search computes the value that would make the whole equal the new one. In
sums and products this takes one subtraction or division. The ratio of required to actual value identifies the edit:
minus one is a flipped sign, a symbol is an added factor. A required value that equals another symbol's is a wrong
name. The form of the new side does not matter. All values are elements of a finite field, so every comparison is
exact.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

from ..equal import field
from ..equal.field import Undefined
from ..equal.pool import Pool
from ..equal.values import FieldWorld
from ..equations.document import reached
from . import costs
from .changes import Change, Values, multiplied, mutations, rational, replaced
from .report import Kind, Path

_FUNCTIONS = frozenset(("sin", "cos", "tan"))
_EXPONENTS = (1, -1, 2, -2)
_LARGEST = 60
"""Largest number of nodes of a function in which edits are tried one by one. A function has about ten edits per node,
and each needs a complete evaluation, so the time grows with the square. Larger functions are reported as rewritten
parts."""


class Edits:
    """Search for single edits.

    Parameters
    ----------
    pool : Pool
        Pool of both expressions.
    olds, news : sequence of FieldWorld
        Evaluations of old and new expressions at the same points.
    """

    def __init__(self, pool: Pool, olds: Sequence[FieldWorld], news: Sequence[FieldWorld]) -> None:
        self.pool = pool
        self._olds, self._news = olds, news
        self._atoms: dict[Values, int] = {}
        self._powers: dict[Values, list[tuple[int, Values]]] = {}
        """Of the values of an atom: each exponent with the values of the inverse power."""
        self._parts: dict[Values, int] = {}
        self._written: frozenset[int] = frozenset()

    def single(self, old: int, required: Values) -> list[Change]:
        """Return single edits that give an expression the required values, most likely first."""
        self._atoms, self._parts, self._written = self._atoms_of(old, old), {}, frozenset()
        return sorted(self.walk(old, required, ()), key=lambda change: (change.cost, change.says))

    def old(self, node: int) -> Values | None:
        """Return the values of an old expression at the test points."""
        return _values(self._olds, node)

    def new(self, node: int) -> Values | None:
        """Return the values of a new expression at the test points."""
        return _values(self._news, node)

    def _values_of(self, new: int) -> dict[Values, int]:
        parts: dict[Values, int] = {}
        for node in reached(self.pool.nodes, [new]):
            values = self.new(node) if self._is_value(node) else None
            if values is not None:
                parts.setdefault(values, node)
        return parts

    def _atoms_of(self, old: int, new: int) -> dict[Values, int]:
        """Return the symbols, sines and cosines of both expressions by value."""
        atoms: dict[Values, int] = {}
        for worlds, root in ((self._olds, old), (self._news, new)):
            for node in reached(self.pool.nodes, [root]):
                operation, *operands = self.pool.nodes[node]
                nodes = [node] if operation == "sym" else []
                if operation in _FUNCTIONS:
                    nodes = [self.pool.intern(name, operands[0]) for name in ("sin", "cos", "tan")]
                for atom in nodes:
                    values = _values(worlds, atom)
                    if values is not None:
                        atoms.setdefault(values, atom)
        return atoms

    def _is_value(self, node: int) -> bool:
        return self.pool.nodes[node][0] not in ("exprcondpair", "num")

    def walk(self, root: int, required: Values, path: Path) -> list[Change]:
        """Return all single edits at or below a node that give it the required values."""
        changes: list[Change] = []
        seen: set[tuple[int, Values]] = set()
        stack = [(root, required, path, True)]
        while stack:
            node, needed, place, term = stack.pop()
            if (node, needed) in seen:
                continue
            seen.add((node, needed))
            value = self.old(node)
            if value is None or value == needed:
                continue
            depth = len(place) - len(path)
            changes += (
                replace(change, cost=change.cost + costs.LEVEL * depth + self._doubt(change, value))
                for change in self._edits(node, value, needed, place, term, bool(depth))
            )
            stack += self._below(node, value, needed, place)
        return changes

    def _doubt(self, change: Change, value: Values) -> float:
        """Return the cost of an edit; lower if it replaces a part unique to the old side by one unique to the new."""
        stays, written = value in self._parts, change.with_ in self._written
        return (costs.STAYS if stays else 0.0) - (costs.WRITTEN if written else 0.0)

    def _below(self, node: int, value: Values, needed: Values, path: Path) -> Iterator[tuple[int, Values, Path, bool]]:
        """Yield the operands of a node with their required values, and True for terms of a sum."""
        operation, *operands = self.pool.nodes[node]
        for k, operand in enumerate(operands):
            if not isinstance(operand, int):
                continue
            child = self.old(operand)
            if child is None:
                continue
            if operation == "add":
                yield operand, _each(field.add, child, _each(field.sub, needed, value)), (*path, k), True
            elif operation == "mul" and 0 not in value:
                ratio = _each(field.mul, needed, _inverse(value))
                yield operand, _each(field.mul, child, ratio), (*path, k), self.pool.nodes[operand][0] == "add"
            elif operation == "pow" and k == 0:
                exponent = self.pool.constant(operands[1])
                if exponent is not None and exponent.numerator in (1, -1) and 0 not in needed:
                    power = 1 / exponent
                    yield operand, tuple(field.power(n, int(power)) for n in needed), (*path, 0), True

    def _edits(self, node: int, value: Values, needed: Values, path: Path, term: bool, inner: bool) -> Iterator[Change]:
        """Yield the edits of a node that give it the required values; `term` is true for a term of a sum."""
        operation, *operands = self.pool.nodes[node]
        if term:
            yield from self._term_edits(node, value, needed, path, inner)
        yield from self._other_name(node, needed, path)
        if operation == "num":
            number = rational(needed)
            if number is not None:
                new = self.pool.number(number)
                says = f"{operands[0]} became {number}"
                yield Change(Kind.COEFFICIENT, path, node, new, new, says, costs.NUMBER)
        if operation == "pow":
            yield from self._exponents(node, operands, needed, path)
        if operation == "add":
            yield from self._added(value, needed, path)
        if operation not in ("add", "mul", "num", "sym"):
            yield from self._inside(node, needed, path)
        if needed in self._parts:
            new = self._parts[needed]
            alike = operation == self.pool.nodes[new][0] and operation not in ("sym", "num")
            cost = costs.PART + costs.PART_OLD_NODE * self._size(node) + costs.PART_NEW_NODE * self._size(new)
            yield self._rewritten(node, new, path, cost + costs.PART_ALIKE * alike)

    def _term_edits(self, node: int, value: Values, needed: Values, path: Path, inner: bool) -> Iterator[Change]:
        """Yield the edits of a term as a whole: lost, or times a number or a power of a symbol."""
        if not any(needed):
            if inner:
                yield Change(Kind.TERM_REMOVED, path, node, None, None, "term lost", costs.LOST_TERM)
            return
        if 0 in value:
            return
        ratio = _each(field.mul, needed, _inverse(value))
        number = rational(ratio)
        if number is None:
            yield from self._factors(node, ratio, path)
        else:
            yield multiplied(self.pool, node, path, number, costs.SIGN if number == -1 else costs.COEFFICIENT)

    def _factors(self, node: int, ratio: Values, path: Path) -> Iterator[Change]:
        """Yield the powers of symbols, with a number, whose product with a term has the required values."""
        for values, atom in self._atoms.items():
            if 0 in values:
                continue
            if values not in self._powers:
                one = _inverse(values)
                self._powers[values] = [
                    (k, tuple(field.power(v, abs(k)) for v in (one if k > 0 else values))) for k in _EXPONENTS
                ]
            for exponent, divisors in self._powers[values]:
                if field.mul(ratio[0], divisors[0]) != field.mul(ratio[-1], divisors[-1]):
                    continue  # no number; nearly every one ends here
                number = rational(_each(field.mul, ratio, divisors))
                if number is None:
                    continue
                factor = self.pool.power(atom, Fraction(exponent))
                new = self._times(node, atom, exponent, number)
                yield self._factor_change(node, new, atom, exponent, factor, number, path)

    def _factor_change(
        self, node: int, new: int, atom: int, exponent: int, factor: int, number: Fraction, path: Path
    ) -> Change:
        """Return the edit of a term times number * atom^exponent: a gained or lost factor, or another exponent."""
        extra = 0.0 if number == 1 else costs.ALSO_SIGN if number == -1 else costs.ALSO_NUMBER
        times = (
            "" if number == 1 else " and the sign flipped" if number == -1 else f" and the coefficient times {number}"
        )
        powers = map(self.pool.raised, self.pool.factors(node))
        before = next((power for base, power in powers if base == atom), None)
        if before is None:
            return Change(Kind.FACTOR, path, node, new, new, f"factor {{{factor}}} gained{times}", costs.FACTOR + extra)
        after = before + exponent
        if after == 0:
            lost = self.pool.power(atom, before)
            says = f"factor {{{lost}}} lost{times}"
            return Change(Kind.FACTOR, path, node, new, new, says, costs.LOST_FACTOR + extra)
        says = f"exponent of {{{atom}}}: {before} became {after}{times}"
        return Change(Kind.EXPONENT, path, node, new, new, says, costs.LOST_FACTOR + extra)

    def _times(self, node: int, atom: int, exponent: int, number: Fraction) -> int:
        """Return a term times number * atom^exponent, with powers of the atom combined."""
        powers = [(part, *self.pool.raised(part)) for part in self.pool.factors(node)]
        rest = [part for part, base, _ in powers if base != atom]
        total = sum((power for _, base, power in powers if base == atom), Fraction(exponent))
        return self.pool.many("mul", [*rest, self.pool.power(atom, total), self.pool.number(number)])

    def _other_name(self, node: int, needed: Values, path: Path) -> Iterator[Change]:
        """Yield the symbol or function, perhaps negative, that has the required values instead of this one."""
        operation = self.pool.nodes[node][0]
        if operation not in ("sym", *_FUNCTIONS):
            return
        kind = Kind.FUNCTION if operation != "sym" else Kind.SYMBOL
        for sign in (1, -1):
            atom = self._atoms.get(needed if sign == 1 else tuple(field.sub(0, v) for v in needed))
            if atom is None or atom == node:
                continue
            alike = operation == "sym" or self.pool.nodes[atom][1:] == self.pool.nodes[node][1:]
            further = (0.0 if alike else costs.OTHER_ARGUMENT) + (0.0 if sign == 1 else costs.ALSO_SIGN)
            new = self.pool.many("mul", [atom, self.pool.number(sign)])
            says = f"{{{node}}} became {'-' * (sign < 0)}{{{atom}}}"
            yield Change(kind, path, node, new, new, says, costs.NAME + further)

    def _exponents(self, node: int, operands: Sequence[Any], needed: Values, path: Path) -> Iterator[Change]:
        """Yield other exponents of a power that give it the required values."""
        base, before = self.old(operands[0]), self.pool.constant(operands[1])
        if base is None or before is None:
            return
        for after in (*map(Fraction, (2, 1, 3, -1, -2, 4, -3)), Fraction(1, 2), Fraction(-1, 2), Fraction(3, 2)):
            try:
                values = tuple(field.rational_power(b, after) for b in base)
            except Undefined:
                continue
            if values == needed:
                new = self.pool.power(operands[0], after)
                says = f"exponent of {{{operands[0]}}}: {before} became {after}"
                yield Change(Kind.EXPONENT, path, node, new, new, says, costs.EXPONENT)

    def _added(self, value: Values, needed: Values, path: Path) -> Iterator[Change]:
        """Yield the terms that a sum lacks: a part of the new expression or a number."""
        missing = _each(field.sub, needed, value)
        for sign in (1, -1):
            part = self._parts.get(missing if sign == 1 else tuple(field.sub(0, v) for v in missing))
            if part is not None:
                term = self.pool.many("mul", [part, self.pool.number(sign)])
                cost = costs.ADDED_TERM + costs.ADDED_NODE * self._size(part)
                yield Change(Kind.TERM_ADDED, path, None, term, term, "term added", cost)
        number = rational(missing)
        if number is not None:
            term = self.pool.number(number)
            yield Change(Kind.TERM_ADDED, path, None, term, term, "term added", costs.ADDED_NUMBER)

    def _inside(self, node: int, needed: Values, path: Path) -> Iterator[Change]:
        """Yield single edits inside a function without known inverse, found by trial."""
        if self._size(node) > _LARGEST:
            return
        for change in mutations(self.pool, node, path, tuple(self._atoms.values())):
            assert change.with_ is not None or change.kind is Kind.TERM_REMOVED
            mutant = replaced(self.pool, node, [replace(change, path=change.path[len(path) :])])
            if _values(self._olds, mutant) == needed:
                yield replace(change, cost=change.cost - costs.WRITTEN * (mutant in self._written))

    @staticmethod
    def _rewritten(old: int, new: int, path: Path, cost: float = costs.REWRITTEN) -> Change:
        return Change(Kind.REWRITTEN, path, old, new, new, f"{{{old}}} became {{{new}}}", cost)

    def _size(self, node: int) -> int:
        return len(reached(self.pool.nodes, [node]))


def _values(worlds: Sequence[FieldWorld], node: int) -> Values | None:
    values: tuple[Any, ...] = tuple(world.defined(node) for world in worlds)
    if any(value is None or isinstance(value, tuple) for value in values):
        return None
    return values


def _each(operation: Any, first: Values, second: Values) -> Values:
    return tuple(operation(a, b) for a, b in zip(first, second, strict=True))


def _inverse(values: Values) -> Values:
    return tuple(field.inverse(value) for value in values)
