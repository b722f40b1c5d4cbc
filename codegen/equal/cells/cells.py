# SPDX-License-Identifier: Apache-2.0
"""Equality of expressions with branches, decided for each cell of constant branches.

A cell is a region in which each branching node has one branch. Both sides are smooth there, and the finite field
decides exactly if they are equal. The remaining task is to find the cells. Lines through ordinary points are searched
for all places where a condition changes. Points beside each place and between neighbouring places are visited, so
that even a slightly moved threshold has a point between its old and new place. Joint states of branches that are
neither equal in the field nor proved impossible are searched for. If no point reaches one, the answer is "undecided".
The field cannot decide some cells, for example where inverse trigonometric functions cancel. Many points on lines
through such a cell decide it.
"""

from __future__ import annotations

import random
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ...equations.formula import Printer
from .. import doubles
from ..branches import Atom
from ..doubles import Array
from ..meaning import Meaning
from ..points import FieldPoints, RealPoints
from ..proofs.known import KnownSigns
from ..verdicts import Verdict
from .centres import centres
from .conditions import Conditions
from .evidence import MOST_LINES, OF_A_LINE, Evidence, Patterns
from .lines import Columns, Lines, Spot, Work, count_of, spot
from .smooth import SmoothTest
from .spots import SpotTest
from .states import JointStates, State

_LINES = 3
"""Number of lines for each name. A line starts at the end of the previous one, and every third line at an ordinary
point, so that lines reach joint states of two names. With fewer lines, more branches must be searched for; more lines
cost time.
"""
_TRIES = 40
"""Number of lines in the search for one missing joint state."""
_WORK = 180_000_000
"""Limit on node evaluations in double precision per question, about three seconds. A third of it leaves some products
of two narrow windows undecided; twice the limit doubles the time of hopeless searches.
"""
_FAR = 1e9
"""Size of a coordinate above which a line starts only if no smaller one exists: a thousand times the drawn sizes."""
_WIDEST = 60
"""Largest number of characters of an expression in a message; two of them fit into three lines."""
_MOST_INSIDE = 12
"""Number of lines that are tried for each needed one, because only some lines reach the cell."""
_INNER = 3
"""Number of points between two places on a line inside a cell."""
_WORST = 8
"""Number of points per line, with the largest differences in double precision, that 50 digits decide."""


class Cells:
    """Search for cells in which two expressions with free names differ.

    Parameters
    ----------
    roots : (int, int)
        Nodes of both expressions.
    inside : sequence of atoms
        Signs that hold if both have a value.
    known : KnownSigns
        Proofs about signs.
    real : RealPoints
        Real points.
    points : FieldPoints
        Points of the field.
    free : Meaning
        Meaning in which all names are free.
    """

    def __init__(
        self,
        roots: tuple[int, int],
        inside: Sequence[Atom],
        known: KnownSigns,
        real: RealPoints,
        points: FieldPoints,
        free: Meaning,
    ) -> None:
        self.pool = known.pool
        self.sampler = real.sampler
        self.conditions = Conditions.of(self.pool, roots, known.parts)
        self.states = JointStates(self.pool, roots, known, inside)
        self.evidence = Evidence(len(self.conditions.names))
        self._same = SmoothTest(points, free)
        self._test = SpotTest(self.conditions, self.states, real, free, self._same)
        self._work = Work(self.pool, _WORK)
        self.lines = Lines(self.conditions, known.bounds, self.sampler.angles, self._work)
        self._patterns = Patterns()
        self._draw = random.Random(1)
        self._walked: set[State] = set()

    def walk(self) -> Verdict | None:
        """Visit ordinary points and points beside all changes along lines; return None if both sides agree."""
        starts = doubles.draw(self.conditions.names, self.sampler, 256, seed=7)
        if outcome := self._visit(starts):
            return outcome
        along = [name for name in self.conditions.names for _ in range(_LINES)]
        if len(along) > MOST_LINES:
            along = self._draw.sample(along, MOST_LINES)
        here = spot(starts, 0)
        for number, name in enumerate(along):
            if self._work.left < 0:
                break
            line = self.lines.points(here, name)
            if outcome := self._visit(line):
                return outcome
            base = starts if number % _LINES == _LINES - 1 else line
            here = self._chosen(base, range(count_of(base))) or here
        return None

    def are_proved(self) -> bool:
        """Return True if each joint state is equal in the field or proved impossible."""
        return not any(True for _ in self._open_states())

    def settle(self) -> Verdict:
        """Search for the joint states that are neither equal in the field nor impossible; call it after `walk`."""
        units = len(self.conditions.units)
        is_proved = True
        for state in self._open_states():
            if state is None:
                return self._undecided((), f"of too many combinations of branches of {units} nodes ")
            is_proved = False
            if outcome := self._look_inside() or self._look(state):
                return outcome
        if is_proved:
            return Verdict(True, f"each combination of branches of {units} nodes is equal in the field or excluded")
        if short := self.evidence.undecided():
            return self._undecided(short)
        how = "on both sides of every switch of"
        excluded = "each combination of branches with a possible difference was reached or excluded"
        points = self.evidence.least()
        return Verdict(True, f"{self._visited} {how} {units} branching nodes; {excluded}", points=points)

    def _open_states(self) -> Iterator[State | None]:
        return self.states.open(self._same.are_equal)

    # Points

    def _visit(self, point: Columns, inside: State | None = None) -> Verdict | None:
        """Compare both sides at points, and in each new cell as smooth expressions.

        With `inside`, some points in this joint state are evaluated with 50 digits.
        """
        if not (count := count_of(point)):
            return None
        values = self._work.values(self.conditions.nodes, point)
        self.evidence.points += count
        self.evidence.line += 1
        old, new = (np.broadcast_to(np.asarray(values[root], dtype=float), count) for root in self.conditions.roots)
        sizes = doubles.apart(old, new)[0]
        worst = np.argsort(sizes)[-_WORST:]
        for k in map(int, worst[sizes[worst] > 0][::-1]):
            if outcome := self._compare(spot(point, k)):
                return outcome
        defined = np.nonzero(np.isfinite(old) & np.isfinite(new))[0]
        return self._compare_patterns(point, defined, self.conditions.patterns(values, count), inside)

    def _compare_patterns(
        self, point: Columns, defined: NDArray[np.intp], patterns: Array, inside: State | None
    ) -> Verdict | None:
        """Compare points with a new pattern of conditions, and some points inside a joint state."""
        members = []
        for k in map(int, defined):
            pattern = patterns[k].tobytes()
            if self._patterns.need(pattern) and (outcome := self._compare(spot(point, k), pattern)):
                return outcome
            if self._patterns.state(pattern) == inside:
                members.append(k)
        return None if inside is None else self._compare_inside(point, self._near(point, members), inside)

    def _compare_inside(self, point: Columns, members: Sequence[int], state: State) -> Verdict | None:
        """Compare some points of a joint state, and remember the last one, at which the next line starts."""
        for k in self._draw.sample(members, min(len(members), OF_A_LINE)):
            self.evidence.agreements[state].at = spot(point, k)
            if outcome := self._compare(spot(point, k)):
                return outcome
        return None

    def _compare(self, here: Spot, pattern: bytes | None = None) -> Verdict | None:
        """Compare both sides at a point and in its cell; return None if both agree."""
        cell = self._test(here)
        if cell is None or isinstance(cell, Verdict):
            return cell
        if pattern is not None:
            self._patterns.settle(pattern, cell.state)
        self.evidence.add(cell, here)
        return None

    def _chosen(self, columns: Columns, among: Sequence[int]) -> Spot | None:
        """Return a point at which the next line starts; None without points."""
        return spot(columns, self._draw.choice(self._near(columns, among))) if among else None

    def _near(self, columns: Mapping[str, Array], among: Sequence[int]) -> Sequence[int]:
        """Return the points with coordinates small enough to avoid rounding, or all points if there are none."""
        far = np.max(np.abs([*columns.values()]), axis=0, initial=0.0)
        return [k for k in among if far[k] <= _FAR] or among

    # Cells that only points decide

    def _look_inside(self) -> Verdict | None:
        """Compare joint states that the field cannot decide, along lines through their points."""
        if self.evidence.agreements and not self._walked and (outcome := self._visit_centres()):
            return outcome
        while waiting := [state for state in self.evidence.agreements if state not in self._walked]:
            self._walked.add(waiting[0])
            if outcome := self._walk_inside(waiting[0]):
                return outcome
        return None

    def _walk_inside(self, state: State) -> Verdict | None:
        """Visit lines through the last point of a joint state until enough points agree.

        Every other line starts with a new value of one name. This leaves the cell, and lines along other names return
        to it.
        """
        along = self.conditions.names
        for number in range(_MOST_INSIDE * self.evidence.lines_wanted):
            if self._work.left < 0 or self.evidence.is_enough(state):
                break
            base = self.evidence.agreements[state].at
            if number // len(along) % 2:
                base = base | spot(doubles.draw([self._draw.choice(along)], self.sampler, 1, number), 0)
            if outcome := self._visit(self.lines.points(base, along[number % len(along)], _INNER), state):
                return outcome
        return None

    def _visit_centres(self) -> Verdict | None:
        """Visit the centres of possible narrow features, first one by one, then together."""
        conditions = self.conditions
        zeros = centres(self.pool, conditions.roots, conditions.atoms)
        lines = self.lines.with_conditions(replace(conditions, turning=(*conditions.turning, *zeros)))
        starts = doubles.draw(conditions.names, self.sampler, 256, seed=13)
        start = spot(starts, int(np.argmin(np.max(np.abs([*starts.values()]), axis=0)))) if starts else {}
        here, moved = start, set[str]()
        for zero in zeros:
            own = list(self.pool.names(zero))
            free = [name for name in own if name not in moved] or own
            for base in (start, here) if here is not start else (start,):
                there = next(((name, place) for name in free if (place := lines.zero(zero, base, name))), None)
                if there is None or self._work.left < 0:
                    continue
                if outcome := self._compare(there[1]) or self._around(lines, there[1]):
                    return outcome
                if base is here:
                    here, moved = there[1], moved | {there[0]}
        return None

    def _around(self, lines: Lines, here: Spot) -> Verdict | None:
        """Visit the lines through a point."""
        outcomes = (self._visit(lines.points(here, name)) for name in self.conditions.names)
        return next(filter(None, outcomes), None)

    # Joint states without a point

    def _look(self, state: State) -> Verdict | None:
        """Search along lines for a point in a joint state; "undecided" if there is none."""
        required = [] if self.evidence.is_decided(state) else self.states.possible(state)
        here = spot(doubles.draw(self.conditions.names, self.sampler, 1, seed=11), 0)
        along = self.conditions.names
        for number in range(_TRIES if required else 0):
            if self._work.left < 0 or self.evidence.is_decided(state):
                break
            line = self.lines.points(here, along[number % len(along)])
            if outcome := self._visit(line):
                return outcome
            if count_of(line):
                score = self._score(required[number // len(along) % len(required)], line)
                here = self._chosen(line, [*map(int, np.nonzero(score == np.max(score))[0])]) or here
        if outcome := self._look_inside():
            return outcome
        return None if self.evidence.is_decided(state) else self._undecided(state)

    def _score(self, required: Sequence[Atom], line: Columns) -> Array:
        """Count the fulfilled signs at points."""
        values = doubles.values(self.pool, self.pool.reached(*(node for node, _ in required)), line)
        right = [np.broadcast_to(np.sign(values[node]) == sign, count_of(line)) for node, sign in required]
        score: Array = np.sum(right, axis=0, dtype=float)
        return score

    # Words

    @property
    def _visited(self) -> str:
        return f"{self.evidence.points} points"

    def _undecided(self, state: State, before: str = "") -> Verdict:
        """Return "undecided", with the branches of a joint state that is open."""
        state = self.evidence.missing(state)
        texts = map(Printer(self.pool.nodes).text, (node for node, _ in state))
        names = " with ".join(text if len(text) <= _WIDEST else f"{text[:_WIDEST]}..." for text in texts)
        what = "a branch of" if len(state) == 1 else "a combination of branches of" if state else "the expression"
        met = [agreement.points for other, agreement in self.evidence.agreements.items() if {*state} <= {*other}]
        how = f"was compared at {sum(met)} points only" if met else "was neither reached nor excluded"
        where = " ".join(filter(None, (what, names)))
        return Verdict(None, f"equal at {self._visited}, but {before}{where} {how}")
