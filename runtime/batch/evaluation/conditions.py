# SPDX-License-Identifier: Apache-2.0
"""Conditions on the summary of a run, as in `T_theta < 20 and final(rho) < 0.01`."""

from __future__ import annotations

import ast
import contextlib
import functools
import itertools
import math
import operator
import re
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mehvar.base.errors import InputError, bad_value, unknown_name, value_text
from mehvar.base.units import Dimension, dimension, has_radians, product, unit_text

from ...arguments import parsed
from ...run.problem import COMPLETE, Status
from ...units import without_units

Values = Mapping[str, NDArray[Any]]

_Value = Callable[[Values], Any]
"""Function that evaluates a number of a condition for many runs."""

_Truth = tuple[NDArray[np.bool_], NDArray[np.bool_]]
"""Two masks of runs: where part of a condition is true, and where it is false. A comparison with NaN is neither; `and`,
`or` and `not` follow Kleene's logic.
"""

_COMPARISONS: Mapping[type[ast.cmpop], Callable[[Any, Any], Any]] = {
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
}
_EQUALITIES: Mapping[type[ast.cmpop], Callable[[Any, Any], Any]] = {ast.Eq: operator.eq, ast.NotEq: operator.ne}
_ARITHMETIC: Mapping[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}
_SIGNS: Mapping[type[ast.AST], str] = {
    ast.And: "and", ast.Or: "or", ast.Not: "not",
    ast.USub: "-", ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/",
    ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!=",
}  # fmt: skip
_DEEPEST = 100
"""Largest depth of a condition: far more than users need, and a tenth of the depth of Python's stack."""
_STATUS = "status"
_WORDS = {status.name.lower(): int(status) for status in Status}


class _Expression:
    """Reader of a text with names of one number per run.

    Attributes
    ----------
    text : str
        The text.
    names : set of str
        The names.
    """

    _usage: str

    def __init__(self, text: str, origin: str) -> None:
        self.text, self._origin = text, origin
        self.names: set[str] = set()
        self._quantities: dict[str, _Quantity] = {}
        plain = without_units(text.strip(), self._quantity, origin)
        try:
            tree = parsed(plain)
        except ValueError:
            raise self._refused() from None
        if _is_deep(tree):
            raise self._refused(f"{self._usage}, of at most {_DEEPEST} levels")
        self._tree = tree
        self._value = self._read(tree)
        if not self.names:
            raise self._refused(f"{self._usage}: this text does not contain a result of a run")

    def _read(self, node: ast.expr) -> Callable[[Values], Any]:
        """Return the evaluator of the text for many runs."""
        raise NotImplementedError

    def check_names(self, units: Mapping[str, str], notes: Mapping[str, str]) -> None:
        """Raise InputError for unknown names and names without a number; units are not checked."""
        for name in sorted(self.names - {_STATUS}):
            if name not in units:
                raise unknown_name("number of a run", name, units, f"{self._origin} = {value_text(self.text)}")
            if name in notes:
                raise bad_value(
                    self._origin, self.text, f"a condition on numbers that the runs have: {name} is {notes[name]}"
                )

    def _alike(self, one: ast.expr, other: ast.expr, units: Mapping[str, str]) -> _Kind | None:
        """Return the common kind of two compared or added numbers; None for plain numbers, which fit every kind."""
        first, second = self._kind(one, units), self._kind(other, units)
        if first and second and not first.fits(second):
            what = f"{self._shown(one)} is in {first.unit}, {self._shown(other)} in {second.unit}"
            raise self._refused(f"a condition on numbers with the same unit: {what}")
        return first or second

    def _kind(self, node: ast.expr, units: Mapping[str, str]) -> _Kind | None:
        """Return the kind of a number."""
        if (name := _name(node)) is not None:
            return _Kind.of(self._quantities[name].unit if name in self._quantities else units[name])
        match node:
            case ast.UnaryOp(operand=inner) | ast.Call(args=[inner]):
                return self._kind(inner, units)
            case ast.BinOp(left=left, op=ast.Add() | ast.Sub(), right=right):
                return self._alike(left, right, units)
            case ast.BinOp(left=left, op=op, right=right):
                power = 1 if isinstance(op, ast.Mult) else -1
                return _times(self._kind(left, units), self._kind(right, units), power)
        return None

    def _quantity(self, value: float, unit: str, text: str) -> str:
        """Store a number that has a unit under an unused name, and return the name."""
        name = f"quantity\N{MIDDLE DOT}{len(self._quantities)}"
        self._quantities[name] = _Quantity(self._finite(value), unit, text)
        return name

    def _shown(self, node: ast.expr) -> str:
        """Return a part of the condition as its author wrote it."""
        names = re.compile("|".join(map(re.escape, self._quantities)) or "$^")
        return names.sub(lambda match: self._quantities[match[0]].text, ast.unparse(node))

    def _refused(self, allowed: str | None = None) -> InputError:
        return bad_value(self._origin, self.text, allowed or self._usage)

    def _number(self, node: ast.expr) -> _Value:
        """Return the evaluator of a node with one number per run."""
        if (name := _name(node)) == _STATUS:
            raise self._refused("a condition without arithmetic on the status, as in 'status == event'")
        if name in self._quantities:
            return lambda _: self._quantities[name].value
        if name is not None:
            self.names.add(name)
            return lambda values: values[name]
        match node:
            case ast.Constant(value=int() | float() as value) if not isinstance(value, bool):
                constant = np.float64(self._finite(value))
                return lambda _: constant
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                inner = self._number(operand)
                return lambda values: -inner(values)
            case ast.BinOp(left=left, op=op, right=right) if type(op) in _ARITHMETIC:
                one, other, apply = self._number(left), self._number(right), _ARITHMETIC[type(op)]
                if not any(_name(part) for part in ast.walk(node) if isinstance(part, ast.expr)):
                    with np.errstate(all="ignore"):
                        self._finite(apply(one({}), other({})))
                return lambda values: apply(one(values), other(values))
            case ast.Call(func=ast.Name(id="abs"), args=[argument], keywords=[]):
                inner = self._number(argument)
                return lambda values: np.abs(inner(values))
        raise self._refused()

    def _finite(self, value: float) -> float:
        """Return a constant as a double; refuse an overflow, such as 1/0."""
        with contextlib.suppress(OverflowError):
            if math.isfinite(value):
                return float(value)
        raise self._refused(f"{self._usage}, with numbers up to {sys.float_info.max:.3g}")


class Criterion(_Expression):
    """A condition that is evaluated for many runs at once.

    Parameters
    ----------
    text : str
        Comparisons (< <= > >=) of sums and products of numbers, abs(...), and names of one number per run; `and`,
        `or`, `not` join them. `final(NAME)`, `minimum(NAME)`, `maximum(NAME)` take a variable of the runs,
        `events(NAME)` counts an event. `status == WORD` and `status != WORD` test how a run ended. Otherwise `==`
        and `!=` accept only counts and whole numbers.
    origin : str
        Origin of the text in error messages.

    Raises
    ------
    InputError
        If the text is not a condition, or a run lacks a named number.
    """

    _usage = "a condition such as 'T_theta < 20 and final(rho) < 0.01'"

    def __init__(self, text: str, origin: str = "success") -> None:
        super().__init__(text, origin)

    def __call__(self, values: Values) -> NDArray[np.bool_]:
        """Return True for runs that fulfil the condition; `values` contains every name of `names`.

        A comparison with NaN is neither true nor false, so that neither `x < 1` nor `not x < 1` holds for it.
        """
        with np.errstate(all="ignore"):
            holds: NDArray[np.bool_] = self._value(values)[0]
            return holds

    def succeeds(self, status: NDArray[Any], column: Callable[[str], NDArray[Any]]) -> NDArray[np.bool_]:
        """Return True for complete runs that fulfil the condition; a condition on the status may accept others.

        Parameters
        ----------
        status : array
            How each run ended.
        column : callable
            Returns one number of each run by name.
        """
        counted = tuple(Status) if _STATUS in self.names else COMPLETE
        holds = self({name: status if name == _STATUS else column(name) for name in self.names})
        return np.isin(status, counted) & holds

    def check(self, units: Mapping[str, str], notes: Mapping[str, str]) -> None:
        """Refuse unknown names, names without a number, and comparisons of different units.

        Parameters
        ----------
        units : mapping of str to str
            Unit of each number of a run, by name.
        notes : mapping of str to str
            Reasons why some names have no number.
        """
        self.check_names(units, notes)
        for node in ast.walk(self._tree):
            if isinstance(node, ast.Compare) and _name(node.left) != _STATUS:
                for one, other in itertools.pairwise((node.left, *node.comparators)):
                    self._alike(one, other, units)

    def units(self, units: Mapping[str, str]) -> str:
        """Return the units of the numbers that the condition compares without a unit, as in "T_x in s"."""
        compared: list[ast.expr] = [node for node in ast.walk(self._tree) if isinstance(node, ast.Compare)]
        words = [
            {name for part in ast.walk(node) if isinstance(part, ast.expr) and (name := _name(part)) is not None}
            for node in compared or [self._tree]
        ]
        bare = set().union(*(names for names in words if self._quantities.keys().isdisjoint(names))) & self.names
        named = ((name, units.get(name, "1")) for name in sorted(bare))
        return ", ".join(f"{name} in {unit}" for name, unit in named if unit not in ("", "1"))

    def nested(self) -> list[Any]:
        """Return the condition as nested lists, operator first, for programs without this grammar; names are texts."""
        nested: list[Any] = self._nested(self._tree)
        return nested

    def _nested(self, node: ast.expr) -> Any:
        """Return a part of the condition as nested lists; chained comparisons become comparisons of pairs."""
        if (name := _name(node)) is not None:
            return self._quantities[name].value if name in self._quantities else name
        match node:
            case ast.BoolOp(op=op, values=nodes):
                return [_SIGNS[type(op)], *map(self._nested, nodes)]
            case ast.UnaryOp(op=op, operand=inner):
                return [_SIGNS[type(op)], self._nested(inner)]
            case ast.BinOp(left=left, op=op, right=right):
                return [_SIGNS[type(op)], self._nested(left), self._nested(right)]
            case ast.Compare(left=left, ops=ops, comparators=rest):
                words = _WORDS if _name(left) == _STATUS else {}
                sides = [
                    words.get(side, side) if isinstance(side, str) else side
                    for side in map(self._nested, (left, *rest))
                ]
                return ["and", *map(list, zip((_SIGNS[type(op)] for op in ops), sides, sides[1:], strict=False))]
            case ast.Call(args=[inner]):
                return ["abs", self._nested(inner)]
        return ast.literal_eval(node)

    def _read(self, node: ast.expr) -> Callable[[Values], _Truth]:
        """Return the evaluator of a node that is true or false."""
        match node:
            case ast.BoolOp(op=op, values=nodes):
                parts = [self._read(part) for part in nodes]
                join = _conjunction if isinstance(op, ast.And) else _disjunction
                return lambda values: functools.reduce(join, (part(values) for part in parts))
            case ast.UnaryOp(op=ast.Not(), operand=operand):
                inner = self._read(operand)
                return lambda values: inner(values)[::-1]
            case ast.Compare(left=left, ops=[op], comparators=[right]) if type(op) in _EQUALITIES:
                name, equal, other = _name(left) or "", _EQUALITIES[type(op)], self._whole(left, right)
                self.names.add(name)
                return lambda values: _comparison(equal, values[name], other)
            case ast.Compare(left=left, ops=ops, comparators=rest) if all(type(op) in _COMPARISONS for op in ops):
                numbers = [self._number(part) for part in (left, *rest)]
                pairs = list(zip([_COMPARISONS[type(op)] for op in ops], numbers, numbers[1:], strict=False))
                return lambda values: functools.reduce(
                    _conjunction, (_comparison(compare, a(values), b(values)) for compare, a, b in pairs)
                )
        raise self._refused()

    def _whole(self, left: ast.expr, right: ast.expr) -> int:
        """Return the integer with which a status or count is compared."""
        name = _name(left) or ""
        match right:
            case ast.Name(id=word) if name == _STATUS and word in _WORDS:
                return _WORDS[word]
            case ast.Constant(value=int() as value) if name.startswith("events(") and not isinstance(value, bool):
                return value
        raise self._refused(
            f"a condition in which == and != compare only the status with one of {', '.join(_WORDS)}, "
            "or a count with a whole number, as in 'status == event and events(NAME) == 1'"
        )


class Number(_Expression):
    """A number of each run: sums and products of numbers, abs(...), and the names of conditions.

    Parameters
    ----------
    text, origin : str
        As of `Criterion`.

    Raises
    ------
    InputError
        If the text is no such number.
    """

    _usage = "a number such as '2*T_theta + abs(final(rho))'"

    def __call__(self, column: Callable[[str], NDArray[Any]]) -> NDArray[np.float64]:
        """Return the number of each run; `column` returns a named number of each run."""
        values = {name: column(name) for name in self.names}
        with np.errstate(all="ignore"):
            return np.asarray(self._value(values), dtype=np.float64)

    def unit(self, units: Mapping[str, str]) -> str | None:
        """Return the unit of the number; None for a plain number."""
        self.check_names(units, {})
        kind = self._kind(self._tree, units)
        return None if kind is None else kind.unit

    def _read(self, node: ast.expr) -> _Value:
        return self._number(node)


@dataclass(frozen=True)
class _Quantity:
    """A number with unit, in SI, and its text."""

    value: float
    unit: str
    text: str


@dataclass(frozen=True)
class _Kind:
    """Unit and dimension of a number, and True for an angle (None if unknown, as for a product)."""

    unit: str
    dimension: Dimension
    angle: bool | None

    @staticmethod
    def of(unit: str) -> _Kind:
        """Return the kind of a number with this unit; a unit outside of SI is its own kind."""
        try:
            return _Kind(unit, dimension(unit), has_radians(unit))
        except ValueError:
            return _Kind(unit, {unit: Fraction(1)}, None)

    def fits(self, other: _Kind) -> bool:
        """Return True if numbers of two kinds can be compared."""
        return self.dimension == other.dimension and (None in (self.angle, other.angle) or self.angle == other.angle)


def _comparison(compare: Callable[[Any, Any], Any], one: Any, other: Any) -> _Truth:
    """Return the masks of a comparison: true, and false."""
    true, known = np.asarray(compare(one, other), dtype=np.bool_), ~(np.isnan(one) | np.isnan(other))
    return true & known, ~true & known


def _conjunction(one: _Truth, other: _Truth) -> _Truth:
    return one[0] & other[0], one[1] | other[1]


def _disjunction(one: _Truth, other: _Truth) -> _Truth:
    return one[0] | other[0], one[1] & other[1]


def _times(one: _Kind | None, other: _Kind | None, power: int) -> _Kind | None:
    """Return the kind of the product of a number and a power of another; None if neither has a unit."""
    if other is None:
        return one
    if one is None and power == 1:
        return other
    factors = ((one.dimension if one else {}, 1), (other.dimension, power))
    whole = product(*factors)
    return _Kind(unit_text(whole), whole, None)


def _is_deep(tree: ast.expr) -> bool:
    """Return True for an expression that is too deep for the recursive functions."""
    level: list[ast.AST] = [tree]
    for _ in range(_DEEPEST):
        level = [child for node in level for child in ast.iter_child_nodes(node)]
    return bool(level)


def _name(node: ast.expr) -> str | None:
    """Return the name that a node refers to: NAME, or final(NAME) and the like."""
    match node:
        case ast.Name(id=name):
            return name
        case ast.Call(
            func=ast.Name(id="final" | "minimum" | "maximum" | "events" as which), args=[ast.Name(id=name)], keywords=[]
        ):
            return f"{which}({name})"
    return None
