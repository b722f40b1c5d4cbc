# SPDX-License-Identifier: Apache-2.0
"""A sigma-point filter of a pendulum against one in NumPy, against its own statistics, and where lines mislead."""

import numpy as np
import pytest

import mehvar
from mehvar import estimated
from mehvar.base.errors import MehvarError
from mehvar.runtime.run.noise import normals

from .swing import (
    DEVIATION,
    KD,
    KP,
    MEAN,
    SIGMA,
    SIGMA_G,
    START,
    TS,
    WALK,
    has_the_bits_on_a_board,
    is_consistent,
    is_of_the_textbook,
    moved,
    swing,
)

N = 3


@pytest.fixture(scope="module")
def model():
    return mehvar.build(estimated(swing(), "pd", START, kind="sigma-point"))


def root(P):
    """Return an upper triangular factor of P, from the last state to the first."""
    return np.linalg.cholesky(P[::-1, ::-1])[::-1, ::-1]


def points(x, P):
    columns = np.sqrt(N) * root(P)
    return np.concatenate([x + columns.T, x - columns.T])


def by_hand(run):
    """Return estimate and covariance before each sample: points of the cubature rule, whole covariance."""
    e = normals(0, 0, run.sizes["t"], 2) * [SIGMA, SIGMA_G]
    x, P = np.array(MEAN, dtype=float), np.diag(np.square(DEVIATION))
    for k, (angle, speed) in enumerate(zip(run["angle"].values, run["rate"].values, strict=True)):
        yield x, P
        measurements = (np.sin(angle) + e[k, 0], speed + e[k, 1])
        for y, sigma, seen in zip(
            measurements, (SIGMA, SIGMA_G), (lambda q: np.sin(q[0]), lambda q: q[1]), strict=True
        ):
            cloud = points(x, P)
            values = np.array([seen(q) for q in cloud])
            S = values.var() + sigma**2
            gain = (cloud - x).T @ (values - values.mean()) / (2 * N) / S
            x, P = x + gain * (y - values.mean()), P - np.outer(gain, gain) * S
        u = -KP * x[0] - KD * x[1]
        cloud = np.array([moved(q, u) for q in points(x, P)])
        x, off = cloud.mean(axis=0), cloud - cloud.mean(axis=0)
        P = off.T @ off / (2 * N) + np.diag([0, 0, WALK**2 * TS])


def test_it_is_the_filter_of_the_textbook(model):
    run = mehvar.simulate(model, "pd", t_end=10.0, initial={"drag": 0.3})
    is_of_the_textbook(run, by_hand(run), 1e-10, 1e-5)


def test_a_board_computes_the_same_bits(model):
    has_the_bits_on_a_board(model)


@pytest.mark.parametrize("n", [200, pytest.param(10_000, marks=pytest.mark.soak)])
def test_errors_and_innovations_are_as_large_as_it_says(model, n):
    is_consistent(model, n)


def test_points_see_a_bend_that_slopes_do_not():
    """At the top of a sine a line has no slope: the measurement surprises one filter, and not the other."""
    wide = {**START, "angle": (np.pi / 2, 0.3)}
    drawn = {name: f"normal({m}, {d})" for name, (m, d) in wide.items()}
    nis = []
    for kind in ("sigma-point", "extended"):
        model = mehvar.build(estimated(swing(), "pd", wide, kind=kind))
        runs = mehvar.batch(model, "pd", 1000, vary=drawn, t_end=2 * TS, save=TS)
        nis.append(float(runs["est_nis"].values[:, 1].mean()))
    assert nis[0] == pytest.approx(2.0, rel=0.2)
    assert nis[1] > 5.0


def test_another_kind_is_refused():
    with pytest.raises(MehvarError, match="kind = 'unscented': must be 'extended' or 'sigma-point'"):
        estimated(swing(), "pd", START, kind="unscented")
