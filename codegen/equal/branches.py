# SPDX-License-Identifier: Apache-2.0
"""Branches of expressions: the branches of a node, their conditions, and the smooth form in each.

A *way* is one branch of a node: the sign under an absolute value, the operand that is the maximum, the selected case,
or the truth of a comparison. If all ways are fixed, an expression is smooth.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from .pool import Pool, evaluated, live, ways

COMPARISONS = frozenset(("strictlessthan", "lessthan", "strictgreaterthan", "greaterthan", "equality", "unequality"))
STEPS = frozenset(("floor", "ceiling", "mod"))
"""Operations with infinitely many branches, one per integer."""
BRANCHING = COMPARISONS | STEPS | {"abs", "sign", "max", "min", "piecewise"}
Atom = tuple[int, int]
"""A node and its sign: 1, -1 or 0."""
Way = tuple[int, int]
"""A branching node and its branch."""
_MOST = 32
"""Largest number of alternatives for one condition: five within five others."""


def branching(pool: Pool, roots: Iterable[int]) -> list[int]:
    """Return the nodes of expressions that branch."""
    return [node for node in pool.reached(*roots) if pool.nodes[node][0] in BRANCHING]


def ways_of(pool: Pool, node: int) -> list[Way]:
    """Return all branches of a node, or none if it has infinitely many."""
    count = 2 if pool.nodes[node][0] in COMPARISONS else ways(pool, node)
    return [(node, way) for way in range(count)]


def replaced_nodes(pool: Pool, root: int, by: Mapping[int, int]) -> int:
    """Return an expression with some nodes replaced by others."""
    numbers = dict(by)
    for node in pool.reached(root):
        if node not in numbers:
            numbers[node] = pool.with_operands(node, numbers.__getitem__)
    return numbers[root]


def smooth(pool: Pool, root: int, taken: Mapping[int, Any]) -> int:
    """Return the smooth form of an expression for given branches."""
    numbers: dict[int, int] = {}
    return evaluated(
        root, lambda node: _taken(pool, node, taken), lambda node: _fixed(pool, node, taken, numbers), numbers
    )


def counted(pool: Pool, root: int, taken: Mapping[int, Any]) -> set[int]:
    """Return the branching nodes that affect a value, for given branches of some nodes."""
    seen: set[int] = set()
    stack = [root]
    while stack:
        node = stack.pop()
        if node not in seen:
            seen.add(node)
            way = taken.get(node) if pool.nodes[node][0] not in STEPS | COMPARISONS else None
            stack += _open(pool, node, taken) if way is None else live(pool, node, way)
    return {node for node in seen if pool.nodes[node][0] in BRANCHING}


def _open(pool: Pool, node: int, taken: Mapping[int, Any]) -> Sequence[int]:
    """Return the operands that may affect a value; for a case distinction, those of possible cases."""
    operands = pool.operands(node)
    if pool.nodes[node][0] != "piecewise":
        return operands
    left: list[int] = []
    for value, condition in map(pool.operands, operands):
        known = _known(pool, condition, taken)
        left += [condition, *(() if known is False else (value,))]
        if known:
            break
    return left


def _known(pool: Pool, node: int, taken: Mapping[int, Any]) -> bool | None:
    """Return the truth of a condition for given branches; None if other comparisons decide it."""
    operation, *operands = pool.nodes[node]
    if operation == "const":
        return bool(operands[0] == "True")
    if operation in COMPARISONS:
        return bool(taken[node]) if node in taken else None
    parts = [_known(pool, operand, taken) for operand in pool.operands(node)]
    if operation == "not":
        return None if parts[0] is None else not parts[0]
    if operation not in ("and", "or"):
        return None
    deciding = operation == "or"
    return deciding if deciding in parts else None if None in parts else not deciding


def _taken(pool: Pool, node: int, taken: Mapping[int, Any]) -> Sequence[int]:
    """Return the operands of an expression that remain for given branches."""
    operation = pool.nodes[node][0]
    way = taken.get(node)
    if operation == "piecewise" and way is not None:
        return pool.operands(pool.operands(node)[way])[:1]
    return live(pool, node, way) if operation not in STEPS | COMPARISONS else pool.operands(node)


def _fixed(pool: Pool, node: int, taken: Mapping[int, Any], numbers: Mapping[int, int]) -> int:
    """Return a node in its smooth form for the given branch; `numbers` are the nodes of its operands."""
    operation, *operands = pool.nodes[node]
    way = taken.get(node)
    if way is None:
        return pool.with_operands(node, numbers.__getitem__)
    if operation == "abs":
        return numbers[operands[0]] if way else pool.many("mul", [numbers[operands[0]], pool.number(-1)])
    if operation == "sign":
        return pool.number(1 if way else -1)
    if operation in ("max", "min"):
        return numbers[operands[way]]
    if operation == "piecewise":
        return numbers[pool.operands(operands[way])[0]]
    if operation == "mod":
        return pool.many("add", [numbers[operands[0]], pool.many("mul", [numbers[operands[1]], pool.number(-way)])])
    return pool.number(way)


def difference(pool: Pool, a: int, b: int) -> int:
    """Return the node a - b or, for two exponentials, the difference of exponents, which has the same sign."""
    if pool.nodes[a][0] == pool.nodes[b][0] == "exp":
        a, b = pool.operands(a)[0], pool.operands(b)[0]
    return pool.many("add", [a, pool.many("mul", [b, pool.number(-1)])])


def atoms(pool: Pool, node: int) -> list[int]:
    """Return the nodes at whose zeros a node changes its branch."""
    operation = pool.nodes[node][0]
    operands = pool.operands(node)
    if operation in ("abs", "sign"):
        return [operands[0]]
    if operation in ("max", "min"):
        return [difference(pool, a, b) for a, b in itertools.combinations(operands, 2)]
    return [difference(pool, *operands)] if operation in COMPARISONS else []


def requirements(pool: Pool, way: Way) -> list[tuple[Atom, ...]] | None:
    """Return the alternative sets of conditions for a node's branch; None if there are too many."""
    node, number = way
    operation = pool.nodes[node][0]
    operands = pool.operands(node)
    if operation in ("abs", "sign"):
        return [((operands[0], 1 if number else -1),)]
    if operation in ("max", "min"):
        sign = 1 if operation == "max" else -1
        others = (o for k, o in enumerate(operands) if k != number)
        return [tuple((difference(pool, operands[number], other), sign) for other in others)]
    if operation == "piecewise":
        conditions = [pool.operands(pair)[1] for pair in operands[: number + 1]]
        return every([_truth(pool, c, k == number) for k, c in enumerate(conditions)])
    return _truth(pool, node, bool(number))


def _truth(pool: Pool, node: int, wanted: bool) -> list[tuple[Atom, ...]] | None:
    """Return the alternatives that make a condition true or false."""
    operation, *operands = pool.nodes[node]
    if operation == "const":
        return [()] if (operands[0] == "True") is wanted else []
    if operation == "not":
        return _truth(pool, operands[0], not wanted)
    if operation in ("and", "or"):
        parts = [_truth(pool, operand, wanted) for operand in operands]
        return every(parts) if (operation == "and") is wanted else either(parts)
    if operation not in COMPARISONS:
        return None
    node = difference(pool, *operands)
    if operation in ("equality", "unequality"):
        return [((node, 0),)] if (operation == "equality") is wanted else [((node, 1),), ((node, -1),)]
    return [((node, 1 if operation.startswith(("strictgreater", "greater")) is wanted else -1),)]


def every(parts: Sequence[list[tuple[Atom, ...]] | None]) -> list[tuple[Atom, ...]] | None:
    """Return the combinations of one entry from each list; None if there are too many."""
    product: list[tuple[Atom, ...]] = [()]
    for part in parts:
        if part is None or len(product) * len(part) > _MOST:
            return None
        product = [(*first, *second) for first in product for second in part]
    return product


def either(parts: Sequence[list[tuple[Atom, ...]] | None]) -> list[tuple[Atom, ...]] | None:
    """Return the union of the lists of alternatives; None if a list is unknown."""
    if any(part is None for part in parts):
        return None
    return [alternative for part in parts for alternative in part or ()]
