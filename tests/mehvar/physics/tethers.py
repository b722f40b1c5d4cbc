# SPDX-License-Identifier: Apache-2.0
"""Physics of tethers on reels: tension, stored and lost energy, and a spin that keeps them taut."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mehvar.physics.gates import Gate, balance, identity, never_rises
from mehvar.physics.machine import Array, Points
from tests.mehvar.physics import triangle

_INPUTS = ("reel1", "reel2", "reel3", *(f"f{i}{axis}" for i in (1, 2, 3) for axis in "xy"))


def gates(begun: Callable[[Points], Points]) -> list[Gate]:
    """Return what holds beside Newton's law; `begun` moves points to the start of their scenario."""

    def steady(at: Points) -> Points:
        """Return a start without slack, gravity or motion in shape."""
        still = {f"u_l{k}_0": 0.0 for k in (1, 2, 3)} | dict.fromkeys(_INPUTS, 0.0)
        return begun(at.moved(slack_0=0.0, mean_motion=0.0, **still))

    def slack(at: Points) -> Array:
        return begun(at).vector(*_OUT) - begun(at.moved(slack_0=0.0)).vector(*_OUT)

    def spun(at: Points) -> Array:
        return np.asarray(at["spin"] * triangle.inertia(at, triangle.placed(at, *at.call("reference")[:, :4].T)))

    return [
        identity("tensions", lambda at: at.result("outputs", "T1", "T2", "T3"), tensions),
        balance("elastic energy", lambda at: at.result("energy", "elastic"), _stored),
        never_rises("energy with reels at rest", _energy, _coasting),
        identity("reels", lambda at: at.result("rhs", *_OUT, "u_s1", "u_s2", "u_s3"), _reels),
        identity("the start is a steady spin", lambda at: steady(at).result("rhs", *_STEADY), _zero),
        identity(
            "reels begin at rest", lambda at: begun(at).vector("u_s1", "u_s2", "u_s3"), lambda at: _zero(at)[:, :3]
        ),
        identity("slack at the start", slack, lambda at: at.vector("slack_0", "slack_0", "slack_0")),
        identity("momentum of the target", lambda at: at.call("reference")[:, 4], spun),
    ]


_OUT = ("s1", "s2", "s3")
_STEADY = ("u_l1", "u_l2", "u_l3", "H")


def _strain(at: Points) -> Array:
    return at.vector("l1", "l2", "l3") / at.vector(*_OUT) - 1


def leaving(at: Points) -> Array:
    """Return the rates at which stretched tether leaves the reels."""
    return (1 + _strain(at)) * at.vector("u_s1", "u_s2", "u_s3")


def tensions(at: Points) -> Array:
    """Return what tethers pull with, by strain and by what the length changes beside what leaves the reels."""
    rate = at.vector("u_l1", "u_l2", "u_l3") - leaving(at)
    return np.maximum(0, at["stiffness"][:, None] * _strain(at) + at["damping"][:, None] * rate)


def _stored(at: Points) -> Array:
    """Return the rate of k (l - s)^2/(2 s) of what is longer than s, by chain rule in l and s."""
    e = np.maximum(0, _strain(at))
    rate = e * at.vector("u_l1", "u_l2", "u_l3") - (e + e**2 / 2) * at.vector("u_s1", "u_s2", "u_s3")
    return np.asarray(at["stiffness"] * rate.sum(axis=1))


def _energy(at: Points) -> Array:
    return at.result("energy", "kinetic", "elastic").sum(axis=1)


def _coasting(at: Points) -> Points:
    reels = dict.fromkeys((*_INPUTS, "u_s1", "u_s2", "u_s3"), 0.0)
    return at.moved(mean_motion=0.0, **reels)


def _reels(at: Points) -> Array:
    turning = at.vector("u_s1", "u_s2", "u_s3")
    return np.hstack([turning, at["k_r"][:, None] * (at.vector("reel1", "reel2", "reel3") - turning)])


def _zero(at: Points) -> Array:
    return np.zeros((len(at["H"]), 4))
