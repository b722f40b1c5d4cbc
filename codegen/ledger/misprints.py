# SPDX-License-Identifier: Apache-2.0
"""Misprints in a formula, term by term, by comparison with its corrected form.

Both forms are written by hand in the same layout, so a parallel walk down both trees finds each change. Of several
possible lists of changes, the shortest is returned. `mehvar.codegen.ledger.relations` tests the corrected form
against the derivation.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import product
from typing import Any, TypeAlias

import numpy as np
import sympy as sp

from mehvar.models.mechanics import reduce_sines
from mehvar.models.paper import Side

Write = Callable[[Any], str]
Part: TypeAlias = str | Any
"""Words or a formula."""
_SIGNS = (sp.Symbol("-"), sp.Symbol("+"))
"""Formulas of plus and minus signs, for typesetting."""
_WHOLE = 1
"""Cost of an additional change, in symbols. With 0, "lost" and "added" cost as much as "should read"; with 2,
dissimilar terms are paired.
"""


@dataclass(frozen=True)
class Edit:
    """A change of a printed formula: words and formulas in turn, and the number of changed symbols."""

    parts: tuple[Part, ...]
    size: int

    def spelled(self, write: Write) -> str:
        """Return the change as text, in which a given function prints formulas."""
        return "".join(part if isinstance(part, str) else write(part) for part in self.parts)


def edits(printed: Side, corrected: Side) -> tuple[Edit, ...]:
    """Return the changes from a printed side to the corrected one.

    Parameters
    ----------
    printed, corrected : Expr or Matrix
        Both forms.
    """
    return tuple(_edits(sp.sympify(printed), sp.sympify(corrected)))


def _edits(printed: Any, corrected: Any) -> Iterator[Edit]:
    """Yield the edits that turn a printed expression into the corrected one, as far inside as possible."""
    if printed == corrected:
        return
    if isinstance(printed, sp.MatrixBase) and isinstance(corrected, sp.MatrixBase):
        yield from _entries(printed, corrected)
    elif printed.is_number and corrected.is_number:
        yield Edit((printed, " should read ", corrected), 1)
    elif _power(printed)[0] == _power(corrected)[0]:
        (base, old), (_, new) = _power(printed), _power(corrected)
        yield Edit(("exponent of ", base, ": printed ", old, ", correct ", new), 1)
    elif isinstance(corrected, sp.Expr) and printed == -corrected:
        yield _sign(printed)
    elif isinstance(printed, sp.Add | sp.MatAdd) or isinstance(corrected, sp.Add | sp.MatAdd):
        yield from _terms(printed, corrected)
    elif isinstance(printed, sp.Mul) or isinstance(corrected, sp.Mul):
        yield from _factors(printed, corrected)
    elif isinstance(printed, sp.MatrixSymbol) or isinstance(corrected, sp.MatrixSymbol):
        yield _replaced(printed, corrected)
    elif printed.func == corrected.func and len(printed.args) == len(corrected.args) and printed.args:
        for old, new in zip(printed.args, corrected.args, strict=True):
            yield from _edits(old, new)
    else:
        yield _replaced(printed, corrected)


def _power(side: Any) -> tuple[Any, Any]:
    return side.as_base_exp() if isinstance(side, sp.Expr) else (side, sp.S.One)  # a condition is no number


def _size(side: Any) -> int:
    return sum(1 for _ in sp.preorder_traversal(side))


def _cost(changes: Sequence[Edit]) -> int:
    return sum(edit.size + _WHOLE for edit in changes)


def _replaced(printed: Any, corrected: Any) -> Edit:
    return Edit((printed, " should read ", corrected), _size(printed) + _size(corrected))


def _sign(printed: Any) -> Edit:
    """Return the sign change of an operand, with its sign."""
    negative = bool(printed.as_coeff_mmul()[0] < 0 if isinstance(printed, sp.MatMul) else _is_negative(printed))
    size = -printed if negative else printed
    return Edit(("sign of ", size, ": printed ", _SIGNS[not negative], ", correct ", _SIGNS[negative]), 1)


def _is_negative(printed: Any) -> bool:
    return isinstance(printed, sp.Expr) and bool(printed.could_extract_minus_sign())


def _entries(printed: sp.MatrixBase, corrected: sp.MatrixBase) -> Iterator[Edit]:
    if printed.shape != corrected.shape:
        yield _replaced(printed, corrected)
        return
    for old, new in zip(printed, corrected, strict=True):
        yield from _edits(old, new)


def _terms(printed: Any, corrected: Any) -> Iterator[Edit]:
    """Yield the changes between sums as written or, if shorter, between expanded sums."""
    extra, missing = _unmatched(_summands(printed), _summands(corrected))
    standing = _paired(extra, missing, "term", _one_term)
    written = _written_out(extra, missing)
    yield from written if written and _cost(written) < _cost(standing) else standing


def _written_out(extra: Sequence[Any], missing: Sequence[Any]) -> list[Edit]:
    """Expand two sums and return their changed terms.

    Only terms that differ in their numbers are paired. The list is empty for matrices and for sums in a denominator.
    """
    if any(isinstance(term, sp.MatrixExpr) or _divides_by_a_sum(term) for term in (*extra, *missing)):
        return []
    old, new = (reduce_sines(sp.Add(*terms)).as_coefficients_dict() for terms in (extra, missing))
    return _paired(
        *_unmatched(*([number * term for term, number in side.items()] for side in (old, new))), "term", _same_product
    )


@lru_cache(maxsize=4096)  # as of `_between`
def _divides_by_a_sum(term: Any) -> bool:
    return bool(sp.denom(sp.together(term)).has(sp.Add))


def _factors(printed: Any, corrected: Any) -> Iterator[Edit]:
    """Yield the changes between products: first the number, then factors."""
    (number, old), (right_number, new) = printed.as_coeff_Mul(), corrected.as_coeff_Mul()
    if number == -right_number:
        sign = _SIGNS[bool(number > 0)], _SIGNS[bool(number < 0)]
        yield Edit(("sign of ", abs(number) * old, ": printed ", sign[0], ", correct ", sign[1]), 1)
    elif number != right_number:
        yield Edit(("number before ", old, ": printed ", number, ", correct ", right_number), 1)
    yield from _paired(*_unmatched(_operands(old), _operands(new)), "factor", _related)


def _summands(side: Any) -> Sequence[Any]:
    return side.args if isinstance(side, sp.Add | sp.MatAdd) else (side,) if side != 0 else ()


def _operands(side: Any) -> Sequence[Any]:
    return [factor for factor in sp.Mul.make_args(side) if factor != 1]


def _unmatched(old: Sequence[Any], new: Sequence[Any]) -> tuple[list[Any], list[Any]]:
    """Return the operands of each side that the other lacks."""
    before, after = Counter(old), Counter(new)
    return list((before - after).elements()), list((after - before).elements())


def _paired(extra: Sequence[Any], missing: Sequence[Any], kind: str, alike: Callable[[Any, Any], bool]) -> list[Edit]:
    """Return the shortest list of changed, added and omitted operands.

    Operands are paired only if they are alike.
    """
    from scipy.optimize import (
        linear_sum_assignment,
    )  # takes a third of a second, which a ledger without misprints does not need

    surplus = [Edit((f"{kind} ", operand, " does not belong there"), _size(operand)) for operand in extra]
    lost = [Edit((f"{kind} ", operand, " is missing"), _size(operand)) for operand in missing]
    changes: dict[tuple[int, int], list[Edit]] = {}
    rows, columns = len(extra), len(missing)
    costs = np.full((rows + columns, columns + rows), np.inf)
    costs[rows:, columns:] = 0
    for i, j in product(range(rows), range(columns)):
        if _related(extra[i], missing[j]) and alike(extra[i], missing[j]):
            change = _between(extra[i], missing[j])
            changes[i, j], costs[i, j] = [_placed(edit, extra[i], kind) for edit in change], _cost(change)
    for i, edit in enumerate(surplus):
        costs[i, columns + i] = _cost([edit])
    for j, edit in enumerate(lost):
        costs[rows + j, j] = _cost([edit])
    chosen = dict(zip(*(side.tolist() for side in linear_sum_assignment(costs)), strict=True))
    changed = [edit for i in range(rows) for edit in changes.get((i, chosen[i]), ())]
    left_out = [surplus[i] for i in range(rows) if chosen[i] >= columns]
    return [*changed, *left_out, *(lost[j] for i, j in chosen.items() if i >= rows and j < columns)]


@lru_cache(maxsize=4096)  # the same brackets occur in many pairs of terms of a long equation
def _between(old: Any, new: Any) -> tuple[Edit, ...]:
    return tuple(_edits(old, new))


def _placed(edit: Edit, operand: Any, kind: str) -> Edit:
    """Add to the change of a factor the product that contains it, unless the change names the product."""
    product_of_a_sum = kind == "term" and isinstance(operand, sp.Mul) and not operand.has(sp.Add)
    if not product_of_a_sum or edit.parts[0] in ("sign of ", "number before ", "in "):
        return edit
    return Edit(("in ", operand, ": ", *edit.parts), edit.size)


def _related(old: Any, new: Any) -> bool:
    """Return True if operands share a symbol, are both numbers or symbols, or are the same function of a symbol."""
    if old.is_number and new.is_number:
        return True
    ours, theirs = (side.atoms(sp.Symbol, sp.MatrixSymbol) for side in (old, new))
    single = len(ours) == len(theirs) == 1 and (old.func == new.func or {old} | {new} == ours | theirs)
    return single or bool(ours & theirs)


def _same_product(old: Any, new: Any) -> bool:
    """Return True if operands differ only in their numbers."""
    return bool(old.as_coeff_Mul()[1] == new.as_coeff_Mul()[1])


def _one_term(old: Any, new: Any) -> bool:
    """Return True if two products differ in one factor, or in two that are less than half of all.

    More different products count as separate terms, so that terms of a shortened equation are not paired at random.
    """
    if not (isinstance(old, sp.Mul | sp.Add) and isinstance(new, sp.Mul | sp.Add)):
        return True
    factors = max(map(len, _unmatched(_operands(old), _operands(new))))
    return factors <= 1 or (factors == 2 and 2 * _cost(_between(old, new)) <= _size(old) + _size(new) + 2 * _WHOLE)
