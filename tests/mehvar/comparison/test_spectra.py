# SPDX-License-Identifier: Apache-2.0
"""Eigenvalues of two versions: each differs beyond its own error."""

from types import SimpleNamespace

import numpy as np
import pytest

from mehvar.comparison.sides import Side
from mehvar.comparison.spectra import moved

TURN = np.linalg.qr(np.random.default_rng(1).normal(size=(5, 5)))[0]


def turned(blocks: np.ndarray) -> np.ndarray:
    return TURN @ blocks @ TURN.T


def test_a_slow_mode_that_becomes_unstable_beside_a_fast_one_is_shown() -> None:
    """A tolerance relative to the largest eigenvalue hid it."""
    old, new = (turned(np.diag([slow, -1.0, -2.0, -3.0, -1e3])) for slow in (-5e-3, 5e-3))
    ((one, other),) = moved(old, new)
    assert (one.real, other.real) == pytest.approx((-5e-3, 5e-3), rel=1e-8)


@pytest.mark.parametrize("size", [1, 2, 3])
def test_integrators_do_not_move(size: int) -> None:
    """Rounding splits the eigenvalue of a chain of integrators; other coordinates split it differently."""
    chain = np.zeros((5, 5))
    chain[range(size - 1), range(1, size)] = 1.0
    chain[range(size, 5), range(size, 5)] = np.arange(size, 5) - 7.0
    assert moved(chain, turned(chain)) == ()
    chain[4, 4] = -9.0
    ((one, other),) = moved(turned(chain), chain + np.diag([0, 0, 0, 0, 1.0]))
    assert (one.real, other.real) == pytest.approx((-9.0, -8.0))


def test_a_rounded_zero_is_zero() -> None:
    old, new = turned(np.diag([0.0, -1.0, -2.0, -3.0, -4.0])), turned(np.diag([0.5, -1.0, -2.0, -3.0, -4.0]))
    ((one, other),) = moved(old, new)
    assert one == 0
    assert other == pytest.approx(0.5)


def test_a_place_far_away_where_forces_vanish_is_no_equilibrium() -> None:
    """Newton's steps move away from a planet by half of the distance each."""

    class Falling(Side):
        """A point above a planet."""

        rates = staticmethod(lambda x: -1e9 / x**2)
        slope = staticmethod(lambda x: np.diag(2e9 / x**3))
        project = staticmethod(lambda x: x)

    assert Falling(SimpleNamespace(state=lambda: [10.0]), {}).rest() == 10.0
