# SPDX-License-Identifier: Apache-2.0
"""Detection of multiplied or combined implicit equations 0 = ..."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ..equal import field
from ..equal.field import Element, Undefined
from ..equal.meaning import Meaning
from ..equal.pool import Pool
from ..equal.verdicts import Verdict
from .changes import Values, rational
from .versions import Item, Versions

_POINTS = 3
"""Number of field points, as in `codegen.equal.equality`."""
_PARTS = {"add": "sum", "exp": "factor", "cosh": "factor", "pow": "factor"}
"""Operations whose values are never zero, in words."""


def scale(versions: Versions, old: Item, new: Item) -> str:
    """Return the factor of a multiplied implicit equation in words; empty if it was not multiplied.

    A factor adds no zeros if it is a number times a power of a positive name, or an expression without zeros.
    """
    words = _scale(versions, old, new)
    sides = (versions.before, old.root), (versions.across, new.root)
    return words if words and versions.equality.where_defined(Verdict(True, words), *sides).equal else ""


def _scale(versions: Versions, old: Item, new: Item) -> str:
    """Return the factor in words: a number, a positive symbol to a power, or a part that is never zero."""
    count = versions.equality.field.count((versions.before, old.root), (versions.across, new.root))
    before = versions.equality.field.values(versions.before, old.root, count)
    after = versions.equality.field.values(versions.across, new.root, count)
    if None in (*before, *after) or 0 in before:
        return ""
    ratio = tuple(field.mul(b, field.inverse(a)) for a, b in zip(before, after, strict=True))
    number = rational(ratio)
    if number:
        return f"multiplied by {number}"
    for name in versions.before.free(old.root):
        if not versions.equality.positive(name):
            continue
        values: Values = versions.equality.field.values(versions.before, versions.pool.intern("sym", name), count)
        for exponent in (1, -1, 2, -2):
            power = tuple(field.power(v, exponent) for v in values)
            number = rational(tuple(field.mul(r, field.inverse(p)) for r, p in zip(ratio, power, strict=True)))
            if number:
                factor = name if exponent == 1 else f"{name}^{exponent}"
                return f"multiplied by {factor}" if number == 1 else f"multiplied by {number} {factor}"
    return _part(versions, old, new, ratio) or _factors(versions, old, new, ratio)


def _part(versions: Versions, old: Item, new: Item, ratio: Values) -> str:
    """Return the factor or divisor of an equation if intervals prove that it is never zero."""
    for meaning, root in ((versions.before, old.root), (versions.across, new.root)):
        for node in meaning.cone(root):
            operation = versions.pool.nodes[node][0]
            values = versions.equality.field.values(meaning, node, len(ratio)) if operation in _PARTS else (None,)
            if None in values or 0 in values or not versions.equality.is_never_zero((meaning, node)):
                continue
            if values == ratio:
                return f"multiplied by a {_PARTS[operation]} that is never zero"
            if tuple(map(field.inverse, values)) == ratio:
                return f"divided by a {_PARTS[operation]} that is never zero"
    return ""


def _factors(versions: Versions, old: Item, new: Item, ratio: Values) -> str:
    """Return a note if an equation was multiplied by several factors that are never zero, else an empty text."""
    for meaning, root in ((versions.across, new.root), (versions.before, old.root)):
        for factor in _common(versions.pool, root):
            values = versions.equality.field.values(meaning, factor, len(ratio))
            if None not in values and 0 not in values and versions.equality.is_never_zero((meaning, factor)):
                inverse = tuple(map(field.inverse, values)) if meaning is versions.across else values
                ratio = tuple(map(field.mul, ratio, inverse))
    return "multiplied by factors that are never zero" if rational(ratio) else ""


def _common(pool: Pool, root: int) -> Sequence[int]:
    """Return the factors of a product, or those common to all terms of a sum."""
    if pool.nodes[root][0] == "mul":
        return [factor for part in pool.operands(root) for factor in _common(pool, part)]
    if pool.nodes[root][0] != "add":
        return [root]
    first, *others = (_common(pool, term) for term in pool.operands(root))
    return [factor for factor in first if all(factor in other for other in others)] or [root]


def recombined(versions: Versions) -> bool:
    """Return True if the equations of motion of both sides have the same solution for the rates."""
    rates = sorted(versions.new.rates.values())
    olds = [item.root for item in versions.olds if item.row.kind == "motion"]
    news = [item.root for item in versions.news if item.row.kind == "motion"]
    if versions.old.rates != versions.new.rates or len(olds) != len(news) or len(news) != len(rates):
        return False
    try:
        return all(
            _solution(versions, versions.before, olds, rates, k) == _solution(versions, versions.after, news, rates, k)
            for k in range(_POINTS)
        )
    except Undefined:
        return False


def _solution(
    versions: Versions, meaning: Meaning, roots: Sequence[int], rates: Sequence[str], number: int
) -> list[Element]:
    """Solve the equations, which are affine in the rates, at one point."""
    zero: Mapping[str, Element] = dict.fromkeys(rates, 0)
    start = _residual(versions, meaning, roots, zero, number)
    columns = [
        [
            field.sub(v, s)
            for v, s in zip(_residual(versions, meaning, roots, {**zero, rate: 1}, number), start, strict=True)
        ]
        for rate in rates
    ]
    rows = [[*(column[k] for column in columns), field.sub(0, start[k])] for k in range(len(roots))]
    return _solved(rows)


def _residual(
    versions: Versions, meaning: Meaning, roots: Sequence[int], rates: Mapping[str, Element], number: int
) -> list[Element]:
    world = versions.equality.field.at(number, fixed=rates)[meaning]
    return [world.value(root) for root in roots]


def _solved(rows: list[list[Element]]) -> list[Element]:
    """Return the solution of a linear system; the last entry of each row is its right side."""
    size = len(rows)
    for k in range(size):
        pivot = next((i for i in range(k, size) if rows[i][k] != 0), None)
        if pivot is None:
            raise Undefined("singular")
        rows[k], rows[pivot] = rows[pivot], rows[k]
        factor = field.inverse(rows[k][k])
        rows[k] = [field.mul(factor, v) for v in rows[k]]
        for i in range(size):
            if i != k and rows[i][k] != 0:
                lead = rows[i][k]
                rows[i] = [field.sub(a, field.mul(lead, b)) for a, b in zip(rows[i], rows[k], strict=True)]
    return [row[-1] for row in rows]
