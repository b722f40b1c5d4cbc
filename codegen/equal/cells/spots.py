# SPDX-License-Identifier: Apache-2.0
"""Comparison of two expressions at one point with 50 digits, and exactly in the cell of the point."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from .. import reals
from ..branches import COMPARISONS, STEPS, atoms
from ..meaning import Meaning
from ..points import RealPoints, differ
from ..reals import RealWorld
from ..verdicts import Verdict
from .conditions import Conditions
from .lines import Spot
from .states import JointStates, State

_JUMPS = COMPARISONS - {"equality", "unequality"} | {"sign"}
_LIT = Fraction(1, 10**30)
"""Relative size above which a sign counts: 30 of 50 digits. The square of a window of 1e-9 needs 18 digits. An
inverse sine or cosine near one keeps half of the 90 computed digits.
"""


@dataclass(frozen=True)
class Cell:
    """The cell of a point.

    Attributes
    ----------
    state : State
        Joint state of the cell.
    is_equal : bool
        True if both sides are the same function there; False if only points can decide.
    """

    state: State
    is_equal: bool


class SpotTest:
    """Comparison at points.

    Parameters
    ----------
    conditions : Conditions
        Conditions of both expressions.
    states : JointStates
        Their joint states.
    real : RealPoints
        Real points.
    free : Meaning
        Meaning in which all names are free.
    same : callable
        Compares two smooth expressions: True, False, or None if only real points can decide.
    """

    def __init__(
        self,
        conditions: Conditions,
        states: JointStates,
        real: RealPoints,
        free: Meaning,
        same: Callable[[int, int], bool | None],
    ) -> None:
        self.pool = conditions.pool
        self._conditions = conditions
        self._states = states
        self._real = real
        self._free = free
        self._same = same
        self._forms: dict[tuple[int, int], bool | None] = {}

    def __call__(self, spot: Spot) -> Verdict | Cell | None:
        """Return "different" or the cell of a point; None if a side has no value or a sign is unclear."""
        point = {name: Fraction(value) for name, value in spot.items()}
        worlds = self._real.at(point)
        world = worlds[self._free]
        if any(world.defined(root) is None for root in self._conditions.roots):
            return None
        if differ(worlds, *((self._free, root) for root in self._conditions.roots)):
            return None if self._is_edge(world) else Verdict(False, f"a point with {reals.DIGITS} digits", point=point)
        taken = {k: self._way(world, k) for k in self._conditions.units if world.memo.get(k) is not None}
        counting = self._states.counted(taken)
        if not all(self._is_clear(world, node) for node in counting):
            return None
        same = self._compared(taken, counting)
        if same is False and not any(self._is_thin(node, taken[node]) for node in counting):
            return Verdict(False, "both sides compared in the field, in the cell of a point", point=point)
        state = tuple(sorted((node, taken[node]) for node in counting if self.pool.nodes[node][0] not in STEPS))
        return Cell(state, same is True)

    def _compared(self, taken: Mapping[int, int], counting: set[int]) -> bool | None:
        """Compare both sides in a cell, and for all whole numbers in place of those of steps."""
        same = self._in_field(taken)
        steps = {node for node in counting if self.pool.nodes[node][0] in STEPS}
        if same and steps and not self._in_field({node: way for node, way in taken.items() if node not in steps}):
            return None
        return same

    def _in_field(self, taken: Mapping[int, int]) -> bool | None:
        forms = self._states.smooth(taken)
        if forms not in self._forms:
            self._forms[forms] = self._same(*forms)
        return self._forms[forms]

    def _way(self, world: RealWorld, node: int) -> int:
        """Return the branch of a node, or the whole number of a step."""
        operation, *operands = self.pool.nodes[node]
        if operation == "mod":
            a, b = (world.value(operand) for operand in operands)
            return reals.floor(a / b)
        if operation in STEPS or operation in COMPARISONS:
            return int(world.value(node))
        return world.ways[node]

    def _is_edge(self, world: RealWorld) -> bool:
        """Return True at a point on a step, where different values do not prove different equations."""
        nodes = self.pool.nodes
        jumps = (k for k in self._conditions.units if nodes[k][0] in _JUMPS and world.memo.get(k) is not None)
        cuts = [self.pool.operands(k)[0] for k in self._conditions.nodes if nodes[k][0] == "atan2"]
        return any(world.defined(edge) == 0 for edge in (*cuts, *(atom for k in jumps for atom in atoms(self.pool, k))))

    def _is_clear(self, world: RealWorld, node: int) -> bool:
        """Return True if rounding cannot change the branch of a node."""
        if self.pool.nodes[node][0] in STEPS:
            return self._is_between(world, node)
        if self._is_thin(node, int(bool(world.memo[node]))):
            return True
        values = ((world.defined(atom), atom) for atom in atoms(self.pool, node))
        return all(value is not None and abs(value) > self._rounding(world, atom) for value, atom in values)

    def _is_between(self, world: RealWorld, node: int) -> bool:
        """Return True if the operand of a rounding function is clearly not a whole number."""
        operands = [world.value(operand) for operand in self.pool.operands(node)]
        whole = operands[0] / operands[1] if len(operands) == 2 else operands[0]
        return bool(abs(whole - reals.floor(whole + 0.5)) > self._rounding(world, node))

    def _rounding(self, world: RealWorld, node: int) -> Any:
        return reals.real(_LIT) * 2 ** max(world.size(node), 0)

    def _is_thin(self, node: int, way: int) -> bool:
        """Return True for a branch that is taken only on a surface, where different forms may have equal values."""
        return (self.pool.nodes[node][0], way) in (("equality", 1), ("unequality", 0))
