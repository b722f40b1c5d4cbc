# SPDX-License-Identifier: Apache-2.0
"""Conditions on the summary of a run, as in `T_theta < 20 and final(rho) < 0.01`.

A text is read once into nested lists, operator first: ["and", ["<", "T_theta", 20], ["<", "final(rho)", 0.01]]. Names
are texts. Values, units and other programs start from these lists.
"""

from __future__ import annotations

import ast
import contextlib
import functools
import math
import operator
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mehvar.base.errors import InputError, bad_value, unknown_name, value_text
from mehvar.base.units import Dimension, dimension, product, radians, unit_text

from ...arguments import parsed
from ...run.problem import COMPLETE, Status
from ...units import without_units

Values = Mapping[str, NDArray[Any]]

_Truth = tuple[NDArray[np.bool_], NDArray[np.bool_]]
"""Two masks of runs: where part of a condition is true, and where it is false. A comparison with NaN is neither; `and`,
`or` and `not` follow Kleene's logic.
"""

_SIGNS: Mapping[type[ast.AST], str] = {
    ast.And: "and", ast.Or: "or", ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/",
    ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!=",
}  # fmt: skip
_Order = ast.Lt | ast.LtE | ast.Gt | ast.GtE
_OPERATORS: Mapping[str, Callable[[Any, Any], Any]] = {
    "+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.truediv,
    "<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge, "==": operator.eq, "!=": operator.ne,
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
        self._tree = self._read(tree)
        if not self.names:
            raise self._refused(f"{self._usage}: this text does not contain a result of a run")

    def _read(self, node: ast.expr) -> Any:
        """Return the text as nested lists."""
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

    def _alike(self, one: Any, other: Any, units: Mapping[str, str]) -> _Kind | None:
        """Return the common kind of two compared or added numbers; None for plain numbers, which fit every kind."""
        first, second = self._kind(one, units), self._kind(other, units)
        if first and second and not first.fits(second):
            what = f"{_shown(one)} is in {first.unit}, {_shown(other)} in {second.unit}"
            raise self._refused(f"a condition on numbers with the same unit: {what}")
        return first or second

    def _kind(self, tree: Any, units: Mapping[str, str]) -> _Kind | None:
        """Return the kind of a number."""
        match tree:
            case str():
                return _Kind.of(units[tree])
            case _Quantity():
                return _Kind.of(tree.unit)
            case ["abs" | "-", inner]:
                return self._kind(inner, units)
            case ["+" | "-", one, other]:
                return self._alike(one, other, units)
            case ["*" | "/" as sign, one, other]:
                return _times(self._kind(one, units), self._kind(other, units), 1 if sign == "*" else -1)
        return None

    def _quantity(self, value: float, negative: float, unit: str, text: str) -> str:
        """Store a number that has a unit under an unused name, and return the name."""
        name = f"quantity\N{MIDDLE DOT}{len(self._quantities)}"
        quantity = self._quantities[name] = _Quantity(self._finite(value))
        quantity.opposite, quantity.unit, quantity.text = negative, unit, text
        return name

    def _refused(self, allowed: str | None = None) -> InputError:
        return bad_value(self._origin, self.text, allowed or self._usage)

    def _number(self, node: ast.expr) -> Any:
        """Return a number of each run as nested lists."""
        if (name := _name(node)) == _STATUS:
            raise self._refused("a condition without arithmetic on the status, as in 'status == event'")
        if name in self._quantities:
            return self._quantities[name]
        if name is not None:
            self.names.add(name)
            return name
        match node:
            case ast.Constant(value=int() | float() as value) if not isinstance(value, bool):
                self._finite(value)
                return value
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                number = self._number(operand)
                return number.negative() if isinstance(number, _Quantity) and number.is_level else ["-", number]
            case ast.BinOp(left=left, op=ast.Add() | ast.Sub() | ast.Mult() | ast.Div() as op, right=right):
                tree = [_SIGNS[type(op)], self._number(left), self._number(right)]
                self._check_levels(tree)
                if not any(isinstance(leaf, str) for leaf in _leaves(tree)):
                    with np.errstate(all="ignore"):
                        self._finite(_value(tree, {}))
                return tree
            case ast.Call(func=ast.Name(id="abs"), args=[argument], keywords=[]):
                tree = ["abs", self._number(argument)]
                self._check_levels(tree)
                return tree
        raise self._refused()

    def _check_levels(self, *trees: Any) -> None:
        """Refuse arithmetic with a level: 5 degC in it may stand for a temperature or for a difference of two."""
        leaves = (leaf for tree in trees for leaf in (_leaves(tree) if isinstance(tree, list) else [tree]))
        if level := next((leaf for leaf in leaves if isinstance(leaf, _Quantity) and leaf.is_level), None):
            raise self._refused(
                f"{self._usage}, with levels such as {level.text} only beside a name: in arithmetic take SI"
            )

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
            return _masks(self._tree, values)[0]

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
        for chain in _chains(self._tree):
            for _, one, other in chain[1:]:
                if one != _STATUS:
                    self._alike(one, other, units)

    def units(self, units: Mapping[str, str]) -> str:
        """Return the units of the numbers that the condition compares without a unit, as in "T_x in s"."""
        leaves = [list(_leaves(chain)) for chain in _chains(self._tree)]
        plain = (group for group in leaves if not any(isinstance(leaf, _Quantity) for leaf in group))
        bare = set().union(*plain) & self.names
        named = ((name, units.get(name, "1")) for name in sorted(bare))
        return ", ".join(f"{name} in {unit}" for name, unit in named if unit not in ("", "1"))

    def nested(self) -> list[Any]:
        """Return the condition as nested lists, operator first, for programs without this grammar; names are texts."""
        nested: list[Any] = self._tree
        return nested

    def _read(self, node: ast.expr) -> list[Any]:
        """Return a condition as nested lists; chained comparisons become comparisons of pairs."""
        match node:
            case ast.BoolOp(op=connective, values=nodes):
                return [_SIGNS[type(connective)], *map(self._read, nodes)]
            case ast.UnaryOp(op=ast.Not(), operand=operand):
                return ["not", self._read(operand)]
            case ast.Compare(left=left, ops=[ast.Eq() | ast.NotEq() as equality], comparators=[right]):
                name, whole = _name(left) or "", self._whole(left, right)
                self.names.add(name)
                return ["and", [_SIGNS[type(equality)], name, whole]]
            case ast.Compare(left=left, ops=ops, comparators=rest) if all(isinstance(op, _Order) for op in ops):
                sides = [self._number(side) for side in (left, *rest)]
                if any(isinstance(leaf, str) for side in sides if isinstance(side, list) for leaf in _leaves(side)):
                    self._check_levels(*sides)
                return ["and", *map(list, zip((_SIGNS[type(op)] for op in ops), sides, sides[1:], strict=False))]
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
            return np.asarray(_value(self._tree, values), dtype=np.float64)

    def unit(self, units: Mapping[str, str]) -> str | None:
        """Return the unit of the number; None for a plain number."""
        self.check_names(units, {})
        kind = self._kind(self._tree, units)
        return None if kind is None else kind.unit

    def _read(self, node: ast.expr) -> Any:
        return self._number(node)


class _Quantity(float):
    """A number with unit, in SI, the same with the other sign before its unit, and its text."""

    opposite: float
    unit: str
    text: str

    @property
    def is_level(self) -> bool:
        """True if its unit does not count from zero or not in equal steps, as degC and dB."""
        return self.opposite != -self

    def negative(self) -> _Quantity:
        """Return the number with the other sign before its unit: -20 degC is 253.15 K."""
        negative = _Quantity(self.opposite)
        negative.opposite, negative.unit, negative.text = float(self), self.unit, f"-{self.text}"
        return negative


@dataclass(frozen=True)
class _Kind:
    """Unit and dimension of a number, and its power of radians (None if unknown, as for a product)."""

    unit: str
    dimension: Dimension
    angle: Fraction | None

    @staticmethod
    def of(unit: str) -> _Kind:
        """Return the kind of a number with this unit; a unit outside of SI is its own kind."""
        try:
            return _Kind(unit, dimension(unit), radians(unit))
        except ValueError:
            return _Kind(unit, {unit: Fraction(1)}, None)

    def fits(self, other: _Kind) -> bool:
        """Return True if numbers of two kinds can be compared."""
        return self.dimension == other.dimension and (None in (self.angle, other.angle) or self.angle == other.angle)


def _masks(tree: Any, values: Values) -> _Truth:
    """Return where a condition is true, and where it is false."""
    sign, *parts = tree
    if sign == "not":
        return _masks(parts[0], values)[::-1]
    if sign in ("and", "or"):
        true, false = zip(*(_masks(part, values) for part in parts), strict=True)
        every, some = (functools.partial(functools.reduce, join) for join in (operator.and_, operator.or_))
        return (every(true), some(false)) if sign == "and" else (some(true), every(false))
    one, other = (_value(part, values) for part in parts)
    holds, known = np.asarray(_OPERATORS[sign](one, other), dtype=np.bool_), ~(np.isnan(one) | np.isnan(other))
    return holds & known, ~holds & known


def _value(tree: Any, values: Values) -> Any:
    """Return a number for many runs."""
    match tree:
        case str():
            return values[tree]
        case ["abs", inner]:
            return np.abs(_value(inner, values))
        case ["-", inner]:
            return -_value(inner, values)
        case [sign, one, other]:
            return _OPERATORS[sign](_value(one, values), _value(other, values))
    return np.float64(tree)


def _chains(tree: Any) -> Iterator[list[Any]]:
    """Yield the chains of comparisons in a condition, as ["and", [sign, one, other], ...]."""
    if tree[1][0] in ("and", "or", "not"):
        for part in tree[1:]:
            yield from _chains(part)
    else:
        yield tree


def _leaves(tree: Any) -> Iterator[Any]:
    """Yield the names, numbers and quantities of nested lists."""
    if isinstance(tree, list):
        for part in tree[1:]:
            yield from _leaves(part)
    else:
        yield tree


def _shown(tree: Any, inner: bool = False) -> str:
    """Return a number of a condition as its author could write it."""
    match tree:
        case ["abs", part]:
            return f"abs({_shown(part)})"
        case ["-", part]:
            return f"-{_shown(part, True)}"
        case [sign, one, other]:
            text = f"{_shown(one, True)} {sign} {_shown(other, True)}"
            return f"({text})" if inner else text
    return tree.text if isinstance(tree, _Quantity) else str(tree)


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
