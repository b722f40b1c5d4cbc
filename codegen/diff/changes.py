# SPDX-License-Identifier: Apache-2.0
"""Edits as replacements in an expression, and making them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

from codegen.diff import field
from codegen.diff.field import Element
from codegen.diff.pool import Pool
from codegen.diff.report import Kind, Path

Values = tuple[Element, ...]
_SMALL = 10_000


@dataclass(frozen=True)
class Change:
    """An edit as a replacement in the old expression.

    Attributes
    ----------
    kind : Kind
        What it does.
    path : Path
        The part of the old expression that is replaced; for an added term, the sum that it joins.
    old, new : int or None
        Nodes that are shown; `new` is added to the sum if the kind is `TERM_ADDED`.
    with_ : int or None
        What replaces the part; None if it is removed.
    says : str
        The edit in words.
    cost : float
        How far-fetched it is.
    """

    kind: Kind
    path: Path
    old: int | None
    new: int | None
    with_: int | None
    says: str
    cost: float


def replaced(pool: Pool, root: int, changes: Sequence[Change]) -> int:
    """Return an expression with edits made in it."""
    here = [change for change in changes if not change.path]
    for change in here:
        if change.kind is not Kind.TERM_ADDED:
            return pool.number(0) if change.with_ is None else change.with_
    operation, *operands = pool.nodes[root]
    new = list(operands)
    for k, operand in enumerate(operands):
        below = [replace(c, path=c.path[1:]) for c in changes if c.path and c.path[0] == k]
        if below and isinstance(operand, int):
            new[k] = replaced(pool, operand, below)
    node = root
    if new != operands:
        node = pool.many(operation, new) if operation in ("add", "mul") else pool.intern(operation, *new)
    terms = [change.with_ for change in here if change.with_ is not None]
    return pool.many("add", [node, *terms]) if terms else node


def rational(values: Values) -> Fraction | None:
    """Return the small fraction that all values are, if they are one."""
    first = values[0]
    if isinstance(first, field.Complex) or any(value != first for value in values):
        return None
    # Continued fractions: the first convergent with a small numerator.
    r0, r1, t0, t1 = field.P, first, 0, 1
    while r1 > _SMALL * _SMALL:
        q = r0 // r1
        r0, r1, t0, t1 = r1, r0 - q * r1, t1, t0 - q * t1
    if t1 == 0 or abs(t1) > _SMALL * _SMALL:
        return None
    return Fraction(r1, t1)
