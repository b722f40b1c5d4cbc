# SPDX-License-Identifier: Apache-2.0
"""Pool of expressions as shared nodes."""

from __future__ import annotations

import functools
from collections.abc import Callable, Container, Mapping, Sequence
from fractions import Fraction
from typing import Any, TypeVar

from ..equations.document import Node, reached

COMMUTATIVE = frozenset(("add", "mul", "min", "max", "and", "or", "equality", "unequality"))

Key = TypeVar("Key")
T = TypeVar("T")


@functools.cache
def fraction(text: str) -> Fraction:
    """Return the value of a number; cached, as few numbers recur often."""
    return Fraction(text)


class Pool:
    """Expressions of both sides as nodes; expressions that differ only in operand order share a node."""

    def __init__(self) -> None:
        self.nodes: list[Node] = []
        self._number: dict[Node, int] = {}
        self._operands: list[tuple[int, ...]] = []

    def intern(self, operation: str, *operands: Any) -> int:
        """Return the number of a node."""
        content = (operation, *(sorted(operands) if operation in COMMUTATIVE else operands))
        if content not in self._number:
            self._number[content] = len(self.nodes)
            self.nodes.append((operation, *operands))
            self._operands.append(tuple(o for o in operands if isinstance(o, int)))
        return self._number[content]

    def copy(
        self, nodes: Sequence[Sequence[Any]], names: Mapping[str, str] | None = None, before: Sequence[int] = ()
    ) -> list[int]:
        """Copy a graph into the pool and return its node numbers.

        Parameters
        ----------
        nodes : sequence
            The graph.
        names : mapping, optional
            Names that are replaced.
        before : sequence of int
            Node numbers that an earlier call returned for the first nodes.
        """
        numbers = list(before)
        for operation, *operands in nodes[len(numbers) :]:
            if operation == "sym":
                numbers.append(self.intern("sym", (names or {}).get(operands[0], operands[0])))
            else:
                numbers.append(self.intern(operation, *(numbers[o] if isinstance(o, int) else o for o in operands)))
        return numbers

    def with_operands(self, node: int, of: Callable[[int], int]) -> int:
        """Return a node with other operands, each a function of the present one."""
        operation, *operands = self.nodes[node]
        if not self.operands(node):
            return node
        return self.intern(operation, *(of(o) if isinstance(o, int) else o for o in operands))

    def operands(self, node: int) -> tuple[int, ...]:
        """Return the operands of a node."""
        return self._operands[node]

    def reached(self, *roots: int) -> list[int]:
        """Return the nodes of expressions, operands first."""
        return reached(self.nodes, roots)

    def cached(self, memo: dict[int, T], root: int, of: Callable[[int], T]) -> T:
        """Return a function of a node; missing values are added to the memo, those of operands first."""
        if root not in memo:
            for node in self._missing(root, memo):
                memo[node] = of(node)
        return memo[root]

    def _missing(self, root: int, memo: Container[int]) -> list[int]:
        """Return the nodes of an expression that a memo lacks, operands first; it has all operands of those it has."""
        missing, stack = set[int](), [root]
        while stack:
            node = stack.pop()
            if node not in memo and node not in missing:
                missing.add(node)
                stack += self.operands(node)
        return sorted(missing)

    def names(self, *roots: int) -> dict[str, int]:
        """Return the nodes of names in expressions, sorted by name."""
        return dict(sorted((self.nodes[k][1], k) for k in self.reached(*roots) if self.nodes[k][0] == "sym"))

    def number(self, value: Fraction | int) -> int:
        """Return the node of a number."""
        return self.intern("num", str(Fraction(value)))

    def constant(self, node: int) -> Fraction | None:
        """Return the value of a node that is a number."""
        operation, *rest = self.nodes[node]
        return fraction(rest[0]) if operation == "num" else None

    def many(self, operation: str, parts: Sequence[int]) -> int:
        """Return a sum or product, flattened and with one number, as in documents."""
        flat = [p for part in parts for p in (self.operands(part) if self.nodes[part][0] == operation else (part,))]
        neutral = Fraction(operation == "mul")
        total = neutral
        for value in map(self.constant, flat):
            if value is not None:
                total = total * value if operation == "mul" else total + value
        rest = [part for part in flat if self.constant(part) is None]
        if operation == "mul" and total == 0:
            return self.number(0)
        if total != neutral or not rest:
            rest.append(self.number(total))
        return rest[0] if len(rest) == 1 else self.intern(operation, *rest)

    def factors(self, node: int) -> tuple[int, ...]:
        """Return the factors of a product; of another node itself."""
        return self.operands(node) if self.nodes[node][0] == "mul" else (node,)

    def raised(self, node: int) -> tuple[int, Fraction]:
        """Return base and exponent of a power with constant exponent; exponent one for other nodes."""
        operation, *operands = self.nodes[node]
        exponent = self.constant(operands[1]) if operation == "pow" else None
        return (node, Fraction(1)) if exponent is None else (operands[0], exponent)

    def power(self, base: int, exponent: Fraction) -> int:
        """Return a power of a node."""
        if exponent == 1:
            return base
        return self.intern("pow", base, self.number(exponent)) if exponent else self.number(1)


def evaluated(root: Key, needs: Callable[[Key], Sequence[Key]], of: Callable[[Key], T], memo: dict[Key, T]) -> T:
    """Return a function of a key; values of needed keys are added to the memo first."""
    stack = [root]
    while stack:
        if missing := [key for key in needs(stack[-1]) if key not in memo]:
            stack += missing
        elif (key := stack.pop()) not in memo:
            memo[key] = of(key)
    return memo[root]


def ways(pool: Pool, node: int) -> int:
    """Return the number of branches of a node; 0 if it does not branch."""
    operation, *operands = pool.nodes[node]
    if operation in ("abs", "sign"):
        return 2
    return len(operands) if operation in ("max", "min", "piecewise") else 0


def live(pool: Pool, node: int, way: int | None) -> Sequence[int]:
    """Return the operands that affect a node's value in a given branch."""
    operation = pool.nodes[node][0]
    operands = pool.operands(node)
    if way is None or operation in ("abs", "sign"):
        return operands
    if operation in ("max", "min"):
        return operands[way : way + 1]
    return [*(pool.operands(pair)[1] for pair in operands[: way + 1]), pool.operands(operands[way])[0]]
