# SPDX-License-Identifier: Apache-2.0
"""Edits of expressions as replacements."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

from ..equal import field
from ..equal.field import Element
from ..equal.pool import Pool
from . import costs
from .report import Kind, Path

Values = tuple[Element, ...]
_SMALL = 10_000
"""Square root of the limit on numerators and denominators of numbers in equations. About 10^16 such fractions exist. A
random value of the field is one of 2^154, so it equals such a fraction with probability 10^-30."""


@dataclass(frozen=True)
class Change:
    """An edit: a replacement in the old expression.

    Attributes
    ----------
    kind : Kind
        Kind of the edit.
    path : Path
        The part of the old expression that is replaced; for an added term, the sum that it joins.
    old, new : int or None
        Nodes that are shown; `new` is added to the sum if the kind is `TERM_ADDED`.
    with_ : int or None
        Replacement of the part; None if it is removed.
    says : str
        The edit in words.
    cost : float
        Cost of the edit: larger for less plausible ones.
    """

    kind: Kind
    path: Path
    old: int | None
    new: int | None
    with_: int | None
    says: str
    cost: float


def mutations(pool: Pool, root: int, path: Path, atoms: Sequence[int]) -> Iterator[Change]:
    """Yield every small edit of an expression; `atoms` may replace a symbol or a sine."""
    stack = [(root, path, False)]
    while stack:
        node, place, term = stack.pop()
        operation, *operands = pool.nodes[node]
        for k, operand in enumerate(operands):
            if isinstance(operand, int):
                stack.append((operand, (*place, k), operation not in ("mul", "pow")))
        if node != root:
            yield from _mutated(pool, node, place, term, atoms)


def _mutated(pool: Pool, node: int, path: Path, term: bool, atoms: Sequence[int]) -> Iterator[Change]:
    """Yield the small edits of one node: another number, sign, factor, symbol or function, or a lost term."""
    operation = pool.nodes[node][0]
    if operation in ("exprcondpair", "const"):
        return
    if operation == "num":
        value = Fraction(pool.nodes[node][1])
        for number in dict.fromkeys((-value, 2 * value, value / 2, value + 1, value - 1)):
            if number:
                new = pool.number(number)
                yield Change(Kind.COEFFICIENT, path, node, new, new, f"{value} became {number}", costs.INNER_NUMBER)
    if term and operation != "num":
        yield Change(Kind.TERM_REMOVED, path, node, None, None, "term lost", costs.INNER_TERM)
        for number in (Fraction(-1), Fraction(2), Fraction(1, 2)):
            yield multiplied(pool, node, path, number, costs.INNER_TERM)
    if operation in ("sym", "sin", "cos", "tan"):
        for atom in atoms:
            if atom != node and (operation == "sym" or pool.nodes[atom][0] != "sym"):
                kind = Kind.SYMBOL if operation == "sym" else Kind.FUNCTION
                yield Change(kind, path, node, atom, atom, f"{{{node}}} became {{{atom}}}", costs.INNER_NAME)


def multiplied(pool: Pool, node: int, path: Path, number: Fraction, cost: float) -> Change:
    """Return the edit of a term that multiplies its coefficient; for -1 a flipped sign."""
    new, coefficient = pool.many("mul", [node, pool.number(number)]), _coefficient(pool, node)
    if number == -1:
        says = "sign flipped: + became -" if coefficient > 0 else "sign flipped: - became +"
        return Change(Kind.SIGN, path, node, new, new, says, cost)
    says = f"coefficient {coefficient} became {coefficient * number}"
    return Change(Kind.COEFFICIENT, path, node, new, new, says, cost)


def _coefficient(pool: Pool, node: int) -> Fraction:
    """Return the numeric factor of a product."""
    return next((c for c in map(pool.constant, pool.factors(node)) if c is not None), Fraction(1))


def replaced(pool: Pool, root: int, changes: Sequence[Change]) -> int:
    """Return an expression after edits."""
    here = [change for change in changes if not change.path]
    added = [change.with_ for change in here if change.kind is Kind.TERM_ADDED and change.with_ is not None]
    for change in here:
        if change.kind is not Kind.TERM_ADDED:
            instead = [] if change.with_ is None else [change.with_]
            return pool.many("add", [*instead, *added])
    operation, *operands = pool.nodes[root]
    new = list(operands)
    for k, operand in enumerate(operands):
        below = [replace(c, path=c.path[1:]) for c in changes if c.path and c.path[0] == k]
        if below and isinstance(operand, int):
            new[k] = replaced(pool, operand, below)
    node = root
    if new != operands:
        node = pool.many(operation, new) if operation in ("add", "mul") else pool.intern(operation, *new)
    return pool.many("add", [node, *added]) if added else node


def rational(values: Values) -> Fraction | None:
    """Return the common small fraction that all field values represent; None without one."""
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
