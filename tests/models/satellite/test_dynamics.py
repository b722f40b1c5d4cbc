# SPDX-License-Identifier: Apache-2.0
"""The generated plant: against a hand-written one, point masses, conservation laws, and between its two charts."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from mehvar.base.errors import InputError
from mehvar.runtime.run.problem import Status
from mehvar.runtime.run.simulate import simulate
from tests.models.satellite.loop import satellite
from tests.reference.reference_satellite import INERTIA, ORBIT_RATE, SPIN, START, Plant, rates, rotation, wheel_limit

EULER, QUATERNION = satellite("euler"), satellite("quaternion")
RANDOM = np.random.default_rng(5)
P = EULER.names("parameters")
ENVIRONMENT = {"dipole_x": 0.1, "dipole_y": -0.2, "dipole_z": 0.3, "air_density": 1e-12, "solar_pressure": 4.56e-6}


def plant(generated=EULER, **settings):
    return generated.parameters(settings)[0]


def random_states(n):
    angles = RANDOM.uniform((-3, -1.2, -3), (3, 1.2, 3), (n, 3))
    rest = RANDOM.normal(0, [0.01] * 3 + [0.1] * 3, (n, 6))
    return np.hstack([angles, rest, RANDOM.uniform(-3, 3, (n, 1))])


def as_quaternion(x):
    """Replace the angles of states by the quaternion of the same attitude."""
    half = x[..., :3] / 2
    (sr, sp, sy), (cr, cp, cy) = np.moveaxis(np.sin(half), -1, 0), np.moveaxis(np.cos(half), -1, 0)
    parts = (
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    )
    return np.concatenate([np.stack(parts, -1), x[..., 3:]], axis=-1)


def integrate(generated, x, p, span, u=(0.0, 0.0, 0.0), points=11):
    u = np.asarray(u, dtype=float)
    times = np.linspace(0, span, points)
    done = solve_ivp(
        lambda _t, y: generated.rhs(y, u, p), (0, span), x, "DOP853", times, rtol=1e-13, atol=1e-15, max_step=5.0
    )
    assert done.success
    return done.y.T


@pytest.mark.parametrize("wheels", [1.0, 0.0])
def test_the_right_hand_side_is_the_hand_written_one(wheels):
    p = plant(wheels=wheels, omega0=ORBIT_RATE)
    for x in random_states(30):
        u = RANDOM.normal(0, 0.1, 3)
        if not wheels:
            x[6:9] = 0
        expected = rates(Plant(wheels=bool(wheels)), x[:9].tolist(), u.tolist())
        assert EULER.rhs(x, u, p)[:9] == pytest.approx(expected, rel=1e-13, abs=1e-15)
        assert EULER.rhs(x, u, p)[9] == ORBIT_RATE


def test_the_orbital_rate_is_that_of_a_circular_orbit():
    assert plant()[P.index("omega0")] == pytest.approx(ORBIT_RATE, rel=1e-9)


@pytest.mark.parametrize("spin", [SPIN, np.array([0.3, 0.01, 0.02])], ids=["paper", "heavy"])
def test_gravity_gradient_of_six_point_masses(spin):
    """Six masses on the principal axes have the inertia of all; each is pulled by the inverse square law."""
    radius = plant()[P.index("orbit_radius")]
    total = INERTIA + spin
    squares = total.sum() / 2 - total
    arms = np.vstack([sign * np.diag(np.sqrt(squares / 2)) for sign in (1, -1)])
    mu = ORBIT_RATE**2 * radius**3
    for x in random_states(10):
        x[3:9] = 0
        to_earth = radius * rotation(x[:3])[:, 2]
        distance = to_earth - arms
        # the pull less that on the centre of mass, whose moment is zero
        lengths = np.linalg.norm(distance, axis=1)
        excess = np.expm1(-3 * np.log1p((lengths - radius) / radius)) + 1
        torque = np.cross(arms, mu / radius**3 * distance * excess[:, None]).sum(axis=0)
        p = plant(omega0=ORBIT_RATE, Iw_x=spin[0], Iw_y=spin[1], Iw_z=spin[2])
        result = EULER.rhs(x, np.zeros(3), p)[3:6] * INERTIA
        assert result == pytest.approx(torque, rel=1e-6, abs=1e-12)


def test_wheels_are_pulled_at_as_the_body_is():
    """With the same inertia about all axes but for a heavy wheel, gravity turns the tilted satellite all the same."""
    p = plant(**dict.fromkeys(("I_x", "I_y", "I_z"), 3.0), Iw_x=0.3, Iw_y=0.01, Iw_z=0.01)
    x = np.zeros(10)
    x[:3] = np.radians([10, 10, 5])
    nadir = rotation(x[:3])[:, 2]
    expected = 3 * p[P.index("omega0")] ** 2 * np.cross(nadir, np.array([3.3, 3.01, 3.01]) * nadir) / 3
    assert np.abs(expected).max() > 5e-8
    assert EULER.rhs(x, np.zeros(3), p)[3:6] == pytest.approx(expected, rel=1e-12, abs=1e-20)


def test_the_generated_jacobian_holds_the_linear_model():
    p = plant()
    w0 = p[P.index("omega0")]
    x = np.zeros(10)
    x[4] = -w0
    J = EULER.jac_x(x, np.zeros(3), p)[:6, :6]
    turn, stiff, damp = J[:3, :3], J[3:, :3], J[3:, 3:]
    assert J[:3, 3:] == pytest.approx(np.eye(3))
    stiffness, coupling = stiff - damp @ turn, turn + damp
    ix, iy, iz = INERTIA
    gx, gy, gz = INERTIA + SPIN
    expected = [
        -(w0**2) * (iy - iz + 3 * (gy - gz)) / ix, -3 * w0**2 * (gx - gz) / iy, -(w0**2) * (iy - ix) / iz
    ]  # fmt: skip
    assert stiffness == pytest.approx(np.diag(expected), abs=1e-19)
    assert coupling[0, 2] == pytest.approx(1.10850e-3, rel=1e-5)
    assert coupling[2, 0] == pytest.approx(-7.64113e-4, rel=1e-5)
    assert EULER.jac_u(x, np.zeros(3), p)[3:6] == pytest.approx(np.diag(1 / INERTIA))


@pytest.mark.soak
def test_both_charts_describe_the_same_motion():
    x = random_states(1)[0]
    x[:3] = 0.4, 0.5, -0.6
    u, span = (1e-3, -2e-3, 1.5e-3), 20.0
    settings = {**ENVIRONMENT, "wheel_friction": 1e-7}
    euler = integrate(EULER, x, plant(EULER, **settings), span, u)
    quaternion = integrate(QUATERNION, as_quaternion(x), plant(QUATERNION, **settings), span, u)
    r = np.zeros(3)
    outputs = QUATERNION.outputs(quaternion, np.asarray(u), r, plant(QUATERNION, **settings))
    names = QUATERNION.names("outputs")
    angles = np.stack([outputs[:, names.index(a)] for a in ("roll", "pitch", "yaw")], -1)
    assert np.abs(euler[:, 1]).max() < 1.4
    assert angles == pytest.approx(euler[:, :3], abs=1e-9)
    assert quaternion[:, 4:] == pytest.approx(euler[:, 3:], abs=1e-9)


@pytest.mark.parametrize("generated", [EULER, QUATERNION], ids=["euler", "quaternion"])
@pytest.mark.share(2)
def test_inertial_momentum_is_constant_without_external_torque(generated):
    p = plant(generated, omega0=0.0, wheel_friction=1e-6)
    x = random_states(1)[0]
    x[:6] = 0.1, 0.2, -0.3, 0.001, -0.0005, 0.0008
    start = x if generated is EULER else as_quaternion(x)
    states = integrate(generated, start, p, 1000.0, (1e-5, -1e-5, 1e-5))
    H = generated.momentum(states, p)
    assert np.abs(states[-1, -4:-1] - start[-4:-1]).max() > 5e-3
    assert np.abs(H - H[0]).max() < 1e-10 * np.linalg.norm(H[0])


def test_momentum_changes_by_the_external_torque():
    """In inertial axes, along the orbit: the derivative of H is the external torque, turned there."""
    p = plant(**ENVIRONMENT)
    w0, step = p[P.index("omega0")], 1e-3
    names = EULER.names("outputs")
    for x in random_states(5):
        u = RANDOM.normal(0, 0.1, 3)
        slope = EULER.rhs(x, u, p)
        change = (EULER.momentum(x + step * slope, p) - EULER.momentum(x - step * slope, p)) / (2 * step)
        C = rotation(x[:3])
        gradient = 3 * w0**2 * np.cross(C[:, 2], (INERTIA + SPIN) * C[:, 2])
        y = EULER.outputs(x, u, np.zeros(3), p)
        torque = C.T @ (gradient + [y[names.index(f"Tenv_{i}")] for i in "xyz"])
        c, s = math.cos(x[9]), math.sin(x[9])
        inertial = np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]]) @ torque
        assert change == pytest.approx(inertial, abs=2e-8)


def test_the_jacobi_integral_is_constant_in_orbit():
    p = plant()
    x = random_states(1)[0]
    x[:6] = 0.2, 0.3, -0.1, 1e-3, -5e-4, 2e-4
    states = integrate(EULER, x, p, 2000.0)
    spin = INERTIA * states[:, 3:6] + states[:, 6:9]
    orbit = np.array([-p[P.index("omega0")] * rotation(a)[:, 1] for a in states[:, :3]])
    energy = EULER.energy(states, p) - (orbit * spin).sum(axis=1)
    size = np.abs(EULER.energy(states, p) - (states[:, 6:9] ** 2 / (2 * np.array([1.47e-5, 1.26e-5, 1.26e-5]))).sum(1))
    assert np.ptp(states[:, 0]) > 0.5
    assert np.ptp(energy) < 1e-9 * size.max() + 1e-14 * EULER.energy(states, p).max()


def test_pitch_passes_ninety_degrees_in_the_quaternion_chart():
    p = plant(QUATERNION)
    level = {"roll_0_deg": 0.0, "pitch_0_deg": 80.0, "yaw_0_deg": 0.0}
    x = QUATERNION.initial(*(QUATERNION.parameters(level)[k] for k in (0, 2)))
    x[5] = 0.1
    states = integrate(QUATERNION, x, p, 40.0, points=801)
    assert np.linalg.norm(states[:, :4], axis=1) == pytest.approx(1, abs=1e-12)
    names = QUATERNION.names("outputs")
    y = QUATERNION.outputs(states, np.zeros(3), np.zeros(3), p)
    assert np.isfinite(y).all()
    assert y[:, names.index("pitch")].max() > math.radians(89.8)
    assert y[:, names.index("pitch")].min() < -math.radians(89.8)
    assert (QUATERNION.limits(states, np.zeros(3), p) > 0).all()
    stretched = states * 1.01
    assert QUATERNION.project(stretched)[:, :4] == pytest.approx(states[:, :4], abs=1e-12)
    assert QUATERNION.project(stretched)[:, 4:] == pytest.approx(stretched[:, 4:])


def test_torques_of_the_environment():
    p = plant(**ENVIRONMENT)
    dipole, arm = np.array([0.1, -0.2, 0.3]), np.array([0.03, 0.02, 0.05])
    radius, w0, tilt = 6978137.0, p[P.index("omega0")], math.radians(98)
    names = EULER.names("outputs")
    for x in random_states(5):
        v = x[9]
        turn = np.array([math.cos(v) * math.sin(tilt), -math.cos(tilt), 2 * math.sin(v) * math.sin(tilt)])
        sun = [math.cos(0.5) * math.sin(-v), -math.sin(0.5), -math.cos(0.5) * math.cos(v)]
        drag = [-0.5 * 1e-12 * (w0 * radius) ** 2 * 2.2 * 0.5, 0, 0]
        C = rotation(x[:3])
        torque = np.cross(dipole, C @ (7.9e15 / radius**3 * turn))
        torque += np.cross(arm, C @ (np.array(drag) - 4.56e-6 * 1.6 * 0.5 * np.array(sun)))
        y = EULER.outputs(x, np.zeros(3), np.zeros(3), p)
        assert [y[names.index(f"Tenv_{i}")] for i in "xyz"] == pytest.approx(torque, rel=1e-12)
    quiet = EULER.outputs(x, np.zeros(3), np.zeros(3), plant())
    assert [quiet[names.index(f"Tenv_{i}")] for i in "xyz"] == [0, 0, 0]


@given(
    h=st.floats(-0.7, 0.7), wanted=st.floats(-3, 3), umax=st.floats(0.01, 2), hmax=st.floats(0.1, 0.7),
    period=st.floats(0.1, 2),
)  # fmt: skip
@settings(deadline=None)
def test_a_torque_keeps_both_limits_and_the_order_of_them_is_known(h, wanted, umax, hmax, period):
    """Never beyond umax, whatever the wheel holds; a wheel within hmax stays there, and is not driven without cause."""
    x = np.zeros(10)
    x[6:9] = h
    (acts, *_) = EULER.actuate(x, np.full(3, wanted), plant(umax=umax, hmax=hmax, Ts=period))
    assert acts == pytest.approx(wheel_limit(Plant(umax=umax, hmax=hmax), np.array([h]), np.array([wanted]), period)[0])
    assert abs(acts) <= umax
    if abs(h) <= hmax:
        assert abs(h - period * acts) <= hmax * (1 + 1e-12)
        assert min(0, wanted) <= acts <= max(0, wanted)
    without = plant(umax=umax, hmax=hmax, Ts=period, wheels=0.0)
    assert EULER.actuate(x, np.full(3, wanted), without)[0] == max(-umax, min(umax, wanted))


def test_a_full_wheel_gives_no_torque_and_without_limits_all_is_given():
    x = np.zeros(10)
    x[6:9] = 0.5
    assert EULER.actuate(x, np.full(3, -1.0), plant(umax=0.1, hmax=0.5)) == pytest.approx([0, 0, 0])
    assert EULER.actuate(x, np.full(3, 50.0), plant()) == pytest.approx([50.0] * 3)


def test_friction_slows_the_wheels_and_turns_the_body():
    p = plant(omega0=0.0, wheel_friction=1e-6)
    x = np.zeros(10)
    x[6] = 1e-3
    states = integrate(EULER, x, p, 5.0)
    speed = states[:, 6] / 1.47e-5 - states[:, 3]
    assert speed[-1] / speed[0] == pytest.approx(math.exp(-5.0 * 1e-6 * (1 / 1.47e-5 + 1 / 2.13)), rel=1e-9)
    assert states[-1, 3] > 0


@pytest.mark.parametrize("generated", [EULER, QUATERNION], ids=["euler", "quaternion"])
def test_the_sensor_adds_noise_and_rounds(generated):
    x = random_states(1)[0]
    x[:3] = 0.3, -0.2, 0.1
    e = RANDOM.normal(0, 1, 6)
    state = x if generated is EULER else as_quaternion(x)
    noisy = generated.measure(state, e, plant(generated, noise=5e-5, noise_rate=1e-6, Ts=0.25))
    coarse = generated.measure(state, e, plant(generated, noise=5e-5, quantum=1e-3))
    seen = x.copy()
    seen[:3] += 5e-5 * e[:3]
    seen[3:6] += 1e-6 / math.sqrt(0.25) * e[3:]  # a density: a shorter sample averages less
    rounded = x.copy()
    rounded[:3] = 1e-3 * np.floor(seen[:3] / 1e-3 + 0.5)
    for result, expected in ((noisy, seen), (coarse, rounded)):
        assert result == pytest.approx(expected if generated is EULER else as_quaternion(expected), abs=1e-15)
    assert generated.measure(state, e, plant(generated)) == pytest.approx(state, abs=1e-15)


def test_scenarios_start_at_rest_in_the_orbit_axes():
    p, _, s = EULER.parameters({})
    x = EULER.initial(p, s)
    assert x[:3] == pytest.approx(START)
    assert EULER.rhs(x, np.zeros(3), p)[:3] == pytest.approx([0, 0, 0], abs=1e-18)
    assert x[6:] == pytest.approx([0, 0, 0, 0])
    p, _, s = QUATERNION.parameters({})
    assert QUATERNION.initial(p, s) == pytest.approx(as_quaternion(x), abs=1e-15)


def test_references_are_square_waves_that_begin_positive():
    p, _, s = EULER.parameters({})
    for t, side in ((0.0, 1), (199.5, 1), (200.0, -1), (399.5, -1), (400.0, 1), (799.5, -1), (1e6, 1)):
        assert EULER.reference(t, p, s) == pytest.approx(side * np.radians([25, 30, 0]))


def test_what_cannot_be_is_refused():
    def margins(**settings):
        p, _, s = EULER.parameters(settings)
        return EULER.constraints(p, s)

    assert (margins() > 0).all()
    assert margins(I_z=5.2)[0] <= 0
    assert margins(I_x=0.01)[0] <= 0
    assert margins(I_x=1.0, I_y=1.0, I_z=1.99)[0] > 0
    assert margins(I_x=1.0, I_y=1.0, I_z=1.99, Iw_z=0.02)[0] <= 0
    assert margins(half_period=0.4)[1] <= 0
    p, c, s = EULER.parameters({"design_delay": 0.5}, "mrac")
    assert EULER.mrac_constraints(p, c, s)[0] <= 0
    for delay in (0.0, 1.0):
        p, c, s = EULER.parameters({"delay": delay}, "mrac")
        assert c[[q.name for q in EULER.law("mrac").parameters].index("design_delay")] == delay
        assert EULER.mrac_constraints(p, c, s)[0] > 0


def test_a_run_is_lost_past_85_degrees_of_pitch_or_a_huge_torque():
    p = plant()
    x = np.zeros(10)
    assert (EULER.limits(x, np.zeros(3), p) > 0).all()
    x[1] = math.radians(85.1)
    assert EULER.limits(x, np.zeros(3), p)[0] < 0
    assert EULER.limits(x, np.array([0, -1.1e4, 0]), p)[1] < 0


def test_more_momentum_than_a_wheel_can_hold_ends_a_run_and_is_refused_at_its_start():
    x, limited = np.zeros(10), plant(hmax=0.5)
    for h, allowed in ((0.5, True), (-0.5, True), (0.5 + 1e-15, True), (0.501, False), (-0.501, False)):
        x[7] = h
        assert (EULER.limits(x, np.zeros(3), limited)[2] > 0) == allowed
    assert EULER.limits(x, np.zeros(3), plant(hmax=0.5, wheels=0.0))[2] > 0
    values = {"umax": 0.1, "hmax": 0.5, "hx_0": 1.0}
    with pytest.raises(InputError, match=r"lost \(momentum\): a wheel holds more than hmax = 0.5 N m s"):
        simulate("satellite", "mrac", parameters=values)
    with pytest.raises(InputError, match=r"with hx, .*from the call\) is outside.*a wheel holds more"):
        simulate("satellite", "mrac", parameters={**values, "hx_0": 0.0}, initial={"hx": 1.0})


def test_a_run_at_both_limits_passes_neither():
    run = simulate("satellite", "mrac", parameters={"umax": 0.02, "hmax": 0.05}, t_end=400.0)
    assert run.status is Status.DONE
    momentum, torque = np.abs(run.x[:, 6:9]), np.abs(run.u)
    assert torque.max() == 0.02
    assert 0.05 * (1 - 1e-9) < momentum.max() < 0.05 * (1 + 1e-9)
