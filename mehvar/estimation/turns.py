# SPDX-License-Identifier: Apache-2.0
"""Linear loops of a craft whose attitude is a quaternion, with small turns about the axes of the hub instead.

A quaternion has a spare direction. Where a craft turns, the linear loop of a moment mixes it with the attitude, which
feigns modes of the size of the rate times that of what is left of a transient. In axes of the hub, the loop of a craft
that turns steadily is constant.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mehvar.base.manifest import Manifest
from mehvar.runtime.model.functions import FloatArray
from mehvar.runtime.model.linear import LinearSystem

_QUATERNION, _RATE, _TURNS = ("q0", "q1", "q2", "q3"), ("wx", "wy", "wz"), ("turn_x", "turn_y", "turn_z")


def in_turns(manifest: Manifest, cut: LinearSystem, x: FloatArray) -> LinearSystem:
    """Return a loop with three small turns, rad, in place of the quaternion; a loop without one is returned as it is.

    Parameters
    ----------
    manifest : Manifest
        That of the model.
    cut : LinearSystem
        The closed loop, or as `mehvar.runtime.model.linear.ClosedLoop.cut` returns it.
    x : array
        State at which the loop is linear.
    """
    if manifest.parts.get("", {}).get("attitude") != "quaternion":
        return cut
    own = [cut.states.index(name) for name in _QUATERNION]
    q, rest = x[own], [k for k in range(len(cut.states)) if k not in own]
    rate = x[[cut.states.index(name) for name in _RATE]]
    slope = _slope(q)
    into, change = np.zeros((2, len(cut.states), len(rest) + 3))
    into[rest, range(len(rest))] = 1.0
    into[np.ix_(own, range(len(rest), len(rest) + 3))] = slope
    after = into.copy()
    if cut.period is None:
        change[np.ix_(own, range(len(rest), len(rest) + 3))] = _slope(slope @ rate)
    else:
        half = np.linalg.norm(rate) * cut.period / 2
        later = np.cos(half) * q + np.sinc(half / np.pi) * cut.period * (slope @ rate)  # a turn of twice the half
        after[np.ix_(own, range(len(rest), len(rest) + 3))] = _slope(later)
    back = after.T * np.where(np.arange(len(rest) + 3) < len(rest), 1.0, 4.0)[:, None]
    states = (*(cut.states[k] for k in rest), *_TURNS)
    return replace(cut, A=back @ (cut.A @ into - change), B=back @ cut.B, C=cut.C @ into, states=states)


def _slope(q: FloatArray) -> FloatArray:
    """Return the quaternion's derivative by a small turn; four times its transpose is its inverse."""
    a, b, c, d = q
    return np.array([[-b, -c, -d], [a, -d, c], [d, a, -b], [-c, b, a]]) / 2
