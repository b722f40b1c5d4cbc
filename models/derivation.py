# SPDX-License-Identifier: Apache-2.0
"""Derivation: a list of named steps with equation numbers of a paper."""

from __future__ import annotations

import functools
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import sympy as sp

from mehvar.base.names import typeset

from .arguments import expression, instance
from .quantities import Located, ModelError, Quantity, caller

Expr: TypeAlias = sp.Expr


@dataclass(frozen=True)
class Definition(Located):
    """A named step of a derivation.

    Parameters
    ----------
    symbol : sympy.Symbol
        Name of the expression, for use in later expressions.
    expr : sympy.Expr
        The named expression.
    number : str
        Equation number in the paper, such as "(20)"; empty for a step that the paper lacks.
    title : str
        Its subject, in a few words.
    section : str
        Heading under which it is printed.
    unit : str
        SI unit; empty where it follows from the expression.
    latex : str
        LaTeX of the symbol.
    """

    symbol: sp.Symbol
    expr: Expr
    number: str
    title: str
    section: str
    unit: str
    latex: str


@dataclass(frozen=True)
class Equation:
    """A derived result that is shown and compared but not evaluated, such as a differential equation.

    Attributes
    ----------
    left : str
        Left side, as LaTeX.
    expr : Expr
        Right side.
    number : str
        Equation number in the paper, such as "(20)"; empty for a result that the paper lacks.
    title, section : str
        Its subject, and the heading above it.
    unit : str
        Unit of both sides.
    """

    left: str
    expr: Expr
    number: str
    title: str
    section: str
    unit: str


class Derivation:
    """An ordered list of definitions and equations under section headings.

    Parameters
    ----------
    steps : iterable of Definition and Equation
        Earlier steps to continue, as a law continues the derivation of its plant.
    """

    def __init__(self, steps: Iterable[Definition | Equation] = ()) -> None:
        self.steps: list[Definition | Equation] = list(steps)
        self._section = ""
        self._names = {step.symbol.name for step in self.steps if isinstance(step, Definition)}

    @property
    def definitions(self) -> dict[sp.Symbol, Expr]:
        """Definitions up to now, by symbol."""
        return {step.symbol: step.expr for step in self.steps if isinstance(step, Definition)}

    def section(self, title: str) -> None:
        """Start a new heading."""
        self._section = title

    def define(
        self,
        name: str,
        expr: Expr | float,
        number: str = "",
        title: str = "",
        unit: str = "",
        latex: str = "",
        positive: bool = False,
    ) -> sp.Symbol:
        """Name an expression and return its symbol. By default the unit follows from the expression.

        Raises
        ------
        ModelError
            If the name is already in use.
        """
        for what, text in (("name", name), ("number", number), ("title", title), ("unit", unit), ("latex", latex)):
            instance(what, text, str, "a text")
        if name in self._names:
            raise ModelError(f"{caller()}: definition {name!r} exists already")
        self._names.add(name)
        quantity = Quantity(name, unit, title, latex, instance("positive", positive, bool, "True or False"))
        definition = Definition(
            quantity.symbol,
            expression(f"definition {name!r}", expr),
            number,
            title,
            self._section,
            unit,
            latex or typeset(name),
        )
        self.steps.append(definition)
        return quantity.symbol

    def show(self, left: str, expr: Expr, number: str = "", title: str = "", unit: str = "1") -> None:
        """Record a derived equation `left = expr` for display, with `left` in LaTeX."""
        self.steps.append(Equation(left, expression(f"equation {left!r}", expr), number, title, self._section, unit))


def vector(
    name: str, values: Iterable[Expr], title: str, unit: str, latex: str, d: Derivation, number: str = "",
    labels: Sequence[str] = "xyz", positive: bool = False,
) -> sp.Matrix:  # fmt: skip
    """Name the components of a vector; `*` in names and titles stands for the label of a component."""
    return sp.Matrix(
        [
            d.define(name.replace("*", i), value, number, title.replace("*", i), unit, latex.replace("*", i), positive)
            for i, value in zip(labels, values, strict=True)
        ]
    )


def matrix(name: str, values: sp.Matrix, title: str, unit: str, d: Derivation, number: str = "") -> sp.Matrix:
    """Name the elements of a matrix, row by row."""
    labels = [f"{i + 1}{j + 1}" for i in range(3) for j in range(3)]
    return vector(f"{name}*", values, title, unit, f"{name}_{{*}}", d, number, labels).reshape(3, 3)


def symmetric(name: str, values: sp.Matrix, title: str, unit: str, latex: str, d: Derivation) -> sp.Matrix:
    """Name the elements of a symmetric matrix."""
    places = [(i, j) for i in range(3) for j in range(i, 3)]
    labels = [f"{i + 1}{j + 1}" for i, j in places]
    upper = [values[place] for place in places]
    named = dict(zip(places, vector(f"{name}*", upper, title, unit, f"{latex}_{{*}}", d, "", labels), strict=True))
    return sp.Matrix(3, 3, lambda i, j: named[min(i, j), max(i, j)])


def free_symbols(expressions: Iterable[Expr], definitions: Mapping[sp.Symbol, Expr]) -> set[sp.Symbol]:
    """Return the symbols that expressions depend on, with definitions resolved."""
    return {s for s in _reached(expressions, definitions) if s not in definitions}


def used_definitions(expressions: Iterable[Expr], definitions: Mapping[sp.Symbol, Expr]) -> set[sp.Symbol]:
    """Return the definitions that expressions use, directly or indirectly."""
    return {s for s in _reached(expressions, definitions) if s in definitions}


@functools.lru_cache(10_000)
def symbols_of(expression: Expr | float) -> frozenset[sp.Symbol]:
    """Return the symbols in an expression; cached, because checks and functions ask dozens of times for the same."""
    return frozenset(sp.sympify(expression).free_symbols)


def _reached(expressions: Iterable[Expr], definitions: Mapping[sp.Symbol, Expr]) -> set[sp.Symbol]:
    """Return the symbols in expressions and in the definitions that they use."""
    reached: set[sp.Symbol] = set()
    stack = [s for e in expressions for s in symbols_of(e)]
    while stack:
        symbol = stack.pop()
        if symbol not in reached:
            reached.add(symbol)
            if symbol in definitions:
                stack.extend(symbols_of(definitions[symbol]) - reached)
    return reached
