# SPDX-License-Identifier: Apache-2.0
"""Conditions on the summary of a run, as in `T_theta < 20 and final(rho) < 0.01`."""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable, Collection, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mehvar.errors import InputError, bad_value, unknown_name

Values = Mapping[str, NDArray[Any]]

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
_USAGE = "a condition such as 'T_theta < 20 and final(rho) < 0.01'"


class Criterion:
    """A condition that is evaluated for many runs at once.

    Parameters
    ----------
    text : str
        Comparisons (< <= > >=) of sums and products of numbers, abs(...), and names of one number per run; `and`,
        `or`, `not` join them. `final(NAME)`, `minimum(NAME)`, `maximum(NAME)` take a variable of the runs.

    Raises
    ------
    InputError
        If the text is no such condition.
    """

    def __init__(self, text: str, origin: str = "success") -> None:
        self.text, self._origin = text, origin
        self.names: set[str] = set()
        try:
            self._tree = ast.parse(text.strip(), mode="eval").body
        except (SyntaxError, ValueError, MemoryError, RecursionError):
            raise self._refused() from None
        self._collect(self._tree)
        negated = isinstance(self._tree, ast.UnaryOp) and isinstance(self._tree.op, ast.Not)
        if not negated and not isinstance(self._tree, ast.Compare | ast.BoolOp):
            raise self._refused()

    def __call__(self, values: Values) -> NDArray[np.bool_]:
        """Return for which runs it holds; comparisons with NaN do not. The values have every name of `names`."""
        with np.errstate(all="ignore"):
            result: NDArray[np.bool_] = np.asarray(self._value(self._tree, values), dtype=np.bool_)
        return result

    def check(self, names: Collection[str]) -> None:
        """Raise InputError for a name that is not known."""
        for name in sorted(self.names):
            if name not in names:
                raise unknown_name("number of a run", name, names, f"{self._origin} = {self.text!r}")

    def _refused(self) -> InputError:
        return bad_value(self._origin, self.text, _USAGE)

    def _collect(self, node: ast.expr) -> None:
        """Gather the names that are looked up, and refuse what is not understood."""
        if (name := _name(node)) is not None:
            self.names.add(name)
            return
        for child in self._operands(node):
            self._collect(child)

    def _operands(self, node: ast.expr) -> list[ast.expr]:
        match node:
            case ast.Constant(value=int() | float()):
                return []
            case ast.BoolOp(values=values):
                return values
            case ast.UnaryOp(op=ast.Not() | ast.USub(), operand=operand):
                return [operand]
            case ast.BinOp(left=left, op=op, right=right) if type(op) in _ARITHMETIC:
                return [left, right]
            case ast.Compare(left=left, ops=ops, comparators=rest) if all(type(op) in _COMPARISONS for op in ops):
                return [left, *rest]
            case ast.Call(func=ast.Name(id="abs"), args=[argument], keywords=[]):
                return [argument]
        raise self._refused()

    def _value(self, node: ast.expr, values: Values) -> Any:
        if (name := _name(node)) is not None:
            return values[name]
        parts = [self._value(child, values) for child in self._operands(node)]
        match node:
            case ast.Constant(value=value):
                return value
            case ast.BoolOp(op=op):
                return (np.logical_and if isinstance(op, ast.And) else np.logical_or).reduce(
                    np.broadcast_arrays(*parts)
                )
            case ast.UnaryOp(op=ast.Not()):
                return np.logical_not(parts[0])
            case ast.UnaryOp():
                return -parts[0]
            case ast.BinOp(op=op):
                return _ARITHMETIC[type(op)](*parts)
            case ast.Compare(ops=ops):
                pairs = zip(ops, parts, parts[1:], strict=False)
                return np.logical_and.reduce([_COMPARISONS[type(op)](a, b) for op, a, b in pairs])
        return np.abs(parts[0])


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
