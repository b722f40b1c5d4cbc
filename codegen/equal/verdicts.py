# SPDX-License-Identifier: Apache-2.0
"""Answers of a test of equality, and points that show a difference with short numbers."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction

import mpmath

from . import reals
from .meaning import Expression
from .points import Worlds
from .sampler import Point

VISIBLE = 1e-4
"""Relative difference that a counterexample must show, so that at least two of six printed digits differ."""
_PASSES = 2
"""Number of passes over all names, because some names allow a simple value only after others have one."""


@dataclass(frozen=True)
class Counterexample:
    """A point where two expressions differ.

    Attributes
    ----------
    at : tuple of (str, str)
        Names and exact values; all other names are zero or do not matter.
    left, right : str
        Values of both sides with at least six digits and as many as distinguish them; "no value" if a side has none.
    """

    at: tuple[tuple[str, str], ...]
    left: str
    right: str


@dataclass(frozen=True)
class Verdict:
    """Answer of a test of equality: equal, different or undecided (None), with the reason and a point of difference.

    `point` is in a cell in which both sides are different functions, or in which one of them has no value. `points`
    is the number of agreeing points if only points show equality; it is zero if equality is proved.
    """

    equal: bool | None
    how: str
    counterexample: Counterexample | None = None
    point: Point | None = None
    points: int = 0


def simplified(
    point: Mapping[str, Fraction],
    candidates: Callable[[str, Fraction], Iterable[Fraction]],
    fails: Callable[[Point], bool],
) -> dict[str, Fraction]:
    """Simplify the coordinates of a point of difference, name by name."""
    simple = dict(point)
    for _ in range(_PASSES):
        for name in (name for name in sorted(point) if simple[name] == point[name]):
            for value in candidates(name, simple[name]):
                if fails({**simple, name: value}):
                    simple[name] = value
                    break
    return simple


def shown(worlds: Worlds, old: Expression, new: Expression) -> tuple[str, str]:
    """Return two values at a real point with six, twelve, ... digits, until they differ."""
    digits = 6
    while True:
        first, second = (_shown(worlds, expression, digits) for expression in (old, new))
        if first != second or digits > reals.DIGITS:
            return first, second
        digits *= 2


def _shown(worlds: Worlds, expression: Expression, digits: int) -> str:
    """Return a real value as text: "no value" without one, zero for rounding error."""
    meaning, root = expression
    value = worlds[meaning].defined(root)
    if value is None:
        return "no value"
    if isinstance(value, bool | tuple):
        return str(value)
    if reals.vanishes(value, worlds[meaning].size(root)):
        return "0.0"
    return str(mpmath.nstr(value, digits, strip_zeros=True))
