# SPDX-License-Identifier: Apache-2.0
"""Dimensions of expressions, from the units of their symbols."""

from __future__ import annotations

import contextlib
import math
import re
from collections.abc import Iterable, Iterator, Mapping
from fractions import Fraction

import sympy as sp
from sympy.core.relational import Relational

from mehvar.base.units import Dimension, dimension, product, unit_text

from ..derivation import Definition, used_definitions
from ..quantities import LARGEST, TIME, ModelError
from ..system import System
from .vectors import Vector, law_groups, system_groups

NUMBER: Dimension = {}
_SAME = (sp.Add, sp.Min, sp.Max, sp.Mod, sp.atan2, Relational)
"""Functions whose arguments must have equal dimensions."""
_KEPT = (sp.Add, sp.Min, sp.Max, sp.Mod)
"""Functions whose value has the dimension of the arguments."""
_OF_NUMBERS = (
    sp.sin, sp.cos, sp.tan, sp.asin, sp.acos, sp.atan, sp.sinh, sp.cosh, sp.tanh, sp.asinh, sp.acosh, sp.atanh,
    sp.exp, sp.log, sp.floor, sp.ceiling, sp.erf,
)  # fmt: skip


_DEGREE = "deg"
_ROUNDING = 4e-15
"""Relative tolerance that recognises pi/180 despite rounding: a few units in the last place."""


class MisfitError(Exception):
    """Mismatch of dimensions; the caller adds file and line to its message."""


def check_dimensions(system: System, vectors: Iterable[Vector]) -> None:
    """Refuse expressions whose unit differs from their quantity's, and sums of different dimensions.

    A definition without a stated unit has the unit of its expression. A definition that is a plain number has its
    stated unit.
    """
    _check_units(system, vectors)
    dimensions = _ByScope(system)
    apart: set[sp.Symbol] = set()
    for vector in vectors:
        if vector.in_numbers:
            apart |= used_definitions(vector.entries, system.definitions)
            continue
        for k, entry in enumerate(vector.entries):
            _check_row(dimensions.of(vector), vector, k, entry)
    for step in system.definitions_in_order:
        if step.symbol not in apart:
            with placed(f"{step.origin}: definition {step.symbol.name!r}"):
                dimensions.anywhere(step.symbol)


def check_radians(unit: str, where: str) -> None:
    """Refuse degrees: functions of angles use radians, and a check of dimensions cannot see the difference."""
    if "deg" in re.findall("[A-Za-z]+", unit):
        raise ModelError(
            f"{where}: unit = {unit!r}: must be in rad; only a parameter that sympy.rad converts may be in deg"
        )


def _check_row(dimensions: Dimensions, vector: Vector, k: int, entry: sp.Expr) -> None:
    parts = entry.args if vector.margin and isinstance(entry, sp.Min) else (entry,)
    with placed(vector.row(k)):
        values = [dimensions(part) for part in parts]  # only the sign of a smallest margin counts
        if k < len(vector.rows) and values[0] is not None and not vector.in_balance:
            unit = vector.rows[k].unit + ("/s" if vector.rate else "")
            if values[0] != dimension(unit):
                raise MisfitError(f"{short(entry)} has the unit {unit_text(values[0])}: must be {unit}")


def _check_units(system: System, vectors: Iterable[Vector]) -> None:
    """Refuse invalid units in quantities and definitions."""
    for vector in vectors:
        for unit in (*vector.units.values(), *(q.unit for q in vector.rows)):
            with placed(f"{vector.origin}: {vector.what}"):
                dimension(unit)
        for k, row in enumerate(vector.rows):
            check_radians(row.unit, vector.row(k))
    for step in system.definitions_in_order:
        with placed(f"{step.origin}: definition {step.symbol.name!r}"):
            dimension(step.unit or "1")


@contextlib.contextmanager
def placed(where: str) -> Iterator[None]:
    """Prefix a message about a unit with file and line."""
    try:
        yield
    except (MisfitError, ValueError) as error:
        raise ModelError(f"{where}: {error}") from None


class _ByScope:
    """Dimensions by scope: two laws may have gains of one name with different units."""

    def __init__(self, system: System) -> None:
        self._definitions = {step.symbol: step for step in system.definitions_in_order}
        self._common = {q.symbol: q.unit for _, group in system_groups(system) for q in group} | {
            TIME.symbol: TIME.unit
        }
        own_symbols = {q.symbol: q.unit for law in system.controllers for _, group in law_groups(law) for q in group}
        inside = {q.symbol: q.unit for f in system.functions for group in f.arguments for q in group}
        self.anywhere = Dimensions(self._definitions | inside | own_symbols | self._common | self._definitions)
        self._scopes: dict[frozenset[tuple[sp.Symbol, str]], Dimensions] = {}

    def of(self, vector: Vector) -> Dimensions:
        """Return the dimensions in the scope of a vector."""
        units = vector.units
        scope = frozenset((symbol, unit) for symbol, unit in units.items() if self._common.get(symbol) != unit)
        if scope not in self._scopes:
            self._scopes[scope] = Dimensions(self._definitions | self._common | units)
        return self._scopes[scope]


class Dimensions:
    """Dimensions of expressions, from those of their symbols.

    Each shared subexpression is visited once: equations of motion are graphs of a few thousand nodes, but trees of
    millions. Zero and `LARGEST` fit any dimension, written None.

    Parameters
    ----------
    symbols : mapping of Symbol to str or Definition
        Unit of each quantity, or its definition.
    """

    def __init__(self, symbols: Mapping[sp.Symbol, str | Definition]) -> None:
        self._definitions = {s: step for s, step in symbols.items() if isinstance(step, Definition)}
        self._memo: dict[sp.Basic, Dimension | None] = {
            symbol: dimension(unit) for symbol, unit in symbols.items() if isinstance(unit, str)
        }

    def __call__(self, root: sp.Basic) -> Dimension | None:
        """Return the dimension of an expression; None if any dimension fits.

        Raises
        ------
        MisfitError
            If summands differ in dimension, or a function of plain numbers gets an argument with a unit.
        """
        stack, entered = [root], set[sp.Basic]()
        while stack:
            node = stack[-1]
            waiting = [] if node in self._memo else [part for part in self._parts(node) if part not in self._memo]
            if waiting and node in entered:
                raise MisfitError(f"definition {short(node)!r} is defined by itself")
            if waiting:
                entered.add(node)
                stack.extend(waiting)
                continue
            stack.pop()
            if node not in self._memo:
                self._memo[node] = self._of(node)
        return self._memo[root]

    def _parts(self, node: sp.Basic) -> tuple[sp.Basic, ...]:
        return (self._definitions[node].expr,) if node in self._definitions else node.args

    def _of(self, node: sp.Basic) -> Dimension | None:
        """Return a node's dimension from those of its operands; None for zero, which has any unit."""
        if node in self._definitions:
            return self._defined(self._definitions[node])
        if node.is_Number or not node.args:
            return None if node.is_zero or node == LARGEST else NUMBER
        if isinstance(node, sp.Mul):
            return self._product(node)
        if isinstance(node, sp.Pow):
            return self._power(node)
        if isinstance(node, sp.Piecewise):
            return self._common(node, [pair.expr for pair in node.args])
        if isinstance(node, _SAME):
            common = self._common(node, node.args)
            return common if isinstance(node, _KEPT) else NUMBER
        if isinstance(node, _OF_NUMBERS):
            self._number(node.args[0], f"{type(node).__name__} needs a number without unit")
            return NUMBER
        return self._memo[node.args[0]] if isinstance(node, sp.Abs) else NUMBER

    def _defined(self, step: Definition) -> Dimension | None:
        """Return a definition's dimension; refuse a declared unit other than that of its expression."""
        value = self._memo[step.expr]
        if not step.unit or step.expr.is_number:
            return dimension(step.unit) if step.unit else value
        if value is not None and value != dimension(step.unit):
            raise MisfitError(
                f"definition {step.symbol.name!r} at {step.origin}: {short(step.expr)} has the unit "
                f"{unit_text(value)}, and declares {step.unit}: correct one of them"
            )
        return dimension(step.unit)

    def _product(self, node: sp.Mul) -> Dimension | None:
        parts = [self._memo[factor] for factor in node.args]
        known = [part for part in parts if part is not None]
        return self._turned(node, product(*((part, 1) for part in known))) if len(known) == len(parts) else None

    def _turned(self, node: sp.Mul, dimension: Dimension) -> Dimension:
        """Return the dimension of a product; the factor pi/180 converts degrees to radians.

        Half and twice this factor convert too: SymPy merges the numbers of a product, and quaternions use half angles.
        """
        power = dimension.get(_DEGREE)
        if not power:
            return dimension
        number = sp.Mul(*(factor for factor in node.args if factor.is_number))
        turns = abs(float(number / (sp.pi / 180) ** sp.Rational(power)))
        if abs(math.remainder(math.log2(turns), 1)) > _ROUNDING:
            return dimension
        return {base: exponent for base, exponent in dimension.items() if base != _DEGREE}

    def _power(self, node: sp.Pow) -> Dimension | None:
        """Return a power's dimension; refuse a quantity with a unit to a power that is no number."""
        base = self._memo[node.base]
        if not base or not node.exp.is_Rational:
            self._number(node.exp, "an exponent must be a number without unit")
        if not base:
            return base
        if not node.exp.is_Rational:
            raise MisfitError(
                f"{short(node.base)} [{unit_text(base)}] has the exponent {short(node.exp)}: an exponent "
                "of a quantity with a unit must be a number"
            )
        return product((base, Fraction(int(node.exp.p), int(node.exp.q))))

    def _common(self, node: sp.Basic, parts: tuple[sp.Basic, ...] | list[sp.Basic]) -> Dimension | None:
        """Return the dimension that all parts have; refuse two different ones."""
        known = [(part, d) for part in parts if (d := self._memo[part]) is not None]
        for part, other in known[1:]:
            first, expected = known[0]
            if other != expected:
                raise MisfitError(
                    f"{short(first)} [{unit_text(expected)}] and {short(part)} [{unit_text(other)}] "
                    f"have different units in {short(node)}"
                )
        return known[0][1] if known else None

    def _number(self, node: sp.Basic, rule: str) -> None:
        dimension = self._memo[node]
        if dimension:
            hint = (
                "; write sympy.rad(...) of an angle in degrees, as a separate definition"
                if _DEGREE in dimension
                else ""
            )
            raise MisfitError(f"{rule}, but {short(node)} has the unit {unit_text(dimension)}{hint}")


def short(expr: sp.Basic) -> str:
    """Return the text of an expression, shortened for messages."""
    if sum(1 for _ in zip(sp.preorder_traversal(expr), range(_NODES), strict=False)) == _NODES:
        return f"a {type(expr).__name__} of {len(expr.args)} parts"
    return str(expr)


_NODES = 40
"""Largest number of nodes of an expression in a message, which fill one or two lines."""
