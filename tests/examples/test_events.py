# SPDX-License-Identifier: Apache-2.0
"""Events of three systems against closed forms and SciPy: impacts, hysteresis of thrusters, a brake."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import mehvar
from mehvar.models.quantities import Group
from mehvar.physics.gates import TOLERANCE, balance, gates
from mehvar.physics.machine import Machine
from mehvar.runtime.batch.repeat import difference, plan_of, repeat_run
from mehvar.runtime.batch.store.store import open_store
from mehvar.runtime.run.problem import Status
from mehvar.runtime.run.simulate import simulate
from tests.mehvar.physics.units import misfit
from tests.models.edits import parameter
from tests.models.written import written

from . import checks
from .pages import lines, model_here

METHODS = ("rk4", "dopri5", "dop853", "rock4", "rodas5p")
NAMES = ("bounce", "thruster", "cubli")


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    places = {name: tmp_path_factory.mktemp(name) for name in NAMES}
    return {name: model_here(name, place, "tests" if name == "bounce" else "docs") for name, place in places.items()}


@pytest.mark.parametrize("name", NAMES)
def test_an_example_is_short(folders, name):
    assert lines(folders[name].parents[1] / "models" / name) <= 80


def impacts(n, g=9.81, e=0.97, height=1.0):
    """Times of impact of a ball that is let go."""
    first = math.sqrt(2 * height / g)
    return first + np.append(0, np.cumsum(2 * first * e ** np.arange(1, n)))


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("backend", ["c", "python"])
@pytest.mark.share(4)
def test_fifty_bounces(folders, backend, method):
    """In free fall every method is exact, so that what is off is the location alone."""
    run = simulate(folders["bounce"], "fall", backend=backend, method=method)
    times = [t for t, _ in run.events]
    assert len(times) > 50
    np.testing.assert_allclose(times, impacts(len(times)), atol=2e-11)
    assert {name for _, name in run.events} == {"impact"}
    assert np.all(run.x[:, 0] > -1e-9)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("backend", ["c", "python"])
def test_ever_closer_impacts_end_with_a_message(folders, backend, method):
    run = simulate(folders["bounce"], "fall", backend=backend, method=method, e=0.5)
    assert run.status is Status.CHATTERING
    assert run.reason.startswith("the event impact happens again and again without progress in time at t = 1.35457")
    assert abs(run.t_stop - 3 * math.sqrt(2 / 9.81)) < 1e-7


@pytest.mark.parametrize("backend", ["c", "python"])
@pytest.mark.parametrize("options", [{}, {"hold": 0.05}])
def test_a_ball_that_starts_on_the_ground(folders, backend, options):
    run = simulate(
        folders["bounce"], "fall", backend=backend, initial={"height": 0.0, "speed": 3.0}, t_end=2.0, **options
    )
    assert abs(run.events[0][0] - 2 * 3 / 9.81) < 1e-12


def test_an_impact_at_a_sample_comes_before_it(folders):
    """The state of the sample is the one after the event."""
    first = math.sqrt(2 / 9.81)
    run = simulate(folders["bounce"], "fall", t_end=2 * first, dt_out=first / 4)
    assert len(run.events) == 1
    assert run.x[4, 1] > 0


def by_scipy(rate, guards, x, end):
    """Integrate with SciPy from event to event; guards are (function, direction, reset)."""
    t, log, ends = 0.0, [], []
    for function, direction, _ in guards:

        def event(t, x, function=function):
            return function(x)

        event.terminal, event.direction = True, direction
        ends.append(event)
    while t < end:
        solution = solve_ivp(rate, (t, end), x, method="DOP853", rtol=1e-12, atol=1e-13, events=ends)
        t, x = solution.t[-1], solution.y[:, -1]
        if solution.status == 1:
            which = next(k for k, times in enumerate(solution.t_events) if times.size)
            log.append((t, which))
            x = guards[which][2](x)
            beyond = min(t + 1e-4, end)  # past the zero, where SciPy would find the same event again
            x = solve_ivp(rate, (t, beyond), x, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
            t = beyond
    return log, x


def thrusters():
    """The axis under thrusters by hand."""

    def rate(_t, x):
        return [x[1], (0.5 * x[2] + 0.01) / 10, 0.0]

    def signal(x):
        return -(x[0] + 4 * x[1])

    return rate, (
        (lambda x: signal(x) - 0.1, 1, lambda x: [*x[:2], 1.0]),
        (lambda x: signal(x) - 0.05, -1, lambda x: [*x[:2], min(x[2], 0.0)]),
        (lambda x: -signal(x) - 0.1, 1, lambda x: [*x[:2], -1.0]),
        (lambda x: -signal(x) - 0.05, -1, lambda x: [*x[:2], max(x[2], 0.0)]),
    )


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("backend", ["c", "python"])
@pytest.mark.share(4)
def test_a_thruster_with_hysteresis(folders, backend, method):
    names = ("fire_plus", "rest_plus", "fire_minus", "rest_minus")
    rate, guards = thrusters()
    log, x = by_scipy(rate, guards, [0.3, 0.0, -1.0], 60.0)
    run = simulate(folders["thruster"], "trigger", backend=backend, method=method)
    assert [name for _, name in run.events] == [names[k] for _, k in log]
    assert len(log) > 10
    np.testing.assert_allclose([t for t, _ in run.events], [t for t, _ in log], atol=1e-8)
    np.testing.assert_allclose(run.x[-1], x, atol=1e-8)
    assert set(run.x[:, 2]) <= {-1.0, 0.0, 1.0}


def test_a_thruster_beside_a_sampled_law(folders):
    """Python and C agree on the same steps: to the location of the events."""
    c, python = (
        simulate(folders["thruster"], "damped", backend=backend, method="dopri5") for backend in ("c", "python")
    )
    assert [name for _, name in c.events] == [name for _, name in python.events]
    assert len(c.events) > 3
    np.testing.assert_allclose(c.x[-1], python.x[-1], atol=1e-9)


def cube(jump=72.0):
    """The Cubli's prototype by hand."""
    arm, l_b, m_b, m_w, i_b, i_w, c_b, c_w, g = 0.085, 0.075, 0.419, 0.204, 3.34e-3, 0.57e-3, 1.02e-3, 0.05e-3, 9.81
    pivot, weight = i_b + m_w * arm**2, (m_b * l_b + m_w * arm) * g

    def rate(_t, x):
        angle, speed, wheel, phase = x
        torque = 0.04 if phase == 0 else 2 * angle + 0.2024 * speed + 3.2e-3 * wheel if phase == 2 else 0.0
        turn = (weight * math.sin(angle) - c_b * speed - torque + c_w * wheel) / pivot if phase else 0.0
        return [speed if phase else 0.0, turn, (torque - c_w * wheel) / i_w - turn, 0.0]

    def stopped(x):
        return [x[0], (i_w * (x[1] + x[2]) + pivot * x[1]) / (i_w + pivot), 0.0, 1.0]

    return rate, (
        (lambda x: x[2] - jump if x[3] == 0 else -1.0, 1, stopped),
        (lambda x: x[0] + 0.15, 1, lambda x: [*x[:3], 2.0]),
        (lambda x: x[0] + math.pi / 4 if x[3] else 1.0, -1, lambda x: [x[0], 0.0, x[2], 0.0]),
    )


@pytest.mark.parametrize("method", ["dopri5", "dop853", "rock4", "rodas5p"])
@pytest.mark.parametrize("backend", ["c", "python"])
@pytest.mark.share(2)
def test_the_cubli_jumps_up(folders, backend, method):
    rate, guards = cube()
    log, x = by_scipy(rate, guards, [-math.pi / 4, 0.0, 0.0, 0.0], 4.0)
    run = simulate(folders["cubli"], "stand_up", backend=backend, method=method, rtol=1e-9, atol=1e-10)
    assert [name for _, name in run.events] == ["brake", "catch"] == [("brake", "catch", "land")[k] for _, k in log]
    np.testing.assert_allclose([t for t, _ in run.events], [t for t, _ in log], atol=1e-7)
    np.testing.assert_allclose(run.x[-1], x, atol=1e-6)
    assert abs(run.x[-1, 0]) < 0.01


def test_braked_too_early_it_falls_back(folders):
    run = simulate(folders["cubli"], "stand_up", jump=60.0, t_end=3.0)
    assert [name for _, name in run.events][:3] == ["brake", "land", "brake"]


def test_braking_conserves_the_angular_momentum(folders):
    model = mehvar.load(folders["cubli"])
    before = np.array([-0.5, 0.3, 70.0, 0.0])
    after = model.functions["resets"](before, [0.0], model.parameters(), 0.0)
    pivot, wheel = 3.34e-3 + 0.204 * 0.085**2, 0.57e-3
    momenta = [pivot * x[1] + wheel * (x[1] + x[2]) for x in (before, after)]
    np.testing.assert_allclose(momenta[1], momenta[0], rtol=1e-14)
    assert after[2] == 0


BATCHES = [
    ("bounce", "fall", {"e": "uniform(0.3, 1)", "g": "uniform(1, 20)"}),
    ("bounce", "fall", {"e": "uniform(0.8, 1)", "height_0": "uniform(0, 2)"}),
    ("thruster", "trigger", {"torque": "uniform(0.1, 1)", "lead": "uniform(1, 6)"}),
    ("thruster", "damped", {"torque": "uniform(0.1, 1)", "lead": "uniform(1, 6)"}),
    ("cubli", "stand_up", {"jump": "uniform(50, 90)"}),
]


@pytest.mark.parametrize(
    ("name", "law", "vary", "method"),
    [
        pytest.param(*case, method, marks=() if k == m else pytest.mark.soak)  # each compiles a kernel
        for k, case in enumerate(BATCHES)
        for m, method in enumerate(METHODS)
    ],
)
@pytest.mark.share(24)
def test_a_batch_has_the_bits_of_its_runs(folders, tmp_path, name, law, vary, method):
    runs = mehvar.batch(
        folders[name], law, n=9, seed=1, vary=vary, method=method, t_end=5.0, out=tmp_path / "runs.zarr"
    )
    store = open_store(tmp_path / "runs.zarr")
    plan = plan_of(store, folders[name])
    for number in range(9):
        assert difference(repeat_run(plan, store, number), plan, store, number) == ""
    counts = runs[{"bounce": "impacts", "thruster": "pulses", "cubli": "jumps"}[name]].values
    assert counts.max() > 1


def energy(name):
    """Mechanical energy, over the mass for the ball, and the power of what acts; the Cubli's off the ground."""

    def cubli(at):
        pivot, weight = at["I_b"] + at["m_w"] * at["l"] ** 2, (at["m_b"] * at["l_b"] + at["m_w"] * at["l"]) * at["g"]
        wheel = at["I_w"] * (at["rate"] + at["wheel"]) ** 2 / 2
        return pivot * at["rate"] ** 2 / 2 + wheel + weight * np.cos(at["angle"])

    return {
        "bounce": (lambda at: at["g"] * at["height"] + at["speed"] ** 2 / 2, lambda at: at["lift"] * at["speed"]),
        "thruster": (
            lambda at: at["I"] * at["rate"] ** 2 / 2,
            lambda at: (at["torque"] * at["fires"] + at["drift"] + at["wheel"]) * at["rate"],
        ),
        "cubli": (
            cubli, lambda at: at["T"] * at["wheel"] - at["C_b"] * at["rate"] ** 2 - at["C_w"] * at["wheel"] ** 2,
        ),
    }[name]  # fmt: skip


@pytest.mark.parametrize("name", NAMES)
def test_gates(folders, name):
    """Energy changes by the power of what acts, and equations, guards and resets are the same in other units."""
    subject = Machine(checks.system_of(folders[name]), {"phase": (1.0, 2.0)} if name == "cubli" else {})
    assert gates([balance("work", *energy(name))], subject)["work"] < TOLERANCE
    for function in ("rhs", "guards"):
        assert misfit(subject, function) < 1e-12  # some hundred roundings


def test_an_impact_leaves_its_part_of_the_energy(folders):
    model = mehvar.load(folders["bounce"])
    before, p = np.array([0.0, -3.0]), model.parameters()
    after = model.functions["resets"](before, [0.0], p, 0.0)
    np.testing.assert_allclose(after, [0.0, 0.97 * 3.0], rtol=1e-15)


@pytest.mark.parametrize(
    ("name", "old", "new", "row"),
    [
        ("bounce", 'X.height, "falling"', '2 * X.height, "falling"', "changed impact: falling"),
        ("bounce", "-p.e * X.speed", "-p.e**2 * X.speed", "changed impact: speed+"),
        ("thruster", '"rest_plus", signal - p.off', '"rest_plus", signal - 2 * p.off', "changed rest_plus: falling"),
        ("thruster", "sp.Min(mode, 0)", "sp.Max(mode, 0)", "changed rest_plus: fires+"),
        ("cubli", "X.angle + p.catch", "X.angle - p.catch", "changed catch: rising"),
        ("cubli", "{X.rate: NONE, X.phase: NONE}", "{X.phase: NONE}", "rate+"),
    ],
)
@pytest.mark.share(6)
def test_a_diff_shows_an_edited_guard_and_an_edited_reset(folders, name, old, new, row):
    checks.command_shows(folders[name], old, new, row)


def test_the_sampled_law_of_the_thrusters_on_a_board(folders):
    checks.board_agrees(folders["thruster"], "damped")


def dragged(n, k=0.5, g=9.81, e=0.97, height=1.0):
    """Times of impact of a ball with linear drag, v' = -g - k v: roots of its closed form."""
    speed, t, times = 0.0, 0.0, []
    for _ in range(n):
        v = speed + g / k

        def place(s, v=v, start=height):
            return start + v * -math.expm1(-k * s) / k - g * s / k

        top = max(math.log(v * k / g) / k, 0.0)
        fall = brentq(place, top, top + 2.0, xtol=1e-15, rtol=1e-15)
        t, height, speed = t + fall, 0.0, -e * (v * math.exp(-k * fall) - g / k)
        times.append(t)
    return times


@pytest.mark.parametrize("method", ["dopri5", "dop853", "rock4", "rodas5p"])
def test_the_error_of_impacts_follows_the_tolerance(folders, tmp_path, method):
    """In air of linear drag no method is exact; the instants are those of the closed form."""
    system = checks.system_of(folders["bounce"])
    p = Group("p", (*system.parameters.quantities, parameter("k", "1/s", 0.5)))
    x, u = system.states, system.inputs
    folder = written(replace(system, parameters=p, rhs=(x.speed, u.lift - p.g - p.k * x.speed)), tmp_path)
    errors = []
    for tolerance in (1e-4, 1e-6, 1e-8, 1e-10):
        options = {"rtol": tolerance, "atol": tolerance, "dt_out": 5.0}  # whose samples do not help the steps
        run = simulate(folder, "fall", method=method, t_end=5.0, **options)
        times = [t for t, _ in run.events]
        assert len(times) > 5
        errors.append(np.abs(np.subtract(times, dragged(len(times)))).max())
    for tolerance, error in zip((1e-4, 1e-6, 1e-8, 1e-10), errors, strict=True):
        assert error < 2 * tolerance  # half of it at most, of rock4 and dopri5
    assert errors[-1] < errors[0] / 100  # dop853 is good to 2e-10 at the widest: 600 times; the others 1e5
