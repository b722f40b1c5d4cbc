# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from tests.reference import cartesian_triangle as cartesian
from tests.reference import reference_triangle as reference
from tests.reference.reference_triangle import Path, Sliding

MASSES = [(1.0, 1.0, 1.0), (1.0, 2.0, 3.5), (5.0, 0.4, 1.3)]
LAWS: dict[str, reference.ErrorRate] = {"sliding": Sliding(), "path": Path(), "fast": Path(k=5.0)}
TABLE = {  # T_theta, T_rho, T_len, max |u|, rod travel, max rho, flips, min l, max l
    ("A", "sliding", 35.0): (14.67, 20.95, 22.59, 0.3165, 2.700, 0.5518, 20, 0.1184, 0.5066),
    ("A", "path", 35.0): (19.24, 21.20, 21.84, 0.1536, 2.292, 0.6500, 8, 0.0541, 0.5294),
    ("A", "fast", 15.0): (1.926, 2.120, 8.118, 1.151, 1.784, 0.6500, 11, 0.0396, 0.4998),
    ("B", "sliding", 35.0): (13.39, 19.62, np.inf, 0.2547, 2.533, 0.5077, 19, 0.1158, 0.5154),
    ("B", "path", 35.0): (13.03, 16.81, 18.13, 0.1374, 1.933, 0.6500, 7, 0.0429, 0.5609),
}


@pytest.mark.parametrize("masses", MASSES)
def test_base_triangle_has_isotropic_inertia(masses: tuple[float, ...]) -> None:
    x = cartesian.base_triangle(masses)
    m = np.array(masses)
    np.testing.assert_allclose(m @ x, 0, atol=1e-14)
    np.testing.assert_allclose(x.T * m @ x, m.mean() / 2 * np.eye(2), atol=1e-14)
    edge = x[1] - x[0]
    assert edge[0] > 0
    assert edge[1] == pytest.approx(0, abs=1e-14)
    assert x[2, 1] > x[0, 1]


@pytest.mark.parametrize("masses", MASSES)
def test_place_has_the_lengths_and_the_attitude(masses: tuple[float, ...]) -> None:
    X = cartesian.place(0.3, 0.4, 0.5, -2.0, masses)
    np.testing.assert_allclose(cartesian.rods(X), [0.3, 0.4, 0.5], rtol=1e-13)
    assert float(cartesian.attitude(X, masses)) == pytest.approx(-2.0, abs=1e-13)


@pytest.mark.parametrize("masses", MASSES)
@pytest.mark.parametrize(("radius", "centre", "laps"), [(0.25, 0j, 1), (0.65, 0j, 1), (0.2, 0.3 - 0.1j, 2)])
def test_loop_turns_by_twice_its_area(masses: tuple[float, ...], radius: float, centre: complex, laps: int) -> None:
    theta = cartesian.theta_after_loop(radius, centre, masses, laps)
    assert theta == pytest.approx(2 * np.pi * radius**2 * laps, abs=1e-9)


@pytest.mark.parametrize("masses", MASSES)
@pytest.mark.parametrize("momentum", [0.0, 0.3])
def test_newton_and_momentum_routes_agree(masses: tuple[float, ...], momentum: float) -> None:
    mu, radius = 1.7, 0.2
    lengths, rates, accelerations = cartesian.circular_loop(radius, 0.25 + 0.1j, masses, mu)
    times = np.linspace(0, 2 * np.pi, 65)
    l1, l2, l3 = lengths(0.0)
    start = cartesian.place(l1, l2, l3, 0.4, masses)
    X = cartesian.integrate(lengths, rates, masses, start, times, momentum)
    Y, V = cartesian.integrate_newton(lengths, rates, accelerations, masses, start, times, momentum)
    np.testing.assert_allclose(Y, X, atol=1e-9)
    np.testing.assert_allclose(cartesian.rods(X), [lengths(float(t)) for t in times], atol=1e-10)
    assert cartesian.angular_momentum(Y[-1], V[-1], masses) == pytest.approx(momentum, abs=1e-10)
    drift = 3 * momentum / (np.mean(masses) * mu)
    theta = cartesian.attitude(X, masses)
    assert theta[-1] - theta[0] == pytest.approx(2 * np.pi * (radius**2 + drift), abs=1e-9)


@pytest.mark.parametrize(("case", "law", "duration"), TABLE)
@pytest.mark.share(2)
def test_reference_loop_gives_the_expected_numbers(case: str, law: str, duration: float) -> None:
    run = reference.simulate(case, LAWS[law], duration)
    found = reference.metrics(run)
    assert list(found.values())[:9] == pytest.approx(TABLE[case, law, duration], rel=6e-4, abs=6e-5)
    assert reference.sign_changes(run.every(5).rates, 0.001) == found["flips"]


@pytest.mark.parametrize("law", [Sliding(), Path()])
def test_masses_moved_by_the_rod_rates_turn_as_the_reference_says(law: reference.ErrorRate) -> None:
    run = reference.simulate("B", law, 2.0, step=0.01)
    lengths = CubicHermiteSpline(run.time, run.lengths, run.rates)
    masses = (1.0, 1.0, 1.0)
    l1, l2, l3 = run.lengths[0]
    start = cartesian.place(l1, l2, l3, 1.0, masses)
    X = cartesian.integrate(lengths, lengths.derivative(), masses, start, run.time[::10])
    np.testing.assert_allclose(cartesian.attitude(X, masses), run.theta[::10], atol=1e-6)


def test_sign_instead_of_saturation_chatters_under_a_hold() -> None:
    chattering = Sliding(s_min=0.0, theta_min=0.0)
    shape_held = reference.simulate("A", chattering, 10.0, step=0.01, hold=1)
    rods_held = reference.simulate_held_rods("A", chattering, 10.0)
    smooth = reference.simulate_held_rods("A", Sliding(), 10.0)
    assert reference.sign_changes(shape_held.rates, 0.001) > 1000
    assert reference.sign_changes(rods_held.rates, 0.001) > 1000
    assert reference.sign_changes(smooth.rates, 0.001) < 20
