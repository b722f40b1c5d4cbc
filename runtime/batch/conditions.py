# SPDX-License-Identifier: Apache-2.0
"""Conditions on the summary of a run, as in `T_theta < 20 and final(rho) < 0.01`."""

from __future__ import annotations

import ast
import contextlib
import functools
import math
import operator
import sys
import warnings
from collections.abc import Callable, Collection, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mehvar.errors import InputError, bad_value, shown, unknown_name

from ..arguments import literals_are_numbers

Values = Mapping[str, NDArray[Any]]

_Value = Callable[[Values], Any]
"""Evaluates a part of a condition for many runs."""

_COMPARISONS: Mapping[type[ast.cmpop], Callable[[Any, Any], Any]] = {
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
}
_ARITHMETIC: Mapping[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}
_DEEPEST = 100
"""Levels of a condition, far more than anybody writes, and a tenth of what Python's own stack bears."""
_USAGE = "a condition such as 'T_theta < 20 and final(rho) < 0.01'"


class Criterion:
    """A condition that is evaluated for many runs at once.

    Parameters
    ----------
    text : str
        Comparisons (< <= > >=) of sums and products of numbers, abs(...), and names of one number per run; `and`,
        `or`, `not` join them. `final(NAME)`, `minimum(NAME)`, `maximum(NAME)` take a variable of the runs.
    origin : str
        How messages call the text.

    Raises
    ------
    InputError
        If the text is no such condition, or names no number of a run.
    """

    def __init__(self, text: str, origin: str = "success") -> None:
        self.text, self._origin = text, origin
        self.names: set[str] = set()
        tree = self._parsed()
        _check_depth(tree, self._refused)
        if not literals_are_numbers(tree, text.strip()):
            raise self._refused()
        self._holds = self._condition(tree)
        if not self.names:
            raise self._refused(f"{_USAGE}: it names no number of a run")

    def __call__(self, values: Values) -> NDArray[np.bool_]:
        """Return for which runs it holds; comparisons with NaN do not. The values have every name of `names`."""
        with np.errstate(all="ignore"):
            result: NDArray[np.bool_] = np.asarray(self._holds(values), dtype=np.bool_)
        return result

    def check(self, names: Collection[str], notes: Mapping[str, str]) -> None:
        """Raise InputError for a name that is not known, or that has no number for the reason that is noted."""
        for name in sorted(self.names):
            if name not in names:
                raise unknown_name("number of a run", name, names, f"{self._origin} = {shown(self.text)}")
            if name in notes:
                raise bad_value(self._origin, self.text, f"about numbers that the runs have: {name} is {notes[name]}")

    def _parsed(self) -> ast.expr:
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")  # Python warns of texts such as `1if` before it refuses them
                return ast.parse(self.text.strip(), mode="eval").body
        except (SyntaxError, ValueError, MemoryError, RecursionError, Warning):
            raise self._refused() from None

    def _refused(self, allowed: str = _USAGE) -> InputError:
        return bad_value(self._origin, self.text, allowed)

    def _condition(self, node: ast.expr) -> _Value:
        """Return what evaluates a node that holds or does not."""
        match node:
            case ast.BoolOp(op=op, values=nodes):
                parts = [self._condition(part) for part in nodes]
                join = np.logical_and if isinstance(op, ast.And) else np.logical_or
                return lambda values: functools.reduce(join, (part(values) for part in parts))
            case ast.UnaryOp(op=ast.Not(), operand=operand):
                inner = self._condition(operand)
                return lambda values: np.logical_not(inner(values))
            case ast.Compare(left=left, ops=ops, comparators=rest) if all(type(op) in _COMPARISONS for op in ops):
                numbers = [self._number(part) for part in (left, *rest)]
                pairs = list(zip([_COMPARISONS[type(op)] for op in ops], numbers, numbers[1:], strict=False))
                return lambda values: functools.reduce(
                    np.logical_and, (compare(a(values), b(values)) for compare, a, b in pairs)
                )
        raise self._refused()

    def _number(self, node: ast.expr) -> _Value:
        """Return what evaluates a node that is a number for each run."""
        if (name := _name(node)) is not None:
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
        """Return a constant as a double; one that is too large, such as 1/0, is no number that somebody means."""
        with contextlib.suppress(OverflowError):
            if math.isfinite(value):
                return float(value)
        raise self._refused(f"{_USAGE}, with numbers up to {sys.float_info.max:.3g}")


def _check_depth(tree: ast.expr, refused: Callable[[str], InputError]) -> None:
    """Refuse a tree that is deeper than what walks it by recursion can go."""
    level: list[ast.AST] = [tree]
    for _ in range(_DEEPEST):
        level = [child for node in level for child in ast.iter_child_nodes(node)]
        if not level:
            return
    raise refused(f"{_USAGE}, of at most {_DEEPEST} levels")


def _name(node: ast.expr) -> str | None:
    """Return what a node looks up: NAME, or final(NAME) and the like."""
    match node:
        case ast.Name(id=name):
            return name
        case ast.Call(
            func=ast.Name(id="final" | "minimum" | "maximum" as which), args=[ast.Name(id=name)], keywords=[]
        ):
            return f"{which}({name})"
    return None
