# SPDX-License-Identifier: Apache-2.0
"""Proofs that signs exclude each other because the expressions are linearly dependent.

Each nonlinear term is an unknown. Unknowns are eliminated exactly, one by one.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from fractions import Fraction

from ..pool import Pool
from .intervals import CONSTANTS, QUARTERS, RANGES, Bounds

Form = dict[int, Fraction]
"""Coefficients of nodes, with the constant under `_ONE`."""
Row = tuple[Form, bool]
"""A linear form that is positive (flag True) or at least not negative (flag False)."""
Whole = tuple[dict[int, int], bool]
"""A row with integer coefficients, whose sums are much faster than those of fractions."""
_ONE = -1
_MOST = 300
"""Largest number of inequalities; an elimination may square their number. Fewer prove less; more cost time without a
proof.
"""


def impossible(pool: Pool, atoms: Sequence[tuple[int, int]], bounds: Bounds) -> bool:
    """Return True if nodes provably cannot have these signs together."""
    rows: list[Row] = []
    for node, sign in atoms:
        form = _form(pool, node)
        rows += [(_scaled(form, Fraction(s)), bool(sign)) for s in ((sign,) if sign else (1, -1))]
    told: set[int] = {_ONE}
    while unknown := sorted({node for form, _ in rows for node in form} - told):
        told |= {*unknown}
        rows += [row for node in unknown for row in _facts(pool, node, bounds)]
    return _is_contradiction([_at_whole_number(pool, *row) for row in rows])


def _at_whole_number(pool: Pool, form: Form, strict: bool) -> Row:
    """Return a bound on a whole number alone as the nearest whole number, another row as it is."""
    unknowns = form.keys() - {_ONE}
    node = min(unknowns, default=_ONE)
    if len(unknowns) != 1 or pool.nodes[node][0] not in ("floor", "ceiling"):
        return form, strict
    factor = form[node]
    bound = -form.get(_ONE, Fraction(0)) / abs(factor)
    least = math.floor(bound) + 1 if strict else math.ceil(bound)
    return {node: Fraction(1 if factor > 0 else -1), _ONE: Fraction(-least)}, False


def _is_contradiction(fractions: Sequence[Row]) -> bool:
    """Return True if inequalities provably have no solution; False also if there are too many of them."""
    rows = [(_whole(form), strict) for form, strict in fractions]
    while len(rows := _tightest(rows)) <= _MOST:
        if any(_is_false(row) for row in rows):
            return True
        unknowns = {node for form, _ in rows for node in form if node != _ONE}
        if not unknowns:
            return False
        rows = _without(rows, min(unknowns, key=lambda node: (_count(rows, node), node)))
    return False


def _whole(form: Form) -> dict[int, int]:
    common = math.lcm(*(value.denominator for value in form.values()))
    return {node: value.numerator * (common // value.denominator) for node, value in form.items()}


def _tightest(rows: Sequence[Whole]) -> list[Whole]:
    """Return the tightest of the rows that are multiples of each other."""
    best: dict[frozenset[tuple[int, int]], tuple[Fraction, bool]] = {}
    for form, strict in rows:
        common = math.gcd(*(value for node, value in form.items() if node != _ONE)) or 1
        key = frozenset((node, value // common) for node, value in form.items() if node != _ONE)
        bound = Fraction(form.get(_ONE, 0), common), not strict
        if key not in best or bound < best[key]:
            best[key] = bound
    return [
        (
            {node: factor * value.denominator for node, factor in key} | ({_ONE: value.numerator} if value else {}),
            not weak,
        )
        for key, (value, weak) in best.items()
    ]


def _facts(pool: Pool, node: int, bounds: Bounds) -> list[Row]:
    """Return the known inequalities of a term: bounds, or relations to its operands."""
    operation, *rest = pool.nodes[node]
    itself = {node: Fraction(1)}
    if operation == "sym":
        low, high = bounds.get(rest[0], (None, None))
        below = [] if low is None else [_sum([itself, {_ONE: -low}])]
        above = [] if high is None else [_sum([{_ONE: high}, _scaled(itself, Fraction(-1))])]
        return [(form, False) for form in below + above]
    limits = CONSTANTS.get(rest[0]) if operation == "const" else RANGES.get(operation)
    if limits is not None:
        turn = {pool.intern("const", "pi"): Fraction(1, 2)}
        exact = [
            (_scaled(turn, Fraction(end)), s) for end, s in zip(QUARTERS.get(operation, ()), (1, -1), strict=False)
        ]
        sides = [({_ONE: Fraction(end)}, s) for end, s in zip(limits, (1, -1), strict=True) if math.isfinite(end)]
        return [(_scaled(_sum([itself, _scaled(end, Fraction(-1))]), Fraction(s)), False) for end, s in exact + sides]
    forms = [_form(pool, operand) for operand in pool.operands(node)]
    if operation in ("floor", "ceiling"):
        sign = Fraction(1 if operation == "floor" else -1)
        gap = _sum([_scaled(forms[0], sign), _scaled(itself, -sign)])
        return [(gap, False), (_sum([{_ONE: Fraction(1)}, _scaled(gap, Fraction(-1))]), True)]
    if operation == "mod" and forms[1].keys() == {_ONE} and forms[1][_ONE] > 0:
        return [(itself, False), (_sum([forms[1], _scaled(itself, Fraction(-1))]), True)]
    if operation in ("max", "min"):
        sign = Fraction(1 if operation == "max" else -1)
        return [(_sum([_scaled(itself, sign), _scaled(form, -sign)]), False) for form in forms]
    if operation == "abs":
        return [(_sum([itself, _scaled(forms[0], Fraction(sign))]), False) for sign in (1, -1)]
    return []


def _form(pool: Pool, node: int) -> Form:
    """Return a node as a linear form of terms."""
    operands = pool.operands(node)
    value = pool.constant(node)
    if value is not None:
        return {_ONE: value}
    if pool.nodes[node][0] == "add":
        return _sum([_form(pool, operand) for operand in operands])
    if pool.nodes[node][0] == "mul":
        numbers = [c for c in map(pool.constant, operands) if c is not None]
        rest = [o for o in operands if pool.constant(o) is None]
        if numbers and rest:
            return _scaled(_form(pool, pool.many("mul", rest)), math.prod(numbers, start=Fraction(1)))
    return {node: Fraction(1)}


def _sum(forms: Sequence[Form]) -> Form:
    total: Form = {}
    for form in forms:
        for node, factor in form.items():
            total[node] = total.get(node, Fraction(0)) + factor
    return {node: factor for node, factor in total.items() if factor}


def _scaled(form: Mapping[int, Fraction], factor: Fraction) -> Form:
    return {node: value * factor for node, value in form.items()}


def _is_false(row: Whole) -> bool:
    form, strict = row
    value = form.get(_ONE, 0)
    return not form.keys() - {_ONE} and (value <= 0 if strict else value < 0)


def _count(rows: Sequence[Whole], node: int) -> int:
    signs = [form[node] > 0 for form, _ in rows if node in form]
    return sum(signs) * (len(signs) - sum(signs))


def _without(rows: Sequence[Whole], node: int) -> list[Whole]:
    """Eliminate an unknown: each of its lower bounds is below each of its upper bounds."""
    kept = [row for row in rows if node not in row[0]]
    lower = [row for row in rows if row[0].get(node, 0) > 0]
    upper = [row for row in rows if row[0].get(node, 0) < 0]
    for first, strict in lower:
        for second, other in upper:
            up, down = first[node], -second[node]
            sums = {k: down * first.get(k, 0) + up * second.get(k, 0) for k in first.keys() | second.keys()}
            kept.append(({k: value for k, value in sums.items() if value}, strict or other))
    return kept
