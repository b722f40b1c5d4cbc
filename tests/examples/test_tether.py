# SPDX-License-Identifier: Apache-2.0
"""The tether against Kepler's equation, the linear libration, and its equation over the true anomaly."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, fsolve

import mehvar
from mehvar.physics.gates import balance, gates
from mehvar.physics.machine import Machine
from tests.examples import checks
from tests.examples.pages import lines, model_here

pytestmark = pytest.mark.soak  # an example of an implicit form and an orbit

MU, A = 3.986004418e14, 7.0e6
MEAN = np.sqrt(MU / A**3)
FREE = {"rtol": 1e-11, "atol": 1e-11}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return model_here("tether", tmp_path_factory.mktemp("tether"))


def anomaly(t, e):
    """The true anomaly by Kepler's equation."""
    eccentric = brentq(lambda E: E - e * np.sin(E) - MEAN * t, -1, MEAN * t + 1, xtol=1e-14)
    turns = 2 * np.pi * np.round(eccentric / (2 * np.pi))
    return turns + 2 * np.arctan2(np.sqrt(1 + e) * np.sin(eccentric / 2 - turns / 2),
                                  np.sqrt(1 - e) * np.cos(eccentric / 2 - turns / 2))  # fmt: skip


def libration(nu, x, e):
    """(1 + e cos nu) theta'' - 2 e sin nu theta' + 3 sin theta cos theta = 2 e sin nu, primes by the true anomaly."""
    theta, slope = x
    return [slope, (2 * e * np.sin(nu) * (1 + slope) - 3 * np.sin(theta) * np.cos(theta)) / (1 + e * np.cos(nu))]


def swung(x, e, *nu):
    return solve_ivp(libration, (0, nu[-1]), x, "DOP853", t_eval=nu, args=(e,), rtol=1e-12, atol=1e-13).y


def rate_at_perigee(e):
    return MEAN * np.sqrt((1 + e) / (1 - e) ** 3)


def test_the_orbit_is_keplers(folder):
    run = mehvar.simulate(folder, "damp", parameters={"gain": 0.0, "ecc": 0.3}, **FREE)
    np.testing.assert_allclose(run.nu, [anomaly(t, 0.3) for t in run.t.values], atol=1e-8)


def test_small_librations_of_a_circular_orbit_have_root_three_of_its_rate(folder):
    """To ten times the tolerance, for samples lie between steps."""
    run = mehvar.simulate(folder, "damp", parameters={"gain": 0.0, "ecc": 0.0, "theta_0": 1e-4}, **FREE)
    np.testing.assert_allclose(run.theta, 1e-4 * np.cos(np.sqrt(3) * MEAN * run.t.values), atol=1e-10)


def test_large_librations_over_the_true_anomaly(folder):
    run = mehvar.simulate(folder, "damp", parameters={"gain": 0.0, "theta_0": 0.6}, **FREE)
    np.testing.assert_allclose(run.theta[1:], swung([0.6, 0.0], 0.1, *run.nu.values[1:])[0], atol=2e-8)


def test_the_periodic_libration_comes_again(folder):
    """Found by shooting over an orbit; for small e it is e sin(nu)."""
    for e in (0.001, 0.1):
        x = fsolve(lambda x, e=e: swung(x, e, 2 * np.pi)[:, -1] - x, [0.0, e], xtol=1e-13)
        if e < 0.01:
            np.testing.assert_allclose(x, [0.0, e], atol=4 * e**2)
        start = {"gain": 0.0, "ecc": e, "theta_0": x[0], "turn_0": x[1] * rate_at_perigee(e)}
        orbit = 2 * np.pi / MEAN
        run = mehvar.simulate(folder, "damp", parameters=start, t_end=orbit, dt_out=orbit / 100, **FREE)
        assert abs(run.theta[-1] - run.theta[0]) < 1e-8 < np.ptp(run.theta.values)


def test_the_law_damps_what_the_orbit_does_not_force(folder):
    run = mehvar.simulate(folder, "damp", parameters={"ecc": 0.0}, t_end=90000.0)
    assert np.abs(run.theta[-200:]).max() < 0.1 * np.abs(run.theta[:200]).max()


def test_gates(folder):
    system = checks.system_of(folder)
    still = {"tau": (0.0, 0.0), "ecc": (0.0, 0.0)}
    ranges = {"mu": (0.5, 2), "a": (0.5, 2), "l": (0.5, 2), "m_1": (0.5, 2), "m_2": (0.5, 2)}

    def swing(at):
        """Half the square of the rate against the orbit, and the tide's potential, constant in a circle."""
        mean = np.sqrt(at["mu"] / at["a"] ** 3)
        return (at["spin"] - mean) ** 2 / 2 + 1.5 * mean**2 * np.sin(at["theta"]) ** 2

    constant = balance("libration in a circle keeps its energy", swing, lambda at: np.zeros(12))
    assert max(gates([constant], Machine(system, ranges | still)).values()) < 1e-9
    wrong = gates([constant], Machine(system, ranges | still | {"ecc": (0.1, 0.1)}))
    assert min(wrong.values()) > 1e-3


def test_the_rest(folder, tmp_path):
    checks.backends_agree(folder, "damp", "theta", 1e-6)
    checks.runs_repeat(folder, ("damp", "sampled"), {"ecc": "uniform(0, 0.3)", "l": "normal(2000, 50)"}, tmp_path)
    checks.diff_tells(folder, "[radius**2, 0, 0]", "[radius**2 / 2, 0, 0]", "mass_nu_nu")
    checks.board_agrees(folder, "sampled")
    assert lines(Path(__file__).parent / "models" / "tether") <= 80
