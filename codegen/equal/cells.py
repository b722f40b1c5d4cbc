# SPDX-License-Identifier: Apache-2.0
"""Equality of expressions with branches, decided for each cell of constant branches.

A cell is a region in which each branching node has one branch. Both sides are smooth there, and the finite field
decides exactly if they are equal. The remaining task is to find the cells. Lines through ordinary points are searched
for all places where a condition changes. Points beside each place and between neighbouring places are visited, so
that even a slightly moved threshold has a point between its old and new place. Branches, and pairs of branches, that
no point reached are searched for or proved impossible by intervals. If neither succeeds, the answer is "undecided".
The field cannot decide some cells, for example where inverse trigonometric functions cancel. Many points on lines
through such a cell decide it.
"""

from __future__ import annotations

import functools
import itertools
import random
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..equations.document import reached
from ..equations.formula import Printer
from . import doubles, reals
from .branches import (
    COMPARISONS,
    STEPS,
    Atom,
    Way,
    atoms,
    branching,
    counted,
    either,
    every,
    implied,
    requirements,
    smooth,
    ways_of,
)
from .doubles import Array
from .pool import Pool
from .proofs import intervals, linear
from .proofs.signs import Signs, splits
from .reals import PointSampler, RealWorld, Verdict
from .slopes import slope

Point = dict[str, float]
State = frozenset[Way]
_LINES = 3
"""Number of lines for each name. A line starts at the end of the previous one, and every third line at an ordinary
point, so that lines reach joint states of two names. With fewer lines, more branches must be searched for; more lines
cost time.
"""
_MOST_LINES = 60
"""Largest number of lines over all names; with more names, a random selection is used."""
_TRIES = 40
"""Number of lines in the search for one missing branch or pair of branches."""
_MOST_MISSING = 400
"""Largest number of branches and pairs that are searched for or proved impossible. With more, the answer is
"undecided"."""
_WORK = 180_000_000
"""Limit on node evaluations in double precision per question, about three seconds. A third of it leaves some products
of two narrow windows undecided; twice the limit doubles the time of hopeless searches.
"""
_MOST_JOINT = 300_000
"""Limit on nodes of all joint states that are compared in the field, about ten seconds. Half the limit allows one
rearranged saturation less.
"""
_SIXTEENTHS = 16
"""Number of parts into which a bracket is divided at each step. 13 steps give the 52 bits of a double."""
_CUTS = 14
_MOST_PLACES = 64
"""Largest number of places on one line, more than a table has. A floor has infinitely many, which are sampled."""
_BESIDE = 1e-12
"""Relative distance of test points from a place where a condition changes. It is above rounding, and after any larger
shift points lie between the old and new place.
"""
_GRID = tuple(
    sign * digit * 10.0**decade for sign in (-1, 1) for decade in range(-9, 40, 1) for digit in (1.0, 2.0, 5.0)
)
"""Grid points on a line between which sign changes are searched for, besides the expressions' constants."""
_TURN = tuple(np.linspace(-doubles.TURNS, doubles.TURNS, 129) * 2 * np.pi)
_PROOFS = (linear.impossible, intervals.impossible)
_MOST_PROVED = 60_000
"""Limit on nodes of joint states compared in the field before the search for points: one or two seconds."""
_MOST_OPEN = 24
"""Largest number of joint states that may remain open; with more, branches and pairs are searched for."""
_MOST_CASES = 3
"""Largest number of combined cases inside conditions that a proof expands: eight distinctions of two cases."""
_MOST_PATTERNS = 4000
"""Largest number of branch combinations evaluated with 50 digits."""
_MOST_STEPS = 128
"""Largest number of combinations that differ only in the integers of steps; infinitely many exist. It is twice the
number of ordinary points, and each costs a comparison in the field.
"""
_FAR = 1e9
"""Size of a coordinate above which a line starts only if no smaller one exists: a thousand times the drawn sizes."""
_WIDEST = 60
"""Largest number of characters of an expression in a message; two of them fit into three lines."""
_TOLD = 64
"""Number of agreeing points with 50 digits that decide a cell if the field cannot; see `_BRANCHED` in `equality`."""
_OF_A_LINE = 4
"""Largest number of these points per line, so that they lie on at least sixteen lines."""
_MOST_INSIDE = 12
"""Number of lines that are tried for each needed one, because only some lines reach the cell."""
_INNER = 3
"""Number of points between two places on a line inside a cell."""
_BURNT = 3
"""Largest number of points per branch combination that are evaluated with 50 digits to find branches."""
_ARCS = frozenset(("asin", "acos", "atan2"))
_NARROW = frozenset(
    ("exp", "tanh", "sinh", "cosh", "atan", "asinh", "log", "sin", "cos", "tan", "acos", "asin", "atan2")
)
"""Functions that may change only in a narrow region, near a zero or extremum of their operand."""
_BROAD = 3
"""Largest exponent of a power whose change is as wide as that of its base."""
_MOST_CENTRES = 24
"""Largest number of centres around which narrow features are searched for; each costs one line per name."""
_JUMPS = COMPARISONS - {"equality", "unequality"} | {"sign"}
_LIT = Fraction(1, 10**30)
"""Relative size above which a sign counts: 30 of 50 digits. The square of a window of 1e-9 needs 18 digits. An
inverse sine or cosine near one keeps half of the 90 computed digits.
"""


@dataclass
class _Inside:
    """A joint state that the field cannot decide: its last point, and the number of agreeing points."""

    at: Point
    lines: set[int] = field(default_factory=set)
    points: int = 0


class Cells:
    """Search for cells in which two expressions with free names differ.

    Parameters
    ----------
    pool : Pool
        Pool of both expressions.
    sampler : PointSampler
        Draws ordinary points.
    bounds : mapping
        Bounds of free names.
    world : callable
        Makes the real world at a point.
    same : callable
        Compares two smooth expressions: True, False, or None if only real points can decide.
    never_has : callable
        True if an expression provably never has a given sign.
    roots : (int, int)
        Nodes of both expressions.
    inside : sequence of atoms
        Signs that hold if both have a value.
    """

    def __init__(
        self,
        pool: Pool,
        sampler: PointSampler,
        bounds: intervals.Bounds,
        world: Callable[[Mapping[str, Fraction]], RealWorld],
        same: Callable[[int, int], bool | None],
        never_has: Callable[[int, int], bool],
        roots: tuple[int, int],
        inside: Sequence[Atom],
    ) -> None:
        self.pool = pool
        self.sampler = sampler
        self._world = world
        self._same = same
        self._never_has = never_has
        self._bounds = bounds
        self._split = Signs(pool, bounds)
        self._impossible: dict[tuple[Atom, ...], bool] = {}
        self._roots = roots
        self._inside = tuple(inside)
        self._units = branching(self.pool, self._roots)
        self._atoms = list(dict.fromkeys(g for node in self._units for g in atoms(self.pool, node)))
        self._steps = [node for node in self._units if self.pool.nodes[node][0] in STEPS]
        self._nodes = reached(self.pool.nodes, [*self._roots, *self._atoms, *self._units, *self._factors()])
        self._names = sorted({self.pool.nodes[k][1] for k in self._nodes if self.pool.nodes[k][0] == "sym"})
        self._constants = self._numbers()
        self._ways: set[Way] = set()
        self._pairs: set[tuple[Way, Way]] = set()
        self._needed: dict[int, list[list[tuple[Atom, ...]] | None]] = {}
        self._company: dict[Way, frozenset[int]] = {}
        self._follows: dict[Way, dict[int, int]] = {}
        self._doubtful: list[tuple[Way, ...]] = []
        self._states: set[State] = set()
        self._forms: dict[tuple[int, int], bool | None] = {}
        self._patterns: Counter[bytes] = Counter()
        self._numbers_seen: Counter[bytes] = Counter()
        self._cell: dict[bytes, State] = {}
        self._seen: set[bytes] = set()
        self._insides: dict[State, _Inside] = {}
        self._walked: set[State] = set()
        self._line_number = 0
        self._left = _WORK
        self._points = 0
        self._draw = random.Random(1)

    def decide(self, doubtful: Sequence[tuple[Way, ...]] = (), complete: bool = False) -> Verdict:
        """Search for the remaining branches, pairs of branches and doubtful joint states; call it after `walk`.

        Parameters
        ----------
        doubtful : sequence of tuple of ways
            Joint states in which both sides may differ.
        complete : bool
            True if both sides are known to be equal in every other joint state.
        """
        self._doubtful = [tuple(sorted(ways)) for ways in doubtful]
        return self._look_inside() or self._missing() or (None if complete else self._joint()) or self._equal()

    def open_states(self) -> list[tuple[Way, ...]] | None:
        """Return the joint states that are neither equal in the field nor impossible; None if there are too many."""
        found: list[tuple[Way, ...]] = []
        stack: list[dict[int, int]] = [{}]
        left, proofs = _MOST_PROVED, _MOST_MISSING
        while stack:
            taken = stack.pop()
            left -= len(self._nodes)
            if self._are_equal(taken):
                continue
            state = tuple(sorted(taken.items()))
            if taken:
                proofs -= 1
                if self._is_out(state):
                    continue
            if left < 0 or proofs < 0 or len(found) > _MOST_OPEN:
                return None
            free = self._free(taken)
            if free:
                stack += [{**taken, node: way} for node, way in ways_of(self.pool, max(free))]
            else:
                found.append(state)
        return found

    def settle(self, states: Sequence[tuple[Way, ...]]) -> Verdict:
        """Search for the given joint states, given that both sides are equal in all others; call it after `walk`."""
        if not states:
            return Verdict(
                True, f"each combination of branches of {len(self._units)} nodes is equal in the field or excluded"
            )
        return self._look_inside() or next(filter(None, map(self._sought, states)), None) or self._equal()

    @property
    def points(self) -> str:
        """Number of visited points, as text."""
        return f"{self._points} points on both sides of every switch of {len(self._units)} branching nodes"

    def _factors(self) -> list[int]:
        """Return the factors that may decide the sign of an expression: with even roots, those on one side only."""
        first, second = ({*reached(self.pool.nodes, [root])} for root in self._roots)
        rooted = any(self.pool.raised(node)[1].denominator % 2 == 0 for node in first | second)
        kinds = ("add", "sin", "cos", "tan", "sym")
        self._signed = [k for k in sorted(first ^ second) if rooted and self.pool.nodes[k][0] in kinds]
        arcs = (k for k in sorted(first | second) if self.pool.nodes[k][0] in _ARCS)
        turns = (turn for arc in arcs for turn in self._turns(arc))
        parts = (part for atom in self._atoms for part in sorted(self._split.parts(atom)))
        self._turning = [node for node in dict.fromkeys([*turns, *parts]) if node not in self._atoms]
        return [*self._signed, *self._turning]

    def _turns(self, arc: int) -> list[int]:
        """Return the nodes that are zero where an arc changes its branch."""
        operands = self.pool.operands(arc)
        other = {"sin": "cos", "cos": "sin"}.get(self.pool.nodes[operands[0]][0])
        return [*operands, *([self.pool.intern(other, *self.pool.operands(operands[0]))] if other else [])]

    def _numbers(self) -> list[float]:
        numbers = (self.pool.constant(k) for k in self._nodes)
        sizes = {abs(float(n)) for n in numbers if n and abs(n) < 10**300}
        return sorted({sign * size for size in sizes for sign in (1, -1)} | {0.0})

    # Lines

    def walk(self) -> Verdict | None:
        """Visit ordinary points and points beside all changes along lines; return None if both sides agree."""
        starts = doubles.draw(self._names, self.sampler, 256, seed=7)
        if outcome := self._visit(starts):
            return outcome
        lines = [name for name in self._names for _ in range(_LINES)]
        if len(lines) > _MOST_LINES:
            lines = self._draw.sample(lines, _MOST_LINES)
        here = _row(starts, 0)
        for number, name in enumerate(lines):
            if self._left < 0:
                break
            line = self._line(here, name)
            if outcome := self._visit(line):
                return outcome
            base = starts if number % _LINES == _LINES - 1 else line
            here = _row(base, self._chosen(base, range(len(base[name])))) if len(base[name]) else here
        return None

    def _chosen(self, columns: Mapping[str, Array], among: Sequence[int]) -> int:
        """Return the index of the point at which the next line starts."""
        return self._draw.choice(self._near(columns, among))

    def _near(self, columns: Mapping[str, Array], among: Sequence[int]) -> Sequence[int]:
        """Return the points with coordinates small enough to avoid rounding, or all points if there are none."""
        far = np.max(np.abs([*columns.values()]), axis=0, initial=0.0)
        return [k for k in among if far[k] <= _FAR] or among

    def _line(self, base: Point, name: str, inner: int = 0) -> dict[str, Array]:
        """Return points along a name: beside each place where a condition changes, and between places.

        `inner` is the number of further points between two places.
        """
        grid = self._grid(base, name)
        signs = self._signs(base, name, grid)
        rows, columns = np.nonzero(signs[:, 1:] * signs[:, :-1] < 0)
        if len(rows) > _MOST_PLACES:
            keep = np.linspace(0, len(rows) - 1, _MOST_PLACES).astype(int)
            rows, columns = rows[keep], columns[keep]
        places = self._narrowed(base, name, rows, grid[columns], grid[columns + 1])
        on = grid[np.nonzero(np.any(signs == 0, axis=0))[0]] if len(signs) else grid[:0]
        ends = np.unique(np.concatenate([places, on]))
        beside = np.concatenate([ends * (1 - _BESIDE) - 1e-300, ends * (1 + _BESIDE) + 1e-300])
        between = (ends[1:] + ends[:-1]) / 2
        outer = np.array([ends[0] - abs(ends[0]) - 1, ends[-1] + abs(ends[-1]) + 1]) if len(ends) else grid[::16]
        parts = [ends, beside, between, outer]
        if inner:
            shares = [self._draw.random() for _ in range(inner)]
            parts += [grid[self._draw.randrange(8) :: 8], *(ends[:-1] + (ends[1:] - ends[:-1]) * s for s in shares)]
        return self._along(base, name, self._allowed(name, np.unique(np.concatenate(parts))))

    def _grid(self, base: Point, name: str) -> Array:
        turn = _TURN if name in self.sampler.angles else ()
        low, high = self._bounds.get(name, (None, None))
        inner = np.linspace(float(low), float(high), 65) if low is not None and high is not None else ()
        return self._allowed(name, np.unique(np.array([*_GRID, *turn, *inner, *self._constants, base[name]])))

    def _allowed(self, name: str, values: Array) -> Array:
        low, high = self._bounds.get(name, (None, None))
        inside = np.isfinite(values)
        if low is not None:
            inside &= values >= float(low)
        if high is not None:
            inside &= values <= float(high)
        return values[inside]

    def _along(self, base: Point, name: str, values: Array) -> dict[str, Array]:
        return {other: values if other == name else np.full(len(values), base[other]) for other in self._names}

    def _signs(self, base: Point, name: str, grid: Array) -> Array:
        """Return the sign of every condition at places on a line; NaN without a value."""
        return np.sign(self._conditions(self._along(base, name, grid), len(grid)))

    def _conditions(self, point: Mapping[str, Array], count: int) -> Array:
        """Return values whose sign changes with a condition; a floor changes sign at each whole number."""
        found = self._values(point, count)
        rows = [found[k] for k in (*self._atoms, *self._signed, *self._turning)]
        for node in self._steps:
            operands = self.pool.operands(node)
            with np.errstate(all="ignore"):  # without a value, no condition changes
                whole = found[operands[0]] / found[operands[1]] if len(operands) == 2 else found[operands[0]]
                rows.append(np.sin(np.pi * np.asarray(whole)))
        return np.array([np.broadcast_to(np.asarray(row, dtype=float), count) for row in rows]).reshape(-1, count)

    def _values(self, point: Mapping[str, Array], count: int) -> dict[int, Any]:
        self._left -= count * len(self._nodes)
        return doubles.values(self.pool, self._nodes, point)

    def _narrowed(self, base: Point, name: str, rows: NDArray[np.intp], low: Array, high: Array) -> Array:
        """Return the places between pairs of points where conditions change, precise to two bits."""
        return self._cut_down(lambda cuts: self._signs(base, name, cuts), rows, low, high)

    @staticmethod
    def _cut_down(signs_at: Callable[[Array], Array], rows: NDArray[np.intp], low: Array, high: Array) -> Array:
        """Return the places between pairs of points where rows of signs change."""
        parts = np.linspace(0, 1, _SIXTEENTHS + 1)
        for _ in range(_CUTS if len(low) else 0):
            cuts = low[:, None] + (high - low)[:, None] * parts
            signs = signs_at(cuts.ravel()).reshape(-1, *cuts.shape)
            own = signs[rows, np.arange(len(rows))]
            first = np.argmax(own[:, 1:] * own[:, :1] <= 0, axis=1)
            low, high = cuts[np.arange(len(rows)), first], cuts[np.arange(len(rows)), first + 1]
        return (low + high) / 2

    # Points

    def _visit(self, point: Mapping[str, Array], inside: State | None = None) -> Verdict | None:
        """Compare both sides at points, and in each new cell as smooth expressions.

        With `inside`, some points in this joint state are evaluated with 50 digits.
        """
        count = len(next(iter(point.values()))) if point else 1
        if not count:
            return None
        found = self._values(point, count)
        self._points += count
        self._line_number += 1
        old, new = (np.broadcast_to(np.asarray(found[root], dtype=float), count) for root in self._roots)
        sizes = doubles.apart(old, new)[0]
        worst = np.argsort(sizes)[-8:]
        for k in map(int, worst[sizes[worst] > 0][::-1]):
            if outcome := self._decide_at(_row(point, k)):
                return outcome
        return self._look_at(point, np.isfinite(old) & np.isfinite(new), self._table(found, count), inside)

    def _table(self, found: Mapping[int, Any], count: int) -> Array:
        """Return the branches of all branching nodes at each point."""
        rows = [np.broadcast_to(np.asarray(found[node], dtype=float), count) for node in self._steps]
        rows += [
            np.sign(np.broadcast_to(np.asarray(found[node], dtype=float), count))
            for node in (*self._atoms, *self._signed)
        ]
        return np.array(rows, dtype=float).reshape(-1, count).T.copy()

    def _look_at(
        self, point: Mapping[str, Array], defined: NDArray[np.bool_], table: Array, inside: State | None
    ) -> Verdict | None:
        """Compare points with a new branch combination, and some points inside joint states."""
        members = []
        for k in map(int, np.nonzero(defined)[0]):
            pattern = table[k].tobytes()
            is_new = pattern not in self._seen and self._is_wanted(pattern)
            if is_new and (outcome := self._decide_at(_row(point, k), pattern)):
                return outcome
            if inside is not None and self._cell.get(self._signs_of(pattern)) == inside:
                members.append(k)
        near = self._near(point, members)
        for k in self._draw.sample(near, min(len(near), _OF_A_LINE)):
            here = _row(point, k)
            self._insides[inside].at = here  # type: ignore[index]
            if outcome := self._decide_at(here):
                return outcome
        return None

    def _is_wanted(self, pattern: bytes) -> bool:
        """Return True if a branch combination needs another point, and count it."""
        without = self._signs_of(pattern)
        seen = len(self._patterns), self._patterns[pattern], self._numbers_seen[without]
        if seen[0] >= _MOST_PATTERNS or seen[1] >= _BURNT or (self._steps and seen[2] >= _MOST_STEPS):
            return False
        self._patterns[pattern] += 1
        self._numbers_seen[without] += 1
        return True

    def _signs_of(self, pattern: bytes) -> bytes:
        """Return a branch combination without the integers of steps, which joint states ignore."""
        return pattern[8 * len(self._steps) :]

    def _decide_at(self, here: Point, pattern: bytes | None = None) -> Verdict | None:
        """Compare both sides at a point with 50 digits, and exactly in its cell."""
        point = {name: Fraction(value) for name, value in here.items()}
        world = self._world(point)
        worlds = iter((world, self._world(point)))
        if any(world.defined(root) is None for root in self._roots):
            return None
        if reals.differ(lambda: self._sides(next(worlds))):
            return None if self._is_edge(world) else Verdict(False, f"a point with {reals.DIGITS} digits", point=point)
        taken = {k: self._way(world, k) for k in self._units if world.memo.get(k) is not None}
        counting = {node for root in self._roots for node in counted(self.pool, root, taken)}
        if not all(self._is_clear(world, node) for node in counting):
            return None
        same = self._compared(taken)
        steps = {node for node in counting if self.pool.nodes[node][0] in STEPS}
        if same and steps and not self._compared({node: way for node, way in taken.items() if node not in steps}):
            same = None  # equal for these whole numbers; there are infinitely many others
        if same is False:
            if not any(self._is_thin(node, taken[node]) for node in counting):
                return Verdict(False, "both sides compared in the field, in the cell of a point", point=point)
            same = None
        state = frozenset((node, taken[node]) for node in counting if self.pool.nodes[node][0] not in STEPS)
        if pattern is not None:
            self._seen.add(pattern)
            self._cell[self._signs_of(pattern)] = state
        if same or self._is_told(state, here):
            ways = sorted(state)
            self._ways |= {*ways}
            self._pairs |= {*itertools.combinations(ways, 2)}
            self._states.add(state)
        return None

    def _is_told(self, state: State, here: Point) -> bool:
        """Record that both sides agree at a point of a joint state; return True if enough points agree."""
        inside = self._insides.setdefault(state, _Inside(here))
        inside.lines.add(self._line_number)
        inside.points += 1
        return self._is_enough(inside)

    def _is_enough(self, inside: _Inside) -> bool:
        return inside.points >= _TOLD and len(inside.lines) >= self._lines_wanted()

    def _lines_wanted(self) -> int:
        """Return the number of lines needed to decide a cell by points: at least two per name."""
        return max(_TOLD // _OF_A_LINE, min(2 * len(self._names), _MOST_LINES)) if self._names else 1

    def _look_inside(self) -> Verdict | None:
        """Compare joint states that the field cannot decide, along lines through their points.

        Every other line starts with a new value of one name. This leaves the cell, and lines along other names return
        to it.
        """
        if self._insides and not self._walked and (outcome := self._visit_centres()):
            return outcome
        while waiting := [state for state in self._insides if state not in self._walked]:
            state = waiting[0]
            self._walked.add(state)
            if outcome := self._along_inside(state):
                return outcome
        return None

    # Centres

    def _visit_centres(self) -> Verdict | None:
        """Visit the centres of possible narrow features, first one by one, then together.

        A bump such as exp(-s^2 (f - c)^2), or a difference of two steep slopes, is at a zero of f - c. Its operand
        may have an extremum there instead of a zero, such as an expanded square.
        """
        centres = self._centres()
        names = {k: self._names_of(k) for k in centres}
        before = self._turning, self._nodes
        self._turning = [*self._turning, *centres]
        self._nodes = reached(self.pool.nodes, [*self._nodes, *centres])
        starts = doubles.draw(self._names, self.sampler, 256, seed=13)
        start = _row(starts, int(np.argmin(np.max(np.abs([*starts.values()]), axis=0)))) if starts else {}
        outcome, here, moved = None, start, set[str]()
        for centre in centres:
            free = [name for name in names[centre] if name not in moved] or names[centre]
            for base in (start, here) if here is not start else (start,):
                there, name = self._centre(centre, base, free)
                if there is None or self._left < 0:
                    continue
                if outcome := self._decide_at(there) or self._around(there):
                    return outcome
                if base is here:
                    here, moved = there, moved | {name}
        self._turning, self._nodes = before
        return None

    def _around(self, here: Point) -> Verdict | None:
        """Visit the lines through a point."""
        lines = (self._line(here, name) for name in self._names)
        return next((outcome for outcome in map(self._visit, lines) if outcome), None)

    def _centre(self, node: int, base: Point, names: Sequence[str]) -> tuple[Point | None, str]:
        """Return a zero of a node on a line through a point, and the name along which the line runs."""
        for name in names:
            grid = self._grid(base, name)
            signs = self._sign_at(node, base, name, grid)[0]
            hits = np.nonzero(signs[1:] * signs[:-1] <= 0)[0]
            for k in map(int, hits[np.argsort(np.abs(grid[hits]))][:1]):
                signs = functools.partial(self._sign_at, node, base, name)
                place = self._cut_down(signs, np.zeros(1, dtype=int), grid[[k]], grid[[k + 1]])
                return {**base, name: float(place[0])}, name
        return None, ""

    def _sign_at(self, node: int, base: Point, name: str, values: Array) -> Array:
        """Return the sign of a node at places on a line, as a row."""
        nodes = reached(self.pool.nodes, [node])
        self._left -= len(values) * len(nodes)
        found = doubles.values(self.pool, nodes, self._along(base, name, values))[node]
        signs: Array = np.sign(np.broadcast_to(np.asarray(found, dtype=float), len(values)))[None]
        return signs

    def _names_of(self, node: int) -> list[str]:
        nodes = (self.pool.nodes[k] for k in reached(self.pool.nodes, [node]))
        return sorted({name for operation, name, *_ in nodes if operation == "sym"})

    def _centres(self) -> list[int]:
        """Return the nodes that are zero at the centre of a narrow feature; nodes of only one side come first."""
        first, second = ({*reached(self.pool.nodes, [root])} for root in self._roots)
        centres: dict[int, None] = {}
        for node in (*sorted(first ^ second), *sorted(first & second)):
            operation = self.pool.nodes[node][0]
            if operation in _NARROW or (operation == "pow" and not self._is_plain(node)):
                operand = self.pool.operands(node)[0]
                inner = reached(self.pool.nodes, [operand])
                centres |= dict.fromkeys(k for k in inner if self.pool.nodes[k][0] in ("add", "sym", "sin", "cos"))
                slopes = (slope(self.pool, operand, k) for k in inner if self.pool.nodes[k][0] == "sym")
                centres |= dict.fromkeys(k for k in slopes if k is not None and self.pool.constant(k) is None)
        return [k for k in centres if k not in self._atoms and self._names_of(k)][:_MOST_CENTRES]

    def _is_plain(self, node: int) -> bool:
        """Return True for a root or small power, which is not narrow."""
        exponent = self.pool.constant(self.pool.operands(node)[1])
        return exponent is not None and 0 < exponent <= _BROAD

    def _along_inside(self, state: State) -> Verdict | None:
        """Visit lines through points of a joint state until enough points agree; return a difference, if any."""
        inside = self._insides[state]
        for number in range(_MOST_INSIDE * self._lines_wanted()):
            if self._left < 0 or self._is_enough(inside):
                break
            base, name = inside.at, self._names[number % len(self._names)]
            if number // len(self._names) % 2:
                base = base | {
                    other: float(column[0])
                    for other, column in doubles.draw([self._draw.choice(self._names)], self.sampler, 1, number).items()
                }
            if outcome := self._visit(self._line(base, name, _INNER), state):
                return outcome
        return None

    def _sides(self, world: RealWorld) -> tuple[reals.Sized, reals.Sized] | None:
        """Return the values of both sides."""
        old, new = ((world.defined(root), root) for root in self._roots)
        if old[0] is None or new[0] is None:
            return None
        return (old[0], world.size(old[1])), (new[0], world.size(new[1]))

    def _way(self, world: RealWorld, node: int) -> int:
        operation, *operands = self.pool.nodes[node]
        if operation == "mod":
            a, b = (world.value(operand) for operand in operands)
            return reals.floor(a / b)
        if operation in STEPS or operation in COMPARISONS:
            return int(world.value(node))
        return world.ways[node]

    def _compared(self, taken: Mapping[int, int]) -> bool | None:
        """Return True if both sides are the same function for these branches; None if the field cannot decide."""
        forms = smooth(self.pool, self._roots[0], taken), smooth(self.pool, self._roots[1], taken)
        if forms not in self._forms:
            self._forms[forms] = self._same(*forms)
        return self._forms[forms]

    def _is_thin(self, node: int, way: int) -> bool:
        """Return True for a branch that is taken only on a surface, where different forms may have equal values."""
        return (self.pool.nodes[node][0], way) in (("equality", 1), ("unequality", 0))

    def _is_edge(self, world: RealWorld) -> bool:
        """Return True at a point on a step, where equal values do not prove equal equations."""
        steps = (k for k in self._units if self.pool.nodes[k][0] in _JUMPS and world.memo.get(k) is not None)
        cuts = (self.pool.operands(k)[0] for k in self._nodes if self.pool.nodes[k][0] == "atan2")
        edges = itertools.chain((atom for k in steps for atom in atoms(self.pool, k)), cuts)
        return any(world.defined(edge) == 0 for edge in edges)

    def _is_clear(self, world: RealWorld, node: int) -> bool:
        """Return True if rounding cannot change the branch of a node."""
        if self.pool.nodes[node][0] in STEPS:
            return self._is_between(world, node)
        if self._is_thin(node, int(bool(world.memo[node]))):
            return True
        for atom in atoms(self.pool, node):
            value = world.defined(atom)
            if value is None or abs(value) <= reals.real(_LIT) * 2 ** max(world.size(atom), 0):
                return False
        return True

    def _is_between(self, world: RealWorld, node: int) -> bool:
        """Return True if the operand of a rounding function is clearly not an integer."""
        operands = [world.value(operand) for operand in self.pool.operands(node)]
        whole = operands[0] / operands[1] if len(operands) == 2 else operands[0]
        return bool(abs(whole - reals.floor(whole + 0.5)) > reals.real(_LIT) * 2 ** max(world.size(node), 0))

    # Ways without a point

    def _missing(self) -> Verdict | None:
        """Search for branches and pairs of branches without a point, or prove them impossible."""
        ways = [way for node in self._units for way in ways_of(self.pool, node)]
        joint = itertools.combinations(sorted(ways), 2)
        wanted = [*((way,) for way in ways), *self._doubtful, *(pair for pair in joint if pair[0][0] != pair[1][0])]
        wanted = [state for state in wanted if not self._is_met(state) and not self._is_apart(state)]
        if len(wanted) > _MOST_MISSING:
            return self._undecided(wanted[0], f"of {len(wanted)} branches that no point reached ")
        outcomes = map(self._sought, wanted)
        return next((outcome for outcome in outcomes if outcome), None)

    def _joint(self) -> Verdict | None:
        """Compare both sides in all joint states whose branches occur in pairs; None if no reachable one differs.

        Outer nodes get their branches first, so that excluded nodes need none. If both sides are equal for all
        branches of the remaining nodes, these are not enumerated.
        """
        stack: list[dict[int, int]] = [{}]
        left = _MOST_JOINT
        while stack:
            taken = stack.pop()
            if self._are_equal(taken):
                continue
            left -= len(self._nodes)
            free = self._free(taken)
            if not free:
                if outcome := self._sought(tuple(sorted(taken.items()))):
                    return outcome
            elif left < 0:
                return self._undecided(
                    tuple(taken.items()), f"of too many combinations of branches of {len(self._units)} nodes "
                )
            else:
                ways = (way for way in ways_of(self.pool, max(free)) if self._goes_with(way, taken))
                stack += [{**taken, node: way} for node, way in ways]
        return None

    def _free(self, taken: Mapping[int, int]) -> set[int]:
        """Return the open branching nodes, except comparisons, that matter for given branches."""
        counting = (k for root in self._roots for k in counted(self.pool, root, taken) if ways_of(self.pool, k))
        return {k for k in counting if k not in taken and self.pool.nodes[k][0] not in COMPARISONS}

    def _are_equal(self, taken: Mapping[int, int]) -> bool:
        """Return True if both sides are equal for given branches, for all branches of other nodes."""
        return self._same(*(smooth(self.pool, root, taken) for root in self._roots)) is True

    def _goes_with(self, way: Way, taken: Mapping[int, int]) -> bool:
        """Return True if a branch occurred together with each of the others."""
        return way in self._ways and all(tuple(sorted((way, other))) in self._pairs for other in taken.items())

    def _sought(self, ways: tuple[Way, ...]) -> Verdict | None:
        """Search for a joint state in which both sides may differ; None if they are equal or it is impossible."""
        if self._is_met(ways) or self._is_out(ways):
            return None
        return self._look(ways) or (None if self._is_met(ways) else self._undecided(ways))

    def _is_apart(self, ways: tuple[Way, ...]) -> bool:
        """Return True if the branch of one node excludes or determines the other node."""
        return len(ways) == 2 and any(
            b[0] not in self._beside(a) or self._follows[a].get(b[0], b[1]) != b[1] for a, b in (ways, ways[::-1])
        )

    def _beside(self, way: Way) -> frozenset[int]:
        """Return the branching nodes that may matter together with a branch of a node."""
        if way not in self._company:
            self._follows[way] = implied(self.pool, way)
            counting = (counted(self.pool, root, self._follows[way]) for root in self._roots)
            self._company[way] = frozenset(itertools.chain(*counting))
        return self._company[way]

    def _is_met(self, ways: tuple[Way, ...]) -> bool:
        if 0 < len(ways) < 3:
            return {*ways} <= self._ways and (len(ways) < 2 or ways in self._pairs)
        return any(state.issuperset(ways) for state in self._states)

    def _is_out(self, ways: tuple[Way, ...], others: tuple[Way, ...] = ()) -> bool:
        """Return True if branches provably exclude each other for given branches of other nodes.

        A sum of case distinctions is examined case by case, because the sign of the sum proves little.
        """
        alternatives, taken = self._alternatives(ways, others), dict((*ways, *others))
        if alternatives is None:
            return False
        signs = [self._where(taken, alternative) for alternative in alternatives]
        possible = [required for required in signs if not self._are_out(required)]
        if not possible or len(others) == _MOST_CASES:
            return not possible
        cased = branching(self.pool, [node for required in possible for node, _ in required])
        node = next((k for k in cased if k not in taken and self.pool.nodes[k][0] in ("piecewise", "sign")), None)
        return node is not None and all(self._is_out(ways, (*others, way)) for way in ways_of(self.pool, node))

    def _are_out(self, required: tuple[Atom, ...]) -> bool:
        return self._is_impossible(required) or all(map(self._is_impossible, splits(self._split, required)))

    def _where(self, taken: Mapping[int, int], required: tuple[Atom, ...]) -> tuple[Atom, ...]:
        """Return the required signs of nodes, in their smooth forms for given branches."""
        return tuple(dict.fromkeys((smooth(self.pool, node, taken), sign) for node, sign in required))

    def _is_impossible(self, required: tuple[Atom, ...]) -> bool:
        """Return True if signs provably exclude each other."""
        if required not in self._impossible:
            self._impossible[required] = any(proof(self.pool, required, self._bounds) for proof in _PROOFS) or any(
                sign and self._never_has(node, sign) for node, sign in required
            )
        return self._impossible[required]

    def _alternatives(self, ways: tuple[Way, ...], others: tuple[Way, ...] = ()) -> list[tuple[Atom, ...]] | None:
        """Return the alternative conditions for nodes to matter and to take these branches."""
        product = every([*(requirements(self.pool, way) for way in (*ways, *others)), [self._inside]])
        for node in dict.fromkeys(node for node, _ in ways) if product else ():
            for needed in self._needs(node):
                product = every([product, needed]) or product
        return product

    def _needs(self, node: int) -> list[list[tuple[Atom, ...]] | None]:
        """Return the conditions for a node to matter, one entry per node whose branches can exclude it."""
        if node not in self._needed:
            choices = [(k, [way for way in ways_of(self.pool, k) if node in self._beside(way)]) for k in self._units]
            self._needed[node] = [
                either([requirements(self.pool, way) for way in open_])
                for k, open_ in choices
                if k != node and open_ and (len(open_) < len(ways_of(self.pool, k)) or self._may_lack(k))
            ]
        return self._needed[node]

    def _may_lack(self, node: int) -> bool:
        """Return True if a node may lack a value because no case applies."""
        last = self.pool.operands(node)[-1]
        return bool(
            self.pool.nodes[node][0] == "piecewise" and self.pool.nodes[self.pool.operands(last)[1]][0] != "const"
        )

    def _look(self, ways: tuple[Way, ...]) -> Verdict | None:
        """Search along straight lines for a point at which nodes have required branches."""
        possible = [
            required
            for alternative in self._alternatives(ways) or []
            for required in splits(self._split, alternative)
            if required and not self._is_impossible(required)
        ]
        if not possible:
            return None
        starts = doubles.draw(self._names, self.sampler, 1, seed=11)
        here = _row(starts, 0)
        for number in range(_TRIES):
            if self._left < 0 or self._is_met(ways):
                break
            name = self._names[number % len(self._names)]
            line = self._line(here, name)
            if outcome := self._visit(line):
                return outcome
            if not len(line[name]):
                continue
            score = self._score(possible[number // len(self._names) % len(possible)], line)
            best = np.nonzero(score == np.max(score))[0]
            here = _row(line, self._chosen(line, [*map(int, best)]))
        return self._look_inside()

    def _score(self, required: Sequence[Atom], line: Mapping[str, Array]) -> Array:
        """Count the fulfilled signs at points."""
        nodes = reached(self.pool.nodes, [node for node, _ in required])
        count = len(next(iter(line.values())))
        found = doubles.values(self.pool, nodes, line)
        right = (
            (np.sign(np.broadcast_to(np.asarray(found[node], dtype=float), count)) == sign).astype(float)
            for node, sign in required
        )
        score: Array = np.sum([*right], axis=0, dtype=float)
        return score

    # Words

    def _undecided(self, ways: tuple[Way, ...], before: str = "") -> Verdict:
        names = " with ".join(self._text(node) for node, _ in ways)
        state = "a branch of" if len(ways) == 1 else "a combination of branches of" if ways else "the expression"
        met = [inside.points for told, inside in self._insides.items() if told.issuperset(ways)]
        what = f"was compared at {sum(met)} points only" if met else "was neither reached nor excluded"
        where = " ".join(filter(None, (state, names)))
        return Verdict(None, f"equal at {self._points} points, but {before}{where} {what}")

    def _text(self, node: int) -> str:
        """Return the text of a branching expression, shortened."""
        text = Printer(self.pool.nodes).text(node)
        return text if len(text) <= _WIDEST else f"{text[:_WIDEST]}..."

    def _equal(self) -> Verdict:
        told = [inside for state, inside in self._insides.items() if state in self._states]
        if short := next((state for state in self._insides if state not in self._states), None):
            return self._undecided(tuple(sorted(short)))
        if told:
            return Verdict(True, self.points, points=min(inside.points for inside in told))
        return Verdict(
            True, f"{self.points}; each combination of branches with a possible difference was reached or excluded"
        )


def _row(columns: Mapping[str, Array], k: int) -> Point:
    """Return a single point of several."""
    return {name: float(column[k]) for name, column in columns.items()}
