# SPDX-License-Identifier: Apache-2.0
"""The triangle's motion against a Cartesian integration of three masses that shares no code with the model."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline

from mehvar.runtime import load, simulate
from mehvar.runtime.model.model import Model
from tests.derived import variant
from tests.reference.cartesian_triangle import attitude, integrate, place, rods, theta_after_loop

MASSES = (1.0, 2.0, 3.5)


@pytest.fixture(scope="module")
def equal() -> Model:
    return load("triangle")


@pytest.fixture(scope="module")
def general(tmp_path_factory) -> Model:
    folder = tmp_path_factory.mktemp("general")
    for name, text in variant("triangle", masses="general").items():
        (folder / name).write_text(text)
    return load(folder)


def turn_along_circle(model: Model, radius: float, centre: complex, masses: tuple[float, ...] | None) -> float:
    """Integrate theta' of the model once around a circle in the shape disc by the trapezoidal rule, exact for it."""
    angle = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    zeta = centre + radius * np.exp(1j * angle)
    rate = 1j * radius * np.exp(1j * angle)
    rho, phi = np.abs(zeta), np.angle(zeta)
    polar_rate = rate * np.exp(-1j * phi)
    p = model.parameters(**({f"m{k + 1}": m for k, m in enumerate(masses)} if masses else {}))
    x = np.stack([rho, phi, np.full_like(rho, 0.3), 0 * rho], axis=-1)
    u = np.stack([polar_rate.real, polar_rate.imag / rho, 0 * rho], axis=-1)
    return float(model.rhs(x, u, p)[:, 3].mean() * 2 * np.pi)


@pytest.mark.parametrize(("radius", "centre"), [(0.25, 0.0), (0.2, 0.3 + 0.1j), (0.45, -0.1j)])
def test_a_shape_loop_turns_by_twice_its_area(equal, radius, centre):
    expected = 2 * np.pi * radius**2
    assert turn_along_circle(equal, radius, centre, None) == pytest.approx(expected, abs=1e-12)
    assert theta_after_loop(radius, centre, (1.0, 1.0, 1.0)) == pytest.approx(expected, abs=1e-9)


def test_unequal_masses_turn_by_the_same_angle(general):
    assert turn_along_circle(general, 0.25, 0.0, MASSES) == pytest.approx(0.392699, abs=1e-6)
    assert theta_after_loop(0.25, 0.0, MASSES) == pytest.approx(2 * np.pi * 0.25**2, abs=1e-9)


@given(
    rho=st.floats(0.01, 0.69), phi=st.floats(-3.1, 3.1), mu=st.floats(0.01, 10),
    masses=st.tuples(*[st.floats(0.2, 5.0)] * 3),
)  # fmt: skip
@settings(max_examples=60, deadline=None)
def test_lengths_and_shape_are_inverse_for_any_masses(general, rho, phi, mu, masses):
    p = general.parameters(m1=masses[0], m2=masses[1], m3=masses[2])
    lengths = general.functions["lengths"](rho, phi, mu, p)
    result = general.functions["shape"](*lengths, p)
    np.testing.assert_allclose(result, [rho, phi, mu], rtol=1e-7, atol=1e-9)


@pytest.mark.parametrize("masses", [None, MASSES])
def test_a_motion_of_the_model_is_a_motion_of_three_masses(equal, general, masses):
    """Rods that follow smooth shape functions: theta of the model, theta and rods of the three masses."""
    model = general if masses else equal
    p = model.parameters(**({f"m{k + 1}": m for k, m in enumerate(masses)} if masses else {}))
    last = (p,) if masses else ()
    t = np.linspace(0, 4, 401)

    def state(time):
        return 0.35 + 0.2 * np.sin(1.3 * time), 0.4 + 0.9 * time, 0.3 + 0.05 * np.cos(time)

    def inputs(time):
        return 0.26 * np.cos(1.3 * time), 0.9 + 0 * time, -0.05 * np.sin(time)

    def lengths(time):
        return np.array(model.functions["lengths"](*state(time), *last))

    def rates(time):
        x = np.stack([*state(time), 0 * np.asarray(time)], axis=-1)
        return np.asarray(model.functions["length_rates"](x, np.stack(inputs(time), axis=-1), *last))

    weights = masses or (1.0, 1.0, 1.0)
    start = place(*lengths(0.0), 0.2, weights)
    positions = integrate(lengths, rates, weights, start, t)
    np.testing.assert_allclose([rods(X) for X in positions], lengths(t).T, atol=1e-10)
    x = np.stack([*state(t), 0 * t], axis=-1)
    rate = model.rhs(x, np.stack(inputs(t), axis=-1), p)[:, 3]
    spline = CubicSpline(t, rate)
    turned = np.array([spline.integrate(0, end) for end in t])
    angle = np.unwrap([attitude(X, weights) for X in positions])
    np.testing.assert_allclose(angle - angle[0], turned, atol=2e-9)


def test_angular_momentum_makes_the_attitude_drift(equal):
    """With H the attitude drifts at 3H/(mbar mu) and no shape can hold it, (b) of the generalisations."""
    run = simulate(equal, "path", H=0.01, mass=2.0)
    drift = run.u[:, 1] * run.x[:, 0] ** 2 + 3 * 0.01 / (2.0 * run.x[:, 2])
    rates = equal.rhs(run.x, run.u, run.parameters.p)[:, 3]
    np.testing.assert_allclose(rates, drift, atol=1e-12)


@pytest.mark.parametrize("law", ["sliding", "path"])
def test_the_base_shape_is_an_ordinary_start(equal, law):
    """rho = 0, where phi means nothing: both laws pass it without trouble."""
    run = simulate(equal, law, l1_0=0.3, l2_0=0.3, l3_0=0.3)
    assert run.status.name == "DONE"
    assert abs(run.x[-1, 3]) < 0.002


@pytest.mark.parametrize("law", ["sliding", "path"])
def test_starting_at_the_target_shape_is_an_ordinary_start(equal, law):
    """rho~ = 0 with an attitude error: the law must leave the target to turn."""
    run = simulate(equal, law, l1_0=0.3, l2_0=0.3, l3_0=0.5)
    assert run.status.name == "DONE"
    assert abs(run.x[-1, 3]) < 0.01


@given(st.floats(0.0, 0.6), st.floats(-3.1, 3.1), st.floats(-3.0, 3.0))
@settings(max_examples=6, deadline=None)
@pytest.mark.soak
def test_both_laws_reach_the_target_from_anywhere(equal, rho, phi, theta):
    """Claim 1, with room: 60 s, and the bounds that random starts showed."""
    for law, bound in (("sliding", 0.02), ("path", 1e-3)):
        run = simulate(equal, law, initial={"rho": rho, "phi": phi, "theta": theta}, t_end=60.0)
        assert run.status.name == "DONE"
        assert abs(run.x[-1, 3]) < bound
        assert run.x[:, 0].max() < 0.65 + 1e-3
