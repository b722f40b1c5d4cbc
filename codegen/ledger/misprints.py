# SPDX-License-Identifier: Apache-2.0
"""What is wrong with a printed formula, term by term, told from its corrected form.

Both forms are written by hand in the same layout, so a walk down both trees finds the place. That the corrected form is
right is not decided here: `mehvar.codegen.ledger.relations` tests it against the derivation.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import sympy as sp

from mehvar.models.mechanics import reduce_sines
from mehvar.models.paper import Side

Write = Callable[[Any], str]
_MANY = 16
"""Sums that differ in more products than this are no misprint but shortened: every product is listed."""
_LAST = 0.1
"""How close one symbol is to another in its place, sin(x) to sin(y): below all that share a symbol of up to ten."""


def edits(printed: Side, corrected: Side, write: Write = sp.sstr) -> tuple[str, ...]:
    """Say what must change in a printed side to make it the corrected one, in words.

    Parameters
    ----------
    printed, corrected : Expr or Matrix
        Both forms.
    write : callable
        Writes a part of them as text.
    """
    return tuple(_edits(sp.sympify(printed), sp.sympify(corrected), write))


def _edits(printed: Any, corrected: Any, write: Write) -> Iterator[str]:
    if printed == corrected:
        return
    if printed.is_number and corrected.is_number:
        yield f"{write(printed)} should read {write(corrected)}"
    elif isinstance(printed, sp.MatrixBase) and isinstance(corrected, sp.MatrixBase):
        yield from _entries(printed, corrected, write)
    elif isinstance(printed, sp.Add | sp.MatAdd) or isinstance(corrected, sp.Add | sp.MatAdd):
        yield from _terms(printed, corrected, write)
    elif isinstance(printed, sp.MatMul) and isinstance(corrected, sp.MatMul):
        yield from _matrix_factors(printed, corrected, write)
    elif isinstance(printed, sp.Mul) or isinstance(corrected, sp.Mul):
        yield from _factors(printed, corrected, write)
    elif printed.func == corrected.func and len(printed.args) == len(corrected.args) and printed.args:
        for old, new in zip(printed.args, corrected.args, strict=True):
            yield from _edits(old, new, write)
    else:
        yield f"{write(printed)} should read {write(corrected)}"


def _entries(printed: sp.MatrixBase, corrected: sp.MatrixBase, write: Write) -> Iterator[str]:
    if printed.shape != corrected.shape:
        yield f"{write(printed)} should read {write(corrected)}"
        return
    for old, new in zip(printed, corrected, strict=True):
        yield from _edits(old, new, write)


def _terms(printed: Any, corrected: Any, write: Write) -> Iterator[str]:
    """Compare sums: signs first, then terms that resemble each other, then what is lost or added."""
    extra, missing = _unmatched(_summands(printed), _summands(corrected))
    for term in list(extra):
        if -term in missing:
            extra.remove(term)
            missing.remove(-term)
            sign = "-" if term.could_extract_minus_sign() else "+"
            size = -term if sign == "-" else term
            yield f"sign of {write(size)}: printed {sign}, correct {'+' if sign == '-' else '-'}"
    listed = _written_out(extra, missing)
    if len(listed) > _MANY:
        yield from _coefficients(listed, write)
        return
    for old, new in _pairs(extra, missing):
        yield from _edits(old, new, write)
    yield from (f"term {write(term)} does not belong there" for term in extra)
    yield from (f"term {write(term)} is missing" for term in missing)


def _written_out(extra: Sequence[Any], missing: Sequence[Any]) -> dict[Any, tuple[Any, Any]]:
    """Return the products in which sums differ once they are written out, with both coefficients.

    Empty for matrices, and where a sum stands in a denominator.
    """
    if any(isinstance(term, sp.MatrixExpr) or sp.denom(sp.together(term)).has(sp.Add) for term in (*extra, *missing)):
        return {}
    old, new = (reduce_sines(sp.Add(*terms)).as_coefficients_dict() for terms in (extra, missing))
    return {term: (old[term], new[term]) for term in (*old, *new) if old[term] != new[term]}


def _coefficients(listed: Mapping[Any, tuple[Any, Any]], write: Write) -> Iterator[str]:
    for term, (old, new) in listed.items():
        if not new:
            yield f"term {write(old * term)} does not belong there"
        elif not old:
            yield f"term {write(new * term)} is missing"
        elif old == -new:
            before, after = ("-", "+") if old < 0 else ("+", "-")
            yield f"sign of {write(abs(old) * term)}: printed {before}, correct {after}"
        else:
            yield f"number before {write(term)}: printed {old}, correct {new}"


def _factors(printed: Any, corrected: Any, write: Write) -> Iterator[str]:
    """Compare products: the number, then factors with the same base, then factors that resemble each other."""
    (number, old), (right_number, new) = printed.as_coeff_Mul(), corrected.as_coeff_Mul()
    if number == -right_number:
        yield f"sign of {write(old)}: printed {'-' if number < 0 else '+'}, correct {'+' if number < 0 else '-'}"
    elif number != right_number:
        yield f"number before {write(old)}: printed {number}, correct {right_number}"
    extra, missing = _unmatched(sp.Mul.make_args(old), sp.Mul.make_args(new))
    for factor in list(extra):
        base, power = factor.as_base_exp()
        partner = next((other for other in missing if other.as_base_exp()[0] == base), None)
        if partner is not None:
            extra.remove(factor)
            missing.remove(partner)
            yield f"exponent of {write(base)}: printed {power}, correct {partner.as_base_exp()[1]}"
    for before, after in _pairs(extra, missing):
        yield from _edits(before, after, write)
    yield from (f"factor {write(factor)} does not belong there" for factor in extra if factor != 1)
    yield from (f"factor {write(factor)} is missing" for factor in missing if factor != 1)


def _matrix_factors(printed: Any, corrected: Any, write: Write) -> Iterator[str]:
    (number, old), (right_number, new) = (side.as_coeff_matrices() for side in (printed, corrected))
    if old == new:
        yield from _edits(number, right_number, write) if number != -right_number else (f"sign of {write(corrected)}",)
    else:
        yield f"{write(printed)} should read {write(corrected)}"


def _summands(side: Any) -> Sequence[Any]:
    return side.args if isinstance(side, sp.Add | sp.MatAdd) else (side,)


def _unmatched(old: Sequence[Any], new: Sequence[Any]) -> tuple[list[Any], list[Any]]:
    """Return the operands of either side that the other lacks."""
    before, after = Counter(old), Counter(new)
    return list((before - after).elements()), list((after - before).elements())


def _pairs(extra: list[Any], missing: list[Any]) -> Iterator[tuple[Any, Any]]:
    """Take out of both lists what resembles each other most: numbers, or operands that share symbols."""
    while extra and missing:
        closeness = {(old, new): _closeness(old, new) for old in extra for new in missing}
        (old, new), best = max(closeness.items(), key=lambda item: item[1])
        if not best:
            return
        extra.remove(old)
        missing.remove(new)
        yield old, new


def _closeness(old: Any, new: Any) -> float:
    if old.is_number and new.is_number:
        return 1.0
    ours, theirs = set(old.atoms(sp.Symbol, sp.MatrixSymbol)), set(new.atoms(sp.Symbol, sp.MatrixSymbol))
    alone = len(ours) == len(theirs) == 1 and old.func == new.func
    common = len(set(sp.Mul.make_args(old)) & set(sp.Mul.make_args(new)))
    return (len(ours & theirs) + common) / (len(ours | theirs) or 1) or (_LAST if alone else 0.0)
