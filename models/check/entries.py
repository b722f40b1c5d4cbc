# SPDX-License-Identifier: Apache-2.0
"""Check of vectors: number of entries, finite values, allowed symbols."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping

import sympy as sp

from mehvar.base.errors import suggestion

from ..derivation import Definition
from ..quantities import TIME, ModelError
from ..system import System
from .names import role
from .vectors import Vector

_ENDLESS = (sp.nan, sp.zoo, sp.oo, -sp.oo, sp.I)


def check_entries(system: System, vectors: Iterable[Vector]) -> None:
    """Refuse vectors whose length differs from their group's, and entries that cannot be evaluated."""
    nodes = Nodes(system)
    for vector in vectors:
        _check_length(vector)
        received, known = set(vector.units), set[sp.Basic]()
        for k, entry in enumerate(vector.entries):
            if isinstance(entry, sp.MatrixExpr):
                raise ModelError(f"{vector.row(k)}: {entry!r} is a {type(entry).__name__}: must be a SymPy expression")
            _check_constants(nodes.of(entry), vector.row(k))
            _check_symbols(nodes.ends(entry, received, known), system, vector, vector.row(k))
            if vector.margin and next(nodes.ends(entry, received), None) is None:
                raise ModelError(f"{vector.row(k)}: {entry} does not depend on any symbol, so it holds always or never")
    for step in system.definitions_in_order:
        _check_constants(nodes.of(step.expr), f"{step.origin}: definition {step.symbol.name!r}")


class Nodes:
    """Symbols and functions in expressions; each shared part is visited once."""

    def __init__(self, system: System) -> None:
        self.definitions: Mapping[sp.Symbol, Definition] = {step.symbol: step for step in system.definitions_in_order}
        self._known: dict[sp.Basic, frozenset[sp.Basic]] = {}

    def of(self, root: sp.Basic) -> frozenset[sp.Basic]:
        """Return the symbols and other leaves of an expression."""
        if root not in self._known:
            self._known[root] = frozenset(node for node in graph(root) if not node.args)
        return self._known[root]

    def ends(
        self, entry: sp.Basic, received: set[sp.Symbol], known: set[sp.Basic] | None = None
    ) -> Iterator[tuple[sp.Symbol, Definition | None]]:
        """Yield the symbols that an entry depends on, each with the definition in which it occurs.

        Those in `known` are left out, and added to it: entries of a vector share most definitions.
        """
        stack: list[tuple[sp.Basic, Definition | None]] = [(node, None) for node in self.of(entry)]
        seen = set() if known is None else known
        while stack:
            node, within = stack.pop()
            if node in seen or not isinstance(node, sp.Symbol):
                continue
            seen.add(node)
            if node in received or node not in self.definitions:
                yield node, within
            else:
                step = self.definitions[node]
                stack.extend((part, step) for part in self.of(step.expr))


def graph(root: sp.Basic) -> Iterator[sp.Basic]:
    """Yield each distinct part of an expression once, itself included."""
    stack, seen = [root], {root}
    while stack:
        node = stack.pop()
        yield node
        new = [part for part in node.args if part not in seen]
        seen.update(new)
        stack.extend(dict.fromkeys(new))


def _check_length(vector: Vector) -> None:
    if vector.group and len(vector.entries) != len(vector.rows):
        names = ", ".join(q.name for q in vector.rows) or "none"
        raise ModelError(
            f"{vector.origin}: {vector.what} has {len(vector.entries)} entries for {len(vector.rows)} {vector.group} "
            f"({names}): give one for each, in this order"
        )


def _check_constants(nodes: Iterable[sp.Basic], where: str) -> None:
    for node in nodes:
        if node in _ENDLESS or (isinstance(node, sp.Float) and not math.isfinite(float(node))):
            raise ModelError(f"{where} has the constant {node}: numbers must be real and finite")


def _check_symbols(
    ends: Iterable[tuple[sp.Symbol, Definition | None]], system: System, vector: Vector, where: str
) -> None:
    for symbol, within in ends:
        if symbol not in vector.units:
            raise ModelError(f"{where}: {_stranger(symbol, within, system, vector)}")


def _stranger(symbol: sp.Symbol, within: Definition | None, system: System, vector: Vector) -> str:
    """Return a description of a symbol that a vector must not contain."""
    allowed = sorted(s.name for s in vector.units)
    through = f" (by definition {within.symbol.name!r} at {within.origin})" if within else ""
    if symbol.name in allowed:
        what = "has the right name but other assumptions: take the symbol from its group"
    elif symbol == TIME.symbol:
        what = "is time, which it does not receive"
    else:
        kind = role(system, symbol)
        what = f"is a {kind}, which it does not receive" if kind else "belongs to no group of the system"
    names = ", ".join(allowed) or "nothing"
    return f"{symbol.name!r}{through} {what}{suggestion(symbol.name, allowed)}; it is a function of {names}"
