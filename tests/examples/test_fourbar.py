# SPDX-License-Identifier: Apache-2.0
"""The four-bar linkage against Freudenstein's equation and a model in the crank's angle alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import mehvar
from mehvar.physics.gates import balance, derived_equations, gates
from mehvar.physics.machine import Machine, Points
from tests.examples import checks
from tests.examples.pages import lines, model_here

pytestmark = pytest.mark.soak  # an example of an implicit form: tests/models/test_implicit.py has others

A, B, C, D = 0.3, 0.9, 0.7, 1.0
MASSES, G = (0.5, 1.5, 1.2), 9.81


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return model_here("fourbar", tmp_path_factory.mktemp("fourbar"))


def rocker(crank):
    """Freudenstein's equation, K1 cos psi - K2 cos phi + K3 = cos(phi - psi), solved for psi by half angles."""
    k1, k2, k3 = D / A, D / C, (A**2 - B**2 + C**2 + D**2) / (2 * A * C)
    sine, cosine, rest = np.sin(crank), np.cos(crank) - k1, k2 * np.cos(crank) - k3
    # sin(psi) sine + cos(psi) cosine + rest = 0; of its two solutions the open linkage
    return np.arctan2(sine, cosine) - np.arccos(-rest / np.hypot(sine, cosine))


def coupler(crank):
    psi = rocker(crank)
    return np.arctan2(C * np.sin(psi) - A * np.sin(crank), D + C * np.cos(psi) - A * np.cos(crank))


def unwrapped(angle):
    return (angle + np.pi) % (2 * np.pi) - np.pi


def energies(crank):
    """Half the inertia that the crank feels, and the potential energy, from points of the bars and their velocities."""
    step = 1e-5

    def middles(phi):
        psi, tip = rocker(phi), A * np.exp(1j * phi)
        return np.array([tip / 2, tip + B / 2 * np.exp(1j * coupler(phi)), D + C / 2 * np.exp(1j * psi)])

    def slope(function):
        return (8 * (function(crank + step) - function(crank - step))
                - function(crank + 2 * step) + function(crank - 2 * step)) / (12 * step)  # fmt: skip

    turns = [1.0, slope(lambda phi: np.unwrap([coupler(crank), coupler(phi)])[1]),
             slope(lambda phi: np.unwrap([rocker(crank), rocker(phi)])[1])]  # fmt: skip
    speeds = np.abs(slope(middles)) ** 2
    half = sum(m * (v + length**2 * w**2 / 12) / 2
               for m, v, length, w in zip(MASSES, speeds, (A, B, C), turns, strict=True))  # fmt: skip
    return half, sum(m * G * z.imag for m, z in zip(MASSES, middles(crank), strict=True))


def test_the_loop_stays_closed_and_keeps_to_freudenstein(folder):
    run = mehvar.simulate(folder, "drive", rtol=1e-9, atol=1e-9)
    assert float(run.open) < 1e-14
    assert run.phi_1[-1] > 2 * np.pi  # more than a turn
    assert np.abs(unwrapped(run.phi_3.values - rocker(run.phi_1.values))).max() < 1e-12
    assert np.abs(unwrapped(run.phi_2.values - coupler(run.phi_1.values))).max() < 1e-12


def test_another_length_is_another_manifold(folder):
    run = mehvar.simulate(folder, "drive", parameters={"l_2": 0.95})
    assert float(run.open) < 1e-14
    assert np.abs(unwrapped(run.phi_3.values - rocker(run.phi_1.values))).max() > 1e-2


def test_the_motion_of_the_crank_alone(folder):
    """J(phi) phi'' + J' phi'^2/2 + V' = tau."""

    def rate(_, x):
        step = 1e-4
        (low, v_low), (half, _), (high, v_high) = (energies(x[0] + k * step) for k in (-1, 0, 1))
        torque = 2.0 * (6.0 - x[1])
        return [x[1], (torque - (high - low) / (2 * step) * x[1] ** 2 - (v_high - v_low) / (2 * step)) / (2 * half)]

    run = mehvar.simulate(folder, "drive", t_end=0.6, rtol=1e-10, atol=1e-10)  # more than half a turn
    end = solve_ivp(rate, (0, 0.6), [1.0, 6.0], "DOP853", rtol=1e-9, atol=1e-9).y[:, -1]
    np.testing.assert_allclose([run.phi_1[-1], run.w_1[-1]], end, atol=2e-6)


def test_energy_stays_without_a_torque(folder):
    model = mehvar.load(folder)
    run = mehvar.simulate(folder, "drive", parameters={"gain": 0.0}, rtol=1e-10, atol=1e-10)
    x = np.stack([run[name].values for name in model.state_names], axis=1)
    energy = model.functions["energy"](x, model.parameters())
    assert np.ptp(energy) < 1e-8 * np.ptp(run.w_1.values) ** 2


def test_gates(folder):
    system = checks.system_of(folder)

    def energy(at: Points):
        return at.call("energy")

    def closed(at: Points):
        for _ in range(6):  # of Newton's method
            at = at.at(x=at.call("project"))
        return at

    power = balance("energy changes by the torque's power", energy, lambda at: at["tau"] * at["w_1"], where=closed)
    loop = balance("the loop stays closed", lambda at: at.call("outputs"), lambda at: np.zeros((12, 2)), where=closed)
    declared = [power, loop, derived_equations()]
    ranges = {"phi_1": (0.8, 1.2), "phi_2": (0.5, 0.7), "phi_3": (1.2, 1.5)}
    errors = gates(declared, Machine(system, ranges))
    assert max(errors.values()) < 1e-9
    assert errors.keys() == {gate.name for gate in declared}


@pytest.mark.soak
def test_the_rest(folder, tmp_path):
    checks.backends_agree(folder, "drive", "phi_1", 1e-8)
    checks.runs_repeat(folder, ("drive", "sampled"), {"l_2": "uniform(0.88, 0.95)", "w_0": "normal(6, 0.1)"}, tmp_path)
    checks.diff_tells(folder, "mass[6:, 3:6] = G.T, G", "mass[6:, 3:6] = 2 * G.T, 2 * G", "mass_w_1_S_x")
    checks.board_agrees(folder, "sampled")
    mehvar.export_fmu(folder, tmp_path / "fourbar.fmu", controller="drive")
    assert lines(Path(__file__).parent / "models" / "fourbar") <= 80
