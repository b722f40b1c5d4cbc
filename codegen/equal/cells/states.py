# SPDX-License-Identifier: Apache-2.0
"""Joint states of the branching nodes of two expressions, and proofs that exclude them."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator, Mapping, Sequence

from ..branches import COMPARISONS, Atom, Way, counted, every, requirements, smooth, ways_of
from ..pool import Pool
from ..proofs.known import KnownSigns

State = tuple[Way, ...]
"""Sorted branches of the nodes that affect a value, without comparisons and steps."""
_MOST_COMPARED = 300_000
"""Limit on nodes of joint states that are compared in the field, about ten seconds. Half the limit allows one
rearranged saturation less.
"""


class JointStates:
    """Joint states of two expressions.

    Parameters
    ----------
    pool : Pool
        Pool of both expressions.
    roots : (int, int)
        Nodes of both expressions.
    known : KnownSigns
        Proofs about signs.
    inside : sequence of atoms
        Signs that hold if both have a value.
    """

    def __init__(self, pool: Pool, roots: tuple[int, int], known: KnownSigns, inside: Sequence[Atom]) -> None:
        self.pool = pool
        self.roots = roots
        self._known = known
        self._inside = tuple(inside)
        self._excluded = functools.cache(self.are_excluded)
        self._names = functools.cache(lambda node: pool.names(node).keys())

    def smooth(self, taken: Mapping[int, int]) -> tuple[int, int]:
        """Return the smooth forms of both sides for given branches."""
        return smooth(self.pool, self.roots[0], taken), smooth(self.pool, self.roots[1], taken)

    def counted(self, taken: Mapping[int, int]) -> set[int]:
        """Return the branching nodes that affect a value for given branches."""
        return counted(self.pool, self.roots[0], taken) | counted(self.pool, self.roots[1], taken)

    def open(self, are_equal: Callable[[int, int], bool]) -> Iterator[State | None]:
        """Yield the joint states that are neither equal in the field nor impossible; last None if there are too many.

        Outer nodes get their branches first, so that nodes without effect need none. If both sides are equal for all
        branches of the remaining nodes, these are not enumerated.

        Parameters
        ----------
        are_equal : callable
            True if the field proves that two smooth expressions are equal.
        """
        size = len(self.pool.reached(*self.roots))
        left = _MOST_COMPARED
        stack: list[dict[int, int]] = [{}]
        while stack:
            taken = stack.pop()
            left -= size
            if left < 0:
                yield None
                return
            if are_equal(*self.smooth(taken)):
                continue
            state = tuple(sorted(taken.items()))
            if free := self._free(taken):
                ways = ways_of(self.pool, max(free))
                stack += [taken | dict([way]) for way in ways if not self._is_excluded_beside(way, state)]
            elif not self.are_excluded(state):
                yield state

    def possible(self, state: State) -> list[tuple[Atom, ...]]:
        """Return the alternative signs of nodes in a joint state, without those that are impossible."""
        return [
            required
            for alternative in self._alternatives(state) or []
            for required in self._known.parts.splits(alternative)
            if required and not self._known.are_impossible(required)
        ]

    def are_excluded(self, ways: Sequence[Way]) -> bool:
        """Return True if branches provably exclude each other."""
        alternatives, taken = self._alternatives(ways), dict(ways)
        return alternatives is not None and all(
            self._known.exclude(tuple(dict.fromkeys((smooth(self.pool, node, taken), sign) for node, sign in required)))
            for required in alternatives
        )

    def _is_excluded_beside(self, way: Way, others: State) -> bool:
        """Return True if a branch is impossible, alone or with one of the others that has a name in common."""
        pairs = (tuple(sorted((way, other))) for other in others if self._names(way[0]) & self._names(other[0]))
        return any(map(self._excluded, ((way,), *pairs)))

    def _free(self, taken: Mapping[int, int]) -> set[int]:
        """Return the open branching nodes, except comparisons, that matter for given branches."""
        counting = (k for k in self.counted(taken) if ways_of(self.pool, k))
        return {k for k in counting if k not in taken and self.pool.nodes[k][0] not in COMPARISONS}

    def _alternatives(self, ways: Sequence[Way]) -> list[tuple[Atom, ...]] | None:
        """Return the alternative conditions for branches."""
        return every([*(requirements(self.pool, way) for way in ways), [self._inside]])
