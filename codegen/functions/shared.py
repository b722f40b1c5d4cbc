# SPDX-License-Identifier: Apache-2.0
"""Graphs of definitions, converted once for all functions in which their symbols have the same values."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Set

import casadi as ca
import sympy as sp

from mehvar.models.derivation import symbols_of
from mehvar.models.system import Expr, Group

from .lower import Converter


class SharedDefinitions:
    """Definitions with their graphs and the symbols that they depend on; sets of symbols are bits of integers.

    Parameters
    ----------
    definitions : mapping of sympy.Symbol to Expr
        Expressions by symbol, in any order.
    """

    def __init__(self, definitions: Mapping[sp.Symbol, Expr]) -> None:
        self._definitions = definitions
        self._convert = Converter({}, definitions)
        self._converters: dict[object, Converter] = {}
        self._vectors: dict[tuple[str, tuple[sp.Symbol, ...]], tuple[ca.SX, list[ca.SX]]] = {}
        self._elements: dict[sp.Symbol, ca.SX] = {}
        self._bits: dict[sp.Symbol, int] = {}
        self._reach: dict[sp.Symbol, int] = {}

    def vector(self, group: Group) -> tuple[ca.SX, list[ca.SX]]:
        """Return the symbolic vector of a group and its elements, the same ones for all functions."""
        key = (group.name, group.symbols)
        if key not in self._vectors:
            whole = ca.SX.sym(group.name, max(len(group), 1))
            self._vectors[key] = whole, [whole[k] for k in range(len(group))]
            for symbol, element in zip(group.symbols, self._vectors[key][1], strict=True):
                self._elements.setdefault(symbol, element)
        return self._vectors[key]

    def reached(self, expressions: Iterable[Expr], bound: Mapping[sp.Symbol, Expr]) -> set[sp.Symbol]:
        """Return the definitions and the bound symbols that expressions use, directly or indirectly."""
        mask, used, stack = 0, set[sp.Symbol](), list(expressions)
        while stack:
            for symbol in symbols_of(stack.pop()):
                mask |= self._reach_of(symbol)
            new = {symbol for symbol in bound.keys() - used if mask & self._bit(symbol)}
            used |= new
            stack.extend(bound[symbol] for symbol in new)
        return used | {symbol for symbol in self._definitions if mask & self._bit(symbol)}

    def converter(
        self, symbols: Mapping[sp.Symbol, ca.SX], bound: Mapping[sp.Symbol, Expr], reached: Set[sp.Symbol]
    ) -> Converter:
        """Return a converter that knows the graphs of definitions that earlier functions share with this one."""
        key = (frozenset((symbol, id(element)) for symbol, element in symbols.items()), frozenset(bound.items()))
        if key not in self._converters:
            self._converters[key] = Converter(symbols, {**self._definitions, **bound})
        converter = self._converters[key]
        other = self._other(symbols, bound)
        self._convert.memo.update(self._elements)
        for symbol in reached:
            if symbol in self._definitions and not self._reach_of(symbol) & other:
                converter.memo[symbol] = self._convert(symbol)
        return converter

    def _other(self, symbols: Mapping[sp.Symbol, ca.SX], bound: Mapping[sp.Symbol, Expr]) -> int:
        """Return the symbols with a value of their own in a function, or without a value."""
        other = 0
        for symbol, bit in self._bits.items():
            defined, value = symbol in self._definitions, symbols.get(symbol)
            usual = value is None and symbol not in bound if defined else value is not None
            if not usual or (value is not None and value is not self._elements[symbol]):
                other |= bit
        return other

    def _bit(self, symbol: sp.Symbol) -> int:
        return self._bits.setdefault(symbol, 1 << len(self._bits))

    def _reach_of(self, root: sp.Symbol) -> int:
        """Return a symbol and all that it depends on."""
        stack, entered = [root], set[sp.Symbol]()
        while stack:
            symbol = stack[-1]
            if symbol in self._reach:
                stack.pop()
                continue
            below = symbols_of(self._definitions[symbol]) if symbol in self._definitions else frozenset[sp.Symbol]()
            waiting = [other for other in below if other not in self._reach and other not in entered]
            if waiting and symbol not in entered:
                entered.add(symbol)
                stack.extend(waiting)
                continue
            mask = self._bit(symbol)
            for other in below:
                mask |= self._reach.get(other, 0)
            self._reach[symbol] = mask
        return self._reach[root]
