# SPDX-License-Identifier: Apache-2.0
"""Record of the joint states in which both sides agree, and of the points that show it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import combinations

from ..branches import Way
from .lines import Spot
from .spots import Cell
from .states import State

_ENOUGH = 64
"""Number of agreeing points with 50 digits that decide a cell if the field cannot. They miss one of two equal halves of
a cell in one of 10^19 cases.
"""
MOST_LINES = 60
"""Largest number of lines over all names; with more names, a random selection is used."""
OF_A_LINE = 4
"""Largest number of agreeing points per line, so that they lie on at least sixteen lines."""
_MOST_PATTERNS = 4000
"""Largest number of patterns whose points are evaluated with 50 digits."""
_MOST_OF_PATTERN = 3
"""Largest number of points per pattern that are evaluated with 50 digits to find joint states."""


@dataclass
class Agreement:
    """A joint state that the field cannot decide: its last point, and the lines and number of agreeing points."""

    at: Spot
    lines: set[int] = field(default_factory=set)
    points: int = 0


class Evidence:
    """Joint states that points reached.

    Parameters
    ----------
    names : int
        Number of names of both expressions.

    Attributes
    ----------
    points, line : int
        Number of visited points, and of lines.
    agreements : dict
        Joint states that only points can decide.
    """

    def __init__(self, names: int) -> None:
        self.lines_wanted = max(_ENOUGH // OF_A_LINE, min(2 * names, MOST_LINES)) if names else 1
        """Number of lines needed to decide a cell by points: at least two per name."""
        self.points = 0
        self.line = 0
        self.agreements: dict[State, Agreement] = {}
        self._decided: set[frozenset[Way]] = set()

    def add(self, cell: Cell, spot: Spot) -> None:
        """Record that both sides agree at a point of a cell."""
        if not cell.is_equal:
            agreement = self.agreements.setdefault(cell.state, Agreement(spot))
            agreement.lines.add(self.line)
            agreement.points += 1
        if cell.is_equal or self.is_enough(cell.state):
            self._decided.add(frozenset(cell.state))

    def is_enough(self, state: State) -> bool:
        """Return True if agreeing points decide a joint state."""
        agreement = self.agreements[state]
        return agreement.points >= _ENOUGH and len(agreement.lines) >= self.lines_wanted

    def is_decided(self, ways: Sequence[Way]) -> bool:
        """Return True if both sides are equal in a joint state with these branches."""
        return any(state.issuperset(ways) for state in self._decided)

    def missing(self, state: State) -> State:
        """Return the least part of an open joint state that is not decided: a branch, a pair or all of them."""
        parts = (*combinations(state, 1), *combinations(state, 2))
        return next((part for part in parts if not self.is_decided(part)), state)

    def undecided(self) -> State | None:
        """Return a joint state in which too few points agree; None if there is none."""
        return next((state for state in self.agreements if frozenset(state) not in self._decided), None)

    def least(self) -> int:
        """Return the least number of agreeing points in joint states that only points decide; 0 without such states."""
        return min((agreement.points for agreement in self.agreements.values()), default=0)


class Patterns:
    """Patterns of signs at points in double precision, each of which needs a few points with 50 digits."""

    def __init__(self) -> None:
        self._count: Counter[bytes] = Counter()
        self._states: dict[bytes, State] = {}

    def need(self, pattern: bytes) -> bool:
        """Return True if a pattern needs another point, and count it."""
        if pattern in self._states or self._count[pattern] >= _MOST_OF_PATTERN or len(self._count) >= _MOST_PATTERNS:
            return False
        self._count[pattern] += 1
        return True

    def settle(self, pattern: bytes, state: State) -> None:
        """Record the joint state of a pattern."""
        self._states[pattern] = state

    def state(self, pattern: bytes) -> State | None:
        """Return the joint state of a pattern, if known."""
        return self._states.get(pattern)
