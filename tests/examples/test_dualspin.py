# SPDX-License-Identifier: Apache-2.0
"""The dual-spin craft against its linear equations written by hand, and what damping must keep."""

from __future__ import annotations

import numpy as np
import pytest

import mehvar
from mehvar.physics.gates import TOLERANCE, balance, gates
from mehvar.physics.machine import Machine
from tests.examples import checks
from tests.examples.pages import lines, model_here

TIGHT = {"rtol": 1e-11, "atol": 1e-11}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return model_here("dualspin", tmp_path_factory.mktemp("dualspin"))


def by_hand(momentum=120.0):
    """Return the linear equations of wx, wy, the ball's place and speed about the despun state.

    H' + w x H = 0 with H = J w + h e_z - mu r z' e_y, and mu (z'' - r wy') + c z' + k z = 0, mu the reduced mass.
    """
    mu, r, k, c = 200.0 / 201.0, 0.6, 1.6, 0.4
    small = 1e-6  # the ball's own inertia
    mass = np.diag([80.0 + small, 85.0 + small + mu * r**2, 1.0, mu])
    mass[1, 3] = mass[3, 1] = -mu * r
    rest = np.zeros((4, 4))
    rest[0, 1], rest[1, 0], rest[2, 3], rest[3, 2], rest[3, 3] = -momentum, momentum, 1.0, -k, -c
    return np.linalg.solve(mass, rest)


def test_it_is_short():
    from tests.examples.pages import ROOT

    assert lines(ROOT / "docs" / "examples" / "models" / "dualspin") <= 40


def test_nutation_is_that_of_the_equations_by_hand(folder):
    model = mehvar.load(folder)
    names = [q.name for q in model.manifest.states]
    x = np.array([{"q0": 1.0, "rotor_speed": 10.0}.get(n, 0.0) for n in names])
    A, *_ = model.linearize(x, np.zeros(1), model.parameters())
    keep = [names.index(n) for n in ("wx", "wy", "ball_place", "ball_speed")]
    np.testing.assert_allclose(A[np.ix_(keep, keep)], by_hand(), rtol=1e-12, atol=1e-14)
    slow = max(np.linalg.eigvals(by_hand()), key=lambda v: v.real)
    assert slow.real < 0
    run = mehvar.simulate(folder, None, inputs={}, t_end=200.0, dt_out=0.5, wx_0=1e-5, **TIGHT)
    start = np.array([1e-5, 0, 0, 0])
    values, vectors = np.linalg.eig(by_hand())
    share = np.linalg.solve(vectors, start)
    expected = np.real((vectors[0] * share) @ np.exp(np.outer(values, run.t.values)))
    np.testing.assert_allclose(run.wx, expected, atol=1e-9)


def test_momentum_stays_and_energy_goes_to_the_damper(folder):
    machine = Machine(checks.system_of(folder), {})
    energy = balance("energy", lambda at: at.call("energy")[:, 0], lambda at: at.call("power")[:, 0])
    assert max(gates([energy], machine).values()) <= TOLERANCE
    run = mehvar.simulate(folder, None, inputs={}, **TIGHT)
    spin = np.hypot(run.wx, run.wy).values
    assert spin[-1] < 0.05 * spin[0]
