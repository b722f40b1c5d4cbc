# SPDX-License-Identifier: Apache-2.0
"""Modes: states of rate zero, which only resets change. At the values that they take, `<` and `<=` differ."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import TYPE_CHECKING

from ..equal.judge import Verdict
from ..equal.meaning import Expression
from ..equations.document import Document

if TYPE_CHECKING:
    from .versions import Versions

_POINTS = 16
"""Points of all other names, at each number of a mode. A branch that most of them miss is compared by the judge."""


class Modes:
    """The modes that both versions have, with the numbers that resets and starts assign to them.

    Parameters
    ----------
    versions : Versions
        Rows of both sides.
    """

    def __init__(self, versions: Versions) -> None:
        self._judge = versions.judge
        self._pool = versions.pool
        new = {versions.renamed.get(name, name) for name in _constant(versions.new)}
        self._values: dict[str, set[Fraction]] = {name: set() for name in _constant(versions.old) & new}
        self._open: set[str] = set()
        """Modes that a reset sets to an expression, such as 1 - mode."""
        for item in (*versions.olds, *versions.news) if self._values else ():
            name = item.name.removesuffix("(0)") if item.row.kind == "initial" else item.name.partition(": ")[2][:-1]
            name = versions.renamed.get(name, name)
            value = versions.pool.constant(item.root)
            if item.row.kind not in ("initial", "reset") or name not in self._values:
                continue
            if value is not None:
                self._values[name].add(value)
            elif item.row.kind == "reset":
                self._open.add(name)

    def difference(self, old: Expression, new: Expression) -> Verdict | None:
        """Return a verdict if two expressions differ where a mode has one of its numbers; None if they do not.

        It is undecided at a number in the texts that a mode may or may not take.
        """
        names = sorted({*old[0].free(old[1]), *new[0].free(new[1])}) if self._values else []
        for name in names:
            known = self._values.get(name, set())
            for value in sorted(known):
                if point := self._witness(old, new, {name: value}):
                    how = f"they differ at {name} = {value}, to which it is set"
                    return Verdict(False, how, point={each: point[each] for each in names})
            for value in sorted(self._numbers(old, new) - known) if name in self._open else ():
                if self._witness(old, new, {name: value}):
                    return Verdict(None, f"they differ at {name} = {value}, to which a reset may set it")
        return None

    def _witness(self, old: Expression, new: Expression, fixed: Mapping[str, Fraction]) -> dict[str, Fraction] | None:
        """Return a point with some values fixed at which two expressions differ."""
        points = ({**self._judge.sampler.point(number), **fixed} for number in range(_POINTS))
        return next((point for point in points if self._judge.differ(self._judge.real(point), old, new)), None)

    def _numbers(self, *sides: Expression) -> set[Fraction]:
        """Return the numbers in expressions and in the definitions that they use."""
        constants = (self._pool.constant(node) for meaning, root in sides for node in meaning.cone(root))
        return {value for value in constants if value is not None}


def _constant(document: Document) -> set[str]:
    """Return the states whose rate is zero."""
    rates = {row.name.removesuffix("'"): document.nodes[row.node] for row in document.results if row.kind == "rhs"}
    states = {symbol.name for symbol in document.symbols if symbol.role == "state"}
    return {name for name in states if rates.get(name) == ("num", "0")}
