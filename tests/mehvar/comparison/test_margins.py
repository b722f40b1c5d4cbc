# SPDX-License-Identifier: Apache-2.0
"""Gain margins against the eigenvalues of the closed loop, and against closed forms."""

import math

import numpy as np
import pytest

from mehvar.comparison.margins import margins
from mehvar.runtime.model.linear import LinearSystem


def loop(A, b, c, period=None):
    """A loop that was cut at its one input."""
    n = len(A)
    names = tuple(f"x{k}" for k in range(n))
    held = None if period is None else np.array(period)
    return LinearSystem(np.array(A, float), np.array(b, float).reshape(n, 1), np.array(c, float).reshape(1, n),
                        np.zeros((1, 1)), names, ("u",), ("y",), held)  # fmt: skip


def worst(A, b, c, factors, period):
    """Return the growth of the slowest mode of the loop with other gains; negative where it is stable."""
    eigenvalues = np.linalg.eigvals(np.asarray(A) + np.multiply.outer(factors, np.outer(b, c)))
    return eigenvalues.real.max(axis=-1) if period is None else np.abs(eigenvalues).max(axis=-1) - 1


FACTORS = np.geomspace(1, 1e4, 4001)


def nearest(A, b, c, period):
    """The nearest factor to one at which stability is lost, from a scan of eigenvalues."""
    limits = []
    for factors in (FACTORS, 1 / FACTORS):
        signs = worst(A, b, c, factors, period)
        limits += [factors[k] for k in range(1, len(signs)) if signs[k] > 0 > signs[k - 1]][:1]
    return min(limits, key=lambda factor: abs(math.log(factor)), default=math.inf)


@pytest.mark.parametrize("period", [None, 0.2])
@pytest.mark.parametrize("seed", range(60))
def test_the_gain_is_the_first_factor_that_makes_the_loop_unstable(seed, period):
    generator = np.random.default_rng(seed)
    n = generator.integers(1, 5)
    while True:
        A = generator.normal(size=(n, n)) * (1 if period is None else 0.7)
        b, c = generator.normal(size=n), generator.normal(size=n)
        if worst(A, b, c, 1.0, period) < -1e-3:
            break
    (margin,) = margins(loop(A, b, c, period))
    expected = nearest(A, b, c, period)
    if math.isfinite(expected):
        assert margin.gain == pytest.approx(expected, rel=0.01)
    else:
        assert not 1.1e-4 < margin.gain < 0.9e4


@pytest.mark.parametrize("J", [0.25, 2.0, 40.0])
def test_of_a_sampled_rigid_body_it_is_that_of_the_rate(J):
    """z = -1 at the factor 2 J/(kd Ts)."""
    T, kp, kd = 0.2, 0.1 * J, 2.0 * J / 4
    (margin,) = margins(loop([[1, T], [0, 1]], [T**2 / (2 * J), T / J], [-kp, -kd], T))
    assert margin.gain == pytest.approx(2 * J / (kd * T), rel=1e-9)


def test_a_loop_that_a_smaller_gain_loses_has_that_margin():
    (margin,) = margins(loop([[0, 1], [0.5, 0]], [0, 1], [-2, -2]))
    assert margin.gain == pytest.approx(0.25)


def test_a_rigid_body_under_pd_has_none():
    (margin,) = margins(loop([[0, 1], [0, 0]], [0, 1], [-2, -2]))
    assert margin.gain == math.inf
