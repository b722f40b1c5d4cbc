# SPDX-License-Identifier: Apache-2.0
"""Modes: states of rate zero, which only resets change. At the values that they take, `<` and `<=` differ."""

from __future__ import annotations

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
        new = {versions.renamed.get(name, name) for name in _constant(versions.new)}
        self._values: dict[str, set[Fraction]] = {name: set() for name in _constant(versions.old) & new}
        for item in (*versions.olds, *versions.news) if self._values else ():
            name = item.name.removesuffix("(0)") if item.row.kind == "initial" else item.name.partition(": ")[2][:-1]
            value = versions.pool.constant(item.root)
            if item.row.kind in ("initial", "reset") and name in self._values and value is not None:
                self._values[name].add(value)

    def difference(self, old: Expression, new: Expression) -> Verdict | None:
        """Return a negative verdict if two expressions differ where a mode has one of its numbers; None if not."""
        names = sorted({*old[0].free(old[1]), *new[0].free(new[1])}) if self._values else []
        for name in names:
            for value in sorted(self._values.get(name, ())):
                for number in range(_POINTS):
                    point = {**self._judge.sampler.point(number), name: value}
                    if self._judge.differ(self._judge.real(point), old, new):
                        how = f"they differ at {name} = {value}, to which it is set"
                        return Verdict(False, how, point={each: point[each] for each in names})
        return None


def _constant(document: Document) -> set[str]:
    """Return the states whose rate is zero."""
    rates = {row.name.removesuffix("'"): document.nodes[row.node] for row in document.results if row.kind == "rhs"}
    states = {symbol.name for symbol in document.symbols if symbol.role == "state"}
    return {name for name in states if rates.get(name) == ("num", "0")}
