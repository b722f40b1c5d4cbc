# SPDX-License-Identifier: Apache-2.0
"""Common causes of several changes, such as a factor in an energy and in its derivatives.

One edited line of a derivation can change many equations. If a multiple of one quantity explains the first changed
equation, the same multiple is tested on all others, and those that it explains follow. Solutions of changed equations
of motion follow these equations, because generation checks both against each other.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import islice, product

from ...equal import field
from ...equal.field import Element, Undefined
from ...equal.pool import Pool
from ...equal.values import OF_PHASES
from ..changes import Change, Values, rational
from ..report import Kind
from ..versions import Item, Key, Versions
from .extension import naming
from .groups import any_axis

MOTION = "equations of motion"
_POINTS = 3
"""Number of field points, as in `codegen.equal.equality`."""
_MOST_SETS = 32
"""Largest number of factor sets that are tried for a sum: two for each of five terms. Half the number omits the fifth
term.
"""
_SCALABLE = ("parameter", "shown", "scenario", "law")
"""Roles, or their first words, of quantities that may be scaled; states and inputs are not among them."""


_QUARTERS = {("sin", "cos"): 1, ("cos", "sin"): -1}
"""Shift of the angle, in quarter turns, when one function replaces another."""


@dataclass(frozen=True)
class Cause:
    """A changed text and the changes that it explains.

    Attributes
    ----------
    source : Item
        The first changed text in the order of the derivation.
    says : str
        The explanation, such as "2 m/3 in place of m".
    followers : tuple of Item
        The other texts that the same change turns into the new ones.
    """

    source: Item
    says: str
    followers: tuple[Item, ...]


def causes(versions: Versions, changed: Sequence[Item]) -> list[Cause]:
    """Return common causes of changed texts, which are in derivation order."""
    left, result = list(changed), []
    while left:
        cause = _cause(versions, left[0], left[1:])
        left = [item for item in left[1:] if cause is None or item not in cause.followers]
        if cause is not None:
            result.append(cause)
    return result


def _cause(versions: Versions, source: Item, others: Sequence[Item]) -> Cause | None:
    """Return the scaled quantity or sum that explains most texts; the same quantity of equal parts counts as one."""
    best: Cause | None = None
    quantities = _quantities(versions, source)
    sums = ((source.name, members) for members in _of_terms(versions, source, quantities))
    for name, members in (*quantities.items(), *sums):
        scaled = _Scaled(versions, members)
        factor = scaled.factor(source)
        if factor is None:
            continue
        followers = tuple(item for item in others if scaled.explains(item, factor))
        if _beyond_its_axes(source, followers) and (best is None or len(followers) > len(best.followers)):
            best = Cause(source, f"{_multiple(factor, name)} in place of {name}", followers)
    return best


def turns(changed: Sequence[Item], edits: Callable[[Item], Sequence[Change]], pool: Pool) -> list[Cause]:
    """Return causes in which a sine became a cosine or the reverse, with the changes that follow.

    Derivatives of a changed term change accordingly: their sines and cosines shift by a quarter turn too.
    """
    result, left = [], {item.key: (item, _turn(pool, edits(item))) for item in changed}
    for item in changed:
        if item.key not in left or (turn := left.pop(item.key)[1]) is None:
            continue
        same = [(other, of) for other, of in left.values() if of is not None and of[:2] == turn[:2]]
        if any(of[2] != turn[2] for _, of in same):
            before, after = turn[2]
            angle = f"{{{turn[0]}}}"
            followers = tuple(other for other, _ in same)
            left = {key: row for key, row in left.items() if row[0] not in followers}
            result.append(Cause(item, f"{after}({angle}) in place of {before}({angle})", followers))
    return result


def _turn(pool: Pool, edits: Sequence[Change]) -> tuple[int, int, tuple[str, str]] | None:
    """Return angle, direction and original functions of edits that all shift one angle by a quarter turn."""
    seen = [_quarter(pool, edit) for edit in edits]
    if not seen or None in seen or len({row[:2] for row in seen if row}) > 1:
        return None
    return seen[0]


def _quarter(pool: Pool, edit: Change) -> tuple[int, int, tuple[str, str]] | None:
    """Return angle, quarter turns and functions of an edit that replaces a sine by a cosine or the reverse."""
    if edit.kind is not Kind.FUNCTION or edit.old is None or edit.new is None:
        return None
    (before, angle), (after, *parts) = pool.nodes[edit.old], pool.nodes[edit.new]
    negative = after == "mul"
    if negative:
        after, *parts = next((pool.nodes[part] for part in parts if pool.constant(part) is None), ("", 0))
    if parts != [angle] or (before, after) not in _QUARTERS:
        return None
    return angle, (-1 if negative else 1) * _QUARTERS[before, after], (before, after)


def _beyond_its_axes(source: Item, followers: Sequence[Item]) -> bool:
    """Return True if a cause explains more than the axes of one vector, which form a separate group."""
    return any(any_axis(item.name) != any_axis(source.name) for item in followers)


def _multiple(factor: Fraction, name: str) -> str:
    over = f"/{factor.denominator}" if factor.denominator > 1 else ""
    times = {1: "", -1: "-"}.get(factor.numerator, f"{factor.numerator} ")
    return f"{times}{name}{over}"


def _quantities(versions: Versions, item: Item) -> Mapping[str, frozenset[str]]:
    """Return the quantities in a text, grouped by their generic name for equal parts."""
    symbols = {symbol.name: symbol for document in (versions.new, versions.old) for symbol in document.symbols}
    generic = {name: f"{symbol.family}_i" if symbol.family else name for name, symbol in symbols.items()}
    free = {name for name in versions.free_old.free(versions.partner[item.key].root) if name in symbols}
    wanted = sorted({generic[name] for name in free if symbols[name].role.startswith(_SCALABLE)})
    return {name: frozenset(n for n in generic if generic[n] == name) for name in wanted}


def _of_terms(versions: Versions, item: Item, quantities: Mapping[str, frozenset[str]]) -> list[frozenset[str]]:
    """Return sets of one factor per term of a sum; scaling all factors of a set scales the sum."""
    pool, root = versions.pool, versions.partner[item.key].root
    parts = [root, *pool.operands(root)] if pool.nodes[root][0] == "mul" else [root]
    total = next((part for part in parts if pool.nodes[part][0] == "add"), None)
    if total is None:
        return []
    factors: list[list[str]] = []
    for term in pool.operands(total):
        symbols = [pool.nodes[part] for part in (term, *pool.operands(term)) if pool.nodes[part][0] == "sym"]
        factors.append([str(name) for _, name in symbols if any(name in members for members in quantities.values())])
    return [frozenset(names) for names in islice(product(*factors), _MOST_SETS)]


class _Scaled:
    """Old texts with scaled quantities."""

    def __init__(self, versions: Versions, names: frozenset[str]) -> None:
        self._versions = versions
        self._names = names

    @cached_property
    def _naming(self) -> frozenset[int]:
        return naming(self._versions.pool, self._names)

    def factor(self, item: Item) -> Fraction | None:
        """Return the factor, other than one, that turns the old text into the new one; None without one."""
        try:
            none, once, new = self._old(item, Fraction(0)), self._old(item, Fraction(1)), self._new(item)
            ratio = tuple(
                field.mul(field.sub(c, a), field.inverse(field.sub(b, a)))
                for a, b, c in zip(none, once, new, strict=True)
            )
        except Undefined:
            return None
        factor = rational(ratio)
        return factor if factor not in (None, 0, 1) and self.explains(item, factor) else None

    def explains(self, item: Item, factor: Fraction) -> bool:
        """Return True if some factor turns the old text into the new one."""
        if not self._is_followed(item):
            return False
        try:
            return self._old(item, factor) == self._new(item)
        except Undefined:
            return False

    def _is_followed(self, item: Item) -> bool:
        """Return True if the text contains the quantities outside of angles and exponents."""
        pool, stack = self._versions.pool, [self._versions.partner[item.key].root, item.root]
        seen = set(stack) & self._naming
        stack = list(seen)
        while stack:
            node = stack.pop()
            if pool.nodes[node][0] in OF_PHASES:
                return False
            below = {operand for operand in pool.operands(node) if operand in self._naming} - seen
            seen |= below
            stack += below
        return bool(seen)

    def _old(self, item: Item, factor: Fraction) -> Values:
        versions, values = self._versions, []
        for number in range(_POINTS):
            world = versions.equality.field.at(number, fixed=self._multiples(number, factor))[versions.free_old]
            values.append(world.value(versions.partner[item.key].root))
        return tuple(values)

    def _new(self, item: Item) -> Values:
        versions = self._versions
        return tuple(versions.equality.field[k][versions.free_new].value(item.root) for k in range(_POINTS))

    def _multiples(self, number: int, factor: Fraction) -> dict[str, Element]:
        versions, times = self._versions, field.number(factor)
        world = versions.equality.field[number][versions.free_old]
        return {name: field.mul(times, world.value(versions.pool.intern("sym", name))) for name in self._names}


def solving(versions: Versions, changed: Sequence[Item]) -> list[Item]:
    """Return the changed texts that merely solve changed equations of motion."""
    if not any(item.row.kind == "motion" for item in changed):
        return []
    others = [item for item in versions.news if item.row.kind not in ("rhs", "definition")]
    elsewhere = _reached(versions, others)
    rates = _reached(versions, [item for item in versions.news if item.row.kind == "rhs"])
    return [item for item in changed if item.key in rates and item.key not in elsewhere]


def _reached(versions: Versions, items: Sequence[Item]) -> set[Key]:
    """Return the keys of rows and of all their definitions."""
    stack, keys = list(items), {item.key for item in items}
    while stack:
        below = [child for child in versions.children(stack.pop()) if child.key not in keys]
        keys |= {child.key for child in below}
        stack += below
    return keys
