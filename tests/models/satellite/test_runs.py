# SPDX-License-Identifier: Apache-2.0
"""The satellite through the runtime: what is refused, what is warned of, what is lost and when, what limits do."""

import warnings

import numpy as np
import pytest

from mehvar.runtime import InputError, load, simulate
from mehvar.runtime.model.model import Model
from mehvar.runtime.run.problem import Status
from tests.reference.scipy_loop import by_scipy

IGNORANT = {"delay": 1, "design_delay": 0, "applied_regressor": 0}


@pytest.fixture(scope="module")
def satellite() -> Model:
    return load("satellite")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"I_z": 6.0}, "are the inertias of no body"),
        ({"orbit_radius": 6.3e6}, "orbit_radius = 6.3e\\+06 m: an orbit inside the Earth"),
        ({"omega0": 1.3e-3}, "omega0 = 0.0013 rad/s: an orbit inside the Earth"),
        ({"Ts": 0.0}, r"Ts = 0.0.*must be in \(0, inf\) s"),
        ({"Ts": -0.5}, "Ts = -0.5"),
        ({"delay": 2}, r"delay = 2.0.*must be in \[0, 1\]"),
        ({"design_delay": 0.5}, "design_delay = 0.5 samples is not known: it must be 0 or 1"),
        ({"delay": -1}, "delay = -1"),
        ({"half_period": 0.3}, r"half_period = 0.3 s is not longer than a sample, Ts = 0.5 s"),
        ({"inclination": 98.0}, r"inclination = 98.0.*98 degrees are 1.71042 rad"),
        ({"initial": {"roll": float("nan")}}, "roll = nan"),
        ({"initial": {"pitch": 1.5}}, "outside the limits: lost \\(pitch\\)"),
        ({"real": "half"}, "real = 'half'"),
    ],
)
def test_bad_input_is_refused(satellite, options, message):
    with pytest.raises(InputError, match=message):
        simulate(satellite, "mrac", **options)


def test_a_gain_of_the_wrong_sign_is_warned_of_with_its_poles(satellite):
    with pytest.warns(UserWarning, match=r"Kp_x = -0.002 .* unstable: its poles are 0.0233.* and -0.0403.* rad/s"):
        simulate(satellite, "pd", Kp_x=-2e-3, t_end=10.0)
    with pytest.warns(UserWarning, match=r"Kd_z = -0.05 .* about z unstable"):
        simulate(satellite, "pd", Kd_z=-0.05, t_end=10.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        simulate(satellite, "pd", t_end=10.0)


@pytest.mark.parametrize(
    ("law", "scenario", "options", "time"),
    [
        ("mrac-literal", "paper", {"adapt": 0, "b_min": 1e-3, "b_min_ratio": 0}, 178.6),
        ("mrac-literal", "printed", {"delay": 1}, 34.5),
        ("mrac-literal", "printed", IGNORANT, 4.5),
        ("mrac", "paper", {"delay": 1, "rho": 0.001, "adapt": 0}, 184.2),  # between samples
    ],
)
def test_loops_that_are_lost_are_lost_in_time(satellite, law, scenario, options, time):
    run = simulate(satellite, law, scenario, **options)
    assert run.status is Status.LIMIT
    assert run.t_stop == pytest.approx(time, rel=0.02)


def test_a_law_that_ignores_the_delay_is_lost(satellite):
    """Its end runs through the singularity of the angles: 39.5 s here, 41 s in the published reproduction."""
    run = simulate(satellite, "mrac", **IGNORANT)
    assert run.status is Status.LIMIT
    assert run.t_stop == pytest.approx(41.0, rel=0.05)


def test_demand_beyond_the_wheels_is_limited_logged_and_seen_by_the_estimator(satellite):
    run = simulate(satellite, "mrac", matched=0, umax=0.1, hmax=0.5)
    assert run.status is Status.DONE
    assert np.abs(run.u_cmd).max() > 0.1
    assert np.abs(run.u).max() <= 0.1
    assert np.abs(run.x[:, 6:9]).max() <= 0.5 + 1e-12
    blind = simulate(satellite, "mrac", matched=0, umax=0.1, hmax=0.5, applied_regressor=0)
    names = [q.name for q in run.controller.memory]
    guess = names.index("b0_pitch")
    true = 0.5**2 / (2 * 3.04)
    assert abs(run.z[-1, guess] - true) < 0.01 * true
    assert abs(blind.z[200, guess] - true) > 5 * abs(run.z[200, guess] - true)


def test_noise_follows_its_seed_and_the_table_in_distribution(satellite):
    error = []
    for seed in range(4):
        run = simulate(satellite, "mrac", delay=1, noise=5e-5, umax=0.1, seed=seed)
        late = run.t >= 200
        series = run.variables()
        error.append([np.std((series[a] - series[f"ym_{a}"])[late]) for a in ("roll", "pitch", "yaw")])
    rms = np.degrees(np.mean(error, axis=0))
    np.testing.assert_allclose(rms, [0.0370, 0.0384, 0.1165], rtol=0.05)


@pytest.mark.soak
def test_double_c_and_scipy_agree_over_200_samples(satellite):
    for law in ("mrac", "pd"):
        for delay in (0, 1):
            compiled = simulate(satellite, law, delay=delay, t_end=100.0)
            with by_scipy():
                interpreted = simulate(satellite, law, delay=delay, t_end=100.0)
            np.testing.assert_allclose(compiled.x, interpreted.x, atol=1e-9)


def test_a_float_law_stays_within_a_hundredth_of_a_degree(satellite):
    wide, narrow = (simulate(satellite, "mrac", delay=1, real=real) for real in ("double", "float"))
    assert 0 < np.degrees(np.abs(wide.x[:, :3] - narrow.x[:, :3]).max()) < 0.01
