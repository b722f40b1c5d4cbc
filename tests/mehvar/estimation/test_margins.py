# SPDX-License-Identifier: Apache-2.0
"""Margins of linear and of running loops against eigenvalues and closed forms."""

import math
import warnings

import numpy as np
import pytest
import sympy as sp
from scipy.linalg import expm

import mehvar
from mehvar import TIME, Controller, Group, Parameter, Quantity, System
from mehvar.base.errors import InputError
from mehvar.estimation.margins import beside_orbit, linear_margins
from mehvar.mechanics import quaternion_rotation
from mehvar.parts import GravityGradient, Gyro, Hub, Orbit, Spacecraft, StarTracker, Tank, Torquer, Wheel
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


def stable(generator, period):
    """Draw a loop that is stable."""
    n = generator.integers(1, 5)
    while True:
        A = generator.normal(size=(n, n)) * (1 if period is None else 0.7)
        b, c = generator.normal(size=n), generator.normal(size=n)
        if worst(A, b, c, 1.0, period) < -1e-3:
            return A, b, c


FACTORS = np.geomspace(1, 1e3, 3001)


def nearest(A, b, c, period):
    """The nearest factor to one at which stability is lost, from a scan of eigenvalues."""
    limits = []
    for factors in (FACTORS, 1 / FACTORS):
        signs = worst(A, b, c, factors, period)
        limits += [factors[k] for k in range(1, len(signs)) if signs[k] > 0 > signs[k - 1]][:1]
    return min(limits, key=lambda factor: abs(math.log(factor)), default=math.inf)


@pytest.mark.parametrize("period", [None, 0.2])
@pytest.mark.parametrize("seed", range(60))
@pytest.mark.share(5)
def test_the_gain_is_the_first_factor_that_makes_the_loop_unstable(seed, period):
    generator = np.random.default_rng(seed)
    A, b, c = stable(generator, period)
    n = len(A)
    (margin,) = linear_margins(loop(A, b, c, period))
    expected = nearest(A, b, c, period)
    if math.isfinite(expected):
        assert margin.gain == pytest.approx(expected, rel=0.01)
    else:
        assert not 1.1e-3 < margin.gain < 0.9e3
    one = 0.0 if period is None else 1.0
    clock, odometer = np.zeros(n), generator.normal(size=n)
    for row in (clock, odometer):
        more = loop(np.block([[A, np.zeros((n, 1))], [row, one]]), [*b, row.any()], [*c, 0.0], period)
        (with_more,) = linear_margins(more)
        assert with_more.gain == pytest.approx(margin.gain, rel=1e-5)
        assert with_more.phase == pytest.approx(margin.phase, abs=1e-5)
    turn = np.linalg.qr(generator.normal(size=(n + 2, n + 2)))[0]  # rounding splits two integrators
    chain = np.eye(2, k=-1) + one * np.eye(2)
    more = turn @ np.block([[A, np.zeros((n, 2))], [np.outer([1, 0], odometer), chain]]) @ turn.T
    for split in linear_margins(loop(more, turn @ [*b, 0, 0], turn @ [*c, 0, 0], period)):
        if math.isfinite(split.gain):
            step = 1.05 if split.gain > 1 else 1 / 1.05
            assert worst(A, b, c, split.gain * step, period) > 0


@pytest.mark.parametrize("J", [0.25, 2.0, 40.0])
def test_of_a_sampled_rigid_body_it_is_that_of_the_rate(J):
    """z = -1 at the factor 2 J/(kd Ts)."""
    T, kp, kd = 0.2, 0.1 * J, 2.0 * J / 4
    (margin,) = linear_margins(loop([[1, T], [0, 1]], [T**2 / (2 * J), T / J], [-kp, -kd], T))
    assert margin.gain == pytest.approx(2 * J / (kd * T), rel=1e-9)


def test_a_loop_that_a_smaller_gain_loses_has_that_margin():
    (margin,) = linear_margins(loop([[0, 1], [0.5, 0]], [0, 1], [-2, -2]))
    assert margin.gain == pytest.approx(0.25)


def test_a_rigid_body_under_pd_has_none():
    (margin,) = linear_margins(loop([[0, 1], [0, 0]], [0, 1], [-2, -2]))
    assert margin.gain == math.inf


@pytest.mark.parametrize("period", [None, 0.01])
def test_a_slow_unstable_mode_beside_a_fast_lag_is_unstable(period):
    """Such modes grew by less than a millionth of the fastest eigenvalue, or in a sample."""
    A, b, c = np.diag([5e-5, -1000.0]), [0, 1], [0, -1]
    discrete = A if period is None else np.diag(np.exp(np.diag(A) * period))
    assert linear_margins(loop(discrete, b, c, period)) == ()


def test_margins_of_a_slow_loop_with_a_fast_lag_are_those_without_the_lag():
    """L = 3 w^2/(s^2 + 3 w s - 2 w^2): s = 0 at two thirds; |L| = 1 where x = (omega/w)^2 has (x + 2)^2 + 9 x = 9."""
    w, F = 1e-4, 1e3
    (margin,) = linear_margins(loop([[0, 1, 0], [2 * w**2, -3 * w, 1], [0, 0, -F]], [0, 0, F], [-3 * w**2, 0, 0]))
    x = (math.sqrt(189) - 13) / 2
    assert margin.gain == pytest.approx(2 / 3, rel=1e-6)
    assert margin.phase == pytest.approx(math.atan2(3 * math.sqrt(x), x + 2), rel=1e-5)


@pytest.mark.parametrize("period", [None, 0.2])
@pytest.mark.parametrize("seed", range(20))
@pytest.mark.share(3)
def test_the_phase_is_the_first_turn_that_makes_the_loop_unstable(seed, period):
    A, b, c = stable(np.random.default_rng(seed), period)
    turns = np.linspace(0, math.pi, 3001)
    signs = worst(A, b, c, np.exp(1j * turns), period)
    expected = next((turns[k] for k in range(1, len(turns)) if signs[k] > 0), math.inf)
    (margin,) = linear_margins(loop(A, b, c, period))
    assert margin.phase == pytest.approx(expected, abs=2e-3)


TS, INERTIA, GAIN = 0.1, 2.0, 1.5
GRID = np.geomspace(0.1, math.pi / TS, 12)


@pytest.fixture(scope="module")
def turner():
    """A hub with a torque about each axis: rate feedback about x, attitude and rate about y, static error about z."""
    craft = Spacecraft("turner", motion="attitude", period=TS)
    craft.add(Hub("hub", mass=40.0, inertia=(INERTIA, INERTIA, INERTIA)))
    craft.add(Torquer("turn"))

    def feedback(law):
        kd, (_, _, q2, _), (x, y, z) = law.parameter("kd", GAIN, "N m s"), law.attitude, law.rates
        return {"turn": (-kd * x, -law.parameter("kp", 0.6, "N m") * q2 - kd * y, -kd * z)}

    craft.law("feedback", feedback, "rates and one angle")
    return mehvar.build(craft)


@pytest.mark.parametrize("delay", [0, 1])
def test_a_running_loop_has_the_margins_of_closed_forms(turner, delay):
    """L = K z^-delay/(z - 1), K = kd Ts/J, is lost at K = 2 or, delayed, at K = 1; |L| = 1 at 2 sin(w Ts/2) = K."""
    size = {"turnx": np.float32(1e-3)}
    (margin,) = mehvar.margins(turner, "feedback", size=size, t_end=1.0, delay=delay, frequencies=GRID)
    share = GAIN * TS / INERTIA
    assert 20 * math.log10(margin.gain * share / (2 - delay)) == pytest.approx(0, abs=0.01)
    angle = 2 * math.asin(share / 2)
    assert margin.phase == pytest.approx(math.pi / 2 - angle / 2 - delay * angle, abs=1e-3)


def test_a_running_loop_has_the_margins_of_the_linear_one(turner):
    (measured,) = mehvar.margins(turner, "feedback", size={"turny": 1e-3}, t_end=1.0, frequencies=GRID)
    linear = mehvar.margins(turner, "feedback", t_end=1.0)[1]
    assert 20 * math.log10(measured.gain / linear.gain) == pytest.approx(0, abs=0.01)
    assert measured.phase == pytest.approx(linear.phase, abs=1e-3)


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ({"kd": -1.0}, "the linear loop of feedback is unstable where"),
        (
            {"kd": -1.0, "delay": 1, "size": 1e-3, "frequencies": [1.0, 2.0]},
            "the loop is unstable, or size too large: with a sine at 1 rad/s",
        ),
        ({"kp": -0.6, "size": 1e-3, "frequencies": [1.0, 2.0]}, "the linear loop of feedback is unstable where"),
        ({"delay": 1}, "delay = 1: must be 0 for the linear loop; give size"),
        ({"size": 0.0}, "size of turnx = 0.0: must be a number > 0, N m"),
        ({"size": {"x": 1.0}}, "unknown input"),
        ({"size": 1e-3, "frequencies": [1.0, 32.0]}, "at most pi/Ts = 31.4159 rad/s"),
        ({"frequencies": [1.0, 2.0]}, "frequencies = .*: must be left out without size"),
        ({"size": {}}, "size = {}: must be a number, or amplitudes of one input or more"),
    ],
)
def test_what_has_no_margins_is_refused(turner, arguments, text):
    with pytest.raises(InputError, match=text):
        mehvar.margins(turner, "feedback", t_end=1.0, **arguments)


def test_a_law_without_derivative_is_no_unstable_loop(monkeypatch):
    """The root of zero: the linear loop was called unstable, and the sweep ended in a traceback."""
    x, u = Group("x", (Quantity("a", "1", "angle"),)), Group("u", (Quantity("u", "1/s", "rate"),))
    p = Group("p", (Parameter("Ts", "s", "period", default=0.1, bounds="(0, inf)"),
                    Parameter("k", "1/s", "gain", default=1.0)))  # fmt: skip
    law = Controller("root", "", Group("c", ()), (-p.k * sp.sign(x.a) * sp.sqrt(sp.Abs(x.a)),), period="Ts")
    model = mehvar.build(System(name="root", states=x, inputs=u, parameters=p, rhs=(u.u,), controllers=(law,)))
    with pytest.raises(InputError, match=r"root has no derivative where .* ends; give size"):
        mehvar.margins(model, "root", t_end=1.0, dt_out=0.1)
    monkeypatch.setattr("mehvar.estimation.margins._SWEPT", 1)  # in place of three decades, which take seconds
    (margin,) = mehvar.margins(model, "root", t_end=1.0, dt_out=0.1, size=0.01)
    assert 1.0 < margin.gain < math.inf


def test_margins_at_a_moment_of_a_motion_are_said_to_be_so(turner):
    """Halfway through a turn they were given as if the craft rested there."""
    with pytest.warns(UserWarning, match="still moves where default ends, so that the margins are those of a moment"):
        mehvar.margins(turner, "feedback", t_end=2.0, pitch_0=1.0)
    with pytest.raises(InputError, match="unstable where default ends, a moment of a motion"):
        mehvar.margins(turner, "feedback", t_end=0.5, pitch_0=3.0, wy_0=1.0)  # beyond half a turn
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        mehvar.margins(turner, "feedback", t_end=60.0, pitch_0=1.0)


def test_margins_of_a_craft_whose_tank_drains_are_said_to_be_those_of_a_moment():
    craft = Spacecraft("stage", motion="free", period=TS)
    craft.add(Hub("hub", mass=40.0, inertia=(INERTIA, INERTIA, INERTIA)))
    craft.add(Torquer("turn"))
    craft.add(Tank("tank", mass=4.0, nozzle=(-0.5, 0, 0), at=(0.2, 0, 0)))

    def feedback(law):
        w, kd = law.parameter("w", 0.01, "kg/s", bounds="[0, inf)"), law.parameter("kd", GAIN, "N m s")
        return {"tank": w, "turn": tuple(-kd * rate for rate in law.rates)}

    craft.law("feedback", feedback)
    model = mehvar.build(craft)
    with pytest.warns(UserWarning, match="those of a moment: where default ends, fuel leaves tank"):
        mehvar.margins(model, "feedback", t_end=1.0, dt_out=TS)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        mehvar.margins(model, "feedback", t_end=1.0, dt_out=TS, w=0.0)


def test_a_craft_that_turns_steadily_has_the_margins_of_one_at_rest():
    """The quaternion's spare direction feigned a mode that grows, for which loops with an integral were unstable.

    Without one, the factor about the axis of the spin was 0.05 in place of 2 J/(kd Ts). A rate of 0.2 rad/s moves the
    other phases to 1.136 and 1.099 rad, as measured by 31 sines; the map over a period leaves out a turn of w Ts/2.
    """
    craft = Spacecraft("spinner", motion="attitude", period=TS)
    craft.add(Hub("hub", mass=40.0, inertia=(INERTIA, 1.2 * INERTIA, 0.8 * INERTIA)))
    for axis, along in zip("xyz", np.eye(3).tolist(), strict=True):
        craft.add(Wheel(f"w{axis}", axis=along, inertia=0.01))

    def spin(law):
        spin, kp, kd = (
            law.parameter("spin", 0.2, "rad/s"),
            law.parameter("kp", 0.6, "N m"),
            law.parameter("kd", GAIN, "N m s"),
        )
        c, s, ki = sp.cos(spin * TIME.symbol), sp.sin(spin * TIME.symbol), law.parameter("ki", 0.0, "N m/s")
        target = sp.Matrix([[c, s, 0], [-s, c, 0], [0, 0, 1]])
        turn = law.define("turn", quaternion_rotation(list(law.attitude)) * target.T)
        angles = [(turn[i, k] - turn[k, i]) / 2 for i, k in ((1, 2), (2, 0), (0, 1))]
        sums = [law.keep(f"sum_{axis}", "s") for axis in "xyz"]
        law.update_all(sums, [s + law.period * a for s, a in zip(sums, angles, strict=True)])
        rows = zip("xyz", angles, law.rates, turn[:, 2], sums, strict=True)
        return {f"w{axis}": kp * a + kd * (w - spin * e) + ki * s for axis, a, w, e, s in rows}

    craft.law("spin", spin)
    model = mehvar.build(craft)
    result = mehvar.margins(model, "spin", t_end=100.0, dt_out=TS)
    assert [margin.gain * GAIN * TS / (2 * INERTIA) for margin in result] == pytest.approx([1.0, 1.2, 0.8], rel=1e-4)
    assert [margin.phase for margin in result] == pytest.approx([1.136, 1.099, 1.143], abs=0.2 * TS / 2)
    assert mehvar.margins(model, "spin", t_end=100.0, dt_out=TS, ki=0.02, spin=0.02)


@pytest.fixture(scope="module")
def orbiter():
    """A hub in orbit whose gravity gradient acts on the orbit, too, under a sampled and a continuous law."""
    craft = Spacecraft("orbiter", orbit=Orbit(), period=TS)
    craft.add(Hub("hub", mass=40.0, inertia=(INERTIA, 1.2 * INERTIA, 0.8 * INERTIA)))
    craft.add(Torquer("turn"))
    craft.add(GravityGradient())

    def feedback(law):
        kp, kd, (_, *q) = law.parameter("kp", 0.6, "N m"), law.parameter("kd", GAIN, "N m s"), law.attitude
        return {"turn": tuple(-kp * angle - kd * rate for angle, rate in zip(q, law.rates, strict=True))}

    craft.law("sampled", feedback, "attitude and rates")
    craft.law("continuous", feedback, "attitude and rates", sampled=False)
    return mehvar.build(craft)


def test_an_orbit_is_no_part_of_the_loop(orbiter):
    """Its equations have an eigenvalue of sqrt(2) n where they are frozen, for which each loop was called unstable.

    L = K ((w^2 Ts/2 + 1) z + w^2 Ts/2 - 1)/(z - 1)^2, w^2 = kp/(2 kd), is lost at z = -1 and K = 2. Its phase margin:
    kp/2 = k and kd against J in J s^2. The gradient, 3 n^2 J = 7e-6 N m, beside kp/2 = 0.3 N m, moves both by 1e-5.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sampled = mehvar.margins(orbiter, "sampled", t_end=1.0, dt_out=TS)
        continuous = mehvar.margins(orbiter, "continuous", t_end=1.0, dt_out=TS)
    k, d = 0.3, GAIN
    for one, other, share in zip(sampled, continuous, (1.0, 1.2, 0.8), strict=True):
        J = share * INERTIA
        assert one.gain == pytest.approx(2 * J / (d * TS), rel=1e-4)
        assert other.gain == math.inf
        square = (d**2 + math.sqrt(d**4 + 4 * J**2 * k**2)) / (2 * J**2)  # of the frequency at which |L| = 1
        assert other.phase == pytest.approx(math.atan2(d * math.sqrt(square), k), abs=1e-4)


def test_an_unstable_loop_in_orbit_is_refused(orbiter):
    for law in ("sampled", "continuous"):
        with pytest.raises(InputError, match=f"the linear loop of {law} is unstable"):
            mehvar.margins(orbiter, law, t_end=1.0, dt_out=TS, kp=-0.1)


@pytest.fixture(scope="module")
def follower():
    """A hub on three wheels that follows the nadir, with and without an integral of its angles."""
    orbit = Orbit()
    craft = Spacecraft("follower", orbit=orbit, period=TS)
    craft.add(Hub("hub", mass=40.0, inertia=(INERTIA, 1.2 * INERTIA, 0.8 * INERTIA)))
    for axis, along in zip("xyz", np.eye(3).tolist(), strict=True):
        craft.add(Wheel(f"w{axis}", axis=along, inertia=0.01))
    craft.add(GravityGradient())

    def integral(law):
        down, across = -orbit.place, orbit.velocity.cross(orbit.place)
        z, y = (v / sp.sqrt(v.dot(v)) for v in (down, across))
        to = quaternion_rotation(list(law.attitude)) * sp.Matrix.hstack(y.cross(z), y, z)
        turn = law.define("turn", to)
        angles = [(turn[i, k] - turn[k, i]) / 2 for i, k in ((1, 2), (2, 0), (0, 1))]
        kp, kd, ki = (
            law.parameter("kp", 0.6, "N m"),
            law.parameter("kd", GAIN, "N m s"),
            law.parameter("ki", 0.02, "N m/s"),
        )
        sums = [law.keep(f"sum_{axis}", "s") for axis in "xyz"]
        law.update_all(sums, [s + law.period * a for s, a in zip(sums, angles, strict=True)])
        rows = zip("xyz", angles, law.rates, sums, strict=True)
        return {f"w{axis}": kp * a + kd * w + ki * s for axis, a, w, s in rows}

    craft.law("integral", integral, "angles from the nadir, rates and sums")
    return mehvar.build(craft)


def test_a_craft_that_follows_the_nadir_has_margins(follower):
    """A mode that the frozen orbit feigns, of 1e-9 to 1e-4 1/s, had them refused.

    The loop has them: the factors are 2 J/(kd Ts), where a small one does not come first, and measured phases of this
    craft, by 51 frequencies in 12 s, are 1.0694, 1.0080 and 1.1360 rad.
    """
    text = "leave out modes slower than 0.00217 1/s, twice the rate of the orbit, of which one grows by"
    with pytest.warns(UserWarning, match=rf"at wx_torque, wy_torque, wz_torque {text} \S*e-\d+ 1/s"):
        result = mehvar.margins(follower, "integral", t_end=300.0, dt_out=TS)
    assert [margin.phase for margin in result] == pytest.approx([1.0694, 1.0080, 1.1360], abs=3e-4)
    assert result[2].gain == pytest.approx(2 * 0.8 * INERTIA / (GAIN * TS), rel=1e-4)


def test_momentum_that_turns_with_the_orbit_is_no_phase_margin(follower):
    """Wheels exchange it among themselves: a phase of 0.004 rad was taken for the loop's."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # such as of the logarithm of a mode that is over in a sample
        warnings.simplefilter("ignore", UserWarning)
        result = mehvar.margins(follower, "integral", t_end=300.0, dt_out=TS, ki=0.0)
    assert [margin.phase for margin in result] == pytest.approx([1.0814, 1.0257, 1.1432], abs=3e-4)


def test_a_loop_as_slow_as_the_orbit_is_undecided(follower):
    with pytest.raises(InputError, match=r"leave out modes slower than 0\.0021. 1/s, .*; give size to measure"):
        mehvar.margins(follower, "integral", t_end=300.0, dt_out=TS, kp=2e-6, kd=2e-3, ki=0.0)


N = 1e-3
"""Rate of an orbit, rad/s."""


@pytest.mark.parametrize("period", [None, 0.1])
@pytest.mark.parametrize(("share", "keeps"), [(0.0, False), (1e-6, False), (1.0, True)])
def test_an_orbit_that_the_loop_moves_is_part_of_it(share, keeps, period):
    """A body on a spring beside growth of w = sqrt(2) n, under a law that may keep the place, too.

    Two thirds of a command remain at rest: x" = w^2 x - 2 share^2 w^2 x - 2 share^2 w x'.
    """
    w = math.sqrt(2) * N
    A, B = np.zeros((4, 4)), np.array([0, 1, 0, share])
    A[0, 1] = A[2, 3] = 1.0
    A[1, :2], A[3, 2] = (-0.02, -0.3), w**2
    C = np.array([-0.01, -0.15, -3 * share * w**2, -3 * share * w])
    if period is not None:
        held = expm(period * np.block([[A, B[:, None]], [np.zeros((1, 5))]]))
        A, B = held[:4, :4], held[:4, 4]
    cut = loop(A, B, C, period)
    kept = beside_orbit(cut, ("x2", "x3"))
    assert kept.states == (cut.states if keeps else ("x0", "x1"))
    assert beside_orbit(cut, ()).states == cut.states


@pytest.mark.parametrize("period", [None, 0.1])
def test_growth_that_no_input_reaches_and_that_is_no_orbit_is_unstable(period):
    A = np.diag([-1.0, 1e-3]) if period is None else np.diag(np.exp([-0.1, 1e-4]))
    assert linear_margins(loop(A, [1, 0], [-0.1, 0], period)) == ()


@pytest.mark.soak
def test_noise_is_no_motion():
    """The spare direction of a quaternion turned with the rates that noise left, and a craft at rest "moved"."""
    craft = Spacecraft("quiet", motion="attitude", period=TS)
    craft.add(Hub("hub", mass=40.0, inertia=(INERTIA, INERTIA, INERTIA)))
    craft.add(Torquer("turn"))
    craft.add(Gyro("gyro", noise=1e-4))
    craft.add(StarTracker("tracker", sigma=(1e-5, 1e-5, 1e-5)))

    def feedback(law):
        (_, *q), w = law.attitude, law.rates
        kp, kd = law.parameter("kp", 0.6, "N m"), law.parameter("kd", GAIN, "N m s")
        return {"turn": tuple(-kp * a - kd * b for a, b in zip(q, w, strict=True))}

    craft.law("feedback", feedback)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert mehvar.margins(mehvar.build(craft), "feedback", t_end=30.0)
