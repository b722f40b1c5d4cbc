# SPDX-License-Identifier: Apache-2.0
"""Second test of expressions found equal, at a hundred thousand points in double precision.

Double precision only finds candidates. Each is decided with 50 digits, so that rounding causes no difference.
"""

from __future__ import annotations

from collections.abc import Sequence

from ...equal.equality import EqualityTest
from ...equal.meaning import Expression
from ...equal.points import differ
from ...equal.reals import DIGITS
from ...equal.verdicts import Verdict
from ...equations.document import reached

POINTS = 100_000
"""Number of points. In a corpus of 281 pairs, 20 000 points found 9 of 15 wrong answers. Five times as many reach a
region of 1 in 30 000 with probability 0.96."""
_WORK = 400_000_000
"""Limit on node evaluations, about two seconds; expressions above 4000 nodes get fewer points."""
_LOOKS = 8
"""Number of points per pair that are examined with 50 digits. The largest differences come first, because rounding
changes less than terms do."""
_FEW = 16
"""Number of points with values on both sides from which agreement counts, as in `equality`."""
_SEED = 40_000


def check_in_double(
    equality: EqualityTest, pairs: Sequence[tuple[Expression, Expression]]
) -> tuple[dict[int, Verdict], int]:
    """Search for points at which expressions found equal differ.

    Parameters
    ----------
    equality : EqualityTest
        The test that found them equal.
    pairs : sequence of pair of Expression
        The expressions.

    Returns
    -------
    verdicts : dict
        Verdicts other than "equal", by the number of the pair.
    count : int
        Points at which every pair was evaluated.
    """
    from ...equal.doubles import suspects  # imports numpy, which comparing equal texts does not need

    flat = [(equality.written_out(old), equality.written_out(new)) for old, new in pairs]
    nodes = reached(equality.pool.nodes, [node for pair in flat for node in pair])
    count = min(POINTS, _WORK // max(len(nodes), 1))
    points, seen = suspects(equality.pool, flat, equality.sampler, count, _LOOKS, _SEED)
    verdicts = {}
    for number, (old, new) in enumerate(pairs):
        if any(differ(equality.real.at(point), old, new) for point in points.get(number, ())):
            verdicts[number] = Verdict(False, f"a point of {count} in double, checked with {DIGITS} digits")
        elif seen[number] < _FEW and equality.field.is_rooted(old, new):
            verdicts[number] = Verdict(None, f"equal in the field, but both sides exist at {seen[number]} real points")
    return verdicts, count
