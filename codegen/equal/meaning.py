# SPDX-License-Identifier: Apache-2.0
"""Expressions with named definitions, and their expansion."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from .pool import Pool, evaluated


class Meaning:
    """Definitions over a pool of expressions; names outside of it are free.

    Parameters
    ----------
    pool : Pool
        Pool of the expressions.
    targets : callable
        Returns expression and meaning of a name; None for a free name.
    """

    def __init__(self, pool: Pool, targets: Callable[[str], Expression | None]) -> None:
        self.pool = pool
        self.targets = targets

    def cone(self, root: int) -> list[int]:
        """Return all nodes that an expression depends on, definitions included."""
        return sorted({node for _, node in self.depends(root)})

    def free(self, root: int) -> list[str]:
        """Return the free names that an expression depends on."""
        nodes = self.pool.nodes
        names = ((meaning, nodes[node][1]) for meaning, node in self.depends(root) if nodes[node][0] == "sym")
        return sorted({name for meaning, name in names if meaning.targets(name) is None})

    def depends(self, root: int) -> Iterator[tuple[Meaning, int]]:
        """Yield all nodes that an expression depends on, with the meaning of its names."""
        seen: set[Expression] = set()
        stack: list[Expression] = [(self, root)]
        while stack:
            meaning, start = stack.pop()
            for node in self.pool.reached(start):
                if (meaning, node) in seen:
                    continue
                seen.add((meaning, node))
                yield meaning, node
                operation, *operands = self.pool.nodes[node]
                target = meaning.targets(operands[0]) if operation == "sym" else None
                if target is not None:
                    stack.append(target)


Expression = tuple[Meaning, int]
"""An expression with the meanings of its names."""


class Flat:
    """Expander of definitions, after which equal parts of two sides are one node of the pool."""

    def __init__(self, pool: Pool) -> None:
        self.pool = pool
        self._memo: dict[Expression, int] = {}

    def __call__(self, expression: Expression) -> int:
        """Expand an expression until only free names remain."""
        return evaluated(expression, self._needed, self._written, self._memo)

    def _needed(self, place: Expression) -> list[Expression]:
        meaning, node = place
        operation, *operands = self.pool.nodes[node]
        if operation != "sym":
            return [(meaning, operand) for operand in self.pool.operands(node)]
        target = meaning.targets(operands[0])
        return [] if target is None else [target]

    def _written(self, place: Expression) -> int:
        meaning, node = place
        if self.pool.nodes[node][0] == "sym":
            needed = self._needed(place)
            return self._memo[needed[0]] if needed else node
        return self.pool.with_operands(node, lambda operand: self._memo[meaning, operand])
