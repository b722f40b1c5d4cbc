# SPDX-License-Identifier: Apache-2.0
"""Argument checks of the vocabulary's functions: expressions, vectors, mappings."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeVar

import sympy as sp

from .quantities import wrong

_Kind = TypeVar("_Kind")


def expression(name: str, value: object) -> sp.Expr:
    """Return a number or an expression as a SymPy object; texts are refused, as they would become unknown symbols.

    Raises
    ------
    ModelError
        For anything else.
    """
    if isinstance(value, sp.Expr | int | float) and not isinstance(value, bool | sp.MatrixExpr):
        return sp.sympify(value)
    raise wrong(name, value, "a SymPy expression or a number")


def expressions(name: str, values: object, count: int | None = None) -> tuple[sp.Expr, ...]:
    """Return the entries of a sequence or matrix, or raise ModelError; `count` is the required number, if any."""
    allowed = f"{'some' if count is None else count} expressions, as a tuple or a matrix"
    if not isinstance(values, tuple | list | sp.MatrixBase) or count not in (None, len(values)):
        raise wrong(name, values, allowed)
    return tuple(expression(f"{name}[{k}]", value) for k, value in enumerate(values))


def symbols(name: str, values: object, count: int | None = None) -> tuple[sp.Symbol, ...]:
    """Return the entries of a sequence or matrix of distinct symbols, or raise ModelError."""
    result = expressions(name, values, count)
    if not all(isinstance(value, sp.Symbol) for value in result):
        raise wrong(name, values, "SymPy symbols")
    return result


def rates_of(values: object) -> dict[sp.Symbol, sp.Expr]:
    """Return a mapping from symbols to their rates, or raise ModelError."""
    if not isinstance(values, Mapping) or not all(isinstance(key, sp.Symbol) for key in values):
        raise wrong("rates", values, "a mapping of symbols to their rates")
    return {key: expression("a rate", value) for key, value in values.items()}


def instance(name: str, value: object, kind: type[_Kind], allowed: str) -> _Kind:
    """Return a value if it has the given class, or raise ModelError."""
    if isinstance(value, kind):
        return value
    raise wrong(name, value, allowed)
